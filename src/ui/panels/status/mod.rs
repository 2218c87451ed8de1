//! Draws the status line: the place under the pointer, and the running work.
//!
//! The panel reads the state of the app, draws a line of text, and sends commands.

mod cells;

use crate::app::{Action, FollowStatus, LogPlace};
use crate::ui::panels::parts::progress_bar;
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::presentation::text::count;
use egui::{Align, Layout, RichText, Ui};

/// Time after which a running job is shown, seconds.
const PATIENCE_S: f64 = 0.4;

/// Least width of the right end with a job and its button, and without one, points, so that the
/// rest of the line stays in place while jobs start and end.
const JOB_ROOM: f32 = 330.0;
const REST_ROOM: f32 = 150.0;

/// Width for the place under the pointer that the right end leaves free before it shows frame rate
/// and colours, points.
const PLACE_ROOM: f32 = 560.0;

/// Draws the line: first the right end, then the place under the pointer in the remaining space.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let right_to_left = Layout::right_to_left(Align::Center);
    let width = ui.available_width();
    ui.with_layout(right_to_left, |ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        // A followed log is read four times a second: the line must not change each time.
        let follows = context.app.follow_status().is_some();
        let is_busy = follows || !context.app.is_idle() || context.app.is_stopped();
        let reserved = if is_busy { JOB_ROOM } else { REST_ROOM };
        notices(ui, context);
        jobs(ui, context);
        following(ui, context);
        if ui.available_width() > PLACE_ROOM {
            rest(ui, context);
        }
        let room = ui.available_width().min(width - reserved);
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 14.0;
            match context.app.view.hover.or(context.app.view.selection) {
                Some(mark) => place_under_pointer(ui, context, mark, room),
                None => {
                    ui.label(RichText::new("Nothing under the pointer").weak());
                }
            }
        });
    });
}

/// Draws the button that opens the list of notices.
fn notices(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::Notices;
    let count = context.app.notices.all().len();
    let title = RichText::new(format!("Notices {count}")).small();
    context.keyed_button(ui.button(title).accessible_name(action.label()), action);
}

/// Draws the facts of the place that fit into the available width; hovering shows all of them.
fn place_under_pointer(ui: &mut Ui, context: &ViewContext<'_>, mark: LogPlace, room: f32) {
    let cells = cells::of(context.app, mark);
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let colour = ui.visuals().text_color();
    let gap = ui.spacing().item_spacing.x;
    let width = |text: &str| {
        let text = (ui.painter()).layout_no_wrap(text.to_owned(), font.clone(), colour);
        text.size().x + gap
    };
    let shown = cells::fitting(&cells, room, width);
    let all: Vec<&str> = cells.iter().map(|cell| cell.text.as_str()).collect();
    let all = all.join("\n");
    for text in shown {
        let label = ui.add(egui::Label::new(RichText::new(text).monospace()));
        label.on_hover_text(&all);
    }
}

/// Draws the state of following, in words.
fn following(ui: &mut Ui, context: &ViewContext<'_>) {
    let Some(status) = context.app.follow_status() else {
        return;
    };
    let text = match status {
        FollowStatus::Starting => "following: copying the log".to_owned(),
        FollowStatus::Growing { pings, behind } => {
            let behind_s = behind.as_secs_f64();
            format!("following: {} pings, {behind_s:.1} s behind", count(pings))
        }
        FollowStatus::Silent { since } => {
            format!("following: no new pings for {} s", since.as_secs())
        }
        FollowStatus::Ending => "reading the log to its end".to_owned(),
    };
    let is_silent = matches!(status, FollowStatus::Silent { .. });
    let theme = context.theme();
    let colour = if is_silent { theme::stale_colour(theme) } else { theme::accent_colour(theme) };
    let label = ui.label(RichText::new(text).small().color(colour));
    label.on_hover_text(
        "New pings are shown with the calibration of the last run over the whole log; that run is repeated as the log grows, and at the end.",
    );
}

fn rest(ui: &mut Ui, context: &ViewContext<'_>) {
    // The rate is that of the last two consecutive frames; an idle window draws none.
    let rate = egui::Id::unique("frame rate");
    let frame_s = ui.input(|input| input.stable_dt);
    if frame_s < 0.1 {
        ui.data_mut(|data| data.insert_temp(rate, 1.0 / frame_s.max(1e-3)));
    }
    if let Some(fps) = ui.data(|data| data.get_temp::<f32>(rate)) {
        let shown = RichText::new(format!("{fps:.0} fps")).weak().small();
        ui.label(shown).on_hover_text("Frames a second when they last followed each other.");
    }
    let map = context.options().waterfall.colour_map.name();
    ui.label(RichText::new(map).weak().small());
}

fn jobs(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let since = egui::Id::unique("job since");
    let now = ui.input(|input| input.time);
    let Some((what, share)) = context.app.awaited() else {
        ui.data_mut(|data| data.remove::<f64>(since));
        return stopped(ui, context);
    };
    // Short jobs are not shown, because they would flicker.
    let started = ui.data_mut(|data| *data.get_temp_mut_or(since, now));
    if now - started < PATIENCE_S {
        return;
    }
    context.named_button(ui.small_button("Cancel"), Action::Cancel);
    let text = format!("{what} {:.0} %", f64::from(share) * 100.0);
    ui.add(progress_bar(context, share, 110.0));
    ui.label(RichText::new(text).small());
}

/// Offers to continue after processing was stopped. While a slider is dragged, results are out of
/// date on purpose.
fn stopped(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if !context.app.is_stopped() || ui.input(|input| input.pointer.any_down()) {
        return;
    }
    let action = Action::Update;
    context.button(ui.small_button(action.label()), action);
    let text = RichText::new("stopped before it was done").small();
    ui.label(text.color(theme::stale_colour(context.theme())));
}
