//! What is known of water and transducer, and what it does to the depths.

use super::parts::{self, Knob, Section, knob, section};
use crate::app::{Action, Command};
use crate::pipeline::Settings;
use crate::pipeline::Stage;
use crate::ui::ViewContext;
use egui::Ui;

/// What a lake has in spring and autumn: where the slider begins.
const USUAL_C: f64 = 12.0;

/// Draws the section.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: None,
        title: "Depth correction",
        stage: Some(Stage::Cloud),
    };
    section(ui, context, &heading, |ui, context| {
        levels(ui, context);
        sound_speed(ui, context);
        if let Some(products) = &context.app.log.products {
            parts::remark(ui, products.correction.statement());
        }
    });
}

fn levels(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let [draft_m, level_m] = [
        context.app.log.settings.draft_m,
        context.app.log.settings.water_level_m,
    ];
    let draft = Knob {
        name: "Draft",
        undo: "draft",
        hint: "How deep the transducer hangs below the water's surface: added to every depth.",
        range: 0.0..=2.0,
        step: 0.01,
        decimals: 2,
        suffix: " m",
    };
    knob(ui, context, draft, draft_m, |settings, value| {
        settings.draft_m = value;
    });
    let level = Knob {
        name: "Water level",
        undo: "water level",
        hint: "Height of the water over the level that depths should count from: taken off every depth.",
        range: -5.0..=5.0,
        step: 0.01,
        decimals: 2,
        suffix: " m",
    };
    knob(ui, context, level, level_m, |settings, value| {
        settings.water_level_m = value;
    });
    let readings = context.app.log.settings.water_level.file.clone();
    parts::file(
        ui,
        context,
        "Readings",
        "Readings of the water's height over time; the water level above is that of their zero.",
        readings.as_deref(),
        [Action::OpenWaterLevels, Action::RemoveWaterLevels],
    );
}

fn sound_speed(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let speed = context.app.log.settings.sound_speed.clone();
    let known = speed.water_m_s().is_some();
    let mut wanted = known;
    let toggle = ui
        .checkbox(&mut wanted, "Correct the speed of sound")
        .on_hover_text(
            "Scales every range and depth by the speed of sound in this water over that which the recorder assumed.",
        );
    if toggle.changed() {
        let mut settings = Settings::clone(&context.app.log.settings);
        settings.sound_speed.m_s = None;
        settings.sound_speed.temperature_c = wanted.then_some(USUAL_C);
        context.push(Command::Change {
            settings: Box::new(settings),
            label: "sound speed",
            live: false,
        });
    }
    let Some(temperature_c) = speed.temperature_c.filter(|_| known) else {
        return;
    };
    let temperature = Knob {
        name: "Water",
        undo: "water temperature",
        hint: "Temperature of the water, which with salinity gives the speed of sound (Chen and Millero 1977).",
        range: 0.0..=40.0,
        step: 0.1,
        decimals: 1,
        suffix: " °C",
    };
    knob(
        ui,
        context,
        temperature,
        temperature_c,
        |settings, value| {
            settings.sound_speed.temperature_c = Some(value);
        },
    );
    let salinity = Knob {
        name: "Salinity",
        undo: "salinity",
        hint: "Practical salinity: 0 in fresh water, 35 in the ocean.",
        range: 0.0..=40.0,
        step: 0.5,
        decimals: 1,
        suffix: "",
    };
    knob(
        ui,
        context,
        salinity,
        speed.salinity_psu,
        |settings, value| {
            settings.sound_speed.salinity_psu = value;
        },
    );
    let recorder = Knob {
        name: "Recorder",
        undo: "recorder's sound speed",
        hint: "The speed of sound that the recorder computed ranges with: 1500 m/s in most, 1463 m/s in some for fresh water.",
        range: 1400.0..=1600.0,
        step: 1.0,
        decimals: 0,
        suffix: " m/s",
    };
    knob(
        ui,
        context,
        recorder,
        speed.recorder_m_s,
        |settings, value| {
            settings.sound_speed.recorder_m_s = value;
        },
    );
}
