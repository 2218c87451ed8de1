//! Draws the detection of the first return of the bottom.

use super::parts::{self, remark};
use crate::app::{AboveBottom, AboveStretch, Action, Command, LogPlace, Tool};
use crate::ui::{ViewContext, controls, place, text, theme};
use bathyscope_bottom::cloud::PointClass;
use bathyscope_log::survey::Side;
use egui::{Align, Button, Layout, RichText, ScrollArea, Ui};

/// Title of the section.
pub(super) const TITLE: &str = "First return";

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if !place::has_side_scan(context.app) {
        return parts::remark(ui, "This log has no side-scan.");
    }
    found(ui, context);
    parts::settings_of(ui, context, TITLE);
    bottom_edits(ui, context);
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
        for (side, found) in
            [(Side::Port, figures.port_picks), (Side::Starboard, figures.starboard_picks)]
        {
            let short = place::short_name(side);
            let text = RichText::new(format!("{} {short}", text::count(found)));
            ui.label(text.color(theme::side_colour(options, side)))
                .on_hover_text(hint(side.name(), found));
        }
    });
    let found = figures.port_picks + figures.starboard_picks;
    above_bottom(ui, context, &figures.above_bottom, found);
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

/// Height of a row of the list, points.
const ROW: f32 = 18.0;
/// Number of rows of the list that are visible at once.
const ROWS: f32 = 6.0;

/// Draws the first returns above the recorded depth, as a part of all `of` first returns; draws
/// nothing if there are none.
fn above_bottom(ui: &mut Ui, context: &mut ViewContext<'_>, above: &AboveBottom, of: usize) {
    if above.count == 0 {
        return;
    }
    let margin_m = context.app.logs.shown.settings.first_return.above_bottom_margin_m;
    let hint = format!(
        "First returns nearer than the recorded depth by more than {}: dashed in the waterfall.",
        context.units().measure(margin_m, 2)
    );
    let (count, of) = (text::count(above.count), text::count(of));
    ui.label(format!("{count} of {of} above recorded depth")).on_hover_text(hint);
    for text in reasons(context, above) {
        remark(ui, text);
    }
    let title = text::plural(above.stretches.len(), "such stretch", "such stretches");
    egui::CollapsingHeader::new(title)
        .id_salt("stretches above the recorded depth")
        .show(ui, |ui| list(ui, context, &above.stretches));
    tool(ui, context);
}

/// Returns sentences about possible reasons for returns above the bottom, and about the number that
/// counts for the map.
fn reasons(context: &ViewContext<'_>, above: &AboveBottom) -> Vec<String> {
    let units = context.units();
    let settings = &context.app.logs.shown.settings.surface;
    let usual = above.count - above.standing;
    let mut reasons = Vec::new();
    if usual > 0 {
        reasons.push(format!(
            "{} lie as far above it as their neighbours and count as bottom.",
            text::count(usual)
        ));
    }
    if above.standing == 0 {
        return reasons;
    }
    let height = units.measure(above.height_m, 2);
    let standing = text::count(above.standing);
    reasons.push(match above.one_side {
        Some(side) => format!(
            "{standing} stand out by {height}, mostly to {}: a bank, weed or boulders.",
            side.name()
        ),
        None => format!("{standing} stand out by {height}: weed, boulders or a smoothed depth."),
    });
    let left = text::count(above.standing - above.counted);
    let long = units.chosen(settings.longest_above_bottom_m);
    reasons.push(match above.counted {
        _ if settings.above_bottom => "The settings count all of these as bottom.".to_owned(),
        0 => "None of these counts for the map.".to_owned(),
        counted => format!(
            "{} of these go on for over {long} and count; {left} do not.",
            text::count(counted)
        ),
    });
    reasons
}

/// Draws the list of stretches, beginning with those with most returns that do not count: a click
/// shows a stretch in all views, the button accepts it.
fn list(ui: &mut Ui, context: &mut ViewContext<'_>, stretches: &[AboveStretch]) {
    let height = ROWS * (ROW + ui.spacing().item_spacing.y);
    ScrollArea::vertical()
        .id_salt("list of stretches above the recorded depth")
        .max_height(height)
        .show_rows(ui, ROW, stretches.len(), |ui, range| {
            for stretch in &stretches[range] {
                row(ui, context, stretch);
            }
        });
}

fn row(ui: &mut Ui, context: &mut ViewContext<'_>, stretch: &AboveStretch) {
    let AboveStretch { side, pings: pings @ [first, last], count, uncounted, height_m } = *stretch;
    let units = context.units();
    let name = format!("pings {first} to {last}, {}", side.name());
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let accept = ui.add(Button::new("Accept").small());
            let accept = accept.accessible_name(format!("Accept as bottom: {name}"));
            let hint = "Counts these first returns as bottom; undo reverts it.";
            if accept.on_hover_text(hint).clicked() {
                context.push(Command::AcceptBottom {
                    side,
                    pings,
                    accept: true,
                });
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let is_here = context.app.view.selection.is_some_and(|mark| {
                    mark.side == Some(side) && (first..=last).contains(&mark.ping)
                });
                let short = place::short_name(side);
                let height = units.measure(height_m, 2);
                let label = format!("{first} to {last} {short}  {}", units.measure(height_m, 1));
                let label = ui.add(Button::selectable(is_here, label).truncate());
                let label = label.accessible_name(format!("Above recorded depth: {name}"));
                let hint = format!(
                    "{} first returns, {height} above the recorded depth (median); {} do not count for the map. Click to show them in all views.",
                    text::count(count),
                    text::count(uncounted)
                );
                if label.on_hover_text(hint).clicked() {
                    context.push(Command::Reveal(LogPlace {
                        side: Some(side),
                        ..LogPlace::ping(usize::midpoint(first, last))
                    }));
                }
            });
        });
    });
}

fn tool(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::AcceptBottom;
    let holds = context.app.logs.shown.reviewing.tool == Tool::Accept;
    let button = Button::new(action.label()).selected(holds);
    let button = controls::underline(ui, holds, button);
    context.button(button, action);
}
