//! What the pointer does on the cloud: turn, move, zoom, pick.

use super::axes::Axes;
use super::scene::CloudScene;
use crate::app::{App, Command, Mark};
use crate::pipeline::Products;
use crate::render::OrbitCamera;
use crate::ui::{ViewContext, theme};
use egui::{Painter, PointerButton, Pos2, Rect, Response, Shape, Stroke, Ui};
use glam::Vec2;

/// How near a point the pointer must be, points of the screen.
const REACH: f32 = 9.0;
/// Beyond so many points only a click picks: a look at all of them would cost more than a frame.
const MOST_ON_HOVER: usize = 2_000_000;

/// What the pointer was found over.
#[derive(Default)]
pub struct Pointer {
    hovering: bool,
    looked: Option<(Pos2, OrbitCamera, Option<usize>)>,
}

/// Left drag turns, right or middle drag moves, the wheel zooms at the pointer.
pub fn move_camera(ui: &Ui, rect: Rect, response: &Response, camera: &mut OrbitCamera) {
    let height = rect.height().max(1.0);
    let drag = response.drag_delta() / height;
    let drag = Vec2::new(drag.x, drag.y);
    let moves = response.dragged_by(PointerButton::Secondary)
        || response.dragged_by(PointerButton::Middle)
        || (response.dragged() && ui.input(|input| input.modifiers.shift));
    if moves {
        camera.pan(drag);
    } else if response.dragged_by(PointerButton::Primary) {
        camera.orbit(drag);
    }
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = (scroll * 0.005).exp() * pinch;
        if factor != 1.0 {
            let off = (at - rect.center()) / (0.5 * rect.size());
            camera.zoom(factor, Vec2::new(off.x, -off.y), rect.width() / height);
        }
    }
}

impl Pointer {
    /// Hover and click.
    pub fn handle(
        &mut self,
        context: &mut ViewContext<'_>,
        response: &Response,
        scene: &CloudScene,
        (axes, camera): (&Axes<'_>, OrbitCamera),
    ) {
        let preview = context.app.options.cloud.outlier_preview;
        let at = match response.clicked() {
            true => response.interact_pointer_pos(),
            false => response.hover_pos().filter(|_| !response.dragged()),
        };
        let looks = scene.shown(preview) <= MOST_ON_HOVER || response.clicked();
        let point = at.filter(|_| looks).and_then(|at| match self.looked {
            Some((last, with, point)) if last == at && with == camera => point,
            _ => {
                let point = pick(context.app, scene, axes, at);
                self.looked = Some((at, camera, point));
                point
            }
        });
        let mark = point.and_then(|point| scene.mark(point));
        self.hover(context, mark);
        if response.clicked() {
            context.push(match mark {
                Some(mark) => Command::Reveal(mark),
                None => Command::Select(None),
            });
        }
    }

    fn hover(&mut self, context: &mut ViewContext<'_>, mark: Option<Mark>) {
        let ours = mark.is_some() || self.hovering;
        if ours && context.app.hover != mark {
            context.push(Command::Hover(mark));
        }
        self.hovering = mark.is_some();
    }
}

fn pick(app: &App, scene: &CloudScene, axes: &Axes<'_>, at: Pos2) -> Option<usize> {
    let size = axes.rect.size();
    let off = at - axes.rect.min;
    let cover = (0.5 * app.options.cloud.point_size).max(1.0);
    axes.projection.pick(
        scene.places(app.options.cloud.outlier_preview),
        Vec2::new(off.x, off.y),
        Vec2::new(size.x, size.y),
        [cover, REACH],
    )
}

/// Marks the selected and the hovered ping: its points, and the line that joins them under the boat.
pub fn paint_marks(
    painter: &Painter,
    app: &App,
    products: &Products,
    scene: &CloudScene,
    axes: &Axes<'_>,
) {
    let marks = [
        (app.selection, theme::selection_colour(), 2.0),
        (app.hover, theme::hover_colour(), 1.0),
    ];
    for (mark, colour, width) in marks {
        if let Some(mark) = mark {
            paint_mark(
                painter,
                &mark,
                products,
                scene,
                axes,
                Stroke::new(width, colour),
            );
        }
    }
}

fn paint_mark(
    painter: &Painter,
    mark: &Mark,
    products: &Products,
    scene: &CloudScene,
    axes: &Axes<'_>,
    stroke: Stroke,
) {
    let of_ping = scene.of_ping(mark.ping);
    let beside: Vec<Pos2> = of_ping.filter_map(|place| axes.at(place)).collect();
    for at in &beside {
        painter.circle_stroke(*at, 4.5, stroke);
    }
    let ping = products.navigation.pings.get(mark.ping);
    let under = ping
        .filter(|ping| ping.east_m.is_finite())
        .and_then(|ping| {
            let surface = scene.local(ping.east_m, ping.north_m, 0.0);
            let bottom = surface.with_z(scene.corners[0].z);
            axes.at(surface).zip(axes.at(bottom))
        });
    if let Some((surface, bottom)) = under {
        // A plumb line under the boat finds the ping from any distance.
        painter.add(Shape::dashed_line(&[surface, bottom], stroke, 4.0, 3.0));
        painter.circle_stroke(surface, 3.0, stroke);
    }
    let point = mark
        .point
        .and_then(|index| products.cloud.points.get(index));
    let at = point.and_then(|point| axes.at(scene.place(point)));
    if let Some(at) = at {
        painter.circle_stroke(at, 8.0, stroke);
    }
}
