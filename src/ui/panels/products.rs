//! Step 6: what other programs open.

use super::parts;
use super::section::{Section, section};
use crate::app::Action;
use crate::ui::ViewContext;
use bathyscope_products::outputs::files_in_words;
use egui::Ui;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Products").step(6), |ui, context| {
        let action = Action::Export;
        let ready = context.app.log.products.is_some();
        let button = egui::Button::new(action.label()).min_size(egui::vec2(140.0, 22.0));
        let button = ui.add_enabled(ready, button);
        let button = button.on_disabled_hover_text("There are no results yet.");
        context.button(button, action);
        if ready && context.app.stale().is_some() {
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
    });
}
