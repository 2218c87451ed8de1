//! Lists the stretches that are excluded from every result: found turns and stops, and drawn
//! stretches.

use super::parts::{remark, setting, warning};
use crate::app::{Action, Command, ExclusionEdit, FoundExclusions, LogPlace, OpenLog, Tool};
use crate::ui::controls::ListKeys;
use crate::ui::{ViewContext, place, text};
use bathyscope_log::survey::{ExcludedStretch, ExclusionReason, LogPart, Stretch, Survey};
use bathyscope_products::pipeline::settings::rows;
use egui::{Align, Button, Layout, Response, ScrollArea, Ui};

/// Height of a row of the list, points.
const ROW: f32 = 18.0;
/// Number of rows of the list that are visible at once.
const ROWS: f32 = 7.0;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    tool(ui, context);
    for row in [&rows::MAX_TURN, &rows::MIN_SPEED] {
        setting(ui, context, row);
    }
    let settings = &context.app.logs.shown.settings.excluded;
    if settings.max_turn_deg_s.is_some() || settings.min_speed_mps.is_some() {
        setting(ui, context, &rows::MIN_DURATION);
    }
    let Some(found) = context.app.logs.shown.exclusions().cloned() else {
        return;
    };
    for text in &found.exclusions.warnings {
        warning(ui, context, &context.units().sentence(text));
    }
    counts(ui, context, &found);
    list(ui, context, &found);
    kept(ui, context);
}

fn tool(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::Exclude;
    let holds = context.app.logs.shown.reviewing.tool == Tool::Exclude;
    let button = ui.add(Button::new("Exclude stretches").selected(holds));
    context.keyed_button(button.accessible_name(action.label()), action);
}

/// Draws the excluded length, by reason and in total of all logs.
fn counts(ui: &mut Ui, context: &ViewContext<'_>, found: &FoundExclusions) {
    use ExclusionReason::{Bad, Drawn, Stop, Turn};
    let units = context.units();
    if found.exclusions.is_empty() {
        return remark(ui, "No part of this log is excluded.");
    }
    for (reason, one, many) in [
        (Turn, "turn", "turns"),
        (Stop, "stop", "stops"),
        (Bad, "bad stretch", "bad stretches"),
        (Drawn, "drawn stretch", "drawn stretches"),
    ] {
        let extent = found.extent(Some(reason));
        if extent.stretches > 0 {
            let what = text::plural(extent.stretches, one, many);
            let extent = place::stretch_extent(&extent, units);
            ui.label(format!("{what}: {extent}"));
        }
    }
    let others = context.app.logs.visible().filter_map(OpenLog::exclusions);
    let (logs, pings) = others
        .fold((0, 0), |(logs, pings), found| (logs + 1, pings + found.exclusions.ping_count()));
    if logs > 1 {
        let all = text::plural(pings, "ping", "pings");
        remark(ui, format!("{all} of all visible logs"));
    }
}

/// Draws the list of excluded stretches: a click shows a stretch in all views, × includes it again.
fn list(ui: &mut Ui, context: &mut ViewContext<'_>, found: &FoundExclusions) {
    let stretches: Vec<(&ExcludedStretch, f64)> = found.stretches().collect();
    let Some(survey) = context.app.logs.shown.survey.clone() else {
        return;
    };
    let each = ROW + ui.spacing().item_spacing.y;
    let area = ScrollArea::vertical()
        .id_salt("excluded stretches")
        .max_height(ROWS * each)
        .min_scrolled_height(ROWS * each);
    let keys = ListKeys::read(ui, "excluded stretches", stretches.len());
    keys.scroll(area, each, ROWS).show_rows(ui, ROW, stretches.len(), |ui, range| {
        let first = range.start;
        for (index, (stretch, length_m)) in stretches[range].iter().enumerate() {
            let way = context.units().way(*length_m);
            let part = stretch.part();
            let where_at = place(&survey, part);
            let label = format!("{}  {where_at}  {way}", stretch.reason.name());
            let name = format!("{} {where_at}", stretch.reason.name());
            let back = ("Include again", ExclusionEdit::Include);
            let row = row(ui, context, [&label, &name], part, back);
            keys.row(ui, first + index, &row);
        }
    });
}

/// Draws the stretches that count although a turn or a stop is found there.
fn kept(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let Some(survey) = app.logs.shown.survey.clone() else {
        return;
    };
    let settings = app.logs.shown.settings.clone();
    let stretches = settings.excluded.stretches.iter();
    let part = |stretch: &Stretch| match (stretch.pings, stretch.time_s) {
        (Some(pings), _) => Some(LogPart::Pings(pings)),
        (None, time_s) => time_s.map(LogPart::Time),
    };
    let kept = stretches.filter(|stretch| stretch.reason.is_none());
    let kept: Vec<(LogPart, bool)> =
        kept.filter_map(|stretch| Some((part(stretch)?, stretch.trusted))).collect();
    for (part, trusted) in kept {
        let where_at = place(&survey, part);
        let what = if trusted { "soundings trusted" } else { "kept" };
        let label = format!("{what}  {where_at}");
        let name = format!("{what} {where_at}");
        let search = ("Reset", ExclusionEdit::Reset);
        row(ui, context, [&label, &name], part, search);
    }
}

/// Draws a stretch with a button that edits it; returns the response of the stretch.
fn row(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    [label, name]: [&str; 2],
    part: LogPart,
    (what, edit): (&str, ExclusionEdit),
) -> Response {
    let log = context.app.logs.shown.id;
    let row = ui.horizontal(|ui| {
        let row = ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let button = ui.add(Button::new("×").small().frame(false));
            let button = button.accessible_name(format!("{what}: {name}"));
            if button.on_hover_text(what).clicked() {
                context.push(Command::Exclude { log, part, edit });
            }
            let row = ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let selection = context.app.view.selection;
                let is_here = selection.is_some_and(|mark| holds(part, mark));
                let label = ui.add(Button::selectable(is_here, label).truncate());
                let label = label.accessible_name(format!("Stretch {name}"));
                let label = label.on_hover_text("Shows it in all views.");
                if label.clicked()
                    && let LogPart::Pings([first, last]) = part
                {
                    let middle = usize::midpoint(first, last);
                    context.push(Command::Reveal(LogPlace::ping(middle)));
                }
                label
            });
            row.inner
        });
        row.inner
    });
    row.inner
}

fn holds(part: LogPart, mark: LogPlace) -> bool {
    matches!(part, LogPart::Pings([first, last]) if (first..=last).contains(&mark.ping))
}

/// Returns the pings of a stretch as text, `1200..1350`, or its clock times if the log has no
/// pings.
fn place(survey: &Survey, part: LogPart) -> String {
    match part {
        LogPart::Pings([first, last]) => format!("{first}..{last}"),
        LogPart::Time(ends_s) => {
            let [from, to] = ends_s.map(|time_s| text::clock(survey.start_unix_s, time_s));
            format!("{from} to {to}")
        }
    }
}
