//! The table of the objects that the boxes of all visible logs show, with the sightings of the selected one under it.

use super::super::parts::remark;
use super::super::section::{Section, section};
use super::object::swatch;
use crate::app::{
    App, Command, LogBox, ObjectColumn, ObjectFilter, ObjectState, ObjectTable, SurveyObject,
};
use crate::detection::review::{Confidence, State};
use crate::presentation::units::Units;
use crate::ui::{ViewContext, text, theme};
use egui::{
    Align2, Button, Color32, ComboBox, Key, Painter, Pos2, Rect, Response, RichText, Role,
    ScrollArea, Sense, TextEdit, TextStyle, Ui, Vec2, WidgetInfo, pos2, vec2,
};

/// Rows that are seen at once.
const ROWS: f32 = 10.0;
/// Room between the text of a cell and its edges, points.
const ROOM: f32 = 4.0;

/// Draws the table; nothing while there are no objects.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if context.app.objects().is_empty() {
        return;
    }
    let heading = Section {
        number: None,
        title: "Object list",
        stage: None,
    };
    section(ui, context, &heading, |ui, context| {
        filter(ui, context);
        let (shown, all) = (
            context.app.listed_objects().len(),
            context.app.objects().len(),
        );
        let said = text::plural(all, "object", "objects");
        remark(
            ui,
            match shown == all {
                true => format!("{said}. Double-click or Enter: enlarge it in all views."),
                false => format!("{} of {said}, by the filter.", text::count(shown)),
            },
        );
        ScrollArea::horizontal()
            .id_salt("table of objects")
            .auto_shrink([false, true])
            .show(ui, |ui| {
                ui.set_min_width(width());
                ui.vertical(|ui| {
                    ui.spacing_mut().item_spacing.y = 0.0;
                    header(ui, context);
                    rows(ui, context);
                });
            });
    });
}

/// The text and the state that are looked for.
fn filter(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut table = context.app.options.objects.clone();
    ui.horizontal(|ui| {
        let state_width = 96.0;
        let width = (ui.available_width() - state_width - 12.0).max(60.0);
        let field = TextEdit::singleline(&mut table.text)
            .hint_text("Filter")
            .desired_width(width);
        ui.add(field)
            .accessible_name("Filter of the objects")
            .on_hover_text("Number, or part of the name, the class or the remarks.");
        let shown = table.state.map_or("all states", ObjectFilter::name);
        let list = ComboBox::from_id_salt("state of objects")
            .width(state_width)
            .selected_text(shown)
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut table.state, None, "all states");
                for state in ObjectFilter::ALL {
                    ui.selectable_value(&mut table.state, Some(state), state.name());
                }
            });
        list.response.accessible_name("State of the objects");
    });
    show(context, table);
}

fn show(context: &mut ViewContext<'_>, table: ObjectTable) {
    if table != context.app.options.objects {
        let mut options = context.app.options.clone();
        options.objects = table;
        context.push(Command::Show(Box::new(options)));
    }
}

/// Width of a column, points.
fn column_width(column: ObjectColumn) -> f32 {
    match column {
        ObjectColumn::Number => 40.0,
        ObjectColumn::Name => 104.0,
        ObjectColumn::Class => 76.0,
        ObjectColumn::State => 84.0,
        ObjectColumn::Sure => 96.0,
        ObjectColumn::Length | ObjectColumn::Width => 52.0,
        ObjectColumn::Height | ObjectColumn::Depth => 52.0,
        ObjectColumn::Seen => 44.0,
        ObjectColumn::Logs => 60.0,
    }
}

fn width() -> f32 {
    ObjectColumn::ALL.map(column_width).iter().sum()
}

/// Columns of numbers are aligned at their right.
fn is_number(column: ObjectColumn) -> bool {
    !matches!(
        column,
        ObjectColumn::Name | ObjectColumn::Class | ObjectColumn::State | ObjectColumn::Sure
    )
}

