//! Range lines across the picture, and ticks of ping and time along it.

use super::labels;
use super::lens::{Lens, Place, across_m};
use crate::app::Orientation;
use crate::survey::{Side, Survey};
use crate::ui::text;
use egui::{Align2, Color32, Painter, Stroke, vec2};

/// Screen points between range lines, at least.
const LINE_POINTS: f64 = 45.0;
/// Screen points between ticks along the track, at least.
const TICK_POINTS: f64 = 130.0;

/// Half the height of a label, points.
const LABEL_POINTS: f32 = 9.0;

/// Lines of equal slant range on both sides, labelled where the picture begins.
pub(super) fn range_lines(painter: &Painter, lens: &Lens, far_m: f64, ink: Color32) {
    let step_m = text::round_step(lens.metres_per_point() * LINE_POINTS);
    let seen = lens.metres();
    let farthest = seen.start.abs().max(seen.end.abs()).min(far_m);
    for line in 1..=(farthest / step_m).floor() as u32 {
        let range_m = f64::from(line) * step_m;
        for side in Side::BOTH {
            let across_m = across_m(side, range_m);
            if !seen.contains(&across_m) {
                continue;
            }
            let ends = lens.line_at_range(across_m);
            painter.line_segment(ends, Stroke::new(1.0, ink));
            let (anchor, shift) = match lens.orientation {
                Orientation::Horizontal => (Align2::LEFT_CENTER, vec2(6.0, 0.0)),
                Orientation::Vertical => (Align2::CENTER_TOP, vec2(0.0, 4.0)),
            };
            // Half a label at the edge of the picture helps nobody.
            if lens
                .rect
                .shrink(LABEL_POINTS)
                .contains(ends[0] + shift * 3.0)
            {
                let label = text::metres(range_m, step_m);
                labels::text(painter, ends[0] + shift, anchor, &label);
            }
        }
    }
}

/// Ping numbers and times at the far edge of starboard (below) or port (left).
pub(super) fn ticks(painter: &Painter, lens: &Lens, survey: &Survey, ink: Color32) {
    let step = text::round_step((lens.pings_per_point() * TICK_POINTS).max(1.0)) as usize;
    let seen = lens.visible(survey.side_scan.len());
    for ping in (seen.start.next_multiple_of(step)..seen.end).step_by(step) {
        let metres = lens.metres();
        let (edge_m, inward, anchor) = match lens.orientation {
            Orientation::Horizontal => (metres.end, vec2(0.0, -6.0), Align2::CENTER_BOTTOM),
            Orientation::Vertical => (metres.start, vec2(6.0, 0.0), Align2::LEFT_CENTER),
        };
        let at = lens.screen_at(Place {
            ping: ping as f64 + 0.5,
            across_m: edge_m,
        });
        painter.line_segment([at, at + inward], Stroke::new(1.0, ink));
        let Some(recorded) = survey.side_scan.get(ping) else {
            continue;
        };
        let clock = text::clock(survey.start_unix_s, recorded.time_s);
        let label = format!("{ping}  {}", clock.trim_end_matches(" UTC"));
        // A label that would hang over an end of the picture stays away.
        let room = match lens.orientation {
            Orientation::Horizontal => vec2(-40.0, 0.0),
            Orientation::Vertical => vec2(0.0, -8.0),
        };
        if lens.rect.expand2(room).contains(at + inward) {
            labels::text(painter, at + inward, anchor, &label);
        }
    }
}
