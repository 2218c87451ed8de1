//! Draws the comparison of the boxes with the truth, if it is known: the precision-recall curve
//! with the point of the slider, the list of mistakes, and the confusion matrix.
//!
//! The panel reads the state of the app, draws a curve, lists and a table, and sends commands.

use crate::app::{Action, Command, MistakeSort, ViewOptions};
use crate::ui::controls::DropDown;
use crate::ui::panels::parts::{PlotAxes, list_rows, remark, row, warning};
use crate::ui::panels::section::{Section, section};
use crate::ui::{ViewContext, text, theme};
use bathyscope_bottom::presentation::plot::Axis;
use bathyscope_objects::metrics::{Cause, Confusion, CurvePoint, MatchCounts};
use bathyscope_objects::truth::{Mistake, Standing, TruthComparison};
use egui::{
    Align2, Button, Color32, CursorIcon, FontId, Painter, Pos2, Rect, RichText, Role, Sense, Shape,
    Stroke, Ui, WidgetInfo, pos2, vec2,
};

/// Draws the curve with the figures at the slider; draws nothing without truth.
pub(super) fn at_slider(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let judging = &context.app.logs.shown.reviewing.judging;
    let (Some(comparison), Some(standing)) = (judging.comparison(), judging.standing()) else {
        return;
    };
    if comparison.unsearched > 0 {
        let others = text::plural(comparison.unsearched, "object", "objects");
        let text = format!(
            "The figures count the searched part; {others} of the known objects lie elsewhere."
        );
        warning(ui, context, &text);
    }
    curve(ui, context, comparison, standing);
}

/// Draws the section of mistakes; draws nothing without truth.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let judging = &app.logs.shown.reviewing.judging;
    let (Some(comparison), Some(standing)) = (judging.comparison(), judging.standing()) else {
        return;
    };
    section(ui, context, &Section::new("Mistakes"), |ui, context| {
        let unsearched = comparison.unsearched;
        let counted = comparison.counted();
        let all = comparison.truth().objects.len() - unsearched;
        let source = judging.source().unwrap_or_default();
        let objects = text::plural(counted, "object", "objects");
        let mut text = format!("Against {source}: {objects}");
        if counted < all {
            text += &format!(", {} more are not visible and do not count", all - counted);
        }
        if unsearched > 0 {
            text += &format!(", {unsearched} more lie in unsearched parts");
        }
        remark(ui, text + ".");
        list_of_mistakes(ui, context, comparison);
        matrix(ui, context, comparison, standing);
        ui.horizontal(|ui| {
            super::button(ui, context, (Action::OpenTruth, "Open known objects…"));
            super::button(ui, context, (Action::ForgetTruth, "Close"));
        });
    });
}

/// Draws the list of false alarms and missed objects, the choice of its order, and the buttons that
/// step through it.
fn list_of_mistakes(ui: &mut Ui, context: &mut ViewContext<'_>, comparison: &TruthComparison) {
    let reviewing = &context.app.logs.shown.reviewing;
    let mistakes = reviewing.judging.mistakes();
    if mistakes.is_empty() {
        return remark(ui, "No mistake from this score on.");
    }
    let mut sort = reviewing.judging.sort;
    let before = sort;
    row(ui, "Sort by", "The order of the list.", |ui| {
        DropDown::new("sort mistakes", sort.name()).width(ui.available_width() - 2.0).pick(
            ui,
            &mut sort,
            MistakeSort::ALL,
            MistakeSort::name,
        )
    });
    if sort != before {
        context.push(Command::SortMistakes(sort));
    }
    ui.horizontal(|ui| {
        super::button(ui, context, (Action::PreviousMistake, "Previous"));
        super::button(ui, context, (Action::NextMistake, "Next"));
    });
    list(ui, context, comparison, mistakes);
}

/// Draws the rows: a click, or Enter on a row, shows the place in all views.
fn list(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    comparison: &TruthComparison,
    mistakes: &[Mistake],
) {
    let here = context.app.logs.shown.reviewing.mistake_at();
    list_rows(ui, "mistakes", mistakes.len(), here, |ui, index| {
        let mistake = mistakes.get(index)?;
        let label = mistake_text(context, comparison, mistake);
        let colour = colour(context, mistake);
        let shown = RichText::new(&label).color(colour);
        let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
        let button = Button::selectable(here == Some(index), shown).min_size(size);
        let row = ui.add(button);
        if row.clicked() {
            context.push(Command::ShowMistake(*mistake));
        }
        Some(row)
    });
}

