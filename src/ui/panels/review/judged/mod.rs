//! Draws the comparison of the boxes with the truth, if it is known: the precision-recall curve
//! with the point of the slider, the list of mistakes, and the confusion matrix.
//!
//! The panel reads the state of the app, draws a curve, lists and a table, and sends commands.

mod curve;
mod matrix;

use super::super::parts::{list_rows, remark, row, warning};
use super::super::section::{Section, section};
use crate::app::{Action, Command, MistakeSort};
use crate::ui::drop_down::DropDown;
use crate::ui::{ViewContext, text, theme};
use bathyscope_objects::metrics::Cause;
use bathyscope_objects::truth::{Mistake, TruthComparison};
use egui::{Button, RichText, Ui};

/// Draws the curve with the figures at the slider; draws nothing without truth.
pub(super) fn at_slider(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let judging = &context.app.logs.shown.reviewing.judging;
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

/// Draws the section of mistakes; draws nothing without truth.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let judging = &app.logs.shown.reviewing.judging;
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
        list_of_mistakes(ui, context, comparison);
        matrix::ui(ui, context, comparison, standing);
        ui.horizontal(|ui| {
            super::button(ui, context, (Action::OpenTruth, "Open known objects…"));
            super::button(ui, context, (Action::ForgetTruth, "Close"));
        });
    });
}

/// Draws the list of false alarms and missed objects, the choice of its order, and the buttons that
/// step through it.
fn list_of_mistakes(ui: &mut Ui, context: &mut ViewContext<'_>, comparison: &TruthComparison) {
    let reviewing = &context.app.logs.shown.reviewing;
    let mistakes = reviewing.judging.mistakes();
    if mistakes.is_empty() {
        return remark(ui, "No mistake from this score on.");
    }
    let mut sort = reviewing.judging.sort();
    let before = sort;
    row(ui, "Sort by", "The order of the list.", |ui| {
        DropDown::new("sort mistakes", sort.name()).width(ui.available_width() - 2.0).pick(
            ui,
            &mut sort,
            MistakeSort::ALL,
            MistakeSort::name,
        )
    });
    if sort != before {
        context.push(Command::SortMistakes(sort));
    }
    ui.horizontal(|ui| {
        super::button(ui, context, (Action::PreviousMistake, "Previous"));
        super::button(ui, context, (Action::NextMistake, "Next"));
    });
    list(ui, context, comparison, mistakes);
}

/// Draws the rows: a click, or Enter on a row, shows the place in all views.
fn list(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    comparison: &TruthComparison,
    mistakes: &[Mistake],
) {
    let here = context.app.logs.shown.reviewing.mistake_at();
    list_rows(ui, "mistakes", mistakes.len(), here, |ui, index| {
        let mistake = mistakes.get(index)?;
        let label = mistake_text(context, comparison, mistake);
        let colour = colour(context, mistake);
        let shown = RichText::new(&label).color(colour);
        let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
        let button = Button::selectable(here == Some(index), shown).min_size(size);
        let row = ui.add(button);
        if row.clicked() {
            context.push(Command::ShowMistake(*mistake));
        }
        Some(row)
    });
}

/// Returns the text of a mistake: `rock 0.87, background, 1.2 m` or `missed tyre, 0.8 m`.
fn mistake_text(
    context: &ViewContext<'_>,
    comparison: &TruthComparison,
    mistake: &Mistake,
) -> String {
    let size = context.units().measure(mistake.size_m(), 1);
    match mistake {
        Mistake::FalseAlarm { id, score, cause, .. } => {
            let review = &context.app.logs.shown.reviewing.review;
            let class =
                review.get(*id).map_or("", |review_box| review.class_name(review_box.class));
            let cause = match cause {
                Cause::Background => "nothing there",
                Cause::Duplicate => "found twice",
                Cause::OtherClass => "another class",
                Cause::Loose => "overlaps too little",
            };
            format!("{class} {score:.2}, {cause}, {size}")
        }
        Mistake::Miss { object, .. } => {
            let truth = comparison.truth();
            let known = truth.objects.get(*object);
            let class = known.map_or("", |known| truth.class_name(known.class));
            format!("missed {class}, {size}")
        }
    }
}

fn colour(context: &ViewContext<'_>, mistake: &Mistake) -> egui::Color32 {
    let look = context.theme();
    match mistake {
        Mistake::FalseAlarm { id, .. } => {
            let found = context.app.logs.shown.reviewing.review.get(*id);
            let state = found
                .map_or(bathyscope_objects::review::State::Proposed, |review_box| review_box.state);
            theme::box_colour_on_panel(look, state)
        }
        Mistake::Miss { .. } => theme::missed_colour_on_panel(look),
    }
}

/// Returns a share as text: `0.93`, or a dash if it is not finite.
fn share(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { text::NONE.to_owned() }
}
