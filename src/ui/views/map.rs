//! The map view.

use crate::ui::{ViewContext, ViewRequest};

/// State of the map view: where it looks.
#[derive(Default)]
pub struct MapView {}

impl MapView {
    /// Draws the view into all of `ui` and pushes what the analyst does in it.
    pub fn ui(&mut self, ui: &mut egui::Ui, _context: &mut ViewContext<'_>) {
        ui.label("map");
    }

    /// Carries out a wish from menu, key or palette.
    pub fn request(&mut self, _request: ViewRequest) {}

    /// Whether everything on screen is drawn at its final quality.
    pub fn is_settled(&self) -> bool {
        true
    }
}