/// What a heading means.
fn meaning(column: ObjectColumn, units: Units) -> String {
    let what = match column {
        ObjectColumn::Number => "Number of the object.",
        ObjectColumn::Name => "What you call it.",
        ObjectColumn::Class => "What most of its boxes take it for.",
        ObjectColumn::State => "How far the decisions about it are.",
        ObjectColumn::Sure => "How sure you are, and the highest score of the detector.",
        ObjectColumn::Length => "Along the track",
        ObjectColumn::Width => "Across the track",
        ObjectColumn::Height => "Above the bottom, from the shadow",
        ObjectColumn::Depth => "Of the bottom where it lies",
        ObjectColumn::Seen => "Boxes that show it.",
        ObjectColumn::Logs => "Logs that saw it.",
    };
    match column {
        ObjectColumn::Length | ObjectColumn::Width | ObjectColumn::Height | ObjectColumn::Depth => {
            format!("{what}, {}.", units.length.name())
        }
        _ => what.to_owned(),
    }
}

/// The headings: a click sorts by the column, another one the other way around.
fn header(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut table = context.app.options.objects.clone();
    let units = context.app.options.units;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        for column in ObjectColumn::ALL {
            let is_sorted = table.sort == column;
            // Plain letters: an arrow has no glyph in every font.
            let mark = match (is_sorted, table.falling) {
                (false, _) => "",
                (true, false) => " +",
                (true, true) => " -",
            };
            let heading = RichText::new(format!("{}{mark}", column.name())).size(theme::SMALL);
            let size = vec2(column_width(column), ui.spacing().interact_size.y);
            let button = ui.add(
                Button::selectable(is_sorted, heading)
                    .min_size(size)
                    .truncate(),
            );
            let order = match (is_sorted, table.falling) {
                (false, _) => "",
                (true, false) => ", rising",
                (true, true) => ", falling",
            };
            let name = format!("Sort objects by {}{order}", column.name());
            button.widget_info(|| WidgetInfo::selected(Role::Button, true, is_sorted, &name));
            if button.on_hover_text(meaning(column, units)).clicked() {
                table.sort_by(column);
            }
        }
    });
    show(context, table);
}

/// A row of the table.
enum Row<'a> {
    Object(&'a SurveyObject),
    /// A sighting of the selected object.
    Sighting(LogBox),
}

fn rows(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let listed = app.listed_objects();
    let selected = app.selected_object();
    let here = selected.and_then(|one| listed.iter().position(|number| *number == one.number));
    let sightings = match (selected, here) {
        (Some(object), Some(_)) if object.boxes.len() > 1 => object.boxes.as_slice(),
        _ => &[],
    };
    let row_at = |index: usize| -> Option<Row<'_>> {
        let after = here.map_or(listed.len(), |here| here + 1);
        let inside = index
            .checked_sub(after)
            .filter(|inside| *inside < sightings.len());
        match inside {
            Some(inside) => Some(Row::Sighting(sightings[inside])),
            None => {
                let index = match index < after {
                    true => index,
                    false => index - sightings.len(),
                };
                Some(Row::Object(app.object(*listed.get(index)?)?))
            }
        }
    };
    let height = ui.spacing().interact_size.y;
    let mut area = ScrollArea::vertical()
        .id_salt("objects")
        .max_height(ROWS * height)
        .auto_shrink([false, true]);
    // Keys walk along the table: another row than before comes into the middle.
    let last_id = egui::Id::unique("last object shown");
    let last: Option<usize> = ui.data(|data| data.get_temp(last_id)).flatten();
    if here != last {
        ui.data_mut(|data| data.insert_temp(last_id, here));
        if let Some(here) = here {
            let offset = (here as f32 - 0.5 * (ROWS - 1.0)) * height;
            area = area.vertical_scroll_offset(offset.max(0.0));
        }
    }
    let count = listed.len() + sightings.len();
    area.show_rows(ui, height, count, |ui, range| {
        for index in range {
            let command = match row_at(index) {
                Some(Row::Object(object)) => object_row(ui, app, object, here),
                Some(Row::Sighting(id)) => sighting_row(ui, app, id),
                None => None,
            };
            context.commands.extend(command);
        }
    });
}