/// Returns the text of a mistake: `rock 0.87, background, 1.2 m` or `missed tyre, 0.8 m`.
fn mistake_text(
    context: &ViewContext<'_>,
    comparison: &TruthComparison,
    mistake: &Mistake,
) -> String {
    let size = context.units().measure(mistake.size_m(), 1);
    match mistake {
        Mistake::FalseAlarm { id, score, cause, .. } => {
            let review = &context.app.logs.shown.reviewing.review;
            let class =
                review.get(*id).map_or("", |review_box| review.class_name(review_box.class));
            let cause = match cause {
                Cause::Background => "nothing there",
                Cause::Duplicate => "found twice",
                Cause::OtherClass => "another class",
                Cause::Loose => "overlaps too little",
            };
            format!("{class} {score:.2}, {cause}, {size}")
        }
        Mistake::Miss { object, .. } => {
            let truth = comparison.truth();
            let known = truth.objects.get(*object);
            let class = known.map_or("", |known| truth.class_name(known.class));
            format!("missed {class}, {size}")
        }
    }
}

fn colour(context: &ViewContext<'_>, mistake: &Mistake) -> egui::Color32 {
    let look = context.theme();
    match mistake {
        Mistake::FalseAlarm { id, .. } => {
            let found = context.app.logs.shown.reviewing.review.get(*id);
            let state = found
                .map_or(bathyscope_objects::review::State::Proposed, |review_box| review_box.state);
            theme::box_colour_on_panel(look, state)
        }
        Mistake::Miss { .. } => theme::missed_colour_on_panel(look),
    }
}

/// Returns a share as text: `0.93`, or a dash if it is not finite.
fn share(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { text::NONE.to_owned() }
}

/// Height of the plot, points.
const HEIGHT: f32 = 138.0;
/// Greatest width of the plot, points.
const WIDTH: f32 = 166.0;
/// Width of the figures beside the plot, points.
const FIGURES: f32 = 116.0;

/// Draws the curve, and the figures beside it. A click on the curve sets the slider to the nearest
/// point.
fn curve(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    comparison: &TruthComparison,
    standing: &Standing,
) {
    let width = (ui.available_width() - FIGURES).clamp(96.0, WIDTH);
    ui.horizontal(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(width, HEIGHT), Sense::click());
        let painter = ui.painter_at(rect);
        let plot = shares(&painter, rect);
        draw_curve(&painter, &plot, comparison, standing, context.options());
        let description = describe(standing);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &description));
        let picked = response
            .interact_pointer_pos()
            .filter(|_| response.clicked())
            .and_then(|at| nearest(&plot, &comparison.curve, at));
        if let Some(point) = picked {
            let mut queue = context.app.logs.shown.reviewing.queue.clone();
            queue.threshold = point.score;
            context.push(Command::LineUp(Box::new(queue)));
        }
        response
            .on_hover_cursor(CursorIcon::PointingHand)
            .on_hover_text(
                "Precision over recall at every score, as the boxes stand now. A click sets the least score.",
            );
        ui.vertical(|ui| figures(ui, &standing.counts));
    });
}

/// Describes the point of the slider, for screen readers and tests.
fn describe(standing: &Standing) -> String {
    let counts = &standing.counts;
    format!(
        "Precision-recall curve: at score {:.2} precision {}, recall {}, F1 {}; {} found, {}, {} missed",
        standing.score,
        share(counts.precision()),
        share(counts.recall()),
        share(counts.f1()),
        counts.found,
        text::plural(counts.false_alarms, "false alarm", "false alarms"),
        counts.missed(),
    )
}

fn figures(ui: &mut Ui, counts: &MatchCounts) {
    let mut line = |name: &str, value: String, hint: &str| {
        ui.horizontal(|ui| {
            let size = vec2(54.0, ui.spacing().interact_size.y);
            let to_the_left = egui::Layout::left_to_right(egui::Align::Center);
            ui.allocate_ui_with_layout(size, to_the_left, |ui| {
                ui.set_min_width(size.x);
                ui.add(egui::Label::new(name).selectable(false));
            });
            ui.label(RichText::new(value).strong()).on_hover_text(hint);
        });
    };
    let hint = "Precision: share of the shown boxes that are right.";
    line("Precision", share(counts.precision()), hint);
    let hint = "Recall: share of the objects that a shown box found.";
    line("Recall", share(counts.recall()), hint);
    let hint = "2 found / (2 found + false + missed).";
    line("F1", share(counts.f1()), hint);
    let hint = "Objects that a box of their class overlaps by more than half (IoU).";
    let value = format!("{} of {}", counts.found, counts.truths);
    line("Found", value, hint);
    let hint = "Shown boxes that found no object, or one that a box of a higher score found.";
    line("False", text::count(counts.false_alarms), hint);
    let hint = "Objects that no box shown has found.";
    line("Missed", text::count(counts.missed()), hint);
}

