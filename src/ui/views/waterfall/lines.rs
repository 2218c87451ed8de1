//! First return and recorded depth over the picture.

use super::camera::{Lens, Place, across_m};
use super::drawing::Drawing;
use crate::first_return::FirstReturns;
use crate::survey::{Side, Survey};
use crate::waterfall::LineStep;
use egui::{Color32, Painter, Pos2, Shape, Stroke};

/// Pings wider than this many points get a dot each.
const DOT_POINTS: f64 = 7.0;

/// How a line looks.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    /// Its colour.
    pub colour: Color32,
    /// Its width, points.
    pub width: f32,
}

/// The first return of a side; stretches above the canopy are dashed and paler, pings without a pick are gaps.
pub(super) fn first_return(
    painter: &Painter,
    lens: &Lens,
    survey: &Survey,
    drawing: &Drawing,
    returns: &FirstReturns,
    side: Side,
    pen: Pen,
) {
    let step = LineStep::Picks {
        returns,
        lines: drawing.picks.as_deref(),
        side,
    };
    draw(painter, &runs(lens, survey, step, side), lens, pen);
}

/// The recorded depth, as the slant range at which a flat bottom would first be heard.
pub(super) fn depth(painter: &Painter, lens: &Lens, survey: &Survey, drawing: &Drawing, pen: Pen) {
    let step = LineStep::Depth(drawing.depth.as_ref());
    for side in Side::BOTH {
        draw(painter, &runs(lens, survey, step, side), lens, pen);
    }
}

/// A stretch of a line without gaps and of one kind.
struct Run {
    canopy: bool,
    points: Vec<Pos2>,
}

/// The line over the pings in view: one vertex a ping, or two (the extremes) a pixel column where pings share one.
fn runs(lens: &Lens, survey: &Survey, step: LineStep<'_>, side: Side) -> Vec<Run> {
    let halvings = lens.pings_per_point().max(1.0).log2().ceil() as u8;
    let block = 1_usize << halvings;
    let seen = lens.visible(survey.side_scan.len());
    let blocks = seen.start / block..seen.end.div_ceil(block);
    let mut runs: Vec<Run> = Vec::new();
    let mut is_broken = true;
    for index in blocks.start.saturating_sub(1)..blocks.end + 1 {
        let span = step.span(survey, halvings, index);
        if span.is_gap() {
            is_broken = true;
            continue;
        }
        let at = |range_m: f32| {
            lens.to_screen(Place {
                ping: (index as f64 + 0.5) * block as f64,
                across_m: across_m(side, f64::from(range_m)),
            })
        };
        let (near, far) = (at(span.min_m), at(span.max_m));
        let last = runs.last_mut().filter(|_| !is_broken);
        let joint = last.as_ref().and_then(|run| run.points.last().copied());
        match last.filter(|run| run.canopy == span.canopy) {
            Some(run) => run.points.push(near),
            None => runs.push(Run {
                canopy: span.canopy,
                points: joint.into_iter().chain([near]).collect(),
            }),
        }
        if near != far
            && let Some(run) = runs.last_mut()
        {
            run.points.push(far);
        }
        is_broken = false;
    }
    runs
}

fn draw(painter: &Painter, runs: &[Run], lens: &Lens, pen: Pen) {
    let ping_points = 1.0 / lens.pings_per_point();
    for run in runs {
        let pale = pen.colour.lerp_to_gamma(Color32::WHITE, 0.45);
        let colour = if run.canopy { pale } else { pen.colour };
        let stroke = Stroke::new(pen.width, colour);
        match (run.points.as_slice(), run.canopy) {
            ([single], _) => {
                painter.circle_filled(*single, pen.width, colour);
            }
            (points, true) => {
                painter.extend(Shape::dashed_line(points, stroke, 4.0, 3.0));
            }
            (points, false) => {
                painter.line(points.to_vec(), stroke);
            }
        }
        if ping_points >= DOT_POINTS {
            for point in &run.points {
                painter.circle_filled(*point, pen.width * 1.4, colour);
            }
        }
    }
}