/// What a click or Enter on a row asks for: a click selects, a double-click or Enter enlarges.
fn asked(ui: &Ui, response: &Response, id: LogBox) -> Option<Command> {
    let enter = response.has_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if response.double_clicked() || enter {
        return Some(Command::FlyTo(id));
    }
    response.clicked().then_some(Command::SelectLogBox(id))
}

/// Room for a row, its background, and the response to the pointer.
fn row_frame(ui: &mut Ui, is_here: bool) -> Response {
    let size = vec2(width(), ui.spacing().interact_size.y);
    let (_, response) = ui.allocate_exact_size(size, Sense::click());
    let visuals = ui.visuals();
    let fill = match (is_here, response.hovered() || response.has_focus()) {
        (true, _) => visuals.selection.bg_fill,
        (false, true) => visuals.widgets.hovered.weak_bg_fill,
        (false, false) => Color32::TRANSPARENT,
    };
    ui.painter().rect_filled(response.rect, 2.0, fill);
    response
}

/// Where the cells of a row lie.
fn cells(row: Rect) -> impl Iterator<Item = (ObjectColumn, Rect)> {
    let mut left = row.left();
    ObjectColumn::ALL.into_iter().map(move |column| {
        let width = column_width(column);
        let cell = Rect::from_min_size(pos2(left, row.top()), vec2(width, row.height()));
        left += width;
        (column, cell)
    })
}

fn write(
    painter: &Painter,
    ui: &Ui,
    cell: Rect,
    column: ObjectColumn,
    said: &str,
    colour: Color32,
) {
    let inner = cell.shrink2(Vec2::new(ROOM, 0.0));
    let (at, anchor): (Pos2, Align2) = match is_number(column) {
        true => (inner.right_center(), Align2::RIGHT_CENTER),
        false => (inner.left_center(), Align2::LEFT_CENTER),
    };
    let font = TextStyle::Small.resolve(ui.style());
    // What is longer than its cell is cut off.
    painter
        .with_clip_rect(inner.intersect(painter.clip_rect()))
        .text(at, anchor, said, font, colour);
}

fn object_row(
    ui: &mut Ui,
    app: &App,
    object: &SurveyObject,
    here: Option<usize>,
) -> Option<Command> {
    let is_here = here.is_some()
        && app
            .selected_object()
            .is_some_and(|selected| selected.number == object.number);
    let response = row_frame(ui, is_here);
    let (said, state) = state_words(object);
    let colour = theme::box_colour_on_panel(app.options.theme, state);
    let painter = ui.painter().clone();
    for (column, cell) in cells(response.rect) {
        if column == ObjectColumn::Logs && app.log_count() > 1 {
            log_colours(&painter, app, object, cell);
            continue;
        }
        let colour = match column {
            ObjectColumn::State => colour,
            _ if is_here => ui.visuals().selection.stroke.color,
            _ => ui.visuals().text_color(),
        };
        write(
            &painter,
            ui,
            cell,
            column,
            &cell_text(object, column, app.options.units),
            colour,
        );
    }
    let times = text::plural(object.boxes.len(), "time", "times");
    let called = match object.summary.name.as_str() {
        "" => String::new(),
        name => format!("{name}, "),
    };
    let (number, class) = (object.number, &object.joint.class);
    let name = format!("Object {number}, {called}{class}, seen {times}, {said}");
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_here, &name));
    let best = best(app, object)?;
    asked(ui, &response, best)
}