/// Creates the axes: recall across, precision up.
fn shares(painter: &Painter, rect: Rect) -> PlotAxes {
    let axis = |name: &str| Axis {
        name: name.to_owned(),
        ends: [0.0, 1.0],
        ticks: [0.0, 0.5, 1.0].map(|share| (share, share.to_string())).to_vec(),
    };
    PlotAxes::new(painter, rect, axis("recall"), axis("precision"))
}

/// Returns the point of the curve nearest to a position on the screen; `None` without points.
fn nearest<'a>(axes: &PlotAxes, curve: &'a [CurvePoint], at: Pos2) -> Option<&'a CurvePoint> {
    let distance = |point: &CurvePoint| axes.at(point.recall, point.precision).distance_sq(at);
    let drawn = curve.iter().filter(|point| point.recall.is_finite());
    drawn.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

fn draw_curve(
    painter: &Painter,
    plot: &PlotAxes,
    comparison: &TruthComparison,
    standing: &Standing,
    options: &ViewOptions,
) {
    plot.draw(painter, theme::plot_ink(options));
    let accent = theme::accent_colour(options.theme);
    let points: Vec<Pos2> = (comparison.curve.iter())
        .filter(|point| point.recall.is_finite())
        .map(|point| plot.at(point.recall, point.precision))
        .collect();
    if let [only] = points[..] {
        painter.circle_filled(only, 2.0, accent);
    }
    painter.add(Shape::line(points, Stroke::new(1.5, accent)));
    let counts = &standing.counts;
    if counts.recall().is_finite() && counts.precision().is_finite() {
        let here = plot.at(counts.recall(), counts.precision());
        let thin = Stroke::new(1.0, theme::SELECTION_COLOUR.gamma_multiply(0.5));
        painter.line_segment([here, pos2(here.x, plot.area.bottom())], thin);
        painter.line_segment([here, pos2(plot.area.left(), here.y)], thin);
        let ink = theme::plot_ink(options);
        painter.circle(here, 4.0, theme::SELECTION_COLOUR, Stroke::new(1.0, ink));
    }
}

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
        let background = confusion.classes;
        let all = 0..=background;
        let is_used = |class: &usize| {
            let sum = |count: usize, other: usize| {
                count + confusion.at(*class, other) + confusion.at(other, *class)
            };
            *class == background || all.clone().fold(0, sum) > 0
        };
        Self {
            confusion,
            names: &comparison.classes,
            shown: (0..=background).filter(is_used).collect(),
        }
    }

    fn name(&self, class: usize) -> &str {
        self.names.get(class).map_or(BACKGROUND, String::as_str)
    }

    /// Describes a cell in words.
    fn describe_cell(&self, truth: usize, predicted: usize) -> String {
        let count = self.confusion.at(truth, predicted);
        let background = self.confusion.classes;
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
fn matrix(
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
    draw_matrix(&ui.painter_at(rect), &grid, origin, cell, context);
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

fn draw_matrix(
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

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Context, LayerId, RawInput};

    #[test]
    fn a_click_takes_the_nearest_point_of_the_curve() {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(WIDTH, HEIGHT));
        let point = |score, recall, precision| CurvePoint { score, precision, recall, f1: 0.0 };
        let curve = [point(0.9, 0.2, 1.0), point(0.5, 0.8, 0.9), point(0.1, 1.0, 0.4)];
        let ctx = Context::default();
        let _output = ctx.run_ui(RawInput::default(), |ui| {
            let painter = ui.ctx().layer_painter(LayerId::background());
            let plot = shares(&painter, rect);
            let near = |recall, precision| {
                let found = nearest(&plot, &curve, plot.at(recall, precision));
                found.map(|point| point.score)
            };
            assert_eq!(near(0.25, 0.9), Some(0.9));
            assert_eq!(near(0.85, 0.8), Some(0.5));
            assert_eq!(near(0.95, 0.2), Some(0.1));
            assert_eq!(
                plot.at(0.0, 0.0),
                plot.area.left_bottom(),
                "the origin lies below on the left"
            );
            assert!(nearest(&plot, &[], pos2(0.0, 0.0)).is_none());
        });
    }
}
