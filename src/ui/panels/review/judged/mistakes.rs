//! The list of false alarms and misses: a click, or Enter on a row, shows the place in all views.

use super::super::super::parts::{list_rows, remark, row};
use crate::app::{Action, Command, MistakeSort};
use crate::ui::drop_down::DropDown;
use crate::ui::{ViewContext, theme};
use bathyscope_objects::metrics::Cause;
use bathyscope_objects::truth::{Mistake, TruthComparison};
use egui::{Button, RichText, Ui};

/// Draws the list, how it is sorted, and the buttons that walk along it.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>, comparison: &TruthComparison) {
    let reviewing = &context.app.log.reviewing;
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
        super::super::button(ui, context, (Action::PreviousMistake, "Previous"));
        super::super::button(ui, context, (Action::NextMistake, "Next"));
    });
    list(ui, context, comparison, mistakes);
}

fn list(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    comparison: &TruthComparison,
    mistakes: &[Mistake],
) {
    let here = context.app.log.reviewing.mistake_at();
    list_rows(ui, "mistakes", mistakes.len(), here, |ui, index| {
        let mistake = mistakes.get(index)?;
        let said = said(context, comparison, mistake);
        let colour = colour(context, mistake);
        let shown = RichText::new(&said).color(colour);
        let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
        let button = Button::selectable(here == Some(index), shown).min_size(size);
        let row = ui.add(button);
        if row.clicked() {
            context.push(Command::ShowMistake(*mistake));
        }
        Some(row)
    });
}

/// `rock 0.87, background, 1.2 m` or `missed tyre, 0.8 m`.
fn said(context: &ViewContext<'_>, comparison: &TruthComparison, mistake: &Mistake) -> String {
    let size = context.units().measure(mistake.size_m(), 1);
    match mistake {
        Mistake::FalseAlarm { id, score, cause, .. } => {
            let review = &context.app.log.reviewing.review;
            let class = review.get(*id).map_or("", |one| review.class_name(one.class));
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
            let one = context.app.log.reviewing.review.get(*id);
            let state = one.map_or(bathyscope_objects::review::State::Proposed, |one| one.state);
            theme::box_colour_on_panel(look, state)
        }
        Mistake::Miss { .. } => theme::missed_colour_on_panel(look),
    }
}