/// `3 undecided`, and the state whose colour it has.
fn state_words(object: &SurveyObject) -> (String, State) {
    match object.summary.state {
        ObjectState::Open(open) if open == object.boxes.len() => {
            ("undecided".to_owned(), State::Proposed)
        }
        ObjectState::Open(open) => (format!("{open} undecided"), State::Proposed),
        ObjectState::Accepted => ("accepted".to_owned(), State::Accepted),
        ObjectState::Rejected => ("rejected".to_owned(), State::Rejected),
    }
}

fn cell_text(object: &SurveyObject, column: ObjectColumn, units: Units) -> String {
    let summary = &object.summary;
    let length = |value_m: f64| match value_m.is_finite() {
        true => units.number(value_m, 2),
        false => String::new(),
    };
    match column {
        ObjectColumn::Number => object.number.to_string(),
        ObjectColumn::Name => summary.name.clone(),
        ObjectColumn::Class => object.joint.class.clone(),
        ObjectColumn::State => state_words(object).0,
        ObjectColumn::Sure => {
            let score = summary.score.map(|score| format!("{score:.2}"));
            let word = summary
                .confidence
                .map(|word| Confidence::name(word).to_owned());
            let both: Vec<String> = word.into_iter().chain(score).collect();
            both.join(" ")
        }
        ObjectColumn::Length => length(summary.length_m),
        ObjectColumn::Width => length(summary.width_m),
        ObjectColumn::Height => length(object.joint.height_m),
        ObjectColumn::Depth => length(summary.depth_m),
        ObjectColumn::Seen => object.boxes.len().to_string(),
        ObjectColumn::Logs => object.logs().len().to_string(),
    }
}

/// Squares in the colours of the logs that saw it.
fn log_colours(painter: &Painter, app: &App, object: &SurveyObject, cell: Rect) {
    let painter = painter.with_clip_rect(cell.intersect(painter.clip_rect()));
    let logs = object.logs();
    let colours = logs.iter().filter_map(|id| app.open_log(*id));
    for (place, log) in colours.enumerate() {
        let left = cell.left() + ROOM + 12.0 * place as f32;
        let square = Rect::from_center_size(pos2(left + 4.5, cell.center().y), vec2(9.0, 9.0));
        let [r, g, b] = log.colour;
        painter.rect_filled(square, 2.0, Color32::from_rgb(r, g, b));
    }
}

/// A sighting of the selected object, under its row.
fn sighting_row(ui: &mut Ui, app: &App, id: LogBox) -> Option<Command> {
    let (log, one) = (app.open_log(id.log)?, app.log_box(id)?);
    let is_here = app.selected_log_box() == Some(id);
    let response = row_frame(ui, false);
    let inside = response
        .rect
        .with_min_x(response.rect.left() + column_width(ObjectColumn::Number));
    let mut row = ui.new_child(egui::UiBuilder::new().max_rect(inside));
    row.horizontal_centered(|ui| {
        swatch(ui, log.colour);
        let score = one
            .score
            .map_or_else(String::new, |score| format!(", {score:.2}"));
        let said = format!(
            "{} box {}, ping {}, {}{score}",
            log.name(),
            one.id.0,
            one.mark.pings.start,
            one.state.name()
        );
        let said = RichText::new(said).size(theme::SMALL);
        let said = if is_here { said.strong() } else { said };
        ui.add(egui::Label::new(said).selectable(false));
    });
    let name = format!("Row of box {} in {}", one.id.0, log.name());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_here, &name));
    asked(ui, &response, id)
}

/// The box that shows an object first: one of the log that is shown, and of several the surest.
fn best(app: &App, object: &SurveyObject) -> Option<LogBox> {
    let score = |id: &LogBox| {
        let one = app.log_box(*id);
        one.and_then(|one| one.score).unwrap_or(1.0)
    };
    let rank = |id: &LogBox| (id.log == app.log.id, score(id));
    let boxes = object.boxes.iter();
    let best = boxes.max_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    best.copied()
}
