//! Step 6: what other programs open.

use super::parts::{self, Section, section};
use crate::app::{Action, Command};
use crate::ui::ViewContext;
use egui::Ui;

/// Draws the section.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: Some(6),
        title: "Products",
        stage: None,
    };
    section(ui, context, &heading, |ui, context| {
        let action = Action::Export;
        let ready = context.app.products.is_some();
        let button = egui::Button::new(action.label()).min_size(egui::vec2(140.0, 22.0));
        let button = ui
            .add_enabled(ready, button)
            .on_hover_text(action.hint())
            .on_disabled_hover_text("There is no result to write yet.");
        if button.clicked() {
            context.push(Command::Do(action));
        }
        if ready && context.app.stale().is_some() {
            let text = "What is written are the last results, which are older than the settings.";
            parts::warning(ui, context, text);
        }
        parts::remark(
            ui,
            "Points, track, depth maps, isobaths and mosaic for other programs, each with its record",
        );
    });
}
