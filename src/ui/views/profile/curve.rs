//! The curves: raw samples faint behind, normalised intensity in front.

use super::Shown;
use super::plot::ProfilePlot;
use crate::app::ViewOptions;
use crate::ui::raster::{PaintedArea, RasterTexture};
use crate::ui::{place, theme};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::first_return::Normalisation;
use bathyscope_log::survey::{Side, SideSpan};
use egui::{Color32, Painter, Pos2, pos2};

/// Width of a curve, points.
const WIDTH: f32 = 1.0;

/// Draws both curves on both sides.
pub(super) fn draw(
    painter: &Painter,
    plot: &ProfilePlot,
    shown: &Shown<'_>,
    normalisation: &Normalisation,
    options: &ViewOptions,
    picture: &mut Option<RasterTexture>,
) {
    let ink = theme::plot_ink(options);
    let mut raster = PaintedArea::new(painter, plot.area.expand(1.0), Color32::TRANSPARENT);
    for side in Side::BOTH {
        let Some(span) = shown.recorded.side(side) else {
            continue;
        };
        if let Some(samples) = shown.survey.samples(shown.ping, side) {
            let raw: Vec<f32> =
                (0..samples.len()).map(|index| f32::from(samples.get(index)) / 255.0).collect();
            let faint = ink.gamma_multiply(0.45);
            let points = points(plot, shown.reduction, span, side, &raw);
            raster.line(&points, WIDTH, faint);
        }
        let normalised = normalisation.profile(shown.survey, shown.ping, side);
        let points = points(plot, shown.reduction, span, side, &normalised);
        raster.line(&points, WIDTH, ink);
    }
    raster.show(painter, picture);
}

/// One vertex a value, or the largest and smallest of a pixel column where values share one.
fn points(
    plot: &ProfilePlot,
    reduction: Reduction<'_>,
    span: &SideSpan,
    side: Side,
    values: &[f32],
) -> Vec<Pos2> {
    let samples_per_value = f64::from(span.count) / values.len().max(1) as f64;
    let x = |index: usize| {
        let range_m = reduction.range_m(span, (index as f64 + 0.5) * samples_per_value);
        plot.x(place::across_m(side, range_m))
    };
    let mut points: Vec<Pos2> = Vec::new();
    let mut column: Option<(f32, f32, f32)> = None;
    let mut finish = |column: Option<(f32, f32, f32)>| {
        if let Some((x, low, high)) = column {
            points.push(pos2(x, plot.y(low)));
            if high > low {
                points.push(pos2(x, plot.y(high)));
            }
        }
    };
    for (index, &value) in values.iter().enumerate() {
        let x = x(index);
        column = match column {
            Some((at, low, high)) if (at - x).abs() < 1.0 => {
                Some((at, low.min(value), high.max(value)))
            }
            before => {
                finish(before);
                Some((x, value, value))
            }
        };
    }
    finish(column);
    points
}
