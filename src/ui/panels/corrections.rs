//! Draws the sections that correct the recording: the depths, by water and transducer, the
//! positions, by another receiver's track and by shifts and latencies, and the mounting.

use super::find_setting;
use super::parts::{self, fact, name_cell, name_of, press, press_short, remark, setting, warning};
use crate::app::{Action, App, Command, FoundPositions, JobKey};
use crate::ui::{ViewContext, text};
use bathyscope_bottom::bathymetry::position_offsets::FoundShift;
use bathyscope_log::survey::{HeadingSource, MountingSettings, SidePair, Survey, arm_in_words};
use bathyscope_products::pipeline::settings::{ControlValue, rows};
use egui::{RichText, TextEdit, Ui};

/// Initial temperature of the slider, °C: typical of a lake in spring and autumn.
const USUAL_C: f64 = 12.0;

/// Draws the section of the settings of water and transducer that correct the depths.
pub(super) fn depths(ui: &mut Ui, context: &mut ViewContext<'_>) {
    levels(ui, context);
    sound_speed(ui, context);
    if let Some(products) = &context.app.logs.shown.products {
        if let Some(text) = products.correction.gap_warning() {
            warning(ui, context, &context.units().sentence(&text));
        }
        for sentence in products.correction.sentences() {
            remark(ui, context.units().sentence(&sentence));
        }
    }
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

/// Draws the section of the mounting of the recorder on its boat, its default, the coordinate
/// system of positions in metres, and the shown frequency.
pub(super) fn mounting(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let Some(survey) = context.app.logs.shown.survey.clone() else {
        return;
    };
    parts::settings_of(ui, context, "Mounting");
    effect(ui, context, &survey);
    by_crossings(ui, context);
    sounding_lag(ui, context);
    usual(ui, context);
    if survey.track.projected.is_some() {
        system(ui, context, &survey);
    }
    if !survey.pairs.is_empty() {
        frequency(ui, context, &survey);
    }
}

/// Draws the effect of the settings, and a warning for each setting without effect.
fn effect(ui: &mut Ui, context: &ViewContext<'_>, survey: &Survey) {
    let settings = &context.app.logs.shown.settings;
    let mounting = &settings.mounting;
    if let Some(arm_m) = mounting.lever_arm_m() {
        let units = context.units();
        let arm = arm_in_words(arm_m, |metres| units.measure(metres, 2));
        remark(ui, format!("The transducer is {arm} of the antenna."));
    }
    if mounting.heading_offset_deg != 0.0 && settings.heading.source != HeadingSource::Compass {
        let text = "Headings do not come from the compass, so its offset has no effect.";
        warning(ui, context, text);
    }
    if mounting.clock_offset_s != 0.0 && survey.start_unix_s.is_none() {
        let text = "The log has no clock times, so a clock offset has no effect.";
        warning(ui, context, text);
    }
}

/// Draws the warnings about positions and depths that follow from the track's crossings with
/// itself.
fn by_crossings(ui: &mut Ui, context: &ViewContext<'_>) {
    let Some(products) = &context.app.logs.shown.products else {
        return;
    };
    let warnings = [products.latency_warning(), products.repeatability_warning()];
    for text in warnings.into_iter().flatten() {
        warning(ui, context, &context.units().sentence(&text));
    }
}

/// Draws the lag of the soundings that first returns show, with the button that applies it.
fn sounding_lag(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let Some((lag, _)) = context.app.logs.shown.sounding_lag() else {
        return;
    };
    let text = format!(
        "Soundings are late by {:.2} ± {:.2} s, as first returns over slopes show.",
        lag.lag_s, lag.standard_error_s
    );
    warning(ui, context, &text);
    context.named_button(ui.small_button("Apply the lag"), Action::ApplySoundingLag);
}

/// States whether the mounting is the default of the recorder, and draws the actions that change
/// this.
fn usual(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let recorder = app.logs.shown.recorder();
    let mounting = app.logs.shown.settings.mounting;
    let (said, actions): (_, &[Action]) = match app.usual_mounting() {
        Some(usual) if usual == mounting => {
            (format!("From the default of {recorder}."), &[Action::ForgetMounting])
        }
        Some(_) => (
            format!("Not the default of {recorder}."),
            &[Action::UseMounting, Action::ForgetMounting],
        ),
        None if mounting == MountingSettings::default() => {
            (format!("Recorder: {recorder}. It has no default."), &[])
        }
        None => (format!("Of this log alone. Recorder: {recorder}."), &[Action::UseMounting]),
    };
    remark(ui, said);
    if actions.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        for &action in actions {
            let label = match action {
                Action::UseMounting => "Make default",
                _ => "Remove default",
            };
            context.named_button(ui.small_button(label), action);
        }
    });
}

