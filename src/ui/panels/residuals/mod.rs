//! Differences between the points of the survey and a reference: statistics, their distribution,
//! and the quantities that they depend on.
//!
//! In: the state. Out: tables and histograms, and commands.

mod figures;
mod plots;
mod reference;

use super::parts;
use super::section::{Section, section};
use crate::app::{Action, App, Command, MapLayer};
use crate::ui::ViewContext;
use bathyscope_products::pipeline::Stage;
use egui::{Rect, Ui, vec2};
use plots::{HEIGHT, OVERS};

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Residuals").of(Stage::Outliers), |ui, context| {
        // Comparing costs a triangulation of all soundings: it waits until somebody looks.
        let place = Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), HEIGHT));
        if context.app.log.products.is_some() && ui.is_rect_visible(place) {
            context.push(Command::CompareWithReference);
        }
        reference::ui(ui, context);
        let Some(agreement) = context.app.agreement().cloned() else {
            return parts::remark(ui, lack(context.app));
        };
        let figures = context.app.log.figures.as_ref();
        let same_ping = figures
            .filter(|_| agreement.reference.is_none() && agreement.logs.len() == 1)
            .and_then(|figures| figures.residuals.as_ref());
        let units = context.units();
        figures::ui(ui, &agreement.comparison, same_ping, units);
        // Soundings of the same recorder prove no order.
        if agreement.reference.is_some() {
            figures::orders(ui, &agreement.comparison);
        }
        let id = egui::Id::unique("residuals over");
        let mut over = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        // Wrapped: a row that is wider than the panel would widen it when it comes into view.
        ui.horizontal_wrapped(|ui| {
            for (each, name, hint) in OVERS {
                ui.selectable_value(&mut over, each, name).on_hover_text(hint);
            }
        });
        ui.data_mut(|data| data.insert_temp(id, over));
        plots::picture(ui, &agreement.tables, over, context.options());
        let of = if agreement.reference.is_some() {
            "Elevation of the points minus that of the reference at their place"
        } else {
            "Elevation of side-scan points minus that of the soundings at their place"
        };
        parts::remark(ui, format!("{of}: above 0 is shallower."));
        on_map(ui, context);
    });
}

/// Reason why there is nothing to show.
fn lack(app: &App) -> &str {
    match app.agreement_problem() {
        _ if app.is_comparing_with_reference() => "Residuals are being compared.",
        Some(problem) => problem,
        None => "No side-scan point lies over the soundings.",
    }
}

/// Draws the switch that shows the residuals of single points on the map.
fn on_map(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let layers = &context.options().map.layers;
    let mut is_shown = layers.is_visible(MapLayer::Residuals);
    let check = ui.checkbox(&mut is_shown, "Residuals on the map");
    context.button_with_hint(check, Action::ResidualLayer, MapLayer::Residuals.hint());
}
