//! Draws drop-down lists that obey the keyboard: arrow keys move along the choices from the current
//! one, Return takes a choice, Escape leaves the value as it is. The arrow keys also open a closed
//! list that has the keyboard.

use super::list_keys::keep_arrows;
use egui::{AsIdSalt, ComboBox, Id, IdSalt, Key, Popup, Response, Ui, WidgetText};

/// A drop-down list.
pub(in crate::ui) struct DropDown {
    id_salt: IdSalt,
    shown: WidgetText,
    width: f32,
}

/// The choices of an open list.
pub(in crate::ui) struct Choices<'u> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

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
}
