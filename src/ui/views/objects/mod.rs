//! Shows the table of the objects of all visible logs: a row for each with its picture, sorted,
//! filtered, and usable by keys.
//!
//! Input: the state. Output: rows with pictures, and commands.
//!
//! `row` draws a row and the headings, and makes the pictures of the visible rows.

mod row;

use crate::app::{Action, Command, LogBox, Object, ObjectState, ObjectTable, View};
use crate::ui::controls::{self, DropDown, keep_arrows};
use crate::ui::{ViewContext, text};
use egui::{
    Button, Frame, Id, Key, Margin, Modifiers, Rect, Response, RichText, Role, ScrollArea, Sense,
    TextEdit, Ui, WidgetInfo, pos2, vec2,
};
use row::{ColumnWidths, Thumbnails};
use std::ops::Range;

/// Height of a row, points: large enough to recognise an object in its picture.
const ROW_HEIGHT: f32 = 44.0;
/// Width of the text field of the filter, points.
const FIELD_WIDTH: f32 = 220.0;

/// The table of objects: its selection, and the pictures of its rows.
#[derive(Default)]
pub(crate) struct ObjectsView {
    thumbnails: Thumbnails,
    /// True if the rows are to get the keyboard.
    wants_keyboard: bool,
    /// Index of the row that was selected in the last frame; a new selection is scrolled into view.
    last_selected: Option<usize>,
    /// Number of visible rows, which is the step of the keys that turn pages.
    page: usize,
}

impl ObjectsView {
    /// Gives the keyboard to the rows in the next frame.
    pub(crate) fn take_keyboard(&mut self) {
        self.wants_keyboard = true;
    }

    /// Returns true if the pictures of the visible rows are drawn.
    pub(crate) fn is_settled(&self) -> bool {
        !self.thumbnails.is_running()
    }

    /// Draws the table, or a text that explains why it is empty.
    pub(crate) fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let rect = ui.available_rect_before_wrap();
        ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
        Frame::new().inner_margin(Margin::symmetric(8, 6)).show(ui, |ui| {
            if context.app.objects.all().is_empty() {
                no_objects(ui, context)
            } else {
                self.table(ui, context)
            }
        });
    }

    fn table(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        filter(ui, context);
        let columns = ColumnWidths::fit(ui.available_width(), context.app);
        ScrollArea::horizontal().id_salt("wide table of objects").auto_shrink([false, false]).show(
            ui,
            |ui| {
                ui.set_min_width(columns.width());
                ui.spacing_mut().item_spacing.y = 0.0;
                row::header(ui, context, &columns);
                self.rows(ui, context, &columns);
            },
        );
    }

    fn rows(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>, columns: &ColumnWidths) {
        let app = context.app;
        let listed: Vec<&Object> =
            (app.objects.listed().iter()).filter_map(|number| app.objects.get(*number)).collect();
        let selected = app.selected_object().map(|object| object.number);
        let selected = listed.iter().position(|object| Some(object.number) == selected);
        let body = self.body(ui, listed.len(), selected);
        context.commands.extend(self.keys(ui, context, &listed, selected, &body));
        let is_new = selected != std::mem::replace(&mut self.last_selected, selected);
        let mut in_sight = 0..0;
        ScrollArea::vertical().id_salt("objects").auto_shrink([false, false]).show_viewport(
            ui,
            |ui, viewport| {
                let corner = ui.max_rect().min;
                let size = vec2(columns.width(), ROW_HEIGHT);
                let place = |index: usize| {
                    let top = corner.y + ROW_HEIGHT * index as f32;
                    Rect::from_min_size(pos2(corner.x, top), size)
                };
                let all = vec2(size.x, ROW_HEIGHT * listed.len() as f32);
                ui.allocate_rect(Rect::from_min_size(corner, all), Sense::hover());
                if let Some(index) = selected.filter(|_| is_new) {
                    ui.scroll_to_rect(place(index), None);
                }
                self.page = (viewport.height() / ROW_HEIGHT) as usize;
                in_sight = rows_in(viewport, listed.len());
                for index in in_sight.clone() {
                    let row = row::ObjectTableRow {
                        object: listed[index],
                        is_selected: selected == Some(index),
                        is_odd: index % 2 == 1,
                        place: place(index),
                    };
                    let commands = row.ui(ui, app, columns, &self.thumbnails);
                    if !commands.is_empty() {
                        body.request_focus();
                        context.commands.extend(commands);
                    }
                }
            },
        );
        self.thumbnails.ask(app, ui.ctx(), listed[in_sight].iter().copied());
    }

    /// Creates the control that has the keyboard: all rows together, which Tab enters and leaves in
    /// one step.
    fn body(&mut self, ui: &Ui, count: usize, selected: Option<usize>) -> Response {
        let rect = ui.available_rect_before_wrap();
        let body = ui.interact(rect, Id::unique("rows of objects"), Sense::click());
        let name = match selected {
            Some(index) => format!("Objects, row {} of {count} selected", index + 1),
            None => format!("Objects, {count} rows, none selected"),
        };
        body.widget_info(|| WidgetInfo::labeled(Role::List, true, &name));
        if std::mem::take(&mut self.wants_keyboard) {
            body.request_focus();
        }
        if body.has_focus() {
            keep_arrows(ui.ctx(), body.id, false, true);
            let stroke = ui.visuals().selection.stroke;
            let kind = egui::StrokeKind::Inside;
            ui.painter().rect_stroke(rect, 2.0, stroke, kind);
        }
        body
    }

    /// Returns the commands of the keys while the rows have the keyboard: select another row, or
    /// show the selected object in all views.
    fn keys(
        &self,
        ui: &Ui,
        context: &ViewContext<'_>,
        listed: &[&Object],
        selected: Option<usize>,
        body: &Response,
    ) -> Vec<Command> {
        if !body.has_focus() {
            return Vec::new();
        }
        let last = listed.len().saturating_sub(1);
        if let Some(index) = controls::moved(ui, selected, last, self.page.max(1)) {
            let object = listed.get(index);
            let id = object.and_then(|object| context.app.logs.best_box(object));
            return id.map(Command::SelectLogBox).into_iter().collect();
        }
        if !ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter)) {
            return Vec::new();
        }
        let id = context.app.logs.shown.selected_box();
        id.filter(|_| selected.is_some()).map_or_else(Vec::new, enlarged)
    }
}

