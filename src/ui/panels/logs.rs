//! Draws the list of open logs, with which one is shown, their visibility and order, and the height
//! differences between them.

use super::corrections;
use super::parts::{self, fact, name_of, press, remark, warning};
use crate::app::{Action, App, Command, JobKey, OpenLog};
use crate::ui::controls::{self, DropDown, ListKeys};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::presentation::units::Units;
use egui::{Button, RichText, Sense, Ui};

/// Draws the section while a log is open.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let last = app.logs.count().saturating_sub(1);
    let keys = ListKeys::read(ui, "logs", app.logs.count());
    for (place, log) in app.logs.all().enumerate() {
        let walked = (&keys, place);
        let commands = row(ui, app, log, [place > 0, place < last], walked);
        context.commands.extend(commands);
        if let Some(why) = &log.apart {
            remark(ui, app.view.options.units.sentence(&format!("Not on the map: {why}.")));
        }
    }
    add(ui, context);
    if app.logs.count() > 1 {
        heights(ui, context);
        corrections::shifts(ui, context);
    }
}

fn add(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let button = ui.add(Button::new(Action::AddLog.label()).small());
    context.keyed_button(button, Action::AddLog);
}

/// Draws the row of a log; returns the command that was requested on it.
fn row(
    ui: &mut Ui,
    app: &App,
    log: &OpenLog,
    [can_rise, can_sink]: [bool; 2],
    (keys, place): (&ListKeys, usize),
) -> Option<Command> {
    let (id, name) = (log.id, log.name());
    let mut command = None;
    let mut ask = |clicked: bool, requested: Command| {
        if clicked {
            command = Some(requested);
        }
    };
    ui.horizontal(|ui| {
        // A single log is always on the map, unless it was hidden beside others.
        let has_others = app.logs.count() > 1;
        if has_others || !log.is_visible {
            let mut visible = log.is_visible;
            let tick = ui.checkbox(&mut visible, "");
            let shows = format!("Show {name} on the map");
            let tick = accessible(tick, egui::Role::CheckBox, &shows);
            let hint = "Uses this log in map, cloud, depth map, mosaic and products.";
            ask(tick.on_hover_text(hint).changed(), Command::SetLogVisible(id, visible));
        }
        let (swatch, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), Sense::hover());
        ui.painter().rect_filled(swatch, 2.0, theme::rgb(log.colour));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let button = |ui: &mut Ui, sign: &str, what: &str, enabled: bool| {
                let button = ui.add_enabled(enabled, Button::new(sign).small().frame(false));
                let named = format!("{what} {name}");
                accessible(button, egui::Role::Button, &named).on_hover_text(what).clicked()
            };
            if has_others {
                ask(button(ui, "×", "Close", true), Command::CloseLog(id));
            }
            // The buttons are drawn on the row of the shown log only: beside every name there is no
            // space for them.
            if id == app.logs.shown.id && (can_rise || can_sink) {
                let [down, up] = [Command::MoveLog(id, 1), Command::MoveLog(id, -1)];
                ask(button(ui, "Down", "Move down", can_sink), down);
                ask(button(ui, "Up", "Move up", can_rise), up);
            }
            if app.is_processing(id) {
                ui.add(egui::Spinner::new().size(12.0));
            }
            let survey = log.survey.as_ref();
            let warnings = survey.map_or(0, |survey| survey.warnings.len());
            if warnings > 0 {
                let colour = theme::stale_colour(app.view.options.theme);
                ui.colored_label(colour, "!")
                    .on_hover_text(text::plural(warnings, "warning", "warnings"));
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let title = RichText::new(&name);
                let is_it = id == app.logs.shown.id;
                let label = Button::selectable(is_it, title).truncate();
                let label = controls::underline(ui, is_it, label);
                let label = accessible(label, egui::Role::Button, &format!("Log {name}"));
                let shown = label.on_hover_ui(|ui| describe(ui, log, app.view.options.units));
                keys.row(ui, place, &shown);
                ask(shown.clicked(), Command::ShowLog(id));
            });
        });
    });
    command
}

fn accessible(response: egui::Response, role: egui::Role, name: &str) -> egui::Response {
    response.widget_info(|| egui::WidgetInfo::labeled(role, true, name));
    response
}

