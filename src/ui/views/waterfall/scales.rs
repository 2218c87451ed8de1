//! Draws range lines across the picture, ticks of ping and time along it, and the names of its
//! sides.

use super::labels::{INK, WaterfallLabels};
use super::lens::{Lens, LensPlace};
use crate::app::{Orientation, ViewOptions};
use crate::ui::{text, theme};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::picture::PictureGeometry;
use bathyscope_bottom::presentation::ticks;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{Side, SideSpan, Survey};
use egui::{Align2, Color32, Painter, Pos2, Stroke, vec2};

/// Least distance between range lines, screen points.
const LINE_POINTS: f64 = 45.0;
/// Distance from the name of a side to the words beside it, screen points.
const BELOW_SIDE: f32 = 20.0;
/// Least distance between ticks along the track, screen points.
const TICK_POINTS: f64 = 120.0;

/// Largest number of places along the track at which a range line is computed.
const LOOKED_UP: usize = 256;
/// Largest number of range lines on a side: with a damaged scale there would be far too many.
const MOST_LINES: u32 = 1000;

/// Lines of equal range on both sides, on the ground or slant, as far as the picture extends. The
/// picture is drawn with the recorder's scale; the lines are at the ranges shown by the cloud and
/// by every read-out.
pub(super) struct RangeLines {
    step_m: f64,
    units: Units,
    lines: Vec<ShownRangeLine>,
}

/// A line of equal range on one side.
struct ShownRangeLine {
    range_m: f64,
    points: Vec<Pos2>,
}

impl RangeLines {
    /// Returns the visible lines of a picture `far_m` wide on each side.
    pub(super) fn in_view(
        lens: &Lens,
        survey: &Survey,
        reduction: Reduction<'_>,
        far_m: f64,
        units: Units,
    ) -> Self {
        let step_m = units.round_up_m(lens.metres_per_point() * LINE_POINTS);
        let lines = match lens.geometry() {
            PictureGeometry::Ground => on_ground(lens, step_m, far_m),
            PictureGeometry::Slant | PictureGeometry::SlantBeyondWater => {
                in_slant_range(lens, survey, reduction, step_m, far_m)
            }
        };
        Self { step_m, units, lines }
    }

    /// Draws the lines.
    pub(super) fn draw(&self, painter: &Painter, ink: Color32) {
        for line in &self.lines {
            let stroke = Stroke::new(1.0, ink);
            match line.points.as_slice() {
                // The painter aligns a straight line to pixels.
                [start, end] => painter.line_segment([*start, *end], stroke),
                points => painter.line(points.to_vec(), stroke),
            };
        }
    }

    /// Writes the ranges of the lines at the beginning of the picture.
    pub(super) fn label(&self, labels: &mut WaterfallLabels<'_>, lens: &Lens) {
        let (anchor, shift) = match lens.orientation {
            Orientation::Horizontal => (Align2::LEFT_CENTER, vec2(6.0, 0.0)),
            Orientation::Vertical => (Align2::CENTER_TOP, vec2(0.0, 4.0)),
        };
        for line in &self.lines {
            let (first, last) = (line.points.first(), line.points.last());
            let start = if lens.is_flipped() { last } else { first };
            if let Some(start) = start {
                let label = self.units.tick_with_unit(line.range_m, self.step_m);
                labels.write(*start + shift, anchor, &label, INK);
            }
        }
    }
}

/// Returns lines of equal distance on the ground.
fn on_ground(lens: &Lens, step_m: f64, far_m: f64) -> Vec<ShownRangeLine> {
    let mut lines = Vec::new();
    for side in Side::BOTH {
        let seen = lens.seen_of(side);
        for line in 1..=MOST_LINES {
            let range_m = f64::from(line) * step_m;
            if range_m > seen.end.min(far_m) {
                break;
            }
            if seen.contains(&range_m) {
                let points = lens.line_at_distance(side, range_m).to_vec();
                lines.push(ShownRangeLine { range_m, points });
            }
        }
    }
    lines
}

/// A place of a range line: the ping, the recorded range, and the distance from the middle at which
/// that range is shown, metres.
struct LinePlace {
    ping: usize,
    recorded_m: f64,
    shown_m: f64,
}

