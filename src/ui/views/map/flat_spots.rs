//! Draws the ranked flat stretches with their numbers, the stretch that the calibration was
//! measured on, and the proposed stretch.

use super::MapScene;
use crate::ui::theme;
use crate::ui::views::legend;
use bathyscope_bottom::calibration::{FlatSpot, ScaleMode};
use bathyscope_bottom::presentation::units::Units;
use egui::{Align2, Color32, Painter, Pos2, Rect, Shape, Stroke, Vec2, vec2};
use std::ops::Range;

/// Radius of a number's plate, points.
const BADGE: f32 = 8.5;
/// Number of places drawn along a stretch.
const MOST_PLACES: usize = 48;
/// Least distance between two drawn places of a stretch on the screen, points.
const LEAST_STEP: f32 = 2.0;

/// Positions of a stretch's name relative to its middle, best first; the number of the stretch is
/// above the name.
const SIDES: [(Vec2, Align2); 4] = [
    (vec2(10.0, 6.0), Align2::LEFT_TOP),
    (vec2(-10.0, 6.0), Align2::RIGHT_TOP),
    (vec2(10.0, -26.0), Align2::LEFT_BOTTOM),
    (vec2(-10.0, -26.0), Align2::RIGHT_BOTTOM),
];

/// Draws the stretches.
pub(super) fn paint(painter: &Painter, scene: &MapScene<'_>) {
    if scene.options.map.flat_spots {
        let colour = theme::flat_spot_colour(scene.options);
        for (rank, spot) in scene.products.flat_spots.iter().enumerate() {
            stretch(painter, scene, &spot.pings, colour);
            badge(painter, scene, spot, &(rank + 1).to_string());
        }
    }
    let calibration = &scene.products.calibration;
    if let Some(spot) = &calibration.flat_spot {
        stretch(painter, scene, &spot.pings, theme::CALIBRATION_COLOUR);
    }
    if let Some(pings) = scene.proposed {
        let pings = pings.start..pings.end;
        stretch(painter, scene, &pings, theme::PROPOSAL_COLOUR);
    }
}

/// Names the stretch that the calibration was measured on, beside it where nothing else is drawn.
/// If there is no such place, only the colour marks the stretch.
pub(super) fn name_calibrated(painter: &Painter, scene: &MapScene<'_>, covered: &[Rect]) {
    let calibration = &scene.products.calibration;
    let Some(spot) = &calibration.flat_spot else {
        return;
    };
    let Some(middle) = middle(scene, &spot.pings).filter(|_| legend::has_room(scene.rect)) else {
        return;
    };
    let text = match calibration.mode {
        ScaleMode::FlatSpot => "scale from here",
        ScaleMode::Header => "flat stretch, not in use",
    };
    let colour = theme::CALIBRATION_COLOUR;
    let size = legend::plate_size(painter, text);
    let plate_at = |(offset, anchor): (Vec2, Align2)| anchor.anchor_size(middle + offset, size);
    let free = SIDES.into_iter().filter(|side| {
        let plate = plate_at(*side);
        scene.rect.contains_rect(plate) && !covered.iter().any(|other| other.intersects(plate))
    });
    if let Some((offset, anchor)) = free.min_by_key(|side| badges_under(scene, plate_at(*side))) {
        let at = middle + offset;
        legend::plate(painter, scene.options, at, anchor, text, colour);
    }
}

fn badges_under(scene: &MapScene<'_>, plate: Rect) -> usize {
    if !scene.options.map.flat_spots {
        return 0;
    }
    let badges = scene.products.flat_spots.iter();
    badges
        .filter_map(|spot| badge_at(scene, &spot.pings))
        .filter(|at| plate.expand(BADGE).contains(*at))
        .count()
}

/// Returns the rank index of the stretch whose number is under the pointer.
pub(super) fn under(scene: &MapScene<'_>, pointer: Pos2) -> Option<usize> {
    if !scene.options.map.flat_spots {
        return None;
    }
    let hit = |spot: &FlatSpot| {
        badge_at(scene, &spot.pings).is_some_and(|at| at.distance(pointer) <= BADGE + 2.0)
    };
    scene.products.flat_spots.iter().position(hit)
}

/// Describes a stretch in a few lines.
pub(super) fn describe(rank: usize, spot: &FlatSpot, units: Units) -> String {
    let number = rank + 1;
    let spot = units.sentence(&spot.summary());
    format!("flat stretch {number}: {spot}")
}

fn places(scene: &MapScene<'_>, pings: &Range<usize>) -> Vec<Pos2> {
    let navigation = &scene.products.navigation.pings;
    let end = pings.end.min(navigation.len());
    let start = pings.start.min(end);
    let step = ((end - start) / MOST_PLACES).max(1);
    let along = navigation[start..end].iter().step_by(step);
    let known = along.filter(|ping| ping.east_m.is_finite() && ping.north_m.is_finite());
    let places = known.map(|ping| scene.at([ping.east_m, ping.north_m]));
    let mut line: Vec<Pos2> = Vec::new();
    for place in places {
        // Nearer places show nothing more.
        if line.last().is_none_or(|last| last.distance(place) >= LEAST_STEP) {
            line.push(place);
        }
    }
    line
}

fn stretch(painter: &Painter, scene: &MapScene<'_>, pings: &Range<usize>, colour: Color32) {
    let line = places(scene, pings);
    // Wide and faint, so that the track's own colour stays readable under it.
    let [halo, core] = [9.0, 1.2];
    let faint = Stroke::new(halo, colour.gamma_multiply(0.3));
    painter.add(Shape::line(line.clone(), faint));
    painter.add(Shape::line(line, Stroke::new(core, colour)));
}

fn middle(scene: &MapScene<'_>, pings: &Range<usize>) -> Option<Pos2> {
    let line = places(scene, pings);
    line.get(line.len() / 2).copied()
}

/// Returns the place of a stretch's number: beside the middle of the stretch, not on it.
fn badge_at(scene: &MapScene<'_>, pings: &Range<usize>) -> Option<Pos2> {
    Some(middle(scene, pings)? + vec2(0.0, -BADGE - 7.0))
}

fn badge(painter: &Painter, scene: &MapScene<'_>, spot: &FlatSpot, number: &str) {
    let Some(at) = badge_at(scene, &spot.pings) else {
        return;
    };
    let plate = theme::flat_spot_colour(scene.options);
    painter.circle_filled(at, BADGE, plate);
    let ink = theme::canvas_colour(scene.options);
    painter.text(at, Align2::CENTER_CENTER, number, legend::font(), ink);
}