/// Draws date, length, depths and warnings of a log.
fn describe(ui: &mut Ui, log: &OpenLog, units: Units) {
    let Some(survey) = &log.survey else {
        return;
    };
    if let Some(start) = survey.start_unix_s {
        let day = bathyscope_log::support::calendar::date(start);
        let value = format!("{day} {}", text::clock(Some(start), 0.0));
        fact(ui, "Start, UTC", "", value);
    }
    let length = survey.time_span_s().map(|(from, to)| text::duration(to - from));
    fact(ui, "Length", "", length.unwrap_or(text::NONE.to_owned()));
    let pings = text::plural(survey.side_scan.len(), "ping", "pings");
    fact(ui, "Side-scan", "", pings);
    let depths = log.depth_span_m.map(|span_m| units.span(span_m.map(f64::from), 1));
    fact(ui, "Depths", "", depths.unwrap_or(text::NONE.to_owned()));
    if let Some(found) = log.exclusions().filter(|found| !found.exclusions.is_empty()) {
        let extent = place::stretch_extent(&found.extent(None), units);
        fact(ui, "Excluded", "", extent);
    }
    for file in &survey.source.files {
        ui.label(file.display().to_string());
    }
    for warning in survey.warnings.iter().take(8) {
        remark(ui, units.sentence(&warning.text));
    }
}

const HEIGHTS: [(&str, &str); 4] = [
    ("Log", ""),
    (
        "offset",
        "How much deeper the depths of the log are than those of the log that is held, or of all.",
    ),
    ("±", "Standard error of the offset."),
    ("crossings", "Crossings of its track with other tracks."),
];

/// Draws the choice of the log whose height stays.
fn hold(ui: &mut Ui, context: &mut ViewContext<'_>) {
    const MEAN: &str = "mean of all";
    let app = context.app;
    let held = app.findings.heights.held.filter(|id| app.logs.get(*id).is_some());
    let shown = held.map_or_else(|| MEAN.to_owned(), |id| name_of(app, id));
    let mut picked = None;
    let list = DropDown::new("held height", shown).width(96.0).show(ui, |choices| {
        let logs = app.logs.visible().map(|log| (Some(log.id), log.name()));
        for (choice, name) in [(None, MEAN.to_owned())].into_iter().chain(logs) {
            if choices.choice(choice == held, name).clicked() {
                picked = Some(choice);
            }
        }
    });
    list.on_hover_text(
        "The log whose height stays when heights are applied: the one with a measured water level and draft.",
    );
    context.commands.extend(picked.map(Command::HoldHeight));
}

/// Draws the height differences between the logs, where their tracks meet.
fn heights(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let contradicted = app.contradicted_soundings();
    for text in &contradicted {
        warning(ui, context, &app.view.options.units.sentence(text));
    }
    if !contradicted.is_empty() {
        press(ui, context, Action::LeaveOutContradicted, true);
    }
    if let Some(text) = app.unlevelled() {
        warning(ui, context, &app.view.options.units.sentence(&text));
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Hold");
        hold(ui, context);
        let is_known = app.height_offsets().is_some();
        press(ui, context, Action::ApplyHeights, is_known);
        if app.jobs.is_running(&JobKey::CompareHeights) {
            ui.add(egui::Spinner::new().size(12.0));
        }
    });
    let Some(found) = app.height_offsets() else {
        return;
    };
    parts::table(ui, "height offsets", &HEIGHTS, |ui| {
        for (id, offset) in found.logs() {
            ui.add(egui::Label::new(RichText::new(name_of(app, id)).small()).truncate());
            let (value, error) = if !offset.is_determined() {
                (text::NONE.to_owned(), text::NONE.to_owned())
            } else {
                (
                    app.view.options.units.signed(offset.offset_m, 3),
                    app.view.options.units.spread(offset.standard_error_m, 3),
                )
            };
            ui.label(RichText::new(value).small());
            ui.label(RichText::new(error).small());
            ui.label(RichText::new(offset.log_overlaps.to_string()).small());
            ui.end_row();
        }
    });
    if found.groups() > 1 {
        remark(
            ui,
            format!(
                "The tracks form {} groups that never cross: heights can be compared within each group only.",
                found.groups()
            ),
        );
    }
    for text in app.height_contradictions() {
        warning(ui, context, &app.view.options.units.sentence(&text));
    }
}