/// Draws the filter of the rows: a text and a state.
fn filter(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut table = context.options().objects.clone();
    ui.horizontal_wrapped(|ui| {
        let field =
            TextEdit::singleline(&mut table.text).hint_text("Filter").desired_width(FIELD_WIDTH);
        ui.add(field)
            .accessible_name("Filter of the objects")
            .on_hover_text("Number, or part of the name, the class or the remarks.");
        let shown = table.state.map_or("all states", ObjectState::name);
        DropDown::new("state of objects", shown)
            .show(ui, |choices| {
                choices.value(&mut table.state, None, "all states");
                for state in ObjectState::ALL {
                    choices.value(&mut table.state, Some(state), state.name());
                }
            })
            .accessible_name("State of the objects");
        let listed = context.app.objects.listed().len();
        let all = context.app.objects.all().len();
        let objects = text::plural(all, "object", "objects");
        let count = if listed == all {
            objects
        } else {
            format!("{} of {objects}, by the filter", text::count(listed))
        };
        ui.label(RichText::new(count).strong());
        let keys = "Up and Down select a row, Enter or a double-click shows it enlarged.";
        ui.label(RichText::new(keys).weak());
    });
    show(context, table);
}

/// Shows the table with another order or filter.
fn show(context: &mut ViewContext<'_>, table: ObjectTable) {
    let mut options = context.options().clone();
    options.objects = table;
    context.show(options);
}

/// Returns the commands that enlarge an object in all views and bring the waterfall to the front.
fn enlarged(id: LogBox) -> Vec<Command> {
    vec![Command::FlyTo(id), Command::Focus(View::Waterfall)]
}

/// Returns the range of rows that a viewport shows.
fn rows_in(viewport: Rect, count: usize) -> Range<usize> {
    let first = (viewport.top() / ROW_HEIGHT).max(0.0) as usize;
    let end = ((viewport.bottom() / ROW_HEIGHT).ceil().max(0.0) as usize).min(count);
    first.min(end)..end
}

/// Explains how objects get into the table, and offers to search for them.
fn no_objects(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.set_min_size(ui.available_size());
    ui.vertical_centered(|ui| {
        ui.add_space(0.3 * ui.available_height());
        let [draw, mark] = [Action::NewBox, Action::MarkTarget].map(Action::key);
        let text = format!(
            "There are no objects yet. Search for them, draw a box around one ({draw}), or mark a point ({mark})."
        );
        ui.label(RichText::new(text).weak());
        ui.add_space(6.0);
        let action = Action::FindObjects;
        let is_ready = context.app.logs.shown.products.is_some();
        let button = ui.add_enabled(is_ready, Button::new(action.label()));
        context.button(button, action);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_in_sight_are_those_of_the_viewport() {
        let seen = |top: f32, bottom: f32, count| {
            let viewport = Rect::from_min_max(pos2(0.0, top), pos2(100.0, bottom));
            rows_in(viewport, count)
        };
        assert_eq!(seen(0.0, 88.0, 10), 0..2);
        assert_eq!(seen(43.0, 89.0, 10), 0..3);
        assert_eq!(seen(400.0, 900.0, 10), 9..10);
        assert_eq!(seen(400.0, 900.0, 3), 3..3);
    }
}
