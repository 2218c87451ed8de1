//! Draws the settings of depth map, isobaths and mosaic, which apply to the map and the files, and
//! the section that writes the files.

use super::parts::{self, fact};
use crate::app::{Action, MapLayer};
use crate::ui::ViewContext;
use bathyscope_bottom::bathymetry::{FromLevels, LevelsRefused, Surface};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::outputs::files_in_words;
use bathyscope_products::pipeline::settings::rows;
use egui::Ui;

/// Title of a section.
pub(super) const DEPTH_MAP: &str = "Depth map";
/// Title of a section.
pub(super) const ISOBATHS: &str = "Isobaths";
/// Title of a section.
pub(super) const MOSAIC: &str = "Mosaic";

/// Draws the button that shows or hides a layer.
fn layer_button(ui: &mut Ui, context: &mut ViewContext<'_>, layer: MapLayer, action: Action) {
    let shown = context.options().map.layers.is_visible(layer);
    let text = if shown { "Hide on the map" } else { "Show on the map" };
    context.named_button(ui.button(text), action);
}

/// Draws the settings of the depth map, and its worth.
pub(super) fn depth_map(ui: &mut Ui, context: &mut ViewContext<'_>) {
    parts::settings_of(ui, context, DEPTH_MAP);
    worth(ui, context);
}

/// Draws the settings of isobaths.
pub(super) fn isobaths(ui: &mut Ui, context: &mut ViewContext<'_>) {
    layer_button(ui, context, MapLayer::Isobaths, Action::IsobathLayer);
    parts::settings_of(ui, context, ISOBATHS);
    let area = context.app.logs.shown.settings.isobaths.clip.clone();
    let actions = [Action::OpenIsobathArea, Action::RemoveIsobathArea];
    parts::file(ui, context, &rows::CLIP, area.as_deref(), actions);
}

/// Draws the method of interpolation between depths, and the errors of the interpolated depths if
/// they are known.
fn worth(ui: &mut Ui, context: &ViewContext<'_>) {
    let Some(map) = context.app.depth_map().flatten() else {
        return;
    };
    let hint = "Method that gives the depths between measured ones.";
    fact(ui, "Method", hint, map.surface.method.in_words());
    let hint = "Whether depths between the lines are interpolated, follow the slopes on the lines, or come from echo levels where these predict withheld soundings.";
    let units = context.units();
    fact(ui, "Between lines", hint, between_lines(&map.surface));
    if let Some(text) = withheld_errors(&map.surface, units) {
        let hint = "What withheld soundings are missed by: as said above, and by straight lines between depths alone.";
        fact(ui, "Withheld", hint, text);
    }
    if let Some([half_m, most_m]) = map.usual_error_m {
        let units = context.units();
        let hint = "Standard deviation of mapped depths, from withheld depths: the median, and what 90 % of the map do not exceed.";
        let [half, most] = [half_m, most_m].map(|sigma_m| units.spread(sigma_m, 2));
        let text = format!("±{half} to ±{most} {}", units.symbol());
        fact(ui, "Error", hint, text);
    }
}

/// Describes the source of the depths between the survey lines.
fn between_lines(surface: &Surface) -> String {
    match surface.levels {
        FromLevels::Used { .. } => "from echo levels".to_owned(),
        _ if surface.bends.is_some() => "by the slopes on the lines".to_owned(),
        FromLevels::Refused(LevelsRefused::NoBetter { .. }) => "interpolated".to_owned(),
        FromLevels::Off | FromLevels::Refused(_) => surface.levels.to_string(),
    }
}

/// Returns the errors at withheld soundings, with and without the method for depths between the
/// lines, if both were tried: `0.06 m, 0.08 m without`.
fn withheld_errors(surface: &Surface, units: Units) -> Option<String> {
    let [without_m, with_m] = match (surface.levels, surface.bends) {
        (FromLevels::Used { left_out_m }, _) => left_out_m?,
        (_, Some(bends)) => bends.left_out_m,
        (FromLevels::Refused(LevelsRefused::NoBetter { without_m, with_m }), None) => {
            [without_m, with_m]
        }
        (FromLevels::Off | FromLevels::Refused(_), None) => return None,
    };
    let [without, with] = [without_m, with_m].map(|error_m| units.spread(error_m, 2));
    Some(format!("{with} {}, {without} without", units.symbol()))
}

/// Draws the settings of the mosaic.
pub(super) fn mosaic(ui: &mut Ui, context: &mut ViewContext<'_>) {
    layer_button(ui, context, MapLayer::Mosaic, Action::MosaicLayer);
    parts::settings_of(ui, context, MOSAIC);
}

/// Draws the section of the files for other programs.
pub(super) fn products(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::Export;
    let ready = context.app.logs.shown.products.is_some();
    let button = egui::Button::new(action.label()).min_size(egui::vec2(140.0, 22.0));
    let button = ui.add_enabled(ready, button);
    let button = button.on_disabled_hover_text("There are no results yet.");
    context.button(button, action);
    if ready && context.app.logs.shown.stale().is_some() {
        let text =
            "The last results are written; settings were changed since. Update results first.";
        parts::warning(ui, context, text);
    }
    if let Some((folder, files)) = context.app.out_of_date() {
        let folder = folder.display();
        let files = files_in_words(files.into_iter());
        let text = format!("Out of date in {folder}: {files}");
        parts::warning(ui, context, &text);
    }
    parts::settings_of(ui, context, "Products");
}
