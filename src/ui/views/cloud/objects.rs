//! Draws objects in the cloud: the footprint of each box on the bottom.

use super::axes::BoxAxes;
use super::scene::CloudScene;
use crate::app::{App, Reviewing};
use crate::ui::theme;
use bathyscope_objects::review::{BoxId, State};
use egui::{Painter, Pos2, Shape, Stroke};

/// Number of profiles along a shape, and of those across it; number of points of each.
const PROFILES: usize = 3;
const PROFILE_POINTS: usize = 60;
/// Least half size of a footprint on the screen, points: a smaller one, far away, is drawn as a
/// circle of this radius.
const LEAST: f32 = 3.0;
/// Least half width of a footprint on the screen, points: seen from the side, the outline would be
/// one long line.
const LEAST_WIDTH: f32 = 1.5;

/// Draws the footprints of the boxes in the queues of all visible logs; rejected boxes only while
/// they are selected.
pub(super) fn paint(painter: &Painter, app: &App, scene: &CloudScene, axes: &BoxAxes<'_>) {
    if !app.view.options.cloud.boxes {
        return;
    }
    for log in app.logs.visible() {
        let selected = app.logs.shown.reviewing.selected.filter(|_| log.id == app.logs.shown.id);
        boxes(painter, &log.reviewing, selected, scene, axes);
    }
    shape(painter, app, scene, axes);
}

/// Draws the shape of the selected object: its outline on the bottom, and profiles along it and
/// across it.
fn shape(painter: &Painter, app: &App, scene: &CloudScene, axes: &BoxAxes<'_>) {
    let Some(Ok(fitted)) = app.selected_object_shape() else {
        return;
    };
    let (posed, solid) = (&fitted.posed, &fitted.posed.solid);
    let at = |place_m: [f64; 2], height_m: f64| {
        let [east_m, north_m] = posed.place_m(place_m);
        let place = scene.local(east_m, north_m, fitted.bottom_z_m + height_m);
        axes.part.holds(place).then(|| axes.at(place)).flatten()
    };
    let share = |index: usize, count: usize| 1.01 * (index as f64 / count as f64 - 0.5);
    let profile = |along: bool, line: usize| {
        let places = (0..=PROFILE_POINTS).map(|point| {
            let shares = [share(point, PROFILE_POINTS), share(line, PROFILES + 1)];
            let [u, v] = if along { shares } else { [shares[1], shares[0]] };
            [u * solid.length_m, v * solid.width_m]
        });
        places.collect::<Vec<[f64; 2]>>()
    };
    let stroke = Stroke::new(1.5, theme::INFERRED_COLOUR);
    let outline = solid.outline_m();
    let outline = outline.iter().filter_map(|place_m| at(*place_m, 0.0));
    painter.line(outline.collect(), stroke);
    for along in [true, false] {
        for line in 1..=PROFILES {
            let places = profile(along, line);
            let points = places
                .into_iter()
                .filter_map(|place_m| at(place_m, solid.height_at_m(place_m[0], place_m[1])));
            painter.line(points.collect(), stroke);
        }
    }
}

/// Returns half of the width of a footprint across its longest diagonal, points.
fn half_width(corners: &[Pos2]) -> f32 {
    let [a, b, c, d] = corners else {
        return 0.0;
    };
    let area = 0.5 * ((*c - *a).x * (*d - *b).y - (*c - *a).y * (*d - *b).x).abs();
    let longest = a.distance(*c).max(b.distance(*d));
    0.5 * area / longest.max(f32::MIN_POSITIVE)
}

fn boxes(
    painter: &Painter,
    reviewing: &Reviewing,
    selected: Option<BoxId>,
    scene: &CloudScene,
    axes: &BoxAxes<'_>,
) {
    for review_box in reviewing.in_line() {
        let is_selected = Some(review_box.id) == selected;
        let Some(placed) = reviewing.placed(review_box.id) else {
            continue;
        };
        if review_box.state == State::Rejected && !is_selected {
            continue;
        }
        let z_m = -placed.target.depth_m;
        let target = &placed.target;
        if !(axes.part).holds(scene.local(target.east_m, target.north_m, z_m)) {
            continue;
        }
        let corner = |[east_m, north_m]: [f64; 2]| axes.at(scene.local(east_m, north_m, z_m));
        let corners: Vec<Pos2> = placed.corners.iter().filter_map(|at| corner(*at)).collect();
        let Some(middle) = corner([placed.target.east_m, placed.target.north_m]) else {
            continue;
        };
        let is_drawn = corners.len() == 4 && painter.clip_rect().contains(middle);
        if !is_drawn {
            continue;
        }
        let colour = theme::box_colour_on_panel(axes.options.theme, review_box.state);
        let stroke = Stroke::new(if is_selected { 2.5 } else { 1.5 }, colour);
        let is_far = corners.iter().all(|at| at.distance(middle) < LEAST);
        if is_far || half_width(&corners) < LEAST_WIDTH {
            painter.circle_stroke(middle, LEAST, stroke);
        } else {
            if review_box.state == State::Rejected {
                painter.line_segment([corners[0], corners[2]], stroke);
                painter.line_segment([corners[1], corners[3]], stroke);
            }
            painter.add(Shape::closed_line(corners, stroke));
        }
        if is_selected {
            let ring = Stroke::new(2.0, theme::SELECTION_COLOUR);
            painter.circle_stroke(middle, 9.0, ring);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn an_outline_that_is_seen_from_the_side_is_no_line() {
        let above = [pos2(0.0, 0.0), pos2(40.0, 0.0), pos2(40.0, 20.0), pos2(0.0, 20.0)];
        assert!((8.0..=10.0).contains(&half_width(&above)));
        let flat = above.map(|at| pos2(8.0 * at.x, 0.1 * at.y));
        assert!(half_width(&flat) < LEAST_WIDTH, "320 points long, 2 high");
        assert_eq!(half_width(&[pos2(3.0, 4.0); 4]), 0.0);
    }
}
