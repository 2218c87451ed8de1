//! Adds controls that egui does not have: buttons that are on or off, fields for typed numbers,
//! drop-down lists, and the keys of lists.
//!
//! The state of a button is a shape as well as a colour: the knob of a switch is at the right or at
//! the left, and the chosen one of several buttons is underlined. A field or a slider changes its
//! number on Enter, when it loses the keyboard, and while it is dragged, never while digits are
//! typed: if the change moved the field, the views would take the digits that follow as their keys.
//!
//! In a drop-down list, arrow keys move along the choices from the current one, Return takes a
//! choice, Escape leaves the value as it is. The arrow keys also open a closed list that has the
//! keyboard. While a row of another list has the keyboard, the arrow keys move along the rows, also
//! to those that are scrolled out of view, Home and End go to the ends, and Return presses the row.

use super::hint_with_key;
use crate::app::{Action, ViewOptions};
use egui::emath::Numeric;
use egui::{
    AsIdSalt, Button, ComboBox, DragValue, EventFilter, FocusDirection, Id, IdSalt, Key, Modifiers,
    Popup, Response, Role, ScrollArea, Slider, Stroke, StrokeKind, Ui, WidgetInfo, WidgetText,
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

/// A drop-down list.
pub(super) struct DropDown {
    id_salt: IdSalt,
    shown: WidgetText,
    width: f32,
}

/// The choices of an open list.
pub(super) struct Choices<'u> {
    ui: &'u mut Ui,
    /// True if the list has just opened: the current choice then gets the keyboard.
    is_new: bool,
}

impl DropDown {
    /// Creates a list that shows a text while it is closed. No other list in its `Ui` may have this
    /// `id_salt`.
    pub(super) fn new(id_salt: impl AsIdSalt, shown: impl Into<WidgetText>) -> Self {
        Self { id_salt: IdSalt::new(id_salt), shown: shown.into(), width: 0.0 }
    }

    /// Sets the least width of the list, points.
    pub(super) fn width(self, width: f32) -> Self {
        Self { width, ..self }
    }

    /// Draws the list, and its choices while it is open.
    pub(super) fn show(self, ui: &mut Ui, add: impl FnOnce(&mut Choices<'_>)) -> Response {
        // The id that egui gives to the button of the list.
        let button = ui.make_persistent_id(IdSalt::new(self.id_salt));
        let ctx = ui.ctx().clone();
        let had_keyboard = ctx.memory(|memory| memory.has_focus(button));
        let was_down = ComboBox::is_open(&ctx, button);
        drop_by_arrow(ui, button);
        let mut combo = ComboBox::from_id_salt(self.id_salt).truncate().selected_text(self.shown);
        if self.width > 0.0 {
            combo = combo.width(self.width);
        }
        let is_new = !ctx.data(|data| data.get_temp::<bool>(button).unwrap_or(false));
        let mut is_drawn = false;
        let mut is_taken = false;
        let shown = combo.show_ui(ui, |ui| {
            // Before the size of the list is known, no choice can have the keyboard.
            is_drawn = !ui.is_sizing_pass();
            let is_new = is_new && is_drawn;
            add(&mut Choices { ui, is_new });
            is_taken = is_drawn && !is_new && ui.input(|input| input.key_pressed(Key::Enter));
            if is_taken {
                ui.close();
            }
        });
        let is_down = ComboBox::is_open(&ctx, button);
        ctx.data_mut(|data| {
            data.insert_temp(button, is_down && (is_drawn || !is_new));
            if !was_down && is_down {
                data.insert_temp(by_key(button), had_keyboard);
            }
        });
        let by_key = ctx.data(|data| data.get_temp::<bool>(by_key(button)).unwrap_or(false));
        let left = is_taken || ctx.input(|input| input.key_pressed(Key::Escape));
        if was_down && by_key && left {
            // The keyboard goes back to the button that opened the list.
            ctx.memory_mut(|memory| memory.request_focus(button));
        }
        shown.response
    }

    /// Draws the list with all values that can be chosen.
    pub(super) fn pick<T: Copy + PartialEq>(
        self,
        ui: &mut Ui,
        value: &mut T,
        all: impl IntoIterator<Item = T>,
        name: impl Fn(T) -> &'static str,
    ) -> Response {
        self.show(ui, |choices| {
            for choice in all {
                choices.value(value, choice, name(choice));
            }
        })
    }
}

impl Choices<'_> {
    /// Adds a choice; `is_it` is true for the current one.
    pub(super) fn choice(&mut self, is_it: bool, label: impl Into<WidgetText>) -> Response {
        let label: WidgetText = label.into();
        let choice = self.ui.selectable_label(is_it, label);
        if is_it && self.is_new {
            choice.request_focus();
            choice.scroll_to_me(None);
        }
        choice
    }

