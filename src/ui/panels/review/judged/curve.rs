//! The precision-recall curve with the point that the confidence slider stands at.

use super::share;
use crate::app::{Command, ViewOptions};
use crate::detection::metrics::{Counts, CurvePoint};
use crate::detection::truth::{Comparison, Standing};
use crate::ui::{ViewContext, text, theme};
use egui::{
    Align2, CursorIcon, FontId, Painter, Pos2, Rect, RichText, Role, Sense, Shape, Stroke, Ui,
    WidgetInfo, pos2, vec2,
};

/// Height of the picture, points.
const HEIGHT: f32 = 138.0;
/// Its width, points.
const WIDTH: f32 = 146.0;
/// Room for the words of the axes, points.
const MARGIN: f32 = 24.0;

/// Draws the curve, and the figures beside it. A click on the curve moves the slider there.
pub fn ui(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    comparison: &Comparison,
    standing: &Standing,
) {
    ui.horizontal(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(WIDTH, HEIGHT), Sense::click());
        let plot = Plot::new(rect);
        draw(&ui.painter_at(rect), &plot, comparison, standing, &context.app.options);
        let said = said(standing);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &said));
        let picked = response
            .interact_pointer_pos()
            .filter(|_| response.clicked())
            .and_then(|at| plot.nearest(comparison.curve(), at));
        if let Some(point) = picked {
            let mut queue = context.app.log.reviewing.queue.clone();
            queue.threshold = point.score;
            context.push(Command::LineUp(Box::new(queue)));
        }
        response
            .on_hover_cursor(CursorIcon::PointingHand)
            .on_hover_text(
                "Precision over recall at every confidence, as the boxes stand now. A click sets the confidence.",
            );
        ui.vertical(|ui| figures(ui, &standing.counts));
    });
}

/// What the slider's point says to screen readers and tests.
fn said(standing: &Standing) -> String {
    let counts = &standing.counts;
    format!(
        "Precision-recall curve: at confidence {:.2} precision {}, recall {}, F1 {}; {} found, {}, {} missed",
        standing.score,
        share(counts.precision()),
        share(counts.recall()),
        share(counts.f1()),
        counts.found,
        text::plural(counts.false_alarms, "false alarm", "false alarms"),
        counts.missed(),
    )
}

fn figures(ui: &mut Ui, counts: &Counts) {
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
    line(
        "Precision",
        share(counts.precision()),
        "Share of the boxes shown that are right.",
    );
    line(
        "Recall",
        share(counts.recall()),
        "Share of the objects that a box shown has found.",
    );
    line(
        "F1",
        share(counts.f1()),
        "2 found / (2 found + false + missed).",
    );
    line(
        "Found",
        format!("{} of {}", counts.found, counts.truths),
        "Objects that a box of their class overlaps by more than half (IoU).",
    );
    line(
        "False",
        text::count(counts.false_alarms),
        "Boxes shown that found nothing, or what a surer box had found.",
    );
    line(
        "Missed",
        text::count(counts.missed()),
        "Objects that no box shown has found.",
    );
}

/// Between shares and the screen.
struct Plot {
    area: Rect,
}

impl Plot {
    fn new(rect: Rect) -> Self {
        let min = rect.min + vec2(MARGIN, 5.0);
        Self {
            area: Rect::from_min_max(min, rect.max - vec2(6.0, MARGIN)),
        }
    }

    fn at(&self, recall: f64, precision: f64) -> Pos2 {
        // Shares, which an `f32` holds.
        self.area
            .lerp_inside(vec2(recall as f32, 1.0 - precision as f32))
    }

    /// The point of the curve nearest to a place.
    fn nearest<'a>(&self, curve: &'a [CurvePoint], at: Pos2) -> Option<&'a CurvePoint> {
        let distance = |point: &CurvePoint| self.at(point.recall, point.precision).distance_sq(at);
        curve
            .iter()
            .filter(|point| point.recall.is_finite())
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

fn draw(
    painter: &Painter,
    plot: &Plot,
    comparison: &Comparison,
    standing: &Standing,
    options: &ViewOptions,
) {
    axes(painter, plot, options);
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
        let thin = Stroke::new(1.0, theme::selection_colour().gamma_multiply(0.5));
        painter.line_segment([here, pos2(here.x, plot.area.bottom())], thin);
        painter.line_segment([here, pos2(plot.area.left(), here.y)], thin);
        let ink = theme::plot_ink(options);
        painter.circle(here, 4.0, theme::selection_colour(), Stroke::new(1.0, ink));
    }
}

fn axes(painter: &Painter, plot: &Plot, options: &ViewOptions) {
    let ink = theme::plot_ink(options);
    let area = plot.area;
    let font = FontId::proportional(10.0);
    for share in [0.0, 0.5, 1.0] {
        let faint = Stroke::new(1.0, ink.gamma_multiply(0.2));
        let at = plot.at(share, share);
        painter.vline(at.x, area.y_range(), faint);
        painter.hline(area.x_range(), at.y, faint);
        let number = format!("{share}");
        let below = pos2(at.x, area.bottom() + 2.0);
        painter.text(below, Align2::CENTER_TOP, &number, font.clone(), ink);
        let beside = pos2(area.left() - 3.0, at.y);
        painter.text(beside, Align2::RIGHT_CENTER, &number, font.clone(), ink);
    }
    let below = pos2(area.center().x, area.bottom() + 12.0);
    painter.text(below, Align2::CENTER_TOP, "recall", font.clone(), ink);
    let precision = painter.layout_no_wrap("precision".to_owned(), font, ink);
    let quarter = std::f32::consts::FRAC_PI_2;
    let start = pos2(
        area.left() - MARGIN,
        area.center().y + 0.25 * area.height() + precision.size().x / 2.0,
    );
    painter.add(egui::epaint::TextShape::new(start, precision, ink).with_angle(-quarter));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_click_takes_the_nearest_point_of_the_curve() {
        let plot = Plot::new(Rect::from_min_size(pos2(0.0, 0.0), vec2(WIDTH, HEIGHT)));
        let point = |score, recall, precision| CurvePoint {
            score,
            precision,
            recall,
            f1: 0.0,
        };
        let curve = [
            point(0.9, 0.2, 1.0),
            point(0.5, 0.8, 0.9),
            point(0.1, 1.0, 0.4),
        ];
        let near = |recall, precision| {
            let found = plot.nearest(&curve, plot.at(recall, precision));
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
        assert!(plot.nearest(&[], pos2(0.0, 0.0)).is_none());
    }
}
