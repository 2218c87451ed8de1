//! Draws the order and the filter of the boxes, and the least score of shown proposals.

use super::super::parts::{remark, row};
use crate::app::Command;
use crate::ui::controls::{Choices, DropDown, number_field, number_slider};
use crate::ui::{ViewContext, text};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_objects::review::{Queue, Sort, State};
use egui::{Response, Ui};

/// Size beyond which the filter means "any", metres.
const ANY_M: f64 = 100.0;

/// Draws the controls.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let before = &context.app.logs.shown.reviewing.queue;
    let mut queue = before.clone();
    least_score(ui, &mut queue);
    sort(ui, &mut queue);
    class(ui, context, &mut queue);
    state(ui, &mut queue);
    score(ui, &mut queue);
    size(ui, &mut queue, context.units());
    let counts = context.app.logs.review_counts();
    let (line, all) = (counts.in_line, counts.boxes.total());
    if line < all {
        remark(ui, format!("The filter shows {} of {all}.", text::count(line)));
    }
    if queue != *before {
        context.push(Command::LineUp(Box::new(queue)));
    }
}

/// Draws the slider of the least score of shown proposals.
pub(super) fn least_score(ui: &mut Ui, queue: &mut Queue) {
    let hint = "Hides proposals below this score of the detector; decided boxes stay.";
    row(ui, "Least score", hint, |ui| {
        let value_width = 44.0;
        ui.spacing_mut().slider_width = (ui.available_width() - value_width - 8.0).max(40.0);
        ui.spacing_mut().interact_size.x = value_width;
        let slider = number_slider(&mut queue.threshold, 0.0..=1.0);
        ui.add(slider.step_by(0.01).fixed_decimals(2))
    });
}

fn sort(ui: &mut Ui, queue: &mut Queue) {
    row(ui, "Sort by", "The order of Tab and of Accept.", |ui| {
        list(ui, "sort boxes", queue.sort.name(), |choices| {
            for sort in Sort::ALL {
                choices.value(&mut queue.sort, sort, sort.name());
            }
        })
    });
}

fn class(ui: &mut Ui, context: &ViewContext<'_>, queue: &mut Queue) {
    let chosen = &mut queue.filter.class;
    let shown = chosen.clone().unwrap_or_else(|| "all".to_owned());
    row(ui, "Class", "Only boxes of this class.", |ui| {
        list(ui, "class of boxes", &shown, |choices| {
            choices.value(chosen, None, "all");
            for name in context.app.logs.class_names() {
                choices.value(chosen, Some(name.to_owned()), name);
            }
        })
    });
}

fn state(ui: &mut Ui, queue: &mut Queue) {
    let chosen = &mut queue.filter.state;
    let shown = chosen.map_or("all", State::name);
    row(ui, "State", "Only boxes in this state.", |ui| {
        list(ui, "state of boxes", shown, |choices| {
            choices.value(chosen, None, "all");
            for state in State::ALL {
                choices.value(chosen, Some(state), state.name());
            }
        })
    });
}

fn score(ui: &mut Ui, queue: &mut Queue) {
    let (mut low, mut high) = (*queue.filter.score.start(), *queue.filter.score.end());
    between(ui, "Score", "Only boxes of these scores.", |ui, which| {
        let value = if which == 0 { &mut low } else { &mut high };
        let value = number_field(value).range(0.0..=1.0);
        ui.add(value.speed(0.01).fixed_decimals(2))
    });
    if [low, high] != [*queue.filter.score.start(), *queue.filter.score.end()] {
        queue.filter.score = low..=high.max(low);
    }
}

fn size(ui: &mut Ui, queue: &mut Queue, units: Units) {
    let filter = &mut queue.filter.size_m;
    let before = [*filter.start(), filter.end().min(ANY_M)].map(|size_m| units.in_unit(size_m));
    let any = units.in_unit(ANY_M);
    let [mut low, mut high] = before;
    let hint = "Only boxes whose longer side is between these.";
    let name = format!("Size, {}", units.symbol());
    between(ui, &name, hint, |ui, which| {
        let value = if which == 0 { &mut low } else { &mut high };
        let value = number_field(value).range(0.0..=any);
        ui.add(value.speed(0.05).max_decimals(1))
    });
    if [low, high] != before {
        let unit_m = units.length.metres();
        let high_m = if high >= any { f64::INFINITY } else { high.max(low) * unit_m };
        *filter = low * unit_m..=high_m;
    }
}

/// Draws two values in a row, for the ends of a range; both have names for screen readers.
fn between(ui: &mut Ui, name: &str, hint: &str, mut value: impl FnMut(&mut Ui, usize) -> Response) {
    row(ui, name, hint, |ui| {
        let low = value(ui, 0);
        ui.label("to");
        value(ui, 1).accessible_name(format!("{name}, at most"));
        low
    });
}

fn list(ui: &mut Ui, id: &str, shown: &str, items: impl FnOnce(&mut Choices<'_>)) -> Response {
    DropDown::new(id, shown).width(ui.available_width() - 2.0).show(ui, items)
}
