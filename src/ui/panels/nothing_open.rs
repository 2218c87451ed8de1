//! Offers logs to open while none is: any log, the demo survey, the logs on cards and drives, and
//! those opened before.

use super::parts::remark;
use crate::app::{Action, CARDS_LISTED_EVERY, Command};
use crate::ui::{ViewContext, text};
use bathyscope_log::formats::{FoundLog, LogFolder, formats_to_open};
use bathyscope_log::support::calendar;
use egui::{Button, Label, Ui, vec2};
use std::path::Path;
use std::time::SystemTime;

/// Greatest number of offered folders on cards, of logs of each folder, and of logs opened before;
/// the dialog lists all.
const SHOWN: usize = 3;

/// Draws the offers.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.label("Nothing is open.");
    remark(ui, format!("Drop a log on the window, or open one: {}.", formats_to_open()));
    ui.add_space(4.0);
    for action in [Action::Open, Action::OpenDemo] {
        let button = Button::new(action.label()).min_size(vec2(180.0, 24.0));
        context.button(ui.add(button), action);
    }
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
    // No other event redraws the window when a card is inserted.
    ui.ctx().request_repaint_after(CARDS_LISTED_EVERY);
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
    let button = Button::new(words).truncate().min_size(vec2(180.0, 24.0));
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