fn in_slant_range(
    lens: &Lens,
    survey: &Survey,
    reduction: Reduction<'_>,
    step_m: f64,
    far_m: f64,
) -> Vec<ShownRangeLine> {
    let visible = lens.visible(survey.side_scan.len());
    let step = visible.len().div_ceil(LOOKED_UP).max(1);
    let mut lines = Vec::new();
    for side in Side::BOTH {
        let seen = lens.seen_of(side);
        let farthest = seen.end.min(far_m);
        let pings = visible.clone().step_by(step);
        let spans: Vec<(usize, SideSpan)> =
            pings.filter_map(|ping| Some((ping, *survey.span(ping, side)?))).collect();
        // Empty if the side was not recorded in the visible pings.
        if spans.is_empty() {
            continue;
        }
        for line in 1..=MOST_LINES {
            let range_m = f64::from(line) * step_m;
            let place = |(ping, span): &(usize, SideSpan)| {
                let recorded_m = reduction.recorded_range_m(span, range_m);
                LinePlace {
                    ping: *ping,
                    recorded_m,
                    shown_m: lens.distance_m(side, *ping as f64, recorded_m),
                }
            };
            let places: Vec<LinePlace> = spans.iter().map(place).collect();
            let nearest = places.iter().map(|place| place.shown_m);
            if nearest.fold(f64::MAX, f64::min) > farthest {
                break;
            }
            let in_view = |place: &LinePlace| place.shown_m > 0.0 && seen.contains(&place.shown_m);
            if places.iter().any(in_view) {
                let points = points(lens, side, &places);
                lines.push(ShownRangeLine { range_m, points });
            }
        }
    }
    lines
}

/// Returns a line through the places of one range: straight across the whole picture if all places
/// have the same distance.
fn points(lens: &Lens, side: Side, places: &[LinePlace]) -> Vec<Pos2> {
    let first_m = places.first().map_or(0.0, |place| place.shown_m);
    let alike = |place: &LinePlace| (place.shown_m - first_m).abs() < 1e-3;
    if places.iter().all(alike) {
        return lens.line_at_distance(side, first_m).to_vec();
    }
    let at = |place: &LinePlace| {
        lens.screen_at(LensPlace::of(place.ping as f64 + 0.5, side, place.recorded_m))
    };
    places.iter().map(at).collect()
}

/// Writes the geometry of the across direction and the stretch along the track, at the beginning of
/// the picture.
pub(super) fn geometry(labels: &mut WaterfallLabels<'_>, lens: &Lens, stretch: Option<f64>) {
    let across = match lens.geometry() {
        PictureGeometry::Slant => "slant range",
        PictureGeometry::SlantBeyondWater => "slant range, no water column",
        PictureGeometry::Ground => "ground range",
    };
    let along = match stretch {
        Some(stretch) if (stretch - 1.0).abs() < 0.005 => ", 1:1".to_owned(),
        Some(stretch) => format!(", along x{stretch:.2}"),
        None => String::new(),
    };
    let flipped = if lens.is_flipped() { ", flipped" } else { "" };
    let at = lens.rect.shrink(6.0).left_bottom();
    let at = match lens.orientation {
        Orientation::Horizontal => at - vec2(0.0, BELOW_SIDE),
        // The name of the side and the change of its ranges are in this corner.
        Orientation::Vertical => at - vec2(0.0, 2.0 * BELOW_SIDE),
    };
    let words = format!("{across}{along}{flipped}");
    labels.write(at, Align2::LEFT_BOTTOM, &words, INK);
}

/// Writes the change of the recorded ranges, beside the name of the side at the end of the picture.
pub(super) fn range_change(labels: &mut WaterfallLabels<'_>, lens: &Lens, change: &str) {
    let rect = lens.rect.shrink(6.0);
    let (at, anchor) = match lens.orientation {
        Orientation::Horizontal => (rect.right_top() + vec2(0.0, BELOW_SIDE), Align2::RIGHT_TOP),
        Orientation::Vertical => (rect.left_bottom() - vec2(0.0, BELOW_SIDE), Align2::LEFT_BOTTOM),
    };
    labels.write(at, anchor, change, INK);
}

