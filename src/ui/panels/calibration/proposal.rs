//! Draws the stretch that is proposed for the scale, with its result, the objections to it, and the
//! changes that it would make.

use super::{pings, plot};
use crate::app::Action;
use crate::ui::panels::parts::{self, fact};
use crate::ui::{ViewContext, stretch_text, theme};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::pipeline::{Products, ScaleEffect, ScaleTrial};
use egui::{Align, Frame, RichText, Ui};
use std::sync::Arc;

/// Draws the proposed stretch, if there is one; a new one is scrolled into view.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>, products: &Products, is_new: bool) {
    let Some(range) = context.app.logs.shown.proposed_stretch() else {
        return;
    };
    let trial = context.app.logs.shown.scale_trial().cloned();
    let frame = Frame::group(ui.style()).show(ui, |ui| {
        ui.set_width(ui.available_width());
        let title = RichText::new(format!("Proposed: {}", pings(range)));
        ui.label(title.strong().color(theme::accent_colour(context.theme())));
        match &trial {
            Some(trial) => found(ui, context, products, trial),
            None => parts::remark(ui, "Measuring the scale."),
        }
        buttons(ui, context, trial.as_ref());
    });
    if is_new {
        frame.response.scroll_to_me(Some(Align::Center));
    }
}

fn found(ui: &mut Ui, context: &ViewContext<'_>, products: &Products, trial: &ScaleTrial) {
    let units = context.units();
    let spot = &trial.spot;
    let length = units.measure(spot.length_m, 1);
    let depth = units.measure(spot.depth_m, 2);
    let relief = stretch_text::relief(spot, units);
    let place = format!("{length} long, {depth} deep, relief {relief}");
    parts::remark(ui, place);
    for text in &trial.objections {
        parts::warning(ui, context, &units.sentence(text));
    }
    let (Some(factor), Some(spread)) = (stretch_text::factor(spot), stretch_text::spread(spot))
    else {
        return;
    };
    let hint = "What recorded ranges would be multiplied with: recorded depth over recorded range, median over the first returns of the stretch, with the spread of single pings.";
    fact(ui, "Scale", hint, format!("range {factor} {spread}"));
    plot::ui(ui, trial, products, context.options());
    match &trial.effect {
        Some(effect) => changes(ui, effect, units),
        None => parts::remark(ui, "The log has no side-scan depths that would change."),
    }
}

/// Draws the changes of the depths that the scale would cause.
fn changes(ui: &mut Ui, effect: &ScaleEffect, units: Units) {
    let change = &effect.change;
    let hint = "By how much side-scan depths that count for the map would change, in the median of the log; above 0 they become greater.";
    let value = format!("{} (median)", units.signed_difference(change.median_m));
    fact(ui, "Depth change", hint, value);
    let hint = "The largest change of a side-scan depth of the log.";
    let value = units.signed_difference(change.largest_m);
    fact(ui, "At most", hint, value);
    if let Some([now, then]) = &effect.residuals {
        let hint = "Side-scan minus sounding at the same ping, median over the log, with the scale in use and with this one: the nearer to 0 the better.";
        let now = units.signed_difference(now.median_m);
        let then = units.signed_difference(then.median_m);
        let value = format!("{now} now, {then} then");
        fact(ui, "To soundings", hint, value);
    }
}

fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>, trial: Option<&Arc<ScaleTrial>>) {
    let gives_scale = trial.is_some_and(|trial| trial.spot.ppd.is_some());
    ui.horizontal_wrapped(|ui| {
        ui.add_enabled_ui(gives_scale, |ui| {
            let take = Action::UseScale;
            context.button(ui.button(take.label()), take);
        });
        let keep = Action::KeepRecordedRange;
        context.button(ui.button(keep.label()), keep);
        context.button(ui.button("Drop"), Action::DropProposal);
    });
}
