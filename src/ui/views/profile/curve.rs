//! The curves: raw samples faint behind, normalised intensity in front.

use super::Shown;
use super::plot::Plot;
use crate::app::ViewOptions;
use crate::bottom::cloud::Reduction;
use crate::sonar::first_return::Normalisation;
use crate::survey::{Side, SideSpan};
use crate::ui::theme;
use egui::{Color32, Painter, Pos2, Stroke, pos2};

/// Draws both curves on both sides.
pub(super) fn draw(
    painter: &Painter,
    plot: &Plot,
    shown: &Shown<'_>,
    normalisation: &Normalisation,
    options: &ViewOptions,
) {
    let ink = theme::plot_ink(options);
    let painter = painter.with_clip_rect(plot.area.expand(1.0));
    for side in Side::BOTH {
        let Some(span) = shown.recorded.side(side) else {
            continue;
        };
        if let Some(samples) = shown.survey.samples(shown.ping, side) {
            let raw: Vec<f32> = (0..samples.len())
                .map(|index| f32::from(samples.get(index)) / 255.0)
                .collect();
            let faint = ink.gamma_multiply(0.45);
            line(&painter, plot, shown.reduction, span, side, &raw, faint);
        }
        let normalised = normalisation.profile(shown.survey, shown.ping, side);
        line(
            &painter,
            plot,
            shown.reduction,
            span,
            side,
            &normalised,
            ink,
        );
    }
}

/// One vertex a value, or the largest and smallest of a pixel column where values share one.
fn line(
    painter: &Painter,
    plot: &Plot,
    reduction: Reduction<'_>,
    span: &SideSpan,
    side: Side,
    values: &[f32],
    colour: Color32,
) {
    let samples_per_value = f64::from(span.count) / values.len().max(1) as f64;
    let x = |index: usize| {
        let range_m = reduction.range_m(span, (index as f64 + 0.5) * samples_per_value);
        plot.x(match side {
            Side::Port => -range_m,
            Side::Starboard => range_m,
        })
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
    painter.line(points, Stroke::new(1.0, colour));
}
