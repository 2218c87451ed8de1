//! Step 4: radius outlier removal, shown before anything goes.

use super::parts::{self, fact};
use super::section::{Section, section};
use crate::app::Action;
use crate::ui::{ViewContext, text};
use bathyscope_products::pipeline::Stage;
use egui::Ui;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Outliers").step(4).of(Stage::Outliers), |ui, context| {
        removed(ui, context);
        parts::settings_of(ui, context, "Outliers");
        preview(ui, context);
    });
}

fn removed(ui: &mut Ui, context: &ViewContext<'_>) {
    let Some(figures) = &context.app.log.figures else {
        return parts::remark(ui, "No result yet.");
    };
    let classes = figures.classes;
    let hint = "Side-scan points that the filter removes, and their share; about 10 % in the paper (Pulido et al.).";
    let noise = text::count(classes.noise());
    let percent = 100.0 * classes.noise_share();
    let value = format!("{noise} ({percent:.1} %)");
    fact(ui, "Removed", hint, value);
}

fn preview(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::OutlierPreview;
    let mut on = context.options().cloud.outlier_preview;
    let toggle = ui.checkbox(&mut on, "Show unused points in 3D");
    context.named_button(toggle, action);
}
