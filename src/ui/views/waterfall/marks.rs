//! Places that are marked on the picture: cross-hairs, flat stretches, and what the picture cannot be trusted for.

use super::labels;
use super::lens::{Lens, Place, across_m};
use crate::app::{App, Mark};
use crate::survey::{SideScanState, Survey};
use crate::ui::theme;
use egui::{Align2, Color32, Painter, Rect, Stroke, vec2};
use std::ops::Range;

/// A thin line at the ping and, where the mark has a sample, one at its range.
pub(super) fn cross_hair(
    painter: &Painter,
    lens: &Lens,
    survey: &Survey,
    mark: &Mark,
    colour: Color32,
) {
    let ping = mark.ping as f64 + 0.5;
    painter.line_segment(lens.line_at_ping(ping), Stroke::new(1.0, colour));
    let Some((side, sample)) = mark.side.zip(mark.sample) else {
        return;
    };
    let span = survey
        .side_scan
        .get(mark.ping)
        .and_then(|ping| ping.side(side));
    if let Some(span) = span {
        let across_m = across_m(side, span.range_m(f64::from(sample)));
        let faint = colour.gamma_multiply(0.6);
        painter.line_segment(lens.line_at_range(across_m), Stroke::new(1.0, faint));
        let at = lens.screen_at(Place { ping, across_m });
        painter.circle_stroke(at, 5.0, Stroke::new(1.5, colour));
    }
}

/// The stretch that the calibration stands on, shaded; the other ranked flat stretches as bars at the nadir.
pub(super) fn flat_spots(painter: &Painter, lens: &Lens, app: &App) {
    let is_picture = app
        .survey
        .as_ref()
        .is_some_and(|survey| survey.has_side_scan());
    let Some(products) = app.products.as_ref().filter(|_| is_picture) else {
        return;
    };
    let colour = theme::selection_colour();
    for spot in products.flat_spots.iter() {
        let [a, b] = [spot.pings.start, spot.pings.end].map(|ping| {
            lens.screen_at(Place {
                ping: ping as f64,
                across_m: 0.0,
            })
        });
        let bar = Rect::from_two_pos(a, b).expand2(vec2(1.0, 1.0));
        painter.rect_filled(bar, 1.0, colour.gamma_multiply(0.8));
    }
    if let Some(spot) = &products.calibration.flat_spot {
        stretch(painter, lens, &spot.pings, colour, "flat spot");
    }
}

fn stretch(painter: &Painter, lens: &Lens, pings: &Range<usize>, colour: Color32, name: &str) {
    let [start, end] = [pings.start, pings.end].map(|ping| lens.line_at_ping(ping as f64));
    let area = Rect::from_two_pos(start[0], end[1]).intersect(lens.rect);
    if area.is_negative() {
        return;
    }
    painter.rect_filled(area, 0.0, colour.gamma_multiply(0.10));
    for edge in [start, end] {
        painter.line_segment(edge, Stroke::new(1.0, colour.gamma_multiply(0.7)));
    }
    labels::text(
        painter,
        area.left_top() + vec2(4.0, 4.0),
        Align2::LEFT_TOP,
        name,
    );
}

/// A sentence on the picture that changes its meaning.
pub(super) fn banner(painter: &Painter, rect: Rect, text: &str) {
    let galley = painter.layout(
        text.to_owned(),
        egui::FontId::proportional(14.0),
        theme::outlier_colour(),
        (rect.width() - 40.0).max(60.0),
    );
    let area = Align2::CENTER_TOP.anchor_size(rect.center_top() + vec2(0.0, 14.0), galley.size());
    painter.rect_filled(area.expand(8.0), 4.0, Color32::from_black_alpha(200));
    painter.galley(area.min, galley, Color32::PLACEHOLDER);
}

/// What keeps the picture from being a picture of the bottom.
pub(super) fn warning(survey: &Survey) -> Option<String> {
    match survey.side_scan_state {
        SideScanState::Usable => None,
        SideScanState::Absent => {
            Some("no side-scan: this log holds no side-scan frames".to_owned())
        }
        SideScanState::Noise { range_m } => Some(format!(
            "no side-scan: range stuck at ±{range_m:.1} m, noise; was a transducer connected?"
        )),
    }
}
