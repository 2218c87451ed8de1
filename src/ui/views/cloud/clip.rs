//! Shows the clip box, outside of which nothing is drawn. Each of its faces has a handle, and its
//! ends are also shown as numbers beside the cloud.

use super::axes::BoxAxes;
use super::scene::SceneBox;
use crate::app::{ClipBox, ViewOptions};
use crate::ui::ViewContext;
use crate::ui::controls::number_field;
use crate::ui::views::legend;
use crate::ui::{place, theme};
use bathyscope_bottom::presentation::units::Units;
use egui::{Align2, CursorIcon, Id, Rect, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2};
use glam::Vec3;

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
pub(super) fn limits(origin_m: [f64; 3], clip: ClipBox) -> [Vec3; 2] {
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
