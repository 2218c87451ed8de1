//! Step 4: radius outlier removal, shown before anything goes.

use super::parts::{self, Knob, Section, fact, knob, section};
use crate::app::{Action, Command};
use crate::pipeline::Stage;
use crate::ui::{ViewContext, text};
use egui::Ui;

/// Draws the section.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: Some(4),
        title: "Outliers",
        stage: Some(Stage::Outliers),
    };
    section(ui, context, &heading, |ui, context| {
        removed(ui, context);
        controls(ui, context);
        preview(ui, context);
    });
}

fn removed(ui: &mut Ui, context: &ViewContext<'_>) {
    let Some(figures) = &context.app.log.figures else {
        parts::remark(ui, "No result yet.");
        return;
    };
    let outliers = figures.outliers;
    fact(
        ui,
        "Removed",
        "Side-scan points that the filter takes out, and their share of all side-scan points; in the paper it was about a tenth.",
        format!(
            "{} ({:.1} %; paper 10 %)",
            text::count(outliers.removed),
            100.0 * outliers.share()
        ),
    );
}

fn controls(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let outliers = context.app.log.settings.outliers.clone();
    let radius = Knob {
        name: "Radius",
        undo: "outlier radius",
        hint: "Radius of the sphere around a point; 3.011 m in the paper.",
        range: 0.1..=10.0,
        step: 0.001,
        decimals: 3,
        suffix: " m",
    };
    knob(ui, context, radius, outliers.radius_m, |settings, value| {
        settings.outliers.radius_m = value;
    });
    let neighbours = Knob {
        name: "Neighbours",
        undo: "outlier neighbours",
        hint: "A point stays when its sphere holds more than this many points, itself included; 10 in the paper.",
        range: 1.0..=100.0,
        step: 1.0,
        decimals: 0,
        suffix: "",
    };
    knob(
        ui,
        context,
        neighbours,
        outliers.min_neighbors as f64,
        |settings, value| {
            settings.outliers.min_neighbors = value.round().max(1.0) as usize;
        },
    );
}

fn preview(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::OutlierPreview;
    let mut on = context.app.options.cloud.outlier_preview;
    let toggle = ui.checkbox(&mut on, "Show what is removed in the cloud");
    if toggle
        .accessible_name(action.label())
        .on_hover_text(action.hint())
        .clicked()
    {
        context.push(Command::Do(action));
    }
}
