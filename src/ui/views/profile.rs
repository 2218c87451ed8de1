//! One ping as a curve: raw and normalised intensity, threshold, dead zone and picks.

use crate::ui::ViewContext;

/// State of the profile.
#[derive(Default)]
pub struct ProfileView {}

impl ProfileView {
    /// Draws the profile of the hovered ping, or else the selected one.
    pub fn ui(&mut self, ui: &mut egui::Ui, _context: &mut ViewContext<'_>) {
        ui.label("profile");
    }
}
