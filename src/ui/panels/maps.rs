//! How depth map, isobaths and mosaic are made: on the map and in the files.

use super::parts::setting;
use super::section::{Section, section};
use crate::app::{Action, Command, MapLayer};
use crate::pipeline::settings::rows;
use crate::ui::ViewContext;
use egui::Ui;

/// Draws the sections.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = |title| Section {
        number: None,
        title,
        stage: None,
    };
    section(ui, context, &heading("Depth map"), depth_map);
    section(ui, context, &heading("Mosaic"), mosaic);
}

/// Shows or hides a layer, and says which it is now.
fn layer_button(ui: &mut Ui, context: &mut ViewContext<'_>, layer: MapLayer, action: Action) {
    let shown = context.app.options.map.layers.is_visible(layer);
    let text = match shown {
        true => "Hide on the map",
        false => "Show on the map",
    };
    let button = ui.button(text).accessible_name(action.label());
    if button.on_hover_text(action.hint()).clicked() {
        context.push(Command::Do(action));
    }
}

fn depth_map(ui: &mut Ui, context: &mut ViewContext<'_>) {
    for row in [
        &rows::SURFACE_METHOD,
        &rows::SURFACE_CELL,
        &rows::MAX_GAP,
        &rows::SIDE_SCAN_WEIGHT,
        &rows::INTERVAL,
        &rows::SMOOTH,
    ] {
        setting(ui, context, row);
    }
}

fn mosaic(ui: &mut Ui, context: &mut ViewContext<'_>) {
    layer_button(ui, context, MapLayer::Mosaic, Action::MosaicLayer);
    for row in [
        &rows::OVERLAP,
        &rows::GAIN,
        &rows::MOSAIC_COLOURS,
        &rows::WATER_COLUMN,
        &rows::NADIR_GAP,
        &rows::MOST_TURN,
        &rows::MOSAIC_CELL,
    ] {
        setting(ui, context, row);
    }
}
