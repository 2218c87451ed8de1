//! Computes the widths of the columns, and the texts of their cells.

use super::show;
use crate::app::{App, Object, ObjectColumn, ObjectState};
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_objects::objects::{ColumnValues, LOGS_COLUMN};
use bathyscope_objects::review::State;
use egui::{Button, Rect, RichText, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Width of the picture of a row, points.
pub(super) const PICTURE_WIDTH: f32 = 72.0;
/// Space between the text of a cell and its edges, points.
pub(super) const ROOM: f32 = 6.0;

/// The columns right of the picture, each with its width.
pub(super) struct ColumnWidths {
    widths: Vec<(&'static ObjectColumn, f32)>,
}

impl ColumnWidths {
    /// Returns the widths for the available room, points; spare room is given to the columns of
    /// text.
    pub(super) fn fit(room: f32, app: &App) -> Self {
        let shown: Vec<&ObjectColumn> = ObjectColumn::shown(app.logs.count()).collect();
        let least: f32 = shown.iter().map(|column| least_width(column)).sum();
        let shares: f32 = shown.iter().map(|column| share(column)).sum();
        let left = (room - PICTURE_WIDTH - least).max(0.0);
        let width = |column| least_width(column) + left * share(column) / shares;
        Self { widths: shown.into_iter().map(|column| (column, width(column))).collect() }
    }

    /// Returns the width of a row, points.
    pub(super) fn width(&self) -> f32 {
        let columns: f32 = self.widths.iter().map(|(_, width)| width).sum();
        PICTURE_WIDTH + columns
    }

    /// Returns the area of the picture in a row, and of each cell.
    pub(super) fn cells(
        &self,
        row: Rect,
    ) -> (Rect, impl Iterator<Item = (&'static ObjectColumn, Rect)>) {
        let picture = Rect::from_min_size(row.min, vec2(PICTURE_WIDTH, row.height()));
        let mut left = picture.right();
        let cells = self.widths.iter().map(move |(column, width)| {
            let cell = Rect::from_min_size(pos2(left, row.top()), vec2(*width, row.height()));
            left += width;
            (*column, cell)
        });
        (picture, cells)
    }
}

/// Returns the least width of a column, points.
fn least_width(column: &ObjectColumn) -> f32 {
    match column.values {
        ColumnValues::Text(_) if column.name == LOGS_COLUMN => 56.0,
        ColumnValues::Text(_) => 84.0,
        ColumnValues::State(_) => 92.0,
        ColumnValues::Count(_) => 50.0,
        ColumnValues::Number(..) => 56.0,
        ColumnValues::Length(_) => 72.0,
        ColumnValues::Measured(_) => 98.0,
        ColumnValues::Position(_) => 176.0,
    }
}

/// Returns the share of a column in the spare room.
fn share(column: &ObjectColumn) -> f32 {
    let is_words = matches!(column.values, ColumnValues::Text(_)) && column.name != LOGS_COLUMN;
    if is_words { 1.0 } else { 0.0 }
}

/// Returns the heading of a column with its unit: `length, m`.
fn heading(column: &ObjectColumn, units: Units) -> String {
    if column.values.is_length() {
        format!("{}, {}", column.heading, units.symbol())
    } else {
        column.heading.to_owned()
    }
}

/// Returns the state of a box whose colour is used for an object in this state.
pub(super) fn colour_of(state: ObjectState) -> State {
    match state {
        ObjectState::Undecided => State::Proposed,
        ObjectState::Accepted => State::Accepted,
        ObjectState::Rejected => State::Rejected,
    }
}

/// Returns the text of a cell; empty if the value is not known.
pub(super) fn cell_text(app: &App, object: &Object, column: &ObjectColumn) -> String {
    let (of, units) = (app.objects.listed_object(object), app.view.options.units);
    let length =
        |value_m: f64| if value_m.is_finite() { units.number(value_m, 2) } else { String::new() };
    match column.values {
        ColumnValues::Length(value) => length(value(&of)),
        ColumnValues::Measured(value) => match value(&of) {
            [value_m, sigma_m] if sigma_m.is_finite() => {
                format!("{} ± {}", length(value_m), length(sigma_m))
            }
            [value_m, _] => length(value_m),
        },
        ColumnValues::Number(_, value) => match value(&of) {
            known if known.is_finite() => format!("{known:.2}"),
            _ => String::new(),
        },
        ColumnValues::Position(value) => place::written(app, value(&of)),
        ColumnValues::Text(_) | ColumnValues::Count(_) | ColumnValues::State(_) => column.text(&of),
    }
}

/// Draws the headings: a click sorts by the column, another click reverses the order.
pub(super) fn header(ui: &mut Ui, context: &mut ViewContext<'_>, columns: &ColumnWidths) {
    let mut table = context.options().objects.clone();
    let units = context.units();
    let size = vec2(columns.width(), ui.spacing().interact_size.y);
    let (row, _) = ui.allocate_exact_size(size, Sense::hover());
    let (_, cells) = columns.cells(row);
    for (column, cell) in cells {
        let is_sorted = table.is_sorted_by(column);
        // Plain characters, because not every font has a glyph for an arrow.
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
