//! Draws the precision-recall curve, with the point of the least score that the slider sets.

use super::share;
use crate::app::{Command, ViewOptions};
use crate::ui::panels::parts::PlotAxes;
use crate::ui::{ViewContext, text, theme};
use bathyscope_bottom::presentation::plot::Axis;
use bathyscope_objects::metrics::{CurvePoint, MatchCounts};
use bathyscope_objects::truth::{Standing, TruthComparison};
use egui::{
    CursorIcon, Painter, Pos2, Rect, RichText, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2,
    vec2,
};

/// Height of the plot, points.
const HEIGHT: f32 = 138.0;
/// Greatest width of the plot, points.
const WIDTH: f32 = 166.0;
/// Width of the figures beside the plot, points.
const FIGURES: f32 = 116.0;

/// Draws the curve, and the figures beside it. A click on the curve sets the slider to the nearest
/// point.
pub(super) fn ui(
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
        draw(&painter, &plot, comparison, standing, context.options());
        let description = describe(standing);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &description));
        let picked = response
            .interact_pointer_pos()
            .filter(|_| response.clicked())
            .and_then(|at| nearest(&plot, comparison.curve(), at));
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

fn draw(
    painter: &Painter,
    plot: &PlotAxes,
    comparison: &TruthComparison,
    standing: &Standing,
    options: &ViewOptions,
) {
    plot.draw(painter, theme::plot_ink(options));
    let accent = theme::accent_colour(options.theme);
    let points: Vec<Pos2> = (comparison.curve().iter())
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
