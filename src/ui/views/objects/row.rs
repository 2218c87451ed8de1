//! Draws the headings and a row (picture, texts, and the commands of a click on it), computes the
//! widths of the columns, and makes the pictures of the visible rows.

use super::{enlarged, show};
use crate::app::{App, Command, LogBox, Object, ObjectColumn, ObjectState};
use crate::ui::views::chip::{self, BoxChip, ChipKey, Chips, WantedChip};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_objects::objects::{ColumnValues, LOGS_COLUMN};
use bathyscope_objects::review::State;
use egui::{
    Align2, Button, Color32, Id, Rect, Response, RichText, Role, Sense, TextStyle, TextWrapMode,
    Ui, UiBuilder, WidgetInfo, WidgetText, pos2, vec2,
};
use std::collections::HashMap;

/// Largest number of stored pictures; beyond it, the pictures of rows that are not visible are
/// dropped.
const MOST: usize = 600;

/// A row to draw.
pub(super) struct ObjectTableRow<'a> {
    pub object: &'a Object,
    pub is_selected: bool,
    pub is_odd: bool,
    pub place: Rect,
}

impl ObjectTableRow<'_> {
    /// Draws the row; a click selects the object and shows it in all views, a double-click enlarges
    /// it there.
    pub(super) fn ui(
        &self,
        ui: &mut Ui,
        app: &App,
        columns: &ColumnWidths,
        thumbnails: &Thumbnails,
    ) -> Vec<Command> {
        let id = Id::unique(("row of object", self.object.number));
        // Not focusable: all rows together have the keyboard.
        let response = ui.interact(self.place, id, Sense::CLICK);
        self.background(ui, &response);
        let (picture, cells) = columns.cells(self.place);
        self.picture(ui, app, picture.shrink(2.0), thumbnails);
        let pointer = response.hover_pos();
        let mut whole = None;
        for (column, cell) in cells {
            let is_under = pointer.is_some_and(|at| cell.contains(at));
            let is_cut = self.cell(ui, app, column, cell);
            if is_cut && is_under {
                whole = Some(cell_text(app, self.object, column));
            }
        }
        let name = self.name();
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, self.is_selected, &name));
        let response = match whole {
            Some(whole) => response.on_hover_text_at_pointer(whole),
            None => response,
        };
        let Some(best) = app.logs.best_box(self.object) else {
            return Vec::new();
        };
        match (response.double_clicked(), response.clicked()) {
            (true, _) => enlarged(best),
            (false, true) => vec![Command::SelectLogBox(best)],
            (false, false) => Vec::new(),
        }
    }

    /// Returns the name for screen readers and tests: `Object 3, Anna, wreck, seen 2 times,
    /// accepted`.
    fn name(&self) -> String {
        let object = self.object;
        let times = text::plural(object.sightings, "time", "times");
        let called = match object.name.as_str() {
            "" => String::new(),
            name => format!("{name}, "),
        };
        let (number, class) = (object.number, &object.class);
        let state = object.state.name();
        format!("Object {number}, {called}{class}, seen {times}, {state}")
    }

    fn background(&self, ui: &Ui, response: &Response) {
        let visuals = ui.visuals();
        let fill = match (self.is_selected, response.hovered(), self.is_odd) {
            (true, _, _) => visuals.selection.bg_fill,
            (false, true, _) => visuals.widgets.hovered.weak_bg_fill,
            (false, false, true) => visuals.faint_bg_color,
            (false, false, false) => Color32::TRANSPARENT,
        };
        ui.painter().rect_filled(self.place, 0.0, fill);
    }

    fn picture(&self, ui: &mut Ui, app: &App, area: Rect, thumbnails: &Thumbnails) {
        let Some(id) = app.logs.best_box(self.object) else {
            return;
        };
        if let (Some(review_box), Some(chip)) = (app.logs.log_box(id), thumbnails.of(id)) {
            let mut inside = ui.new_child(UiBuilder::new().max_rect(area));
            chip.draw(&mut inside, review_box, area.size(), Sense::hover());
        }
    }

    /// Writes a cell; returns true if its text is longer than the cell.
    fn cell(&self, ui: &Ui, app: &App, column: &ObjectColumn, cell: Rect) -> bool {
        let inner = cell.shrink2(vec2(ROOM, 0.0));
        if column.name == LOGS_COLUMN {
            log_colours(ui, app, self.object, inner);
            return false;
        }
        let colour = match column.values {
            ColumnValues::State(_) => {
                let state = colour_of(self.object.state);
                theme::box_colour_on_panel(app.view.options.theme, state)
            }
            _ if self.is_selected => ui.visuals().selection.stroke.color,
            _ => ui.visuals().text_color(),
        };
        let said = WidgetText::from(cell_text(app, self.object, column));
        let wrap = Some(TextWrapMode::Truncate);
        let galley = said.into_galley(ui, wrap, inner.width(), TextStyle::Body);
        let anchor =
            if column.values.is_number() { Align2::RIGHT_CENTER } else { Align2::LEFT_CENTER };
        let at = anchor.align_size_within_rect(galley.size(), inner).min;
        let is_cut = galley.elided;
        ui.painter().galley(at, galley, colour);
        is_cut
    }
}

/// Draws squares in the colours of the logs that have seen the object.
fn log_colours(ui: &Ui, app: &App, object: &Object, cell: Rect) {
    let painter = ui.painter_at(cell);
    let logs = object.logs();
    let colours = logs.iter().filter_map(|id| app.logs.get(*id));
    for (place, log) in colours.enumerate() {
        let left = cell.left() + 12.0 * place as f32;
        let square = Rect::from_center_size(pos2(left + 4.5, cell.center().y), vec2(9.0, 9.0));
        painter.rect_filled(square, 2.0, theme::rgb(log.colour));
    }
}

/// The pictures of rows: made in the background for the visible rows, and kept while there are no
/// more than [`MOST`].
#[derive(Default)]
pub(super) struct Thumbnails {
    known: HashMap<LogBox, (ChipKey, BoxChip)>,
    making: Chips,
}

impl Thumbnails {
    /// Returns true if pictures are being made.
    pub(super) fn is_running(&self) -> bool {
        self.making.is_running()
    }

    /// Returns the picture of a box that was made last.
    fn of(&self, id: LogBox) -> Option<&BoxChip> {
        self.known.get(&id).map(|(_, chip)| chip)
    }

    /// Starts to make the missing pictures of the visible objects, and stores those that are ready.
    pub(super) fn ask<'a>(
        &mut self,
        app: &App,
        ctx: &egui::Context,
        in_sight: impl Iterator<Item = &'a Object>,
    ) {
        let wanted = |object: &Object| chip::wanted(app, app.logs.best_box(object)?);
        let wanted: Vec<WantedChip> = in_sight.filter_map(wanted).collect();
        if self.known.len() > MOST {
            let is_wanted = |id: &LogBox| wanted.iter().any(|(other, _)| other == id);
            self.known.retain(|id, _| is_wanted(id));
        }
        let is_missing =
            |(id, key): &WantedChip| self.known.get(id).is_none_or(|(of, _)| of != key);
        let missing: Vec<WantedChip> = wanted.into_iter().filter(is_missing).collect();
        if missing.is_empty() {
            return;
        }
        chip::ask(&mut self.making, missing, app, ctx);
        for ((id, key), chip) in self.making.result().into_iter().flatten() {
            self.known.insert(*id, (key.clone(), chip.clone()));
        }
    }
}

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