/// Draws the field for the coordinate system of positions in metres.
fn system(ui: &mut Ui, context: &mut ViewContext<'_>, survey: &Survey) {
    let row = &rows::SOURCE_CRS;
    let in_force = context.app.logs.shown.settings.source.crs.map(String::from);
    let in_force = in_force.unwrap_or_default();
    let typed = egui::Id::unique(("system of the log's metres", context.app.view.survey_serial));
    let mut text =
        ui.data(|data| data.get_temp::<String>(typed)).unwrap_or_else(|| in_force.clone());
    let field = ui
        .horizontal(|ui| {
            let label = name_cell(ui, row.label, row.hint);
            let field = TextEdit::singleline(&mut text)
                .hint_text("EPSG:32633")
                .desired_width(f32::INFINITY);
            let field = ui.add(field).labelled_by(label.id).on_hover_text(row.hint);
            find_setting::answer(ui, context, row.key, &field);
            field
        })
        .inner;
    if field.changed() {
        ui.data_mut(|data| data.insert_temp(typed, text.clone()));
    }
    if field.lost_focus() {
        ui.data_mut(|data| data.remove::<String>(typed));
        take_system(context, text.trim(), &in_force);
    }
    let projected = survey.track.projected.as_ref();
    match projected.and_then(|projected| projected.system.as_ref()) {
        Some(system) => remark(ui, format!("Positions are metres of {system}.")),
        None => warning(
            ui,
            context,
            "The log does not name the system of its positions, so they are drawn at longitude 0, latitude 0. Enter its EPSG number.",
        ),
    }
}

/// Draws the choice of the pair of side-scan channels that is shown.
fn frequency(ui: &mut Ui, context: &mut ViewContext<'_>, survey: &Survey) {
    let row = &rows::SOURCE_FREQUENCY;
    ui.horizontal_wrapped(|ui| {
        name_cell(ui, row.label, row.hint);
        let mut pairs: Vec<(usize, &SidePair)> = survey.pairs.iter().enumerate().collect();
        pairs.sort_by(|(_, a), (_, b)| a.name.cmp(&b.name));
        for (index, pair) in pairs {
            let is_shown = index == 0;
            let khz = pair.frequency_khz.map(f64::from);
            let button = ui.add_enabled_ui(khz.is_some(), |ui| {
                ui.selectable_label(is_shown, pair.summary()).on_hover_text(row.hint)
            });
            if button.inner.clicked() && !is_shown {
                context.set(row, ControlValue::Number(khz), false);
            }
        }
    });
}

/// Sets the typed coordinate system; a number alone is an EPSG code.
fn take_system(context: &mut ViewContext<'_>, typed: &str, in_force: &str) {
    if typed == in_force {
        return;
    }
    let row = &rows::SOURCE_CRS;
    if typed.is_empty() {
        return context.change(row.name, |settings| settings.source.crs = None);
    }
    let is_number = typed.bytes().all(|digit| digit.is_ascii_digit());
    let named = if is_number { format!("EPSG:{typed}") } else { typed.to_owned() };
    let assignment = format!("{}={named}", row.key);
    match context.app.logs.shown.settings.with_assignment(&assignment) {
        Ok(named) => context.change(row.name, |settings| *settings = named),
        Err(error) => context.push(Command::Notify(error.to_string())),
    }
}
