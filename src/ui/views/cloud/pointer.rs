//! Handles the pointer on the cloud: it turns, moves and zooms the view, and picks points.

use super::axes::BoxAxes;
use super::bottom::BottomScene;
use super::scene::{CloudScene, SceneBox, ShownPoints};
use crate::app::{App, Command, LogId, LogPlace};
use crate::ui::render::OrbitCamera;
use crate::ui::{OwnHover, ViewContext, place, theme};
use bathyscope_log::support::geo::LonLat;
use bathyscope_products::pipeline::Products;
use egui::{Painter, PointerButton, Pos2, Rect, Response, Shape, Stroke, Ui};
use glam::Vec2;

/// Greatest distance of the pointer from a point that it picks, points of the screen.
const REACH: f32 = 9.0;
/// Greatest distance from the pointer to a point for which a zoom keeps the place under the
/// pointer, points of the screen.
const NEAR: f32 = 40.0;
/// Number of points above which only a click picks: a search of all of them would cost more than a
/// frame.
const MOST_ON_HOVER: usize = 2_000_000;

/// Hovered place of the view, with the last search for a point.
#[derive(Default)]
pub(super) struct CloudPointer {
    hover: OwnHover,
    looked: Option<(Pos2, OrbitCamera, Option<usize>)>,
}

/// Contents of the scene that the pointer picks from and the camera moves in.
#[derive(Clone, Copy)]
pub(super) struct PickScene<'a> {
    /// The points.
    pub scene: &'a CloudScene,
    /// The bottom; `None` if it is not shown.
    pub bottom: Option<&'a BottomScene>,
    /// The box around both.
    pub all: SceneBox,
}

/// Zooms about the bottom under the pointer, or else about the point nearest to `at` on the screen:
/// a zoom about an empty place would end in an empty picture. If no point is in the picture, the
/// camera comes no nearer.
pub(super) fn zoom(
    camera: &mut OrbitCamera,
    seen: PickScene<'_>,
    (shown, rect): (ShownPoints, Rect),
    at: Pos2,
    factor: f32,
) {
    let aspect = rect.width().max(1.0) / rect.height().max(1.0);
    let ndc_of = |at: Pos2| ndc(rect, at);
    let PickScene { scene, bottom, all } = seen;
    let looks = scene.shown(shown.outliers) <= MOST_ON_HOVER;
    let under = || bottom?.under(&camera.projection(aspect), ndc_of(at));
    let under = under().filter(|place| factor > 1.0 && shown.part.holds(*place));
    if let Some(place) = under {
        camera.look_at_depth_of(place);
    }
    if factor <= 1.0 || !looks || under.is_some() {
        camera.zoom(factor, ndc_of(at), aspect);
        return camera.hold(all.corners);
    }
    let (size, off) = (rect.size(), at - rect.min);
    let (size, off) = (Vec2::new(size.x, size.y), Vec2::new(off.x, off.y));
    let projection = camera.projection(aspect);
    let is_in_picture = |place: &glam::Vec3| {
        let ndc = projection.project(*place);
        ndc.is_some_and(|ndc| ndc.truncate().abs().max_element() <= 1.0)
    };
    let places = scene.places(shown).filter(|(_, place)| is_in_picture(place));
    let nearest = projection.pick(places, off, size, [REACH, f32::INFINITY]);
    let Some(place) = nearest.and_then(|point| scene.place_of(point)) else {
        return;
    };
    let Some(point_ndc) = projection.project(place) else {
        return;
    };
    let ndc = ndc_of(at);
    let off_px = (0.5 * size * (point_ndc.truncate() - ndc)).length();
    let after = ndc + (point_ndc.truncate() - ndc) * factor;
    let stays = off_px <= NEAR && after.abs().max_element() < 0.95;
    camera.look_at_depth_of(place);
    // The place under the pointer stays where it is on the screen; if that would move the nearest
    // point out of the picture, the point stays instead.
    let about = if stays { ndc } else { point_ndc.truncate() };
    camera.zoom(factor, about, aspect);
    camera.hold(all.corners);
}

/// Returns a place of the screen in normalised device coordinates.
fn ndc(rect: Rect, at: Pos2) -> Vec2 {
    let off = (at - rect.center()) / (0.5 * rect.size());
    Vec2::new(off.x, -off.y)
}

