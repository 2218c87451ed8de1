//! The boxes against the truth, where it is known: the precision-recall curve that the least score
//! slider runs along, the list of mistakes, and what was taken for what.
//!
//! In: the state. Out: a curve, lists and a table, and commands.

mod curve;
mod matrix;
mod mistakes;

use super::super::parts::{remark, warning};
use super::super::section::{Section, section};
use crate::app::Action;
use crate::ui::{ViewContext, text};
use egui::Ui;

/// Draws the curve with the figures at the slider; nothing while there is no truth.
pub(super) fn at_slider(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let judging = &context.app.log.reviewing.judging;
    let (Some(comparison), Some(standing)) = (judging.comparison(), judging.standing()) else {
        return;
    };
    if comparison.unsearched() > 0 {
        let others = text::plural(comparison.unsearched(), "object", "objects");
        let text = format!(
            "The figures count the searched part; {others} of the known objects lie elsewhere."
        );
        warning(ui, context, &text);
    }
    curve::ui(ui, context, comparison, standing);
}

/// Draws the section of mistakes; nothing while there is no truth.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let judging = &app.log.reviewing.judging;
    let (Some(comparison), Some(standing)) = (judging.comparison(), judging.standing()) else {
        return;
    };
    section(ui, context, Section::new("Mistakes"), |ui, context| {
        let unsearched = comparison.unsearched();
        let counted = comparison.counted();
        let all = comparison.truth().objects.len() - unsearched;
        let source = judging.source().unwrap_or_default();
        let objects = text::plural(counted, "object", "objects");
        let mut text = format!("Against {source}: {objects}");
        if counted < all {
            text += &format!(", {} more are not visible and do not count", all - counted);
        }
        if unsearched > 0 {
            text += &format!(", {unsearched} more lie in unsearched parts");
        }
        remark(ui, text + ".");
        mistakes::ui(ui, context, comparison);
        matrix::ui(ui, context, comparison, standing);
        ui.horizontal(|ui| {
            super::button(ui, context, (Action::OpenTruth, "Open known objects…"));
            super::button(ui, context, (Action::ForgetTruth, "Close"));
        });
    });
}

/// `0.93`, or a dash where there is nothing to divide by.
fn share(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { text::NONE.to_owned() }
}
