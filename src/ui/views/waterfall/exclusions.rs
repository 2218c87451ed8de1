//! Draws a veil over the pings that are excluded.

use super::labels::{self, WaterfallLabels};
use super::lens::Lens;
use crate::app::App;
use bathyscope_log::survey::ExclusionReason;
use egui::{Align2, Color32, Painter, Pos2, Rect, Stroke, pos2, vec2};

/// Distance between the lines of the veil, points.
const HATCH: f32 = 14.0;
/// Width on the screen below which a stretch has edges but no lines, points.
const NARROW: f32 = 6.0;
/// Width on the screen below which a stretch is labelled with its reason only, points.
const WORDY: f32 = 90.0;

/// A visible excluded stretch.
pub(super) struct Veiled {
    area: Rect,
    edges: [[Pos2; 2]; 2],
    reason: ExclusionReason,
}

/// Returns the visible excluded stretches.
pub(super) fn in_view(lens: &Lens, app: &App) -> Vec<Veiled> {
    let found = app.logs.shown.exclusions();
    let stretches = found.iter().flat_map(|found| &found.exclusions.stretches);
    let seen = stretches.filter_map(|stretch| {
        let pings = stretch.pings?;
        Some(Veiled { area: area(lens, pings)?, edges: edges(lens, pings), reason: stretch.reason })
    });
    seen.collect()
}

impl Veiled {
    /// Draws the veil; the picture below stays readable.
    pub(super) fn draw(&self, painter: &Painter) {
        veil(painter, self.area);
        for edge in self.edges {
            painter.line_segment(edge, Stroke::new(1.0, Color32::from_white_alpha(150)));
        }
    }

    /// Writes the reason at the end of the stretch.
    pub(super) fn label(&self, labels: &mut WaterfallLabels<'_>) {
        let reason = self.reason.name();
        let text = if self.area.width() < WORDY {
            reason.to_owned()
        } else {
            format!("excluded: {reason}")
        };
        let corner = self.area.left_bottom() + vec2(5.0, -22.0);
        labels.write(corner, Align2::LEFT_BOTTOM, &text, labels::INK);
    }
}

pub(super) fn edges(lens: &Lens, [first, last]: [usize; 2]) -> [[Pos2; 2]; 2] {
    [first as f64, last as f64 + 1.0].map(|ping| lens.line_at_ping(ping))
}

/// Returns the area of pings in the picture; `None` if they are not visible.
pub(super) fn area(lens: &Lens, pings: [usize; 2]) -> Option<Rect> {
    let [from, to] = edges(lens, pings);
    let area = Rect::from_two_pos(from[0], to[1]).intersect(lens.rect);
    area.is_positive().then_some(area)
}

/// Darkens a part of the picture, which is dark or coloured in any theme, and hatches it.
pub(super) fn veil(painter: &Painter, area: Rect) {
    painter.rect_filled(area, 0.0, Color32::from_black_alpha(150));
    if area.width().min(area.height()) < NARROW {
        return;
    }
    let painter = painter.with_clip_rect(area.intersect(painter.clip_rect()));
    let line = Stroke::new(1.0, Color32::from_white_alpha(60));
    // On the grid of the screen, so that the lines stay in place while the picture moves.
    let reach = area.height();
    let mut x = (area.left() / HATCH).floor() * HATCH;
    while x < area.right() + reach {
        painter.line_segment([pos2(x, area.top()), pos2(x - reach, area.bottom())], line);
        x += HATCH;
    }
}
