//! The ranked flat stretches along the nadir, numbered as on the map, and the one that the calibration was measured on.

use super::labels::Labels;
use super::lens::{Lens, Place};
use crate::app::App;
use crate::calibration::ScaleMode;
use crate::ui::theme;
use egui::{Align2, Color32, Painter, Rect, Stroke, pos2, vec2};
use std::ops::Range;

/// Thickness of a bar, points.
const BAR: f32 = 2.0;

/// A stretch in view.
pub(super) struct Stretch {
    /// Over the whole picture's range.
    area: Rect,
    edges: [[egui::Pos2; 2]; 2],
    nadir: Rect,
    /// `None` for the stretch of the calibration.
    rank: Option<usize>,
    name: String,
}

/// The stretches that a lens sees: of the calibration, and the ranked ones if they are shown.
pub(super) fn in_view(lens: &Lens, app: &App) -> Vec<Stretch> {
    let has_picture = app
        .log
        .survey
        .as_ref()
        .is_some_and(|survey| survey.has_side_scan());
    let Some(products) = app.log.products.as_ref().filter(|_| has_picture) else {
        return Vec::new();
    };
    let calibration = &products.calibration;
    let name = match calibration.mode {
        ScaleMode::FlatSpot => "calibrated here",
        ScaleMode::Header => "flat spot",
    };
    let used = calibration.flat_spot.iter();
    let used = used.filter_map(|spot| stretch(lens, &spot.pings, None, name.to_owned()));
    let ranked = products.flat_spots.iter().enumerate();
    let ranked = ranked
        .filter(|_| app.options.waterfall.flat_stretches)
        .filter_map(|(rank, spot)| {
            stretch(lens, &spot.pings, Some(rank), format!("flat {}", rank + 1))
        });
    used.chain(ranked).collect()
}

fn stretch(
    lens: &Lens,
    pings: &Range<usize>,
    rank: Option<usize>,
    name: String,
) -> Option<Stretch> {
    let ends = [pings.start as f64, pings.end as f64];
    let edges = ends.map(|ping| lens.line_at_ping(ping));
    let area = Rect::from_two_pos(edges[0][0], edges[1][1]).intersect(lens.rect);
    let [start, end] = ends.map(|ping| {
        lens.screen_at(Place {
            ping,
            across_m: 0.0,
        })
    });
    let nadir = Rect::from_two_pos(start, end).expand(BAR / 2.0);
    area.is_positive().then_some(Stretch {
        area,
        edges,
        nadir: nadir.intersect(lens.rect.expand(BAR)),
        rank,
        name,
    })
}

impl Stretch {
    /// Draws it: two lines across the picture for the calibration's, a bar along the nadir for the others. The echoes
    /// between stay as they are.
    pub fn draw(&self, painter: &Painter) {
        let colour = self.colour();
        if self.rank.is_some() {
            painter.rect_filled(self.nadir.expand(1.0), 1.0, Color32::from_black_alpha(150));
            painter.rect_filled(self.nadir, 1.0, colour);
            return;
        }
        for edge in self.edges {
            painter.line_segment(edge, Stroke::new(3.0, Color32::from_black_alpha(110)));
            painter.line_segment(edge, Stroke::new(1.0, colour));
        }
    }

    /// Writes its name at its beginning or, for a bar, on its middle.
    pub fn label(&self, labels: &mut Labels<'_>) {
        let (at, anchor) = if self.rank.is_some() {
            (self.nadir.center(), Align2::CENTER_CENTER)
        } else {
            let corner = self.area.left_top();
            (pos2(corner.x, corner.y) + vec2(5.0, 4.0), Align2::LEFT_TOP)
        };
        labels.write(at, anchor, &self.name, self.colour());
    }

    fn colour(&self) -> Color32 {
        match self.rank {
            // White on any theme: it lies on the picture, which is dark or coloured.
            Some(_) => Color32::from_gray(235),
            None => theme::calibration_colour(),
        }
    }
}
