//! Draws the survey: the contents of the log and its warnings; and the presets.

use super::parts::{fact, remark, warning};
use crate::app::Command;
use crate::ui::{ViewContext, controls, text};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::calendar;
use bathyscope_log::support::printable::one_line;
use bathyscope_log::survey::{SideScanState, Survey};
use bathyscope_products::pipeline::Preset;
use egui::Ui;

/// Greatest number of warnings that are shown at once; a damaged log can have thousands.
const WARNINGS_SHOWN: usize = 40;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if let Some(survey) = context.app.logs.shown.survey.clone() {
        summary(ui, context, &survey);
        warnings(ui, context, &survey);
        if context.app.logs.shown.settings.matching_preset() == Some(Preset::Published) {
            warning(ui, context, "The settings are those of the paper, whose depths are biased.");
        }
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

/// Draws a chip for each preset, and the name of the preset in force.
pub(super) fn preset(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let in_force = context.app.logs.shown.settings.matching_preset();
    ui.horizontal_wrapped(|ui| {
        for (preset, name, label, hint) in [
            (
                Preset::Recommended,
                "recommended",
                "recommended",
                "The settings with the smallest depth errors on simulated surveys.",
            ),
            (
                Preset::Published,
                "published",
                "as published (biased)",
                "The formulas of the paper (Pulido et al.), to reproduce its figures.",
            ),
        ] {
            let chip = controls::chip(ui, in_force == Some(preset), label);
            let chip = chip.accessible_name(format!("Preset {name}"));
            if chip.on_hover_text(hint).clicked() {
                context.push(Command::UsePreset(preset));
            }
        }
    });
    if in_force.is_none() {
        remark(
            ui,
            "Some settings differ from both; a click on a preset restores all of its settings.",
        );
    }
}
