//! The headings: a click sorts by the column, another one the other way around.

use super::columns::{ColumnWidths, heading};
use super::filter::show;
use crate::ui::{ViewContext, theme};
use egui::{Button, Rect, RichText, Role, Sense, Ui, WidgetInfo, vec2};

pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>, columns: &ColumnWidths) {
    let mut table = context.options().objects.clone();
    let units = context.units();
    let size = vec2(columns.width(), ui.spacing().interact_size.y);
    let (row, _) = ui.allocate_exact_size(size, Sense::hover());
    let (_, cells) = columns.cells(row);
    for (column, cell) in cells {
        let is_sorted = table.is_sorted_by(column);
        // Plain letters: an arrow has no glyph in every font.
        let (mark, order) = match (is_sorted, table.falling) {
            (false, _) => ("", ""),
            (true, false) => (" +", ", rising"),
            (true, true) => (" -", ", falling"),
        };
        let text = format!("{}{mark}", heading(column, units));
        let text = RichText::new(text).size(theme::SMALL);
        let button = Button::selectable(is_sorted, text).min_size(cell.size()).truncate();
        let button = ui.put(Rect::from_min_size(cell.min, cell.size()), button);
        let name = format!("Sort objects by {}{order}", column.heading);
        button.widget_info(|| WidgetInfo::selected(Role::Button, true, is_sorted, &name));
        if button.on_hover_text(column.meaning).clicked() {
            table.sort_by(column);
        }
    }
    show(context, table);
}
