//! Draws the status line: the place under the pointer, and the running work.
//!
//! The panel reads the state of the app, draws a line of text, and sends commands.

use super::parts::progress_bar;
use crate::app::{Action, App, FollowStatus, LogPlace};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::presentation::text::count;
use egui::{Align, Layout, RichText, Ui};

/// Time after which a running job is shown, seconds.
const PATIENCE_S: f64 = 0.4;

/// Least width of the right end with a job and its button, and without one, points, so that the
/// rest of the line stays in place while jobs start and end.
const JOB_ROOM: f32 = 330.0;
const REST_ROOM: f32 = 150.0;

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
        if context.app.logs.shown.survey.is_none() {
            return;
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
    let cells = cells_of(context.app, mark);
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let colour = ui.visuals().text_color();
    let gap = ui.spacing().item_spacing.x;
    let width = |text: &str| {
        let text = (ui.painter()).layout_no_wrap(text.to_owned(), font.clone(), colour);
        text.size().x + gap
    };
    let shown = fitting(&cells, room, width);
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
/// date on purpose; a press of this button is no drag.
fn stopped(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if !context.app.is_stopped() || ui.ctx().dragged_id().is_some() {
        return;
    }
    let action = Action::Update;
    context.button(ui.small_button(action.label()), action);
    let text = RichText::new("stopped before it was done").small();
    ui.label(text.color(theme::stale_colour(context.theme())));
}

/// One fact of a place.
struct StatusCell {
    /// Full text.
    text: String,
    /// Short text for a narrow bar; `None` if the full text is used there, too.
    short: Option<String>,
    /// Rank of importance: cells with the highest rank are left out first when the window becomes
    /// narrower.
    rank: u8,
}

impl StatusCell {
    fn new(rank: u8, text: String) -> Self {
        let short = None;
        Self { text, short, rank }
    }
}

/// Returns position, ping, range, altitude, depth, heading, speed and time of a place, in the order
/// of the bar.
fn cells_of(app: &App, mark: LogPlace) -> Vec<StatusCell> {
    let units = app.view.options.units;
    let survey = app.logs.shown.survey.as_ref();
    let Some(ping) = survey.and_then(|survey| survey.side_scan.get(mark.ping)) else {
        return Vec::new();
    };
    let position = place::lon_lat(app, mark).map(|at| StatusCell::new(0, place::written(app, at)));
    let range = place::range_m(app, mark).map(|range_m| {
        let side =
            mark.side.map_or_else(String::new, |side| format!(" {}", place::short_name(side)));
        StatusCell::new(2, format!("range {}{side}", units.measure(range_m, 2)))
    });
    let products = app.logs.shown.products.as_ref();
    let here = products.and_then(|products| products.navigation.pings.get(mark.ping));
    let speed = here.map_or(f64::NAN, |here| here.speed_mps);
    let start_unix_s = survey.and_then(|survey| survey.start_unix_s);
    let bottom = place::bottom(app, mark.ping);
    let metres = |of: fn(place::BottomBelow) -> f64| units.measure(bottom.map_or(f64::NAN, of), 2);
    let depth = StatusCell {
        text: format!("depth {}", place::depth(app, mark.ping)),
        short: Some(format!("depth {}", metres(|bottom| bottom.depth_m))),
        rank: 1,
    };
    let cells = [
        position,
        Some(StatusCell::new(4, format!("ping {}", mark.ping))),
        range,
        Some(StatusCell::new(3, format!("altitude {}", metres(|bottom| bottom.altitude_m)))),
        Some(depth),
        Some(StatusCell::new(6, place::labelled_heading(app, mark.ping))),
        Some(StatusCell::new(7, units.speed(speed, 1))),
        Some(StatusCell::new(5, text::clock(start_unix_s, ping.time_s))),
    ];
    cells.into_iter().flatten().collect()
}

/// Returns the texts that fit into `room`, in their order: all full texts, or all short ones, or
/// the short ones without the least important cells. `width` returns the width of a text with the
/// gap behind it.
fn fitting(cells: &[StatusCell], room: f32, width: impl Fn(&str) -> f32) -> Vec<&str> {
    let total = |texts: &[&str]| texts.iter().map(|text| width(text)).sum::<f32>();
    let full: Vec<&str> = cells.iter().map(|cell| cell.text.as_str()).collect();
    if total(&full) <= room {
        return full;
    }
    let last = cells.iter().map(|cell| cell.rank).max().unwrap_or(0);
    let upto = |rank: u8| -> Vec<&str> {
        let cells = cells.iter().filter(|cell| cell.rank <= rank);
        cells.map(|cell| cell.short.as_ref().unwrap_or(&cell.text).as_str()).collect()
    };
    let candidates = (0..=last).rev().map(upto);
    let mut fitting = candidates.filter(|texts| total(texts) <= room);
    fitting.next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_matters_least_gives_way_first() {
        let cells = [
            StatusCell::new(0, "position".to_owned()),
            StatusCell::new(2, "ping".to_owned()),
            StatusCell {
                text: "depth below transducer".to_owned(),
                short: Some("depth".to_owned()),
                rank: 1,
            },
            StatusCell::new(3, "speed".to_owned()),
        ];
        let shown = |room: f32| fitting(&cells, room, |text| text.len() as f32).join(" ");
        assert_eq!(shown(39.0), "position ping depth below transducer speed");
        assert_eq!(shown(38.0), "position ping depth speed");
        assert_eq!(shown(22.0), "position ping depth speed");
        assert_eq!(shown(21.0), "position ping depth");
        assert_eq!(shown(16.0), "position depth");
        assert_eq!(shown(12.0), "position");
        assert_eq!(shown(7.0), "", "nothing is cut off");
        assert!(fitting(&[], 10.0, |_| 1.0).is_empty());
    }
}
