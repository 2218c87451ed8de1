//! Draws the ranked flat stretches along the nadir, numbered as on the map, the stretch that the
//! calibration was measured on, and the proposed stretch.

use super::labels::WaterfallLabels;
use super::lens::{Lens, LensPlace};
use crate::app::{App, Tool};
use crate::ui::{place, stretch_text, theme};
use bathyscope_bottom::calibration::{FlatSpot, PingRange, ScaleMode};
use bathyscope_log::survey::Side;
use egui::{Align2, Color32, Painter, Pos2, Rect, Stroke, vec2};
use std::ops::Range;

/// Thickness of a bar, points.
const BAR: f32 = 2.0;
/// Greatest distance of the pointer from a bar, points.
const REACH: f32 = 10.0;

/// A visible flat stretch.
pub(super) struct ShownStretch {
    /// Area of the stretch over the whole range of the picture.
    area: Rect,
    edges: [[egui::Pos2; 2]; 2],
    nadir: Rect,
    kind: Kind,
    name: String,
}

/// Kind of a stretch.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    InUse,
    Proposed,
    Ranked,
}

/// Returns the visible stretches: that of the calibration, the proposed one, and the ranked ones if
/// they are shown or one is to be chosen.
pub(super) fn in_view(lens: &Lens, app: &App) -> Vec<ShownStretch> {
    let products = app.logs.shown.products.as_ref();
    let Some(products) = products.filter(|_| place::has_side_scan(app)) else {
        return Vec::new();
    };
    let calibration = &products.calibration;
    let name = match calibration.mode {
        ScaleMode::FlatSpot => "scale from here",
        ScaleMode::Header => "flat stretch, not in use",
    };
    let used = calibration.flat_spot.iter();
    let used = used.filter_map(|spot| stretch(lens, &spot.pings, Kind::InUse, name.to_owned()));
    let proposed = app.logs.shown.proposed_stretch();
    let proposed = proposed.map(|pings| pings.start..pings.end);
    let proposed = proposed.and_then(|pings| {
        let name = "proposed for the scale".to_owned();
        stretch(lens, &pings, Kind::Proposed, name)
    });
    let units = app.view.options.units;
    let ranked = products.flat_spots.iter().enumerate();
    let ranked = ranked.filter(|_| shows_ranked(app)).filter_map(|(rank, spot)| {
        let name = format!("{}: {}", rank + 1, stretch_text::brief(spot, units));
        stretch(lens, &spot.pings, Kind::Ranked, name)
    });
    proposed.into_iter().chain(used).chain(ranked).collect()
}

fn shows_ranked(app: &App) -> bool {
    app.view.options.waterfall.flat_stretches || app.logs.shown.reviewing.tool == Tool::Calibrate
}

/// Returns the ranked stretch whose bar is under the pointer.
pub(super) fn under(lens: &Lens, app: &App, at: Pos2) -> Option<PingRange> {
    let spots = app.logs.shown.products.as_ref()?.flat_spots.iter();
    let mut spots = spots.filter(|_| shows_ranked(app));
    let is_here = |spot: &&FlatSpot| {
        let found = stretch(lens, &spot.pings, Kind::Ranked, String::new());
        found.is_some_and(|found| found.nadir.expand(REACH).contains(at))
    };
    spots.find(is_here).map(FlatSpot::range)
}

fn stretch(lens: &Lens, pings: &Range<usize>, kind: Kind, name: String) -> Option<ShownStretch> {
    let ends = [pings.start as f64, pings.end as f64];
    let edges = ends.map(|ping| lens.line_at_ping(ping));
    let area = Rect::from_two_pos(edges[0][0], edges[1][1]).intersect(lens.rect);
    let [start, end] = ends.map(|ping| lens.screen_at(LensPlace::of(ping, Side::Starboard, 0.0)));
    let nadir = Rect::from_two_pos(start, end).expand(BAR / 2.0);
    area.is_positive().then_some(ShownStretch {
        area,
        edges,
        nadir: nadir.intersect(lens.rect.expand(BAR)),
        kind,
        name,
    })
}

impl ShownStretch {
    /// Draws the stretch: two lines across the picture for the stretch of the calibration and the
    /// proposed one, a bar along the nadir for the others. The echoes between the lines stay
    /// visible.
    pub(super) fn draw(&self, painter: &Painter) {
        let colour = self.colour();
        if self.kind == Kind::Ranked {
            painter.rect_filled(self.nadir.expand(1.0), 1.0, Color32::from_black_alpha(150));
            painter.rect_filled(self.nadir, 1.0, colour);
            return;
        }
        for edge in self.edges {
            painter.line_segment(edge, Stroke::new(3.0, Color32::from_black_alpha(110)));
            let width = if self.kind == Kind::Proposed { 2.0 } else { 1.0 };
            painter.line_segment(edge, Stroke::new(width, colour));
        }
        if self.kind == Kind::Proposed {
            painter.rect_filled(self.nadir.expand(1.0), 1.0, colour);
        }
    }

    /// Writes the name at the beginning of the stretch or, for a bar, in its middle.
    pub(super) fn label(&self, labels: &mut WaterfallLabels<'_>) {
        let (at, anchor) = match self.kind {
            Kind::Ranked => (self.nadir.center(), Align2::CENTER_CENTER),
            Kind::InUse => (self.area.left_top() + vec2(5.0, 4.0), Align2::LEFT_TOP),
            // Lower than the name of the stretch in use, so that both fit if they are the same
            // stretch.
            Kind::Proposed => (self.area.left_top() + vec2(5.0, 22.0), Align2::LEFT_TOP),
        };
        labels.write(at, anchor, &self.name, self.colour());
    }

    fn colour(&self) -> Color32 {
        match self.kind {
            // White in any theme, because the picture is dark or coloured.
            Kind::Ranked => Color32::from_gray(235),
            Kind::InUse => theme::CALIBRATION_COLOUR,
            Kind::Proposed => theme::PROPOSAL_COLOUR,
        }
    }
}
