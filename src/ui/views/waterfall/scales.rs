//! Range lines across the picture, ticks of ping and time along it, and the names of its sides.

use super::labels::{INK, Labels};
use super::lens::{Lens, Place, across_m};
use crate::app::{Orientation, ViewOptions};
use crate::survey::{Side, Survey};
use crate::ui::{text, theme};
use egui::{Align2, Color32, Painter, Stroke, vec2};

/// Screen points between range lines, at least.
const LINE_POINTS: f64 = 45.0;
/// Screen points between ticks along the track, at least.
const TICK_POINTS: f64 = 120.0;

/// Lines of equal slant range on both sides, as far as the picture goes.
pub(super) struct RangeLines {
    step_m: f64,
    /// Signed ranges in view.
    across_m: Vec<f64>,
}

impl RangeLines {
    /// The lines that a lens sees of a picture `far_m` wide on each side.
    pub fn in_view(lens: &Lens, far_m: f64) -> Self {
        let step_m = text::round_step(lens.metres_per_point() * LINE_POINTS);
        let seen = lens.metres();
        let farthest = seen.start.abs().max(seen.end.abs()).min(far_m);
        let across_m = (1..=(farthest / step_m).floor() as u32)
            .flat_map(|line| Side::BOTH.map(|side| across_m(side, f64::from(line) * step_m)))
            .filter(|across_m| seen.contains(across_m));
        Self {
            step_m,
            across_m: across_m.collect(),
        }
    }

    /// Draws the lines.
    pub fn draw(&self, painter: &Painter, lens: &Lens, ink: Color32) {
        for &across_m in &self.across_m {
            painter.line_segment(lens.line_at_range(across_m), Stroke::new(1.0, ink));
        }
    }

    /// Writes their ranges where the picture begins.
    pub fn label(&self, labels: &mut Labels<'_>, lens: &Lens) {
        let (anchor, shift) = match lens.orientation {
            Orientation::Horizontal => (Align2::LEFT_CENTER, vec2(6.0, 0.0)),
            Orientation::Vertical => (Align2::CENTER_TOP, vec2(0.0, 4.0)),
        };
        for &across_m in &self.across_m {
            let [start, _] = lens.line_at_range(across_m);
            let label = text::metres(across_m.abs(), self.step_m);
            labels.write(start + shift, anchor, &label, INK);
        }
    }
}

/// Ping numbers and times at the far edge of starboard (below) or port (left).
pub(super) fn ticks(
    painter: &Painter,
    labels: &mut Labels<'_>,
    lens: &Lens,
    survey: &Survey,
    ink: Color32,
) {
    let step = text::round_step((lens.pings_per_point() * TICK_POINTS).max(1.0)) as usize;
    let seen = lens.visible(survey.side_scan.len());
    let metres = lens.metres();
    let (edge_m, inward, anchor) = match lens.orientation {
        Orientation::Horizontal => (metres.end, vec2(0.0, -6.0), Align2::CENTER_BOTTOM),
        Orientation::Vertical => (metres.start, vec2(6.0, 0.0), Align2::LEFT_CENTER),
    };
    for ping in (seen.start.next_multiple_of(step)..seen.end).step_by(step) {
        let at = lens.screen_at(Place {
            ping: ping as f64 + 0.5,
            across_m: edge_m,
        });
        painter.line_segment([at, at + inward], Stroke::new(1.0, ink));
        let Some(recorded) = survey.side_scan.get(ping) else {
            continue;
        };
        let clock = text::clock(survey.start_unix_s, recorded.time_s);
        let label = format!("ping {ping}  {}", clock.trim_end_matches(" UTC"));
        labels.write(at + inward * 1.4, anchor, &label, INK);
    }
}

/// The names of the sides in view, in the colours of their first returns, where the picture ends.
pub(super) fn sides(labels: &mut Labels<'_>, lens: &Lens, options: &ViewOptions) {
    let seen = lens.metres();
    for side in Side::BOTH {
        let is_seen = match side {
            Side::Port => seen.start < 0.0,
            Side::Starboard => seen.end > 0.0,
        };
        if !is_seen {
            continue;
        }
        let rect = lens.rect.shrink(6.0);
        let (at, anchor) = match (lens.orientation, side) {
            (Orientation::Horizontal, Side::Port) => (rect.right_top(), Align2::RIGHT_TOP),
            (Orientation::Vertical, Side::Port) => (rect.left_bottom(), Align2::LEFT_BOTTOM),
            (_, Side::Starboard) => (rect.right_bottom(), Align2::RIGHT_BOTTOM),
        };
        // Thin strokes need more light than a line to be read on the dark.
        let ink = theme::side_colour(options, side).lerp_to_gamma(INK, 0.35);
        labels.write(at, anchor, side.name(), ink);
    }
}
