//! The waterfall view.

use crate::ui::{ViewContext, ViewRequest};

/// State of the waterfall view: where it looks.
#[derive(Default)]
pub struct WaterfallView {}

impl WaterfallView {
    /// Draws the view into all of `ui` and pushes what the analyst does in it.
    pub fn ui(&mut self, ui: &mut egui::Ui, _context: &mut ViewContext<'_>) {
        ui.label("waterfall");
    }

    /// Carries out a wish from menu, key or palette.
    pub fn request(&mut self, _request: ViewRequest) {}

    /// Whether everything on screen is drawn at its final quality.
    pub fn is_settled(&self) -> bool {
        true
    }
}

impl WaterfallView {
    /// Shows exactly these pings (`snapshot --pings`).
    pub fn show_pings(&mut self, _pings: std::ops::Range<usize>) {}
}
