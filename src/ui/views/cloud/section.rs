//! Draws the cross-section, which is the bottom along the line of the depth profile without what is
//! in front of it, and the water's surface with the boat's track.

use super::axes::BoxAxes;
use super::clip;
use super::scene::CloudScene;
use crate::app::{App, ViewOptions};
use crate::ui::render::{CameraProjection, Cut, ScenePart};
use crate::ui::theme;
use bathyscope_bottom::bathymetry::TransectStation;
use egui::{Color32, Painter, Pos2, Shape, Stroke};
use glam::{Vec3, Vec4};

/// Largest number of places drawn of all tracks together.
const MOST_PLACES: usize = 20_000;
/// Opacity of the water's surface, of 255.
const WATER_ALPHA: u8 = 36;
/// Least distance from the camera at which the water's surface is drawn, metres.
const NEAREST_M: f32 = 0.01;

/// Returns the part of the scene that is drawn when seen from `eye`: inside the clip box and behind
/// the cross-section.
pub(super) fn part(app: &App, scene: &CloudScene, eye: Vec3) -> ScenePart {
    let options = &app.view.options.cloud;
    let corners = options.clip.map(|clip_box| clip::limits(scene.origin_m, clip_box));
    let cut = options.cut.then(|| cut(app.map.measuring.stations(), scene, eye));
    ScenePart { corners: corners.unwrap_or(ScenePart::WHOLE.corners), cut: cut.flatten() }
}

/// Returns the vertical plane from the first to the last place of a profile; the side of the camera
/// is left out, so that the section is visible from any direction.
fn cut(stations: &[TransectStation], scene: &CloudScene, eye: Vec3) -> Option<Cut> {
    let ends = [stations.first()?, stations.last()?];
    let [first, last] = ends.map(|end| scene.local(end.place[0], end.place[1], 0.0).truncate());
    let right = (last - first).try_normalize()?.perp();
    let is_right = right.dot(eye.truncate() - first) > 0.0;
    let outward = if is_right { right } else { -right };
    Some(Cut { outward, at_m: outward.dot(first) })
}

/// Draws the bottom along the profile, and the plane from the bottom up to the level that depths
/// count from.
pub(super) fn paint(painter: &Painter, app: &App, scene: &CloudScene, axes: &BoxAxes<'_>) {
    let stations = app.map.measuring.stations();
    if axes.part.cut.is_none() {
        return;
    }
    let colour = theme::MEASURE_COLOUR;
    let at = |station: &TransectStation, depth_m: f64| {
        let [east_m, north_m] = station.place;
        in_box(axes, scene.local(east_m, north_m, -depth_m))
    };
    let bottom = |station: &TransectStation| at(station, f64::from(station.depth_m?));
    let bottom: Vec<Option<Pos2>> = stations.iter().map(bottom).collect();
    let surface: Vec<Option<Pos2>> = stations.iter().map(|station| at(station, 0.0)).collect();
    let thin = Stroke::new(1.0, colour);
    lines(painter, &bottom, Stroke::new(2.5, colour));
    lines(painter, &surface, thin);
    let both = bottom.iter().zip(&surface);
    let upright = both.filter_map(|(low, high)| Some([(*low)?, (*high)?]));
    let upright: Vec<[Pos2; 2]> = upright.collect();
    for ends in upright.first().into_iter().chain(upright.last()) {
        painter.line_segment(*ends, thin);
    }
}

/// Returns the place on the screen of a point above, in or below the box that is drawn; `None`
/// beside the box.
fn in_box(axes: &BoxAxes<'_>, place: Vec3) -> Option<Pos2> {
    let [low, high] = axes.corners.map(Vec3::truncate);
    let beside = place.truncate();
    let is_in = beside.cmpge(low).all() && beside.cmple(high).all();
    is_in.then(|| axes.at(place)).flatten()
}

/// Draws the water's surface, or the other level that depths count from, and on it the tracks of
/// all visible logs.
pub(super) fn paint_water(painter: &Painter, app: &App, scene: &CloudScene, axes: &BoxAxes<'_>) {
    if !app.view.options.cloud.water {
        return;
    }
    let up = scene.local(0.0, 0.0, 0.0).z;
    let [low, high] = axes.corners;
    let corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
    let corners = corners.map(|(east, north)| Vec3::new(east, north, up));
    // Not drawn from below, where the surface would be behind the bottom.
    let outline = in_front(&axes.projection, &corners);
    let outline: Vec<Pos2> = outline.iter().filter_map(|place| axes.at(*place)).collect();
    if axes.projection.eye.z > up && outline.len() > 2 {
        let [fill, line] = water_colours(axes.options);
        painter.add(Shape::convex_polygon(outline, fill, Stroke::new(1.0, line)));
    }
    let logs = app.logs.with_results();
    let most = MOST_PLACES / logs.len().max(1);
    for shown in logs {
        let pings = &shown.log.products.navigation.pings;
        let [r, g, b] = shown.colour;
        let thinned = pings.iter().step_by(pings.len().div_ceil(most.max(2)).max(1));
        let places = thinned.map(|ping| in_box(axes, scene.local(ping.east_m, ping.north_m, 0.0)));
        let places: Vec<Option<Pos2>> = places.collect();
        let stroke = Stroke::new(1.5, Color32::from_rgb(r, g, b));
        lines(painter, &places, stroke);
    }
}

/// Returns fill and edge colour of the water's surface.
fn water_colours(options: &ViewOptions) -> [Color32; 2] {
    let [r, g, b, _] = theme::canvas_text_colour(options).to_array();
    let tinted = |alpha| Color32::from_rgba_unmultiplied(r / 3, g / 2, b / 2 + 127, alpha);
    [tinted(WATER_ALPHA), tinted(4 * WATER_ALPHA)]
}

/// Returns the part of a polygon in front of the camera.
fn in_front(projection: &CameraProjection, corners: &[Vec3]) -> Vec<Vec3> {
    let away_m = |place: Vec3| {
        let clip: Vec4 = projection.clip_from_world * place.extend(1.0);
        clip.w - NEAREST_M
    };
    let next = corners.iter().cycle().skip(1);
    let mut found = Vec::new();
    for (from, to) in corners.iter().zip(next) {
        let [a, b] = [*from, *to].map(away_m);
        if a >= 0.0 {
            found.push(*from);
        }
        if (a >= 0.0) != (b >= 0.0) {
            found.push(from.lerp(*to, a / (a - b)));
        }
    }
    found
}

/// Joins successive places by lines; a missing place breaks the line.
fn lines(painter: &Painter, places: &[Option<Pos2>], stroke: Stroke) {
    for piece in places.split(Option::is_none) {
        let points: Vec<Pos2> = piece.iter().copied().flatten().collect();
        if points.len() > 1 {
            painter.line(points, stroke);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::render::OrbitCamera;

    #[test]
    fn what_lies_behind_the_camera_is_cut_off() {
        let projection = OrbitCamera::default().projection(1.0);
        let eye = projection.eye;
        // A square around the point below the camera, half of it behind the camera.
        let corner = |x: f32, y: f32| Vec3::new(eye.x + x, eye.y + y, eye.z - 10.0);
        let square = [(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)];
        let square = square.map(|(x, y)| corner(x, y));
        let shown = in_front(&projection, &square);
        assert!(shown.len() > 2 && shown.len() < 7, "{shown:?}");
        let is_seen = |place: &Vec3| projection.project(*place).is_some();
        assert!(shown.iter().all(is_seen));
        assert!(!square.iter().all(is_seen));
    }
}