/// Draws ping numbers and times at the lower or left edge of the picture.
pub(super) fn ticks(
    painter: &Painter,
    labels: &mut WaterfallLabels<'_>,
    lens: &Lens,
    survey: &Survey,
    ink: Color32,
) {
    let step = ticks::round_up((lens.pings_per_point() * TICK_POINTS).max(1.0)) as usize;
    let seen = lens.visible(survey.side_scan.len());
    let metres = lens.metres();
    let (edge_m, inward, anchor) = match lens.orientation {
        Orientation::Horizontal => (metres.end, vec2(0.0, -6.0), Align2::CENTER_BOTTOM),
        Orientation::Vertical => (metres.start, vec2(6.0, 0.0), Align2::LEFT_CENTER),
    };
    for ping in (seen.start.next_multiple_of(step)..seen.end).step_by(step) {
        let at = lens.at(ping as f64 + 0.5, edge_m);
        painter.line_segment([at, at + inward], Stroke::new(1.0, ink));
        let Some(recorded) = survey.side_scan.get(ping) else {
            continue;
        };
        let clock = text::clock(survey.start_unix_s, recorded.time_s);
        let label = format!("ping {ping}  {}", clock.trim_end_matches(" UTC"));
        labels.write(at + inward * 1.4, anchor, &label, INK);
    }
}

/// Writes the names of the visible sides in the colours of their first returns, at the end of the
/// picture.
pub(super) fn sides(labels: &mut WaterfallLabels<'_>, lens: &Lens, options: &ViewOptions) {
    for side in Side::BOTH {
        if lens.seen_of(side).is_empty() {
            continue;
        }
        let rect = lens.rect.shrink(6.0);
        let (at, anchor) = match (lens.orientation, lens.is_first(side)) {
            (Orientation::Horizontal, true) => (rect.right_top(), Align2::RIGHT_TOP),
            (Orientation::Vertical, true) => (rect.left_bottom(), Align2::LEFT_BOTTOM),
            (_, false) => (rect.right_bottom(), Align2::RIGHT_BOTTOM),
        };
        // Thin letters must be brighter than a line to be readable on the dark background.
        let ink = theme::side_colour(options, side).lerp_to_gamma(INK, 0.35);
        labels.write(at, anchor, side.name(), ink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::views::waterfall::camera::EXTENT;
    use crate::ui::views::waterfall::camera::{Camera, PictureExtent, Size};
    use bathyscope_bottom::calibration::Calibration;
    use bathyscope_bottom::cloud::Correction;
    use bathyscope_log::survey::SidePing;
    use egui::{Rect, pos2, vec2};
    use std::sync::Arc;

    #[test]
    fn range_lines_stand_at_the_ranges_of_the_read_outs() {
        let span = SideSpan::of_bytes(1000, [0.0, 20.0]);
        let ping = SidePing {
            time_s: 0.0,
            depth_m: 3.0,
            depth_fault: None,
            port: Some(span),
            starboard: Some(span),
        };
        let survey = Survey { side_scan: Arc::new(vec![ping; 50]), ..Survey::default() };
        let calibration = Calibration { offset_m: -0.4, ..Calibration::default() };
        let correction = Correction::default();
        let reduction = Reduction::new(&calibration, &correction);
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(500.0, 400.0));
        let extent = PictureExtent { pings: 50.0, near_m: -20.0, far_m: 20.0, ..EXTENT };
        let size = Size::of(rect.size(), Orientation::Horizontal);
        let lens = Lens::new(Camera::start(&extent, size), rect, Orientation::Horizontal);
        let lines = RangeLines::in_view(&lens, &survey, reduction, 20.0, Units::default());
        assert!(lines.lines.len() > 4);
        for line in &lines.lines {
            let recorded_m = lens.place_at(line.points[0]).across_m.abs();
            let read_m = reduction.range_m(&span, span.sample_at(recorded_m));
            assert!((read_m - line.range_m).abs() < 0.01, "{read_m} {}", line.range_m);
            assert!((recorded_m - line.range_m + 0.4).abs() < 0.01, "{recorded_m}");
        }
    }
}
