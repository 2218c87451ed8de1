//! Cross-hairs on the picture, and what it cannot be trusted for.

use super::lens::{Lens, LensPlace};
use crate::app::LogPlace;
use crate::ui::theme;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{SideScanState, Survey};
use egui::{Align2, Color32, Painter, Rect, Stroke, vec2};

/// A thin line at the ping and, where the mark has a sample, one at its range.
pub(super) fn cross_hair(
    painter: &Painter,
    lens: &Lens,
    survey: &Survey,
    mark: &LogPlace,
    colour: Color32,
) {
    let ping = mark.ping as f64 + 0.5;
    painter.line_segment(lens.line_at_ping(ping), Stroke::new(1.0, colour));
    let Some((side, sample)) = mark.side.zip(mark.sample) else {
        return;
    };
    let recorded = survey.side_scan.get(mark.ping);
    if let Some(span) = recorded.and_then(|recorded| recorded.side(side)) {
        let place = LensPlace::of(ping, side, span.range_m(f64::from(sample)));
        let faint = colour.gamma_multiply(0.6);
        let along = lens.line_at_range(place.across_m);
        painter.line(along, Stroke::new(1.0, faint));
        let at = lens.screen_at(place);
        painter.circle_stroke(at, 5.0, Stroke::new(1.5, colour));
    }
}

/// A sentence on the picture that changes its meaning; returns what it covers.
pub(super) fn banner(painter: &Painter, rect: Rect, text: &str) -> Rect {
    let (font, colour) = (egui::FontId::proportional(14.0), theme::OUTLIER_COLOUR);
    let width = (rect.width() - 40.0).max(60.0);
    let galley = painter.layout(text.to_owned(), font, colour, width);
    let area = Align2::CENTER_TOP.anchor_size(rect.center_top() + vec2(0.0, 14.0), galley.size());
    let ground = area.expand(8.0);
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(200));
    painter.galley(area.min, galley, Color32::PLACEHOLDER);
    ground
}

/// Reason why the picture does not show the bottom; `None` if it does.
pub(super) fn warning(survey: &Survey, units: Units) -> Option<String> {
    match survey.side_scan_state {
        SideScanState::Usable => None,
        SideScanState::Absent => {
            Some("no side-scan: this log holds no side-scan frames".to_owned())
        }
        SideScanState::Noise { range_m } => Some(format!(
            "no side-scan: range stuck at ±{}, noise; was a transducer connected?",
            units.measure(f64::from(range_m), 1)
        )),
    }
}
