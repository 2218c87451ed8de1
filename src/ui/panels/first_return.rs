//! Draws step 1: the detection of the first return of the bottom.

mod above_bottom;

use super::parts;
use super::section::{Section, section};
use crate::app::{Action, Tool};
use crate::ui::{ViewContext, controls, place, text, theme};
use bathyscope_bottom::cloud::PointClass;
use bathyscope_log::survey::Side;
use bathyscope_products::pipeline::Stage;
use egui::{Button, RichText, Ui};

/// Title of the section.
const TITLE: &str = "First return";

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new(TITLE).step(1).of(Stage::FirstReturn), |ui, context| {
        if !place::has_side_scan(context.app) {
            return parts::remark(ui, "This log has no side-scan.");
        }
        found(ui, context);
        parts::settings_of(ui, context, TITLE);
        bottom_edits(ui, context);
    });
}

fn found(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let (Some(products), Some(figures)) = (&app.logs.shown.products, &app.logs.shown.figures)
    else {
        parts::remark(
            ui,
            if context.app.is_stopped() {
                "No result yet: the search was stopped."
            } else {
                "Searching…"
            },
        );
        return;
    };
    // A preview may hold the visible pings only; the counts refer to the whole log.
    let options = context.options();
    let pings = products.returns.port.len().max(1);
    let hint = |side: &str, found: usize| {
        let share = 100.0 * found as f64 / pings as f64;
        format!("A first return was found to {side} in {share:.1} % of all pings.")
    };
    ui.horizontal_wrapped(|ui| {
        for (side, short, found) in [
            (Side::Port, "port", figures.port_picks),
            (Side::Starboard, "stbd", figures.starboard_picks),
        ] {
            let text = RichText::new(format!("{} {short}", text::count(found)));
            ui.label(text.color(theme::side_colour(options, side)))
                .on_hover_text(hint(side.name(), found));
        }
    });
    let found = figures.port_picks + figures.starboard_picks;
    above_bottom::ui(ui, context, &figures.above_bottom, found);
    let unsure = figures.classes.count(PointClass::Unclassified);
    if unsure > 0 {
        let share = 100.0 * unsure as f64 / figures.classes.side_scan.max(1) as f64;
        ui.label(format!("{} below minimum confidence", text::count(unsure)))
            .on_hover_text(format!("{share:.1} % of all first returns are below the minimum confidence; neither cloud nor map uses them."));
    }
    for text in &products.bottom_line.warnings {
        parts::warning(ui, context, &context.units().sentence(text));
    }
}

/// Draws the button of the pen, and the edits that were made with it.
fn bottom_edits(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let bottom = &app.logs.shown.settings.bottom;
    let (drawn, accepted) = (bottom.ping_count(), bottom.accepted_count());
    ui.horizontal(|ui| {
        let holds = app.logs.shown.reviewing.tool == Tool::Bottom;
        let mut both = app.view.options.waterfall.bottom_both_sides;
        let pen = Button::new("Draw bottom").selected(holds);
        let pen = controls::underline(ui, holds, pen);
        context.named_button(pen, Action::DrawBottom);
        let sides = ui.checkbox(&mut both, "Both sides");
        context.named_button(sides, Action::BottomBothSides);
    });
    if drawn + accepted > 0 {
        ui.horizontal_wrapped(|ui| {
            if drawn > 0 {
                ui.label(format!("{} edited", text::plural(drawn, "ping", "pings")))
                    .on_hover_text("Pings whose first return was drawn, both sides counted.");
            }
            if accepted > 0 {
                let pings = text::plural(accepted, "ping", "pings");
                ui.label(format!("{pings} accepted as bottom"))
                    .on_hover_text("Pings whose first return counts as bottom where it was found, both sides counted.");
            }
            context.named_button(ui.button("Forget"), Action::ForgetBottom);
        });
    }
}
