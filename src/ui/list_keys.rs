//! Makes lists obey the keyboard: while a row has the keyboard, the arrow keys move along the rows,
//! also to those that are scrolled out of view, Home and End go to the ends, and Return presses the
//! row.

use egui::{AsIdSalt, EventFilter, FocusDirection, Id, Key, Modifiers, Response, ScrollArea, Ui};

/// Rows that Page Up and Page Down pass.
const PAGE: usize = 8;

/// The keys pressed for a list in this frame.
pub(in crate::ui) struct ListKeys {
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
pub(in crate::ui) fn keep_arrows(ctx: &egui::Context, control: Id, across: bool, upright: bool) {
    let arrows = EventFilter {
        horizontal_arrows: across,
        vertical_arrows: upright,
        ..EventFilter::default()
    };
    ctx.memory_mut(|memory| memory.set_focus_lock_filter(control, arrows));
}

/// Returns the row that the keys of this frame move to from the row `here`; the first row if `here`
/// is `None` and the key moves by rows or pages.
pub(in crate::ui) fn moved(
    ui: &Ui,
    here: Option<usize>,
    last: usize,
    page: usize,
) -> Option<usize> {
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
