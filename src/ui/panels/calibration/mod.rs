//! Draws step 2, from samples to metres: the scale in use, the flat stretches on which one can be
//! measured, and the proposed stretch.
//!
//! The panel reads the state of the app, draws controls and texts, and sends commands.

mod candidates;
mod plot;

use super::find_setting;
use super::parts::{self, fact, setting};
use super::section::{Section, section, unfold_section};
use crate::app::{Action, Tool};
use crate::ui::{ViewContext, controls, stretch_text, text, theme};
use bathyscope_bottom::calibration::{Calibration, PingRange, Scale, ScaleMode};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::RangeSource;
use bathyscope_products::pipeline::settings::rows;
use bathyscope_products::pipeline::{Products, ScaleEffect, ScaleTrial, Stage};
use egui::{Align, Button, Frame, RichText, Ui};
use std::sync::Arc;

/// Title of the section.
const TITLE: &str = "Calibration";

/// Draws the section.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let is_new = follow_proposal(ui, context);
    section(ui, context, Section::new(TITLE).step(2).of(Stage::Calibration), |ui, context| {
        let Some(products) = context.app.logs.shown.products.clone() else {
            return parts::remark(ui, "No result yet.");
        };
        let calibration = &products.calibration;
        let survey = context.app.logs.shown.survey.clone();
        let source = survey.as_ref().map(|survey| survey.range_source).unwrap_or_default();
        in_use(ui, calibration, source, context.units());
        setting(
            ui,
            context,
            match calibration.mode {
                ScaleMode::FlatSpot => &rows::PPD_REACH,
                ScaleMode::Header => &rows::OFFSET,
            },
        );
        let Some(survey) = survey.filter(|survey| !survey.soundings.is_empty()) else {
            return parts::remark(ui, "This log records no depth to measure a scale against.");
        };
        for text in &calibration.warnings {
            parts::warning(ui, context, &context.units().sentence(text));
        }
        tools(ui, context, calibration.mode);
        proposed(ui, context, &products, is_new);
        candidates::ui(ui, context, &survey, &products);
    });
}

/// Returns true if a stretch was proposed that was not proposed in the last frame; the section then
/// opens.
fn follow_proposal(ui: &Ui, context: &ViewContext<'_>) -> bool {
    let id = egui::Id::unique("stretch proposed in the frame before");
    let now = context.app.logs.shown.proposed_stretch();
    let before: Option<PingRange> = ui.data(|data| data.get_temp(id)).flatten();
    ui.data_mut(|data| data.insert_temp(id, now));
    let is_new = now.is_some() && now != before;
    if is_new {
        unfold_section(ui.ctx(), TITLE);
    }
    is_new
}

fn scale(scale: Option<&Scale>) -> String {
    scale.map_or_else(
        || text::NONE.to_owned(),
        |scale| format!("{:.2} ±{:.2} pixels/m", scale.px_per_m, scale.spread_px_per_m),
    )
}

/// Draws the scale in use, and the available scales.
fn in_use(ui: &mut Ui, calibration: &Calibration, source: RangeSource, units: Units) {
    let is_estimated = source == RangeSource::Estimated;
    let spot = calibration.flat_spot.as_ref();
    let in_use = match (calibration.mode, spot) {
        (ScaleMode::FlatSpot, Some(spot)) => format!("flat stretch, {}", pings(spot.range())),
        _ if is_estimated => "estimated range".to_owned(),
        _ => "recorded range".to_owned(),
    };
    let hint = "What turns samples into metres: the range that the recorder wrote, or a flat stretch where first returns are compared with soundings.";
    fact(ui, "Scale in use", hint, in_use);
    let hint = range_hint(calibration, units);
    fact(ui, "Slant ranges", &hint, ranges(calibration, source, units));
    let header = calibration.header.as_ref();
    match header.filter(|_| is_estimated) {
        Some(header) => {
            let hint = "Pixels per metre by the size of the transducer: the recorder writes no range, and this may be off by some percent. Calibrate it on a flat stretch.";
            let value = format!("{:.1} pixels/m, to some percent", header.px_per_m);
            fact(ui, "Estimated", hint, value);
        }
        None => {
            let hint = "Pixels per metre by the ranges that the recorder wrote: median over the log and robust spread.";
            fact(ui, "From recorder", hint, scale(header));
        }
    }
    let hint = "Pixels per metre (PPD of Pulido et al.) on the flat stretch: first return over recorded depth, median over its pings and robust spread.";
    fact(ui, "From stretch", hint, scale(calibration.ppd().as_ref()));
    if calibration.beams.overlap_rad > 0.0 {
        let hint = "How far the beam of each side looks past the point below the boat, to the other side, as first returns over slopes show it. On a slope the first return of the lower side comes from there.";
        let value = format!("{:.1}° past the nadir", calibration.beams.overlap_rad.to_degrees());
        fact(ui, "Beam overlap", hint, value);
    }
    if let Some(fit) = calibration.fit {
        let offset = units.signed(fit.b_m, 2);
        let spread = units.spread(fit.spread_m, 2);
        fact(
            ui,
            "Line fit",
            &format!(
                "Line of recorded first-return range against recorded depth over the whole log; they scatter by ±{spread} {} about it.",
                units.symbol()
            ),
            format!("range = {:.3} × depth {offset}", fit.k),
        );
    }
}

/// Describes the correction of the ranges: factor or offset.
fn ranges(calibration: &Calibration, source: RangeSource, units: Units) -> String {
    let ranges = if source == RangeSource::Estimated { "estimated" } else { "recorded" };
    let factor = calibration.flat_spot.as_ref();
    let factor = factor.and_then(stretch_text::factor);
    match (calibration.mode, factor, calibration.offset_note) {
        (ScaleMode::FlatSpot, Some(factor), _) => format!("{ranges} range {factor}"),
        (_, _, Some(note)) => format!("as {ranges}; offset: {}", units.sentence(note)),
        _ => format!("{ranges} {}", units.signed(-calibration.offset_m, 2)),
    }
}

fn range_hint(calibration: &Calibration, units: Units) -> String {
    let measured = calibration.measured_offset.map_or(String::new(), |found| {
        let differ = units.signed_within(found.offset_m, found.uncertainty_m, 2);
        format!(" First returns differ from the soundings by {differ}.")
    });
    format!("What is done to every recorded range before depths are made of it.{measured}")
}

/// Returns the pings of a stretch as text: `pings 400 to 499`.
fn pings(range: PingRange) -> String {
    format!("pings {} to {}", range.start, range.end.saturating_sub(1))
}

/// Draws the tool that proposes a stretch, and the button that restores the recorded range.
fn tools(ui: &mut Ui, context: &mut ViewContext<'_>, mode: ScaleMode) {
    let action = Action::Calibrate;
    let holds = context.app.logs.shown.reviewing.tool == Tool::Calibrate;
    ui.horizontal_wrapped(|ui| {
        let button = Button::new("Calibrate on a stretch").selected(holds);
        let response = controls::underline(ui, holds, button);
        // The tool is the control of the setting of the scale.
        find_setting::answer(ui, context, rows::SCALE.key, &response);
        context.keyed_button(response, action);
        if mode == ScaleMode::FlatSpot && context.app.logs.shown.proposed_stretch().is_none() {
            let keep = Action::KeepRecordedRange;
            context.button(ui.button(keep.label()), keep);
        }
    });
}

/// Draws the proposed stretch, if there is one; a new one is scrolled into view.
fn proposed(ui: &mut Ui, context: &mut ViewContext<'_>, products: &Products, is_new: bool) {
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
