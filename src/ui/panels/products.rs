//! Step 6: what other programs open.

use super::parts::{self, setting};
use super::section::{Section, section};
use crate::app::{Action, Command};
use crate::outputs::{OUTPUT_FILES, Product, When, files_in_words};
use crate::pipeline::settings::rows;
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
        let ready = context.app.log.products.is_some();
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
        if let Some((folder, files)) = context.app.out_of_date() {
            let text = format!(
                "Older than the settings in {}: {}",
                folder.display(),
                files_in_words(files.into_iter())
            );
            parts::warning(ui, context, &text);
        }
        setting(ui, context, &rows::CRS);
        groups(ui, context);
        setting(ui, context, &rows::POINTS_LAS);
        setting(ui, context, &rows::REPORT_PROPOSALS);
        parts::remark(
            ui,
            "manifest.json says of each: inputs, settings, system, extent.",
        );
    });
}

/// What is written: a box to tick for each group of files.
fn groups(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut options = context.app.options.clone();
    ui.horizontal_wrapped(|ui| {
        for product in Product::ALL {
            let mut files = product.files();
            if product == Product::Residuals && context.app.comparing.reference.is_some() {
                let compared = OUTPUT_FILES.iter().filter(|row| row.when == When::Compared);
                files = format!("{files}; {}", files_in_words(compared));
            }
            let mut requested = !options.left_out.contains(&product);
            if ui
                .checkbox(&mut requested, product.name())
                .on_hover_text(files)
                .clicked()
            {
                match requested {
                    true => options.left_out.retain(|one| *one != product),
                    false => options.left_out.push(product),
                }
            }
        }
    });
    if options.left_out != context.app.options.left_out {
        context.push(Command::Show(Box::new(options)));
    }
}
