//! Step 4: radius outlier removal, shown before anything goes.

use super::parts::{self, fact, setting};
use super::section::{Section, section};
use crate::app::{Action, Command};
use crate::pipeline::Stage;
use crate::pipeline::settings::rows;
use crate::ui::{ViewContext, text};
use egui::Ui;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: Some(4),
        title: "Outliers",
        stage: Some(Stage::Outliers),
    };
    section(ui, context, &heading, |ui, context| {
        removed(ui, context);
        setting(ui, context, &rows::RADIUS);
        setting(ui, context, &rows::MIN_NEIGHBOURS);
        preview(ui, context);
    });
}

fn removed(ui: &mut Ui, context: &ViewContext<'_>) {
    let Some(figures) = &context.app.log.figures else {
        parts::remark(ui, "No result yet.");
        return;
    };
    let classes = figures.classes;
    fact(
        ui,
        "Removed",
        "Side-scan points that the filter removes, and their share; about 10 % in the paper (Pulido et al.).",
        format!(
            "{} ({:.1} %)",
            text::count(classes.noise()),
            100.0 * classes.noise_share()
        ),
    );
}

fn preview(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::OutlierPreview;
    let mut on = context.app.view.options.cloud.outlier_preview;
    let toggle = ui.checkbox(&mut on, "Show unused points in 3D");
    if toggle
        .accessible_name(action.label())
        .on_hover_text(action.hint())
        .clicked()
    {
        context.push(Command::Do(action));
    }
}