    /// Adds a choice that sets `value` when it is taken.
    pub(super) fn value<T: PartialEq>(
        &mut self,
        value: &mut T,
        choice: T,
        label: impl Into<WidgetText>,
    ) {
        if self.choice(*value == choice, label).clicked() {
            *value = choice;
        }
    }

    /// Returns the `Ui` of the list, for parts that are no choices: a line between them, a check
    /// box.
    pub(super) fn ui(&mut self) -> &mut Ui {
        self.ui
    }
}

/// Opens a list whose button has the keyboard when Up or Down is pressed; otherwise these keys
/// would move the keyboard to another control.
fn drop_by_arrow(ui: &Ui, button: Id) {
    let ctx = ui.ctx();
    if !ctx.memory(|memory| memory.has_focus(button)) || ComboBox::is_open(ctx, button) {
        return;
    }
    keep_arrows(ctx, button, false, true);
    let is_pressed = |key| ctx.input_mut(|input| input.consume_key(Default::default(), key));
    if is_pressed(Key::ArrowDown) || is_pressed(Key::ArrowUp) {
        ctx.memory_mut(|memory| memory.move_focus(egui::FocusDirection::None));
        Popup::open_id(ctx, button.with("popup"));
    }
}

fn by_key(button: Id) -> Id {
    button.with("dropped by key")
}

/// Rows that Page Up and Page Down pass.
const PAGE: usize = 8;

/// The keys pressed for a list in this frame.
pub(super) struct ListKeys {
    id: Id,
    /// Index of the row that is to get the keyboard; `None` if no key moves to another row.
    next: Option<usize>,
}

impl ListKeys {
    /// Reads the keys of a list of `count` rows, before the rows are drawn.
    pub(super) fn read(ui: &Ui, name: impl AsIdSalt, count: usize) -> Self {
        let id = ui.scope_id().with(name);
        let known: Option<(usize, Id)> = ui.data(|data| data.get_temp(id));
        let here = known.filter(|(_, row)| ui.memory(|memory| memory.has_focus(*row)));
        let next = here.and_then(|(here, _)| moved(ui, Some(here), count.checked_sub(1)?, PAGE));
        if next.is_some() {
            // egui has handled the key too, and would move the keyboard to a control in that
            // direction.
            ui.memory_mut(|memory| memory.move_focus(FocusDirection::None));
        }
        Self { id, next }
    }

    /// Scrolls an area to the row that gets the keyboard. All rows have the height `row_height`,
    /// points, which includes their spacing.
    pub(super) fn scroll(
        &self,
        area: ScrollArea,
        row_height: f32,
        rows_in_sight: f32,
    ) -> ScrollArea {
        match self.next {
            Some(next) => {
                let offset = (next as f32 - 0.5 * (rows_in_sight - 1.0)) * row_height;
                area.vertical_scroll_offset(offset.max(0.0))
            }
            None => area,
        }
    }

    /// Gives the keyboard to a drawn row if the keys moved to it, and remembers the row that has
    /// the keyboard.
    pub(super) fn row(&self, ui: &Ui, index: usize, row: &Response) {
        if self.next == Some(index) {
            row.request_focus();
            row.scroll_to_me(None);
        }
        if row.has_focus() {
            ui.data_mut(|data| data.insert_temp(self.id, (index, row.id)));
        }
    }
}

/// Reserves the arrow keys for a control that has the keyboard: egui would move to another one.
pub(super) fn keep_arrows(ctx: &egui::Context, control: Id, across: bool, upright: bool) {
    let arrows = EventFilter {
        horizontal_arrows: across,
        vertical_arrows: upright,
        ..EventFilter::default()
    };
    ctx.memory_mut(|memory| memory.set_focus_lock_filter(control, arrows));
}

