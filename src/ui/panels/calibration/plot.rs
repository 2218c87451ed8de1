//! Plots the first-return ranges against soundings with the line of a scale, and the residuals
//! below.

use crate::app::ViewOptions;
use crate::ui::panels::parts::PlotAxes;
use crate::ui::theme;
use bathyscope_bottom::calibration::{Calibration, RangeAtDepth, ScaleMode};
use bathyscope_bottom::presentation::plot::Axis;
use bathyscope_products::pipeline::{Products, ScaleTrial};
use egui::{Color32, Painter, Rect, Role, Sense, Stroke, Ui, WidgetInfo, vec2};

/// Height of each of the two plots, points.
const HEIGHT: f32 = 96.0;
/// Greatest number of points that are drawn of a log, and of a stretch.
const MOST_POINTS: usize = 1500;
/// Share of the points at either end that does not affect the axes.
const TAIL: f64 = 0.02;
/// Least range of the lower plot, metres.
const LEAST_REACH_M: f64 = 0.1;

/// Draws both plots.
pub(super) fn ui(ui: &mut Ui, trial: &ScaleTrial, products: &Products, options: &ViewOptions) {
    let Some(factor) = trial.spot.factor else {
        return;
    };
    let size = vec2(ui.available_width(), 2.0 * HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    let (above, below) = rect.split_top_bottom_at_fraction(0.5);
    let points = Points::of(trial);
    points.ranges(&painter, above, (factor, &products.calibration), options);
    points.residuals(&painter, below, factor, options);
    let said = format!(
        "First-return range against sounding over {} first returns, {} of them on the stretch; the line is range = depth / {factor:.3}",
        trial.points.len(),
        points.stretch.len()
    );
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &said));
    response.on_hover_text(
        "Above: recorded range of first returns over the recorded depth; grey all of the log, yellow those of the stretch. The yellow line is the proposed scale, the dashed one the scale in use.\nBelow: what is left between scaled range and depth.",
    );
}

/// Points of both plots.
struct Points<'a> {
    log: Vec<&'a RangeAtDepth>,
    stretch: Vec<&'a RangeAtDepth>,
    /// Ends of the depths of the log, metres.
    depths_m: [f64; 2],
}

impl<'a> Points<'a> {
    fn of(trial: &'a ScaleTrial) -> Self {
        let pings = &trial.spot.pings;
        let step = trial.points.len().div_ceil(MOST_POINTS).max(1);
        let on_stretch: Vec<&RangeAtDepth> =
            (trial.points.iter()).filter(|point| pings.contains(&point.ping)).collect();
        let every = on_stretch.len().div_ceil(MOST_POINTS).max(1);
        let depths = trial.points.iter().map(|point| point.depth_m);
        let [least_m, most_m] = ends(depths.collect());
        let margin_m = (0.05 * (most_m - least_m)).max(0.05);
        Self {
            log: trial.points.iter().step_by(step).collect(),
            stretch: on_stretch.into_iter().step_by(every).collect(),
            depths_m: [least_m - margin_m, most_m + margin_m],
        }
    }

    fn ranges(
        &self,
        painter: &Painter,
        rect: Rect,
        (factor, in_use): (f64, &Calibration),
        options: &ViewOptions,
    ) {
        let units = options.units;
        let ends = self.depths_m.map(|depth_m| units.in_unit(depth_m));
        let across = Axis::new(&format!("sounding, {}", units.symbol()), ends);
        let up = Axis::new(
            &format!("range, {}", units.symbol()),
            ends.map(|depth| depth / factor.min(1.0)),
        );
        let axes = PlotAxes::new(painter, rect, across, up);
        axes.draw(painter, theme::plot_ink(options));
        let at = |point: &RangeAtDepth| {
            axes.at(units.in_unit(point.depth_m), units.in_unit(point.range_m))
        };
        let inner = painter.with_clip_rect(axes.area);
        dots(&inner, self.log.iter().map(|point| at(point)), faint(options));
        let line = |range_m: &dyn Fn(f64) -> f64| {
            let of =
                |depth_m: f64| axes.at(units.in_unit(depth_m), units.in_unit(range_m(depth_m)));
            self.depths_m.map(of)
        };
        let used = line(&|depth_m| match (in_use.mode, in_use.factor()) {
            (ScaleMode::FlatSpot, Some(used)) => depth_m / used,
            _ => depth_m + in_use.offset_m,
        });
        let stroke = Stroke::new(1.0, theme::plot_ink(options));
        inner.extend(egui::Shape::dashed_line(&used, stroke, 4.0, 3.0));
        let colour = ink(options);
        dots(&inner, self.stretch.iter().map(|point| at(point)), colour);
        let proposed = line(&|depth_m| depth_m / factor);
        inner.line_segment(proposed, Stroke::new(1.5, colour));
    }

    fn residuals(&self, painter: &Painter, rect: Rect, factor: f64, options: &ViewOptions) {
        let units = options.units;
        let left_m = |point: &RangeAtDepth| factor * point.range_m - point.depth_m;
        let all = self.log.iter().map(|point| left_m(point).abs());
        let [_, reach_m] = ends(all.collect());
        let reach_m = reach_m.max(LEAST_REACH_M);
        let ends = self.depths_m.map(|depth_m| units.in_unit(depth_m));
        let across = Axis::new(&format!("residual over sounding, {}", units.symbol()), ends);
        let up = Axis {
            // The numbers leave no space for a name.
            name: String::new(),
            ends: [-reach_m, reach_m],
            ticks: [-reach_m, 0.0, reach_m]
                .map(|metres| (metres, units.small_difference(metres)))
                .to_vec(),
        };
        let axes = PlotAxes::new(painter, rect, across, up);
        axes.draw(painter, theme::plot_ink(options));
        let at = |point: &RangeAtDepth| axes.at(units.in_unit(point.depth_m), left_m(point));
        let inner = painter.with_clip_rect(axes.area);
        dots(&inner, self.log.iter().map(|point| at(point)), faint(options));
        dots(&inner, self.stretch.iter().map(|point| at(point)), ink(options));
        let zero = ends.map(|depth| axes.at(depth, 0.0));
        inner.line_segment(zero, Stroke::new(1.0, ink(options)));
    }
}

/// Returns the ends of the values, without the share [`TAIL`] at either end.
fn ends(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_unstable_by(f64::total_cmp);
    let tail = (TAIL * values.len() as f64) as usize;
    let ends = values.get(tail).zip(values.iter().rev().nth(tail));
    ends.map_or([0.0, 1.0], |(least, most)| [*least, *most])
}

fn dots(painter: &Painter, places: impl Iterator<Item = egui::Pos2>, colour: Color32) {
    painter.extend(places.map(|at| egui::Shape::circle_filled(at, 1.2, colour)));
}

fn faint(options: &ViewOptions) -> Color32 {
    theme::plot_ink(options).gamma_multiply(0.45)
}

/// Returns the colour of the proposed scale on the background of a panel.
fn ink(options: &ViewOptions) -> Color32 {
    theme::proposal_ink(options)
}
