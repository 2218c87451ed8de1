//! Draws the confusion matrix: counts by true and predicted class, as a grid of numbers.

use crate::ui::{ViewContext, text, theme};
use bathyscope_objects::metrics::Confusion;
use bathyscope_objects::truth::{Standing, TruthComparison};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Space for the names of the rows, points.
const NAMES: f32 = 66.0;
/// Space for the names of the columns, which are written upwards, points.
const ABOVE: f32 = 62.0;
/// Largest side of a cell, points.
const CELL: f32 = 26.0;
/// Space for the name of an axis, points.
const AXIS: f32 = 14.0;

/// Name of the class of places without an object.
const BACKGROUND: &str = "background";

/// The rows and columns of the matrix that are not empty.
struct MatrixGrid<'a> {
    confusion: &'a Confusion,
    names: &'a [String],
    /// Classes in use, the background last.
    shown: Vec<usize>,
}

impl<'a> MatrixGrid<'a> {
    fn new(comparison: &'a TruthComparison, standing: &'a Standing) -> Self {
        let confusion = &standing.confusion;
        let background = confusion.classes();
        let all = 0..=background;
        let is_used = |class: &usize| {
            let sum = |count: usize, other: usize| {
                count + confusion.at(*class, other) + confusion.at(other, *class)
            };
            *class == background || all.clone().fold(0, sum) > 0
        };
        Self {
            confusion,
            names: comparison.classes(),
            shown: (0..=background).filter(is_used).collect(),
        }
    }

    fn name(&self, class: usize) -> &str {
        self.names.get(class).map_or(BACKGROUND, String::as_str)
    }

    /// Describes a cell in words.
    fn describe_cell(&self, truth: usize, predicted: usize) -> String {
        let count = self.confusion.at(truth, predicted);
        let background = self.confusion.classes();
        let (is, proposed) = (self.name(truth), self.name(predicted));
        match (truth == background, predicted == background) {
            (true, _) => {
                format!("{}: {proposed}", text::plural(count, "false alarm", "false alarms"))
            }
            (_, true) => format!("{count} missed: {is}"),
            _ if truth == predicted => format!("{count} found: {is}"),
            _ => format!("{count} {is} taken for {proposed}"),
        }
    }

    /// Describes all cells that are not empty, for screen readers and tests.
    fn describe(&self) -> String {
        let cells = self
            .shown
            .iter()
            .flat_map(|&truth| self.shown.iter().map(move |&predicted| (truth, predicted)));
        let cells_text: Vec<String> = cells
            .filter(|&(truth, predicted)| self.confusion.at(truth, predicted) > 0)
            .map(|(truth, predicted)| self.describe_cell(truth, predicted))
            .collect();
        let cells_text = cells_text.join("; ");
        format!("Confusion matrix, rows truth, columns proposed: {cells_text}")
    }
}

/// Draws the grid; the cell under the pointer is described in its tooltip.
pub(super) fn ui(
    ui: &mut Ui,
    context: &ViewContext<'_>,
    comparison: &TruthComparison,
    standing: &Standing,
) {
    let grid = MatrixGrid::new(comparison, standing);
    let count = grid.shown.len() as f32;
    let width = ui.available_width();
    let cell = ((width - NAMES - AXIS) / count).clamp(8.0, CELL);
    let size = vec2(width, AXIS + ABOVE + count * cell + 2.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let origin = rect.min + vec2(AXIS + NAMES, AXIS + ABOVE);
    draw(&ui.painter_at(rect), &grid, origin, cell, context);
    let description = grid.describe();
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &description));
    let under = response.hover_pos().and_then(|at| {
        let [column, row] = [at.x - origin.x, at.y - origin.y].map(|along| (along / cell).floor());
        let class = |index: f32| (index >= 0.0).then(|| grid.shown.get(index as usize).copied())?;
        class(row).zip(class(column))
    });
    let text = under.map_or_else(
        || "Rows: what is there. Columns: what was proposed from this score on.".to_owned(),
        |(truth, predicted)| grid.describe_cell(truth, predicted),
    );
    response.on_hover_text(text);
}

fn draw(
    painter: &Painter,
    grid: &MatrixGrid<'_>,
    origin: Pos2,
    cell: f32,
    context: &ViewContext<'_>,
) {
    let options = context.options();
    let ink = theme::plot_ink(options);
    let small = FontId::proportional(10.0);
    let extent = grid.shown.len() as f32 * cell;
    let most = grid.shown.iter().flat_map(|&truth| {
        let row = grid.shown.iter();
        row.map(move |&predicted| grid.confusion.at(truth, predicted))
    });
    let most = most.max().unwrap_or(0).max(1) as f32;
    let top = pos2(origin.x + extent / 2.0, origin.y - ABOVE);
    painter.text(top, Align2::CENTER_BOTTOM, "proposed", small.clone(), ink);
    let left = pos2(origin.x - NAMES - AXIS + 2.0, origin.y + extent / 2.0);
    upright(painter, left, Align2::CENTER_CENTER, "truth", ink);
    for (row, &truth) in grid.shown.iter().enumerate() {
        let y = origin.y + row as f32 * cell;
        let beside = pos2(origin.x - 4.0, y + cell / 2.0);
        let name = grid.name(truth);
        painter.text(beside, Align2::RIGHT_CENTER, name, small.clone(), ink);
        let above = pos2(origin.x + (row as f32 + 0.5) * cell, origin.y - 3.0);
        upright(painter, above, Align2::LEFT_CENTER, name, ink);
        for (column, &predicted) in grid.shown.iter().enumerate() {
            let corner = pos2(origin.x + column as f32 * cell, y);
            let area = Rect::from_min_size(corner, vec2(cell, cell)).shrink(0.5);
            let count = grid.confusion.at(truth, predicted);
            let share = count as f32 / most;
            let right = truth == predicted;
            painter.rect_filled(area, 1.0, ground(context, right, share));
            if count > 0 {
                let (number, middle) = (text::count(count), area.center());
                let strong = painter.ctx().global_style().visuals.strong_text_color();
                painter.text(middle, Align2::CENTER_CENTER, number, small.clone(), strong);
            }
        }
    }
}

/// Returns the colour of a cell: the accent for found objects, the error colour for mistakes,
/// stronger for a greater share.
fn ground(context: &ViewContext<'_>, right: bool, share: f32) -> Color32 {
    let options = context.options();
    let full = if right {
        theme::accent_colour(options.theme)
    } else {
        theme::error_colour(options.theme)
    };
    if share > 0.0 {
        full.gamma_multiply(0.2 + 0.45 * share)
    } else {
        theme::grid_colour(options).gamma_multiply(0.5)
    }
}

/// Writes a text upwards. `anchor` refers to the text before it is turned: left is its beginning.
fn upright(painter: &Painter, at: Pos2, anchor: Align2, words: &str, ink: Color32) {
    let galley = painter.layout_no_wrap(words.to_owned(), FontId::proportional(10.0), ink);
    let size = galley.size();
    let along = anchor.x().to_factor() * size.x;
    let across = anchor.y().to_factor() * size.y;
    // The text is turned a quarter to the left about its start: right becomes up, and down becomes
    // right.
    let start = at + vec2(-across, along);
    let quarter = std::f32::consts::FRAC_PI_2;
    painter.add(egui::epaint::TextShape::new(start, galley, ink).with_angle(-quarter));
}