/// Returns the row that the keys of this frame move to from the row `here`; the first row if `here`
/// is `None` and the key moves by rows or pages.
pub(super) fn moved(ui: &Ui, here: Option<usize>, last: usize, page: usize) -> Option<usize> {
    let back = |rows: usize| here.map_or(0, |here| here.saturating_sub(rows));
    let on = |rows: usize| here.map_or(0, |here| here + rows);
    let keys = [
        (Key::ArrowUp, back(1)),
        (Key::ArrowDown, on(1)),
        (Key::PageUp, back(page)),
        (Key::PageDown, on(page)),
        (Key::Home, 0),
        (Key::End, last),
    ];
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    let next = keys.into_iter().find(|(key, _)| pressed(*key));
    next.map(|(_, next)| next.min(last))
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

    const NAMES: [&str; 4] = ["north", "east", "south", "west"];

    fn list(chosen: usize) -> Harness<'static, usize> {
        let build = |ui: &mut Ui, chosen: &mut usize| {
            ui.add(egui::Button::new("Before"));
            DropDown::new("wind", NAMES[*chosen])
                .width(120.0)
                .show(ui, |choices| {
                    for (index, name) in NAMES.into_iter().enumerate() {
                        choices.value(chosen, index, name);
                    }
                })
                .accessible_name("Wind");
            ui.add(egui::Button::new("After"));
        };
        let mut harness =
            Harness::builder().with_size([240.0, 240.0]).build_ui_state(build, chosen);
        harness.run();
        harness
    }

    fn press(harness: &mut Harness<'static, usize>, keys: &[Key]) {
        for key in keys {
            harness.key_press(*key);
            harness.run();
        }
    }

    #[test]
    fn arrows_walk_from_the_choice_in_force_and_return_takes_one() {
        let mut harness = list(1);
        harness.get_by_label("Wind").click();
        harness.run();
        assert!(harness.query_by_label("west").is_some());
        press(&mut harness, &[Key::ArrowDown, Key::ArrowDown, Key::Enter]);
        assert_eq!(*harness.state(), 3);
        assert!(harness.query_by_label("north").is_none(), "it is up again");
        // The list was opened by the pointer: the views have the keyboard again.
        assert_eq!(harness.ctx.memory(|memory| memory.focused()), None);
    }

    #[test]
    fn the_whole_of_it_goes_by_keys() {
        let mut harness = list(2);
        press(&mut harness, &[Key::Tab, Key::Tab, Key::ArrowDown]);
        assert!(harness.query_by_label("west").is_some(), "it is down");
        press(&mut harness, &[Key::ArrowUp, Key::Enter]);
        assert_eq!(*harness.state(), 1);
        assert!(harness.query_by_label("west").is_none());
        // The button of the list has the keyboard again: Escape in the list leaves the choice as it
        // is.
        press(&mut harness, &[Key::Enter, Key::ArrowUp]);
        assert!(harness.query_by_label("west").is_some());
        press(&mut harness, &[Key::Escape]);
        assert_eq!(*harness.state(), 1);
        assert!(harness.query_by_label("west").is_none());
        press(&mut harness, &[Key::ArrowUp, Key::ArrowDown, Key::Enter]);
        assert_eq!(*harness.state(), 2);
    }

    #[test]
    fn keys_reach_rows_out_of_sight_and_return_presses_one() {
        let build = |ui: &mut Ui, pressed: &mut Option<usize>| {
            let keys = ListKeys::read(ui, "rows", 40);
            let area = keys.scroll(ScrollArea::vertical().max_height(100.0), 20.0, 5.0);
            ui.spacing_mut().item_spacing.y = 0.0;
            area.show_rows(ui, 20.0, 40, |ui, range| {
                for index in range {
                    let size = egui::vec2(80.0, 20.0);
                    let button = egui::Button::new(format!("Row {index}")).min_size(size);
                    let row = ui.add(button);
                    keys.row(ui, index, &row);
                    if row.clicked() {
                        *pressed = Some(index);
                    }
                }
            });
        };
        let mut list = Harness::builder()
            .with_size([200.0, 200.0])
            .with_max_steps(24)
            .build_ui_state(build, None);
        list.run();
        let mut press = |keys: &[Key]| {
            for key in keys {
                list.key_press(*key);
                list.run();
            }
            let row = list.ctx.memory(|memory| memory.focused());
            let row = row.and_then(|row| list.ctx.read_response(row));
            let offset = row.map(|row| row.rect.top());
            (offset.is_some_and(|top| (0.0..=100.0).contains(&top)), *list.state())
        };
        assert_eq!(press(&[Key::Tab, Key::ArrowDown, Key::ArrowDown]), (true, None));
        assert_eq!(press(&[Key::Enter]), (true, Some(2)));
        assert_eq!(press(&[Key::PageDown, Key::Enter]), (true, Some(10)));
        assert_eq!(press(&[Key::End, Key::Enter]), (true, Some(39)));
        assert_eq!(press(&[Key::ArrowUp, Key::Enter]), (true, Some(38)));
        assert_eq!(press(&[Key::Home, Key::Enter]), (true, Some(0)));
    }
}
