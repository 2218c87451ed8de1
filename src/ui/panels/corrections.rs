//! Draws the sections that correct the recording: the depths, by water and transducer, and the
//! positions, by another receiver's track and by shifts and latencies.

use super::parts::{self, fact, name_of, press, press_short, remark, setting};
use super::section::{Section, section};
use crate::app::{Action, App, FoundPositions, JobKey};
use crate::ui::{ViewContext, text};
use bathyscope_bottom::bathymetry::position_offsets::FoundShift;
use bathyscope_products::pipeline::Stage;
use bathyscope_products::pipeline::settings::rows;
use egui::{RichText, Ui};

/// Initial temperature of the slider, °C: typical of a lake in spring and autumn.
const USUAL_C: f64 = 12.0;

/// Draws the section of the settings of water and transducer that correct the depths.
pub(super) fn depths(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Depth correction").of(Stage::Cloud), |ui, context| {
        levels(ui, context);
        sound_speed(ui, context);
        if let Some(products) = &context.app.logs.shown.products {
            if let Some(text) = products.correction.gap_warning() {
                parts::warning(ui, context, &context.units().sentence(&text));
            }
            for sentence in products.correction.sentences() {
                parts::remark(ui, context.units().sentence(&sentence));
            }
        }
    });
}

fn levels(ui: &mut Ui, context: &mut ViewContext<'_>) {
    setting(ui, context, &rows::DRAFT);
    setting(ui, context, &rows::WATER_LEVEL);
    let readings = context.app.logs.shown.settings.water_level.file.clone();
    let readings = readings.as_deref();
    let actions = [Action::OpenWaterLevels, Action::RemoveWaterLevels];
    parts::file(ui, context, &rows::WATER_LEVEL_FILE, readings, actions);
}

fn sound_speed(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let speed = context.app.logs.shown.settings.sound_speed.clone();
    let known = speed.water_m_s().is_some();
    let mut requested = known;
    let toggle = ui.checkbox(&mut requested, "Correct the speed of sound").on_hover_text(
        "Multiplies ranges and depths by the ratio of this sound speed to that of the recorder.",
    );
    if toggle.changed() {
        context.change("sound speed", |settings| {
            settings.sound_speed.m_s = None;
            settings.sound_speed.temperature_c = requested.then_some(USUAL_C);
        });
    }
    if known && speed.temperature_c.is_some() {
        for row in [&rows::TEMPERATURE, &rows::SALINITY, &rows::RECORDER_SPEED] {
            setting(ui, context, row);
        }
    }
}

/// Draws the section of the positions: the track of another receiver, the offset of its clock, and
/// the shifts of all positions.
pub(super) fn positions(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Position").of(Stage::Navigation), |ui, context| {
        let path = context.app.logs.shown.settings.track.file.clone();
        let actions = [Action::OpenTrack, Action::RemoveTrack];
        parts::file(ui, context, &rows::TRACK_FILE, path.as_deref(), actions);
        match path {
            Some(_) => clock(ui, context),
            None => remark(ui, "Positions are those of the recorder."),
        }
        for row in [&rows::SHIFT_EAST, &rows::SHIFT_NORTH] {
            setting(ui, context, row);
        }
        // With several logs, their positions are compared in the list of logs.
        if context.app.logs.count() == 1 {
            shifts(ui, context);
        }
    });
}

/// Draws the offset of the clock, and the distance between the tracks that results from it.
fn clock(ui: &mut Ui, context: &mut ViewContext<'_>) {
    setting(ui, context, &rows::TRACK_OFFSET);
    let apart = &context.app.logs.shown.external.apart;
    if !apart.pairs.is_empty() {
        let hint = "Median distance between the positions of recorder and receiver at the same times: \
                    smallest where their clocks agree.";
        let apart = context.units().measure(apart.median_m, 2);
        let text = format!("{apart} from the recorder's");
        fact(ui, "Lies", hint, text);
    }
    remark(
        ui,
        "The map shows the recorder's track as a thin line; short lines join positions of the same time.",
    );
}

/// Draws the buttons for shifts and latencies of the positions of the logs, and the results.
pub(super) fn shifts(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    ui.horizontal(|ui| {
        let can_compare = !app.jobs.is_running(&JobKey::ComparePositions);
        press(ui, context, Action::ComparePositions, can_compare);
        let tells = app.findings.positions.as_ref().is_some_and(FoundPositions::tells);
        press_short(ui, context, (Action::ApplyPositions, "Apply"), tells);
        if app.jobs.is_running(&JobKey::ComparePositions) {
            ui.add(egui::Spinner::new().size(12.0));
        }
    });
    let Some(found) = app.findings.positions.as_ref() else {
        return;
    };
    table(ui, app, found);
    if !found.tells() {
        remark(ui, FoundPositions::NOTHING_TOLD);
    }
}

const SHIFT_COLUMNS: [(&str, &str); 6] = [
    ("Log", ""),
    ("east", "Shift of its positions to the east."),
    ("north", "Shift of its positions to the north."),
    ("\u{b1}", "Standard error of both shifts; about 2 m where no crossing shows them."),
    ("late, s", "How much later its positions are than its echoes, seconds."),
    ("\u{b1} s", "Standard error of the latency; about 1 s where no crossing shows it."),
];

fn table(ui: &mut Ui, app: &App, found: &FoundPositions) {
    parts::table(ui, "positions", &SHIFT_COLUMNS, |ui| {
        for (id, log) in &found.logs {
            let name = RichText::new(name_of(app, *id)).small();
            ui.add(egui::Label::new(name).truncate());
            for value in values(app, &log.found) {
                ui.label(RichText::new(value).small());
            }
            ui.end_row();
        }
    });
}

fn values(app: &App, found: &FoundShift) -> [String; 5] {
    let units = app.view.options.units;
    let of = |error: f64, value: &dyn Fn() -> String| {
        if error.is_nan() { text::NONE.to_owned() } else { value() }
    };
    let (shift_m, error_m, error_s) = (&found.shift, found.shift_error_m, found.latency_error_s);
    [
        of(error_m, &|| units.signed(shift_m.east_m, 2)),
        of(error_m, &|| units.signed(shift_m.north_m, 2)),
        of(error_m, &|| units.spread(error_m, 2)),
        of(error_s, &|| format!("{:+.2}", shift_m.latency_s)),
        of(error_s, &|| format!("{error_s:.2}")),
    ]
}
