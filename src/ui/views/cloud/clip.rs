//! Shows the clip box, outside of which nothing is drawn, and the cross-section, which is the
//! bottom along the line of the depth profile without what is in front of it; and draws the water's
//! surface with the boat's track. Each face of the clip box has a handle, and its ends are also
//! shown as numbers beside the cloud.

use super::axes::BoxAxes;
use super::scene::{CloudScene, SceneBox};
use crate::app::{App, ClipBox, ViewOptions};
use crate::ui::controls::number_field;
use crate::ui::render::{CameraProjection, Cut, ScenePart};
use crate::ui::views::legend;
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::bathymetry::TransectStation;
use bathyscope_bottom::presentation::units::Units;
use egui::{
    Align2, Color32, CursorIcon, Id, Painter, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2,
    WidgetInfo, vec2,
};
use glam::{Vec3, Vec4};

/// Shortest edge of the box as a share of the cloud's, so that something is left to see.
const SHORTEST: f32 = 0.01;
/// Radius of a handle, and half of the square that takes the pointer, points of the screen.
const HANDLE: [f32; 2] = [5.0, 9.0];
/// Length on the screen of a handle's way across the whole cloud, points, below which the face has
/// no handle: it is seen from in front.
const SHORTEST_WAY: f32 = 30.0;
/// Names of the axes, and of a handle at each end.
const AXES: [(&str, [&str; 2]); 3] = [
    ("east", ["west end", "east end"]),
    ("north", ["south end", "north end"]),
    ("elevation", ["lower end", "upper end"]),
];

/// Returns the corners of the clip box in coordinates of the scene; the largest numbers where the
/// box has no end.
fn limits(origin_m: [f64; 3], clip: ClipBox) -> [Vec3; 2] {
    let end = |end: usize| {
        let at = |axis: usize| (clip.ends_m[axis][end] - origin_m[axis]) as f32;
        Vec3::new(at(0), at(1), at(2)).clamp(Vec3::MIN, Vec3::MAX)
    };
    [end(0), end(1)]
}

/// Returns the box around what is drawn. It always keeps a part of the cloud, even if a newly
/// computed cloud is elsewhere than the clip box.
pub(super) fn part(scene: SceneBox, clip: Option<ClipBox>) -> [Vec3; 2] {
    let [low, high] = scene.corners;
    let Some(clip) = clip else {
        return scene.corners;
    };
    let shortest = SHORTEST * (high - low);
    let [from, to] = limits(scene.origin_m, clip);
    let from = from.max(low).min(high - shortest);
    [from, to.min(high).max(from + shortest)]
}

/// Returns the box with one end moved, in coordinates of the scene. An end that reaches the end of
/// the cloud becomes infinite.
fn with_end(scene: SceneBox, mut clip: ClipBox, axis: usize, end: usize, to: f32) -> ClipBox {
    let [low, high] = scene.corners.map(|corner| corner[axis]);
    let shortest = SHORTEST * (high - low);
    let [from, until] = part(scene, Some(clip)).map(|corner| corner[axis]);
    let placed = |local: f32| f64::from(local) + scene.origin_m[axis];
    clip.ends_m[axis][end] = match end {
        0 if to <= low => f64::NEG_INFINITY,
        0 => placed(to.min(until - shortest)),
        _ if to >= high => f64::INFINITY,
        _ => placed(to.max(from + shortest)),
    };
    clip
}

/// Shows handles and numbers of the clip box, if there is one; returns the box if it was changed.
pub(super) fn show(
    ui: &mut Ui,
    context: &ViewContext<'_>,
    scene: SceneBox,
    axes: &BoxAxes<'_>,
) -> Option<ClipBox> {
    let clip = context.options().cloud.clip?;
    let dragged = handles(ui, scene, axes, clip);
    let changed = if legend::has_room(axes.rect) {
        numbers(ui, context, scene, axes, dragged)
    } else {
        dragged
    };
    (changed != clip).then_some(changed)
}

