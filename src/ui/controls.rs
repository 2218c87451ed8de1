//! Adds controls that egui does not have: buttons that are on or off, and fields for typed numbers.
//!
//! The state of a button is a shape as well as a colour: the knob of a switch is at the right or at
//! the left, and the chosen one of several buttons is underlined. A field or a slider changes its
//! number on Enter, when it loses the keyboard, and while it is dragged, never while digits are
//! typed: if the change moved the field, the views would take the digits that follow as their keys.

use super::hint_with_key;
use crate::app::{Action, ViewOptions};
use egui::emath::Numeric;
use egui::{
    Button, DragValue, Response, Role, Slider, Stroke, StrokeKind, Ui, WidgetInfo, WidgetText,
    pos2, vec2,
};
use std::ops::RangeInclusive;

/// Width and height of the slot that the knob of a switch moves in, points.
const SLOT: egui::Vec2 = vec2(18.0, 10.0);

/// Draws a switch with its name; a click turns it on or off.
pub(super) fn switch(ui: &mut Ui, on: &mut bool, name: &str) -> Response {
    // Spaces of the font make room for the slot, so that the button gets the right size by itself.
    let font = egui::TextStyle::Small.resolve(ui.style());
    let colour = egui::Color32::PLACEHOLDER;
    let spaces = ui.painter().layout_no_wrap("    ".to_owned(), font, colour);
    let space = spaces.size().x / 4.0;
    let room = " ".repeat((SLOT.x / space.max(1.0)).ceil() as usize + 1);
    let text = egui::RichText::new(format!("{room}{name}")).small();
    let button = ui.add(Button::new(text));
    if button.clicked() {
        *on = !*on;
    }
    let is_on = *on;
    button.widget_info(|| WidgetInfo::selected(Role::Button, true, is_on, name));
    let ink = ui.style().interact(&button).fg_stroke.color;
    let left = button.rect.left() + ui.spacing().button_padding.x;
    let centre = pos2(left + 0.5 * SLOT.x, button.rect.center().y);
    let slot = egui::Rect::from_center_size(centre, SLOT);
    let knob = |x: f32| pos2(x, centre.y);
    let (reach, painter) = (0.5 * SLOT.y, ui.painter());
    if is_on {
        painter.rect_filled(slot, reach, ui.visuals().selection.bg_fill);
        painter.circle_filled(knob(slot.right() - reach), reach - 1.0, ink);
    } else {
        let (at, stroke) = (knob(slot.left() + reach), Stroke::new(1.2, ink));
        painter.circle_stroke(at, reach - 2.5, stroke);
    }
    painter.rect_stroke(slot, reach, Stroke::new(1.0, ink), StrokeKind::Inside);
    button
}

/// Draws a switch for the display option that a command turns on or off.
pub(super) fn option_switch(ui: &mut Ui, options: &mut ViewOptions, action: Action) {
    if let Some((name, option)) = action.display_option(options) {
        switch(ui, option, name).on_hover_text(hint_with_key(action));
    }
}

/// Draws a checkbox for the display option that a command turns on or off.
pub(super) fn option_checkbox(ui: &mut Ui, options: &mut ViewOptions, action: Action) {
    if let Some((name, option)) = action.display_option(options) {
        ui.checkbox(option, name).on_hover_text(hint_with_key(action));
    }
}

/// Draws the button of a tool or of one of several choices, underlined if `chosen`.
pub(super) fn chip(ui: &mut Ui, chosen: bool, name: impl Into<WidgetText>) -> Response {
    let name: WidgetText = name.into();
    underline(ui, chosen, Button::selectable(chosen, name))
}

/// Draws a button, underlined if it is chosen or its tool is in use.
pub(super) fn underline(ui: &mut Ui, chosen: bool, button: Button<'_>) -> Response {
    let response = ui.add(button);
    if chosen {
        let stroke = Stroke::new(2.0, ui.visuals().selection.stroke.color);
        let line = response.rect.shrink2(vec2(3.0, 0.0));
        ui.painter().hline(line.x_range(), response.rect.bottom() - 1.0, stroke);
    }
    response
}

/// Returns a field for a number.
pub(super) fn number_field<N: Numeric>(value: &mut N) -> DragValue<'_> {
    DragValue::new(value).update_while_editing(false).custom_parser(parse_number)
}

/// Returns a slider for a number, with a field.
pub(super) fn number_slider<N: Numeric>(value: &mut N, range: RangeInclusive<N>) -> Slider<'_> {
    Slider::new(value, range).update_while_editing(false).custom_parser(parse_number)
}

/// Returns the number in a text, or `None` if it is no finite number. Commas count as points,
/// because half of the world writes a decimal comma, and the minus sign of print is accepted,
/// because figures are copied with it.
pub(super) fn parse_number(text: &str) -> Option<f64> {
    let sign = |letter: char| match letter {
        '\u{2212}' => '-',
        ',' => '.',
        other => other,
    };
    let is_kept = |letter: &char| !letter.is_whitespace();
    let number: f64 = text.chars().filter(is_kept).map(sign).collect::<String>().parse().ok()?;
    number.is_finite().then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::Harness;
    use egui_kittest::kittest::{NodeT as _, Queryable as _};

    #[test]
    fn a_switch_says_its_state_and_turns() {
        let mut panel = Harness::new_ui_state(
            |ui, on| {
                switch(ui, on, "Range lines");
            },
            false,
        );
        let state = |panel: &Harness<'_, bool>| {
            let node = panel.get_by_label("Range lines");
            node.accesskit_node().toggled()
        };
        assert_eq!(state(&panel), Some(egui::accesskit::Toggled::False));
        panel.get_by_label("Range lines").click();
        panel.run();
        assert!(*panel.state());
        assert_eq!(state(&panel), Some(egui::accesskit::Toggled::True));
    }

    #[test]
    fn numbers_are_read_with_comma_and_point() {
        assert_eq!(parse_number("0,45"), Some(0.45));
        assert_eq!(parse_number(" \u{2212}1 200.5 "), Some(-1200.5));
        assert_eq!([parse_number(""), parse_number("deep"), parse_number("nan")], [None; 3]);
    }
}
