//! Draws the survey: the contents of the log, its warnings, and the preset in force; or offers logs
//! to open while none is.

use super::parts::{fact, remark, warning};
use crate::app::{Action, CARDS_LISTED_EVERY, Command};
use crate::ui::{ViewContext, controls, text};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::formats::{FoundLog, LogFolder, formats_to_open};
use bathyscope_log::support::calendar;
use bathyscope_log::support::printable::one_line;
use bathyscope_log::survey::{SideScanState, Survey};
use bathyscope_products::pipeline::Preset;
use egui::{Button, Label, Ui, vec2};
use std::path::Path;
use std::time::SystemTime;

/// Greatest number of warnings that are shown at once; a damaged log can have thousands.
const WARNINGS_SHOWN: usize = 40;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    match context.app.logs.shown.survey.clone() {
        Some(survey) => {
            summary(ui, context, &survey);
            warnings(ui, context, &survey);
            preset_line(ui, context);
        }
        None => nothing_open(ui, context),
    }
}

fn summary(ui: &mut Ui, context: &ViewContext<'_>, survey: &Survey) {
    let name = survey.source.files.first().map_or_else(
        || survey.name(),
        |file| file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    );
    let title = ui.add(egui::Label::new(egui::RichText::new(name).heading().strong()).truncate());
    title.on_hover_ui(|ui| {
        for file in &survey.source.files {
            ui.label(file.display().to_string());
        }
    });
    channels(ui, survey, context.units());
    let span = time_span(survey);
    let pings = survey.side_scan.len();
    let length = span.map_or(text::NONE.to_owned(), |(from, to)| text::duration(to - from));
    let hint = "Side-scan pings, and the time that they cover.";
    let value = match pings {
        0 => "none".to_owned(),
        _ => format!("{} · {length}", text::plural(pings, "ping", "pings")),
    };
    fact(ui, "Side-scan", hint, value);
    let hint =
        "Depths that the recorder found, below the transducer; repeated ones are not counted.";
    fact(ui, "Soundings", hint, soundings(context, survey));
    let faults = context.app.logs.shown.figures.as_ref().map(|figures| figures.faults);
    if let Some(faults) = faults.filter(|faults| faults.all() > 0) {
        let hint = "Soundings with a fault, by its kind. They are drawn faded, and count only where a first return confirms them.";
        fact(ui, "False soundings", hint, faults.summary());
    }
    if let (Some(start), Some((from, _))) = (survey.start_unix_s, span) {
        let hint = "Start of the log by the recorder's clock, corrected by the clock offset.";
        let day = calendar::date(start + from);
        let clock = text::clock(Some(start), from);
        let value = format!("{day} {}", clock.trim_end_matches(" UTC"));
        fact(ui, "Start, UTC", hint, value);
    }
    state_line(ui, context, survey);
}

fn time_span(survey: &Survey) -> Option<(f64, f64)> {
    match (survey.side_scan.first(), survey.side_scan.last()) {
        (Some(first), Some(last)) => Some((first.time_s, last.time_s)),
        _ => Some((survey.soundings.first()?.time_s, survey.soundings.last()?.time_s)),
    }
}

fn soundings(context: &ViewContext<'_>, survey: &Survey) -> String {
    let count = text::count(survey.soundings.len());
    match context.app.logs.shown.depth_span_m {
        _ if survey.soundings.is_empty() => "none".to_owned(),
        None => format!("{count} · bottom never found"),
        Some([low, high]) => {
            let span = context.units().span([low, high].map(f64::from), 1);
            format!("{count} · {span}")
        }
    }
}

/// Draws format and size; hovering shows every channel of the log.
fn channels(ui: &mut Ui, survey: &Survey, units: Units) {
    let format = &survey.source.format;
    let bytes = text::bytes(survey.source.byte_count);
    let channels = text::plural(survey.channels.len(), "channel", "channels");
    let line = format!("{format} · {bytes} · {channels}");
    let shown = egui::Label::new(egui::RichText::new(line).small().weak());
    let shown = ui.add(shown.truncate());
    shown.on_hover_ui(|ui| {
        for channel in &survey.channels {
            let khz = channel.frequency_khz;
            let frequency = khz.map_or(String::new(), |khz| format!(", {khz:.0} kHz"));
            let range = channel.range_m.map_or(String::new(), |(near, far)| {
                format!(", {}", units.span([near, far].map(f64::from), 1))
            });
            let (kind, name) = (channel.kind.name(), one_line(&channel.recorder_name));
            let pings = text::plural(channel.ping_count, "ping", "pings");
            ui.label(format!("{kind} ({name}): {pings}{frequency}{range}"));
        }
    });
}

fn state_line(ui: &mut Ui, context: &ViewContext<'_>, survey: &Survey) {
    let units = context.units();
    match survey.side_scan_state {
        SideScanState::Usable => {}
        SideScanState::Absent => warning(
            ui,
            context,
            "no side-scan in this log: depths and track only; record sl2 or sl3 with side-scan on",
        ),
        SideScanState::Noise { range_m } => warning(
            ui,
            context,
            &format!(
                "no side-scan: range ±{}, noise; was a transducer connected?",
                units.measure(f64::from(range_m), 1)
            ),
        ),
    }
}

fn warnings(ui: &mut Ui, context: &ViewContext<'_>, survey: &Survey) {
    let count = survey.warnings.len();
    if count == 0 {
        return;
    }
    let title = text::plural(count, "warning", "warnings");
    egui::CollapsingHeader::new(title).id_salt("warnings of the log").show(ui, |ui| {
        for log_warning in survey.warnings.iter().take(WARNINGS_SHOWN) {
            let place = log_warning.place.map_or(String::new(), |(file, offset)| {
                let name = survey.source.files.get(file);
                let name = name.and_then(|file| file.file_name()).unwrap_or_default();
                let name = name.to_string_lossy();
                let offset = text::count(offset as usize);
                format!(" ({name} byte {offset})")
            });
            let said = context.units().sentence(&log_warning.text);
            warning(ui, context, &format!("{said}{place}"));
        }
        if count > WARNINGS_SHOWN {
            remark(ui, format!("and {} more", text::count(count - WARNINGS_SHOWN)));
        }
    });
}

fn preset_line(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let in_force = context.app.logs.shown.settings.matching_preset();
    ui.add_space(2.0);
    ui.horizontal_wrapped(|ui| {
        ui.add(egui::Label::new("Preset").selectable(false));
        for (preset, label, hint) in [
            (
                Preset::Recommended,
                "recommended",
                "The settings with the smallest depth errors on simulated surveys.",
            ),
            (
                Preset::Published,
                "published",
                "The formulas of the paper (Pulido et al.), to reproduce its figures.",
            ),
        ] {
            let chip = controls::chip(ui, in_force == Some(preset), label);
            let chip = chip.accessible_name(format!("Preset {label}"));
            if chip.on_hover_text(hint).clicked() {
                context.push(Command::UsePreset(preset));
            }
        }
        if in_force.is_none() {
            let colour = crate::ui::theme::stale_colour(context.theme());
            ui.colored_label(colour, "changed").on_hover_text(
                "Some settings differ from the preset; a click on a preset restores all of its settings.",
            );
        }
    });
}

/// Greatest number of offered folders on cards, of logs of each folder, and of logs opened before;
/// the dialog lists all.
const SHOWN: usize = 3;

/// Draws the offers.
fn nothing_open(ui: &mut Ui, context: &mut ViewContext<'_>) {
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
