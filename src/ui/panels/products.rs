//! Step 6: what other programs open.

use super::parts::{self, setting};
use super::section::{Section, section};
use crate::app::{Action, Command};
use crate::pipeline::settings::rows;
use crate::products::outputs::files_in_words;
use crate::ui::ViewContext;
use egui::Ui;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: Some(6),
        title: "Products",
        stage: None,
    };
    section(ui, context, &heading, |ui, context| {
        let action = Action::Export;
        let ready = context.app.log.products.is_some();
        let button = egui::Button::new(action.label()).min_size(egui::vec2(140.0, 22.0));
        let button = ui
            .add_enabled(ready, button)
            .on_hover_text(action.hint())
            .on_disabled_hover_text("There are no results yet.");
        if button.clicked() {
            context.push(Command::Do(action));
        }
        if ready && context.app.stale().is_some() {
            let text =
                "The last results are written; settings were changed since. Update results first.";
            parts::warning(ui, context, text);
        }
        if let Some((folder, files)) = context.app.out_of_date() {
            let text = format!(
                "Out of date in {}: {}",
                folder.display(),
                files_in_words(files.into_iter())
            );
            parts::warning(ui, context, &text);
        }
        setting(ui, context, &rows::CRS);
        setting(ui, context, &rows::POINTS_LAS);
        setting(ui, context, &rows::REPORT_PROPOSALS);
    });
}
