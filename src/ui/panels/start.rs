//! Draws the page that offers logs to open while none is: the dialog, the demo and its tour, the
//! logs on cards, and the logs that were opened before.

use super::parts::remark;
use crate::app::{Action, CARDS_LISTED_EVERY, Command};
use crate::ui::{ViewContext, text};
use bathyscope_log::formats::{FoundLog, LogFolder, formats_to_open};
use bathyscope_log::support::calendar;
use egui::{Button, Label, Rect, RichText, ScrollArea, Ui, UiBuilder, vec2};
use std::path::Path;
use std::time::SystemTime;

/// Greatest number of offered folders on cards, of logs of each folder, and of logs opened before;
/// the dialog lists all.
const SHOWN: usize = 3;

/// Width of the page, and of its buttons, points.
const PAGE: f32 = 420.0;
const BUTTON: f32 = 280.0;
/// Space above the page, as a share of the height of the window.
const ABOVE: f32 = 0.2;

/// Draws the page in the middle of the window.
pub(in crate::ui) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let area = ui.available_rect_before_wrap();
    let width = area.width().min(PAGE);
    let left = area.center().x - 0.5 * width;
    let page = Rect::from_x_y_ranges(left..=left + width, area.y_range());
    ui.scope_builder(UiBuilder::new().max_rect(page), |ui| {
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.add_space(ABOVE * area.height());
            ui.vertical_centered(|ui| offers(ui, context));
        });
    });
    // No other event redraws the window when a card is inserted.
    ui.ctx().request_repaint_after(CARDS_LISTED_EVERY);
}

fn offers(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.label(RichText::new("Open the log that your recorder wrote on its card").heading().strong());
    ui.label("or drop it on this window.");
    ui.add_space(12.0);
    for action in [Action::Open, Action::OpenDemo, Action::Tour] {
        let button = Button::new(action.label()).min_size(vec2(BUTTON, 28.0));
        context.button(ui.add(button), action);
    }
    ui.add_space(12.0);
    remark(ui, format!("Formats: {}.", formats_to_open()));
    let app = context.app;
    for folder in app.card_search.folders().into_iter().take(SHOWN) {
        on_card(ui, context, folder);
    }
    if !app.recent.is_empty() {
        ui.add_space(8.0);
        ui.label("Opened before");
    }
    for path in app.recent.iter().take(SHOWN) {
        offer(ui, context, name(path), path, || Command::Open(path.clone()));
    }
}

/// Draws the newest logs of a folder, and a button for all of them.
fn on_card(ui: &mut Ui, context: &mut ViewContext<'_>, folder: &LogFolder) {
    ui.add_space(8.0);
    let words = format!("On {}", folder.on_card.display());
    ui.add(Label::new(words).truncate()).on_hover_text(folder.path.display().to_string());
    for log in folder.logs.iter().take(SHOWN) {
        let words = match written(log) {
            Some(day) => format!("{}  ·  {day}", name(&log.path)),
            None => name(&log.path),
        };
        offer(ui, context, words, &log.path, || Command::OpenAll(vec![log.path.clone()]));
    }
    if folder.logs.len() > 1 {
        let words = format!("All {}", text::plural(folder.logs.len(), "log", "logs"));
        let all = || folder.logs.iter().map(|log| log.path.clone()).collect();
        offer(ui, context, words, &folder.path, || Command::OpenAll(all()));
    }
}

fn offer(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    words: String,
    path: &Path,
    command: impl FnOnce() -> Command,
) {
    let button = Button::new(words).truncate().min_size(vec2(BUTTON, 24.0));
    let response = ui.add(button).on_hover_text(path.display().to_string());
    if response.clicked() {
        context.push(command());
    }
}

fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Returns the day on which a log was last written, by the file system of the drive.
fn written(log: &FoundLog) -> Option<String> {
    let since = log.written?.duration_since(SystemTime::UNIX_EPOCH).ok()?;
    Some(calendar::date(since.as_secs_f64()))
}