/// Moves the camera: left drag turns, right or middle drag moves, the wheel zooms at the pointer.
pub(super) fn move_camera(
    ui: &Ui,
    (shown, rect): (ShownPoints, Rect),
    response: &Response,
    seen: PickScene<'_>,
    camera: &mut OrbitCamera,
) {
    let height = rect.height().max(1.0);
    let drag = response.drag_delta() / height;
    let drag = Vec2::new(drag.x, drag.y);
    let moves = response.dragged_by(PointerButton::Secondary)
        || response.dragged_by(PointerButton::Middle)
        || (response.dragged() && ui.input(|input| input.modifiers.shift));
    if moves {
        camera.pan(drag);
        camera.hold(seen.all.corners);
    } else if response.dragged_by(PointerButton::Primary) {
        camera.orbit(drag);
    }
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = (scroll * 0.005).exp() * pinch;
        if factor != 1.0 {
            zoom(camera, seen, (shown, rect), at, factor);
        }
    }
}

impl CloudPointer {
    /// Handles hover and click: sets the hovered place, and a click selects a point or a place on
    /// the bottom.
    pub(super) fn handle(
        &mut self,
        context: &mut ViewContext<'_>,
        response: &Response,
        PickScene { scene, bottom, .. }: PickScene<'_>,
        (axes, camera): (&BoxAxes<'_>, OrbitCamera),
    ) {
        let shown = axes.shown();
        let at = if response.clicked() {
            response.interact_pointer_pos()
        } else {
            response.hover_pos().filter(|_| !response.dragged())
        };
        let looks = context.options().cloud.points
            && (scene.shown(shown.outliers) <= MOST_ON_HOVER || response.clicked());
        let point = at.filter(|_| looks).and_then(|at| match self.looked {
            Some((last, with, point)) if last == at && with == camera => point,
            _ => {
                let point = pick(context.app, scene, axes, at);
                self.looked = Some((at, camera, point));
                point
            }
        });
        let mark = point.and_then(|point| scene.mark(point));
        // Other views show the log of the selection; they have no place for a hovered point of
        // another log.
        let here = mark.filter(|(log, _)| *log == context.app.logs.shown.id);
        self.hover.tell(context, here.map(|(_, mark)| mark));
        if response.clicked() {
            let on_bottom = || position_on(bottom?, context.app, axes, at?);
            context.push(match (mark, on_bottom()) {
                (Some((log, mark)), _) => Command::RevealIn(log, mark),
                (None, Some(position)) => Command::ShowPlace(position),
                (None, None) => Command::Select(None),
            });
        }
    }
}

/// Returns the position on the bottom at a place of the screen; `None` where no bottom is drawn.
fn position_on(bottom: &BottomScene, app: &App, axes: &BoxAxes<'_>, at: Pos2) -> Option<LonLat> {
    let place = bottom.under(&axes.projection, ndc(axes.rect, at))?;
    if !axes.part.holds(place) {
        return None;
    }
    let [east_m, north_m, _] = axes.origin_m;
    let (survey, products) = (app.logs.shown.survey.as_ref()?, app.logs.shown.products.as_ref()?);
    let [east_m, north_m] = [east_m + f64::from(place.x), north_m + f64::from(place.y)];
    Some((products.navigation).to_lon_lat(&survey.track, east_m, north_m))
}

fn pick(app: &App, scene: &CloudScene, axes: &BoxAxes<'_>, at: Pos2) -> Option<usize> {
    let size = axes.rect.size();
    let off = at - axes.rect.min;
    let cover = (0.5 * app.view.options.cloud.point_size).max(1.0);
    axes.projection.pick(
        scene.places(axes.shown()),
        Vec2::new(off.x, off.y),
        Vec2::new(size.x, size.y),
        [cover, REACH],
    )
}

/// Marks the selected and the hovered ping: its points, a vertical line under the boat, and its
/// place on the bottom.
pub(super) fn paint_marks(
    painter: &Painter,
    app: &App,
    products: &Products,
    seen: PickScene<'_>,
    axes: &BoxAxes<'_>,
) {
    let marks = [
        (app.view.selection, theme::SELECTION_COLOUR, 2.0),
        (app.view.hover, theme::HOVER_COLOUR, 1.0),
    ];
    for (mark, colour, width) in marks {
        if let Some(mark) = mark {
            let stroke = Stroke::new(width, colour);
            let of_log = (app.logs.shown.id, &mark);
            paint_mark(painter, of_log, products, seen.scene, axes, stroke);
            let is_on_bottom = mark.point.is_none() && mark.sample.is_some();
            let place = || seen.bottom?.at(place::east_north(app, mark)?);
            if let Some(at) = place().filter(|_| is_on_bottom).and_then(|at| axes.at(at)) {
                painter.circle_stroke(at, 8.0, stroke);
            }
        }
    }
}

fn paint_mark(
    painter: &Painter,
    (log, mark): (LogId, &LogPlace),
    products: &Products,
    scene: &CloudScene,
    axes: &BoxAxes<'_>,
    stroke: Stroke,
) {
    let of_ping = scene.of_ping(log, mark.ping);
    let beside: Vec<Pos2> = of_ping.filter_map(|place| axes.at(place)).collect();
    for at in &beside {
        painter.circle_stroke(*at, 4.5, stroke);
    }
    let ping = products.navigation.pings.get(mark.ping);
    let under = ping.filter(|ping| ping.east_m.is_finite()).and_then(|ping| {
        let surface = scene.local(ping.east_m, ping.north_m, 0.0);
        let bottom = surface.with_z(scene.corners[0].z);
        axes.at(surface).zip(axes.at(bottom))
    });
    if let Some((surface, bottom)) = under {
        // A vertical line under the boat makes the ping visible from any distance.
        painter.add(Shape::dashed_line(&[surface, bottom], stroke, 4.0, 3.0));
        painter.circle_stroke(surface, 3.0, stroke);
    }
    let point = mark.point.and_then(|index| products.cloud.points.get(index));
    let at = point.and_then(|point| axes.at(scene.place(point)));
    if let Some(at) = at {
        painter.circle_stroke(at, 8.0, stroke);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{SwathShown, ViewOptions};
    use crate::ui::render::ScenePart;
    use crate::ui::views::cloud::scene::{ColourEnds, SceneLogPoints};
    use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud, PointSource};
    use bathyscope_log::support::progress::Progress;
    use std::sync::Arc;

    /// Returns two lines of points 40 m apart, and nothing between them.
    fn scene() -> CloudScene {
        let point = |index: u32| CloudPoint {
            confidence: 1.0,
            sample: 1.0,
            ..CloudPoint::new(
                PointSource::DownScan,
                index,
                [f64::from(index % 2) * 40.0, f64::from(index / 2), -3.0],
            )
        };
        let cloud = PointCloud { points: (0..120).map(point).collect(), zero_heading: 0 };
        let log = SceneLogPoints {
            id: LogId(1),
            name: String::new(),
            cloud: Arc::new(cloud),
            classes: Arc::new(vec![PointClass::Bottom; 120]),
            ranging: None,
            colour: [0; 3],
            swath: SwathShown::default(),
        };
        let (ends, options) = (ColourEnds::default(), ViewOptions::default());
        let made = CloudScene::new(vec![log], ends, &options, None, &Progress::new());
        made.expect("a scene")
    }

    #[test]
    fn the_wheel_never_ends_where_nothing_is() {
        let scene = scene();
        let rect = Rect::from_min_size(Pos2::ZERO, egui::vec2(600.0, 400.0));
        let all = ShownPoints { outliers: false, part: ScenePart::WHOLE };
        for at in [[300.0, 200.0], [5.0, 5.0], [590.0, 380.0], [310.0, 395.0]] {
            for factor in [1.3, 1.0 / 1.3] {
                let mut camera = OrbitCamera::default();
                camera.fit(scene.corners, 1.5, 1.2);
                for _ in 0..100 {
                    let seen = PickScene { scene: &scene, bottom: None, all: scene.extent() };
                    let shown = (all, rect);
                    zoom(&mut camera, seen, shown, at.into(), factor);
                }
                let projection = camera.projection(1.5);
                let in_picture = scene.places(all).filter(|(_, place)| {
                    let ndc = projection.project(*place);
                    ndc.is_some_and(|ndc| ndc.truncate().abs().max_element() <= 1.0)
                });
                assert!(in_picture.count() > 0, "{at:?} {factor} {camera:?}");
            }
        }
    }
}