fn handles(ui: &Ui, scene: SceneBox, axes: &BoxAxes<'_>, clip: ClipBox) -> ClipBox {
    let [low, high] = axes.corners;
    let (middle, size) = (0.5 * (low + high), scene.corners[1] - scene.corners[0]);
    let mut changed = clip;
    for (axis, (_, names)) in AXES.iter().enumerate() {
        for (end, name) in names.iter().enumerate() {
            let mut face = middle;
            face[axis] = axes.corners[end][axis];
            let step = 0.01 * size[axis];
            let mut ahead = face;
            ahead[axis] += step;
            let (Some(at), Some(ahead)) = (axes.at(face), axes.at(ahead)) else {
                continue;
            };
            let way = ahead - at;
            if 100.0 * way.length() < SHORTEST_WAY || !axes.rect.contains(at) {
                continue;
            }
            let reach = Rect::from_center_size(at, Vec2::splat(2.0 * HANDLE[1]));
            let id: Id = ui.scope_id().with(("clip box", axis, end));
            let response = ui
                .interact(reach, id, Sense::drag())
                .on_hover_and_drag_cursor(CursorIcon::Grab)
                .on_hover_text(format!("The {name} of the clip box: drag it."));
            response.widget_info(|| {
                let name = format!("{name} of the clip box");
                WidgetInfo::labeled(Role::Slider, true, name)
            });
            let is_held = response.hovered() || response.dragged();
            let fill = if is_held { theme::HOVER_COLOUR } else { theme::SELECTION_COLOUR };
            let painter = ui.painter_at(axes.rect);
            painter.circle(at, HANDLE[0], fill, edge(axes.options));
            if response.dragged() {
                let steps = response.drag_delta().dot(way) / way.length_sq();
                changed = with_end(scene, changed, axis, end, face[axis] + steps * step);
            }
        }
    }
    changed
}

/// Returns the outline of a handle, which separates it from what is behind.
fn edge(options: &ViewOptions) -> Stroke {
    Stroke::new(1.5, theme::canvas_text_colour(options))
}

/// Shows the ends as numbers that can be dragged or typed; returns the changed box.
fn numbers(
    ui: &mut Ui,
    context: &ViewContext<'_>,
    scene: SceneBox,
    axes: &BoxAxes<'_>,
    mut clip: ClipBox,
) -> ClipBox {
    let options = context.options();
    let reference = place::reduction(context.app).reference();
    let size = vec2(196.0, 84.0);
    let corner = axes.rect.right_top() + vec2(-4.0 - size.x, 4.0);
    let place = Rect::from_min_size(corner, size);
    legend::framed(ui, options, place, |ui| {
        egui::Grid::new("clip box").show(ui, |ui| {
            for (axis, (name, names)) in AXES.iter().enumerate() {
                ui.small(*name).on_hover_text(match axis {
                    2 => format!("Below 0: {}.", reference.name()),
                    _ => "Local metres of the survey, as on the scale of the box.".to_owned(),
                });
                for (end, end_name) in names.iter().enumerate() {
                    let local = part(scene, Some(clip))[end][axis];
                    if let Some(to) = number(ui, options.units, scene, axis, local, end_name) {
                        clip = with_end(scene, clip, axis, end, to);
                    }
                }
                ui.end_row();
            }
        });
    });
    clip
}

/// Shows an end as a number in the unit in use; returns its new coordinate in the scene if it was
/// changed.
fn number(
    ui: &mut Ui,
    units: Units,
    scene: SceneBox,
    axis: usize,
    local: f32,
    name: &str,
) -> Option<f32> {
    let origin_m = scene.origin_m[axis];
    let before = units.in_unit(f64::from(local) + origin_m);
    let mut value = before;
    let size_m = f64::from(scene.corners[1][axis] - scene.corners[0][axis]);
    let field = number_field(&mut value)
        .speed(units.in_unit(0.005 * size_m))
        .fixed_decimals(2)
        .suffix(format!(" {}", units.symbol()));
    let response = ui.add(field).on_hover_text(format!("{name} of the clip box."));
    let is_changed = response.changed() && value != before;
    is_changed.then(|| (value * units.length.metres() - origin_m) as f32)
}

/// Notes in an exported picture that not everything is drawn.
pub(super) fn paint_note(painter: &egui::Painter, rect: Rect, options: &ViewOptions) {
    if options.cloud.clip.is_some() {
        let at = rect.right_top() + vec2(-8.0, 8.0);
        legend::words(painter, options, at, Align2::RIGHT_TOP, "clipped");
    }
}

/// Largest number of places drawn of all tracks together.
const MOST_PLACES: usize = 20_000;
/// Opacity of the water's surface, of 255.
const WATER_ALPHA: u8 = 36;
/// Least distance from the camera at which the water's surface is drawn, metres.
const NEAREST_M: f32 = 0.01;

/// Returns the part of the scene that is drawn when seen from `eye`: inside the clip box and behind
/// the cross-section.
pub(super) fn scene_part(app: &App, scene: &CloudScene, eye: Vec3) -> ScenePart {
    let options = &app.view.options.cloud;
    let corners = options.clip.map(|clip_box| limits(scene.origin_m, clip_box));
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
pub(super) fn paint_section(painter: &Painter, app: &App, scene: &CloudScene, axes: &BoxAxes<'_>) {
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
        let thinned = pings.iter().step_by(pings.len().div_ceil(most.max(2)).max(1));
        let places = thinned.map(|ping| in_box(axes, scene.local(ping.east_m, ping.north_m, 0.0)));
        let places: Vec<Option<Pos2>> = places.collect();
        let stroke = Stroke::new(1.5, theme::rgb(shown.colour));
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
