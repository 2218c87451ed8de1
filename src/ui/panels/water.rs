//! Settings of water and transducer that correct the depths.

use super::parts::{self, setting};
use super::section::{Section, section};
use crate::app::Action;
use crate::ui::ViewContext;
use bathyscope_products::pipeline::Stage;
use bathyscope_products::pipeline::settings::rows;
use egui::Ui;

/// Initial temperature of the slider, °C: usual for a lake in spring and autumn.
const USUAL_C: f64 = 12.0;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Depth correction").of(Stage::Cloud), |ui, context| {
        levels(ui, context);
        sound_speed(ui, context);
        if let Some(products) = &context.app.log.products {
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
    let readings = context.app.log.settings.water_level.file.clone();
    let readings = readings.as_deref();
    let actions = [Action::OpenWaterLevels, Action::RemoveWaterLevels];
    parts::file(ui, context, &rows::WATER_LEVEL_FILE, readings, actions);
}

fn sound_speed(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let speed = context.app.log.settings.sound_speed.clone();
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
