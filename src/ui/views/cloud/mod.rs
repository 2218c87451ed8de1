//! Draws the cloud view: soundings and first returns in 3D.
//!
//! Input: the state. Output: a picture in 3D with axes, legend and marks, and commands.

mod axes;
mod bottom;
mod clip;
mod controls;
mod objects;
mod pointer;
mod scene;
mod shown;

use super::legend;
use crate::app::{App, CloudColour, Command, LogPlace, SideColours, ThemeChoice};
use crate::ui::render::{OrbitCamera, Uploader};
use crate::ui::{ViewContext, ViewRequest, flat, place, theme};
use axes::BoxAxes;
use bathyscope_products::pipeline::Background;
use bottom::ShownBottom;
use eframe::egui_wgpu::RenderState;
use egui::{Painter, Rect, Response, Role, Sense, Ui, Vec2, WidgetInfo};
use pointer::PickScene;
use scene::{CloudScene, ColourEnds, SceneBox, SceneLogPoints, ShownPoints};
use shown::{CloudPicture, ShownCloud};
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

/// Points of the screen that the numbers around the box need, both sides together.
const LABEL_ROOM: f32 = 90.0;

type CloudKey = (Vec<SceneLogPoints>, ColourEnds, (CloudColour, ThemeChoice, SideColours));

/// State of the cloud view: its camera, and the data computed for it.
#[derive(Default)]
pub struct CloudView {
    camera: Option<OrbitCamera>,
    /// The camera that showed everything, and the size of the view at that time. If the user has
    /// not moved the camera, it is fitted again after a change of size.
    fitted: Option<(OrbitCamera, Vec2)>,
    request: Option<ViewRequest>,
    scene: Background<CloudKey, Arc<CloudScene>>,
    bottom: ShownBottom,
    picture: CloudPicture,
    pointer: pointer::CloudPointer,
    /// Width over height of the view in the last frame.
    aspect: Option<f32>,
    /// Width over height of the view that the first frame is to reproduce; `None` for no such view.
    aim: Option<f32>,
    seen_plane: u64,
    seen_reveal: u64,
    /// Origin of the scene and corners of its box in the last frame, to which the camera refers.
    about: Option<Extent>,
}

/// Origin of a scene, metres east, north and up, and the corners of its box relative to this
/// origin.
type Extent = ([f64; 3], [glam::Vec3; 2]);

impl CloudView {
    /// Draws the view into all of `ui` and pushes the commands of the user.
    pub fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        let canvas = theme::canvas_colour(context.options());
        flat::fill(&painter, rect, canvas, context.render_state);
        if self.seen_plane != context.app.view.plane_serial {
            self.seen_plane = context.app.view.plane_serial;
            self.camera = None;
            self.scene = Background::default();
        }
        let name = self.content(ui, context, rect, &response);
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    }

    /// Returns a view from the same place, for a picture of any size.
    pub(crate) fn for_picture(&self, app: &App) -> Self {
        Self {
            camera: self.camera,
            aim: self.aspect,
            seen_plane: app.view.plane_serial,
            ..Self::default()
        }
    }

    /// Carries out a request from menu, key or palette.
    pub fn request(&mut self, request: ViewRequest) {
        self.request = Some(request);
    }

    /// Returns true if everything on screen is drawn at its final quality.
    pub fn is_settled(&self) -> bool {
        !self.scene.is_running() && !self.bottom.is_running() && self.request.is_none()
    }

    /// Draws the contents of the view; returns the view's accessible name.
    fn content(
        &mut self,
        ui: &mut Ui,
        context: &mut ViewContext<'_>,
        rect: Rect,
        response: &Response,
    ) -> String {
        let Some(survey) = context.app.logs.shown.survey.clone() else {
            return "3D point cloud, empty".to_owned();
        };
        let Some(products) = context.app.logs.shown.products.clone() else {
            legend::wait(ui, context, rect, "The point cloud is being built.");
            return "3D point cloud, being built".to_owned();
        };
        self.ask_for_scene(context);
        let Some(scene) = self.scene.result().cloned() else {
            if !self.scene.is_running() {
                legend::say(ui, context, rect, "This log has no positions to place points at.");
            }
            return "3D point cloud, no points".to_owned();
        };
        let Some(state) = context.render_state else {
            legend::say(ui, context, rect, legend::NO_GPU);
            return shown::name(&scene);
        };
        let uploader = Uploader::new(&state.device, &state.queue);
        let bottom = bottom::of(&mut self.bottom, context.app, scene.origin_m, &uploader).cloned();
        let shown = ShownCloud::new(&survey, &products, &scene, bottom.as_ref());
        let camera = self.navigate(ui, context, rect, response, shown.pick_scene());
        let axes = shown.axes(context.app, rect, camera.projection(aspect(rect)));
        let painter = ui.painter_at(rect);
        self.paint(&painter, state, context.app, &shown, &axes);
        self.pointer.handle(context, response, shown.pick_scene(), (&axes, camera));
        self.controls(ui, context, shown.all, &axes);
        shown.name()
    }

    /// Draws the points and the bottom, with axes, marks and legend.
    fn paint(
        &mut self,
        painter: &Painter,
        state: &RenderState,
        app: &App,
        shown: &ShownCloud<'_>,
        axes: &BoxAxes<'_>,
    ) {
        let (rect, scene) = (axes.rect, shown.scene);
        axes.walls(painter);
        let drawing = shown.drawing(app, axes, painter.pixels_per_point());
        self.picture.show(painter, rect, state, drawing);
        clip::paint_water(painter, app, scene, axes);
        clip::paint_section(painter, app, scene, axes);
        objects::paint(painter, app, scene, axes);
        pointer::paint_marks(painter, app, shown.products, shown.pick_scene(), axes);
        let reference = place::reduction(app).reference();
        let bottom = shown.bottom.map(|scene| &*scene.bottom);
        let covered = controls::paint_legend(
            painter,
            rect,
            axes.options,
            shown.survey,
            (scene, bottom),
            reference,
        );
        axes.labels(painter, &covered);
        controls::paint_read_out(painter, rect, app, shown.survey, shown.products);
    }

    /// Shows the controls over the view; an exported picture shows their values instead.
    fn controls(
        &mut self,
        ui: &mut Ui,
        context: &mut ViewContext<'_>,
        all: SceneBox,
        axes: &BoxAxes<'_>,
    ) {
        if context.app.view.is_picture {
            let painter = ui.painter_at(axes.rect);
            controls::paint_exaggeration(&painter, axes.rect, axes.options);
            clip::paint_note(&painter, axes.rect, axes.options);
            return;
        }
        controls::show(ui, context, axes.rect, &mut self.request);
        if let Some(changed) = clip::show(ui, context, all, axes) {
            let mut options = context.app.view.options.clone();
            options.cloud.clip = Some(changed);
            context.push(Command::Show(Box::new(options)));
        }
    }

    fn ask_for_scene(&mut self, context: &ViewContext<'_>) {
        let options = context.options().clone();
        let colours = (options.cloud.colour, options.theme, options.side_colours);
        let logs: Vec<SceneLogPoints> = context
            .app
            .logs
            .with_results()
            .iter()
            .map(|shown| SceneLogPoints::of(shown, options.swath))
            .collect();
        let uploader = context.uploader();
        let ends = ColourEnds {
            depth_m: context.app.logs.depth_range_m(),
            scales: context.app.logs.point_scales(),
        };
        let key = (logs.clone(), ends, colours);
        self.scene.ask(key, context.app.jobs.workers(), move |progress| {
            let scene = CloudScene::new(logs, ends, &options, uploader.as_ref(), progress);
            scene.map(Arc::new)
        });
    }

    /// Moves the camera as asked by keys, wheel, drag and reveals; returns it.
    fn navigate(
        &mut self,
        ui: &Ui,
        context: &ViewContext<'_>,
        rect: Rect,
        response: &Response,
        seen: PickScene<'_>,
    ) -> OrbitCamera {
        let scene = seen.scene;
        self.follow(seen.all);
        let outgrown = self
            .fitted
            .is_some_and(|(fitted, size)| self.camera == Some(fitted) && size != rect.size());
        let is_new = self.camera.is_none() || outgrown;
        let mut camera = self.camera.unwrap_or_default();
        camera.exaggeration = context.options().cloud.vertical_exaggeration.max(0.1);
        self.aspect = Some(aspect(rect));
        // Views of any width show the same height: a narrower one would cut off the sides.
        if let Some(seen) = self.aim.take().filter(|seen| aspect(rect) < *seen) {
            camera.zoom(aspect(rect) / seen, glam::Vec2::ZERO, aspect(rect));
        }
        let request = self.request.take();
        let clip = context.options().cloud.clip;
        let eye = camera.projection(aspect(rect)).eye;
        let shown = ShownPoints {
            outliers: context.options().cloud.outlier_preview,
            part: clip::scene_part(context.app, scene, eye),
        };
        let shown = (shown, rect);
        let mut zoom = |factor| pointer::zoom(&mut camera, seen, shown, rect.center(), factor);
        match request {
            Some(ViewRequest::ZoomIn) => zoom(1.4),
            Some(ViewRequest::ZoomOut) => zoom(1.0 / 1.4),
            Some(ViewRequest::Top) => camera.look_from_south(FRAC_PI_2),
            Some(ViewRequest::Side) => camera.look_from_south(0.0),
            Some(ViewRequest::Fit | ViewRequest::OneToOne) | None => {}
        }
        let fits = matches!(request, Some(ViewRequest::Fit | ViewRequest::Top | ViewRequest::Side));
        if is_new || fits || response.double_clicked() {
            camera.fit(clip::part(seen.all, clip), aspect(rect), margin(rect));
            self.fitted = Some((camera, rect.size()));
        }
        pointer::move_camera(ui, shown, response, seen, &mut camera);
        if let Some(reveal) = context.app.view.reveal
            && reveal.serial != self.seen_reveal
        {
            self.seen_reveal = reveal.serial;
            match place::enlarged(&reveal) {
                Some(([east_m, north_m, z_m], size_m)) => {
                    camera.close_up(scene.local(east_m, north_m, z_m), size_m as f32);
                }
                None => show_place(&mut camera, context.app, reveal.mark, rect, scene),
            }
        }
        self.camera = Some(camera);
        camera
    }

    /// Moves the camera with the cloud when its box or its origin has changed: after a change of
    /// preset the cloud may have another size and another place. A camera that the user has not
    /// moved shows all of the cloud again.
    fn follow(&mut self, all: SceneBox) {
        let now = (all.origin_m, all.corners);
        let Some(before) = self.about.replace(now).filter(|before| *before != now) else {
            return;
        };
        let is_fitted = self.fitted.is_some_and(|(fitted, _)| self.camera == Some(fitted));
        let shift = shift(before.0, now.0);
        let fitted = self.fitted.as_mut().map(|(camera, _)| camera);
        for camera in self.camera.as_mut().into_iter().chain(fitted) {
            camera.target += shift;
        }
        let was = before.1.map(|corner| corner + shift);
        let target = self.camera.map(|camera| camera.target);
        if has_moved(was, now.1, target.filter(|_| !is_fitted)) {
            self.camera = None;
        }
    }
}

/// Returns the shift of coordinates from one origin to another.
fn shift(from_m: [f64; 3], to_m: [f64; 3]) -> glam::Vec3 {
    let by = |axis: usize| (from_m[axis] - to_m[axis]) as f32;
    glam::Vec3::new(by(0), by(1), by(2))
}

/// Returns true if a cloud has moved away: its box differs by more than a twentieth, or a fifth in
/// depth. With a camera that the analyst has placed, returns true if its target was inside the
/// cloud and is now outside.
fn has_moved(was: [glam::Vec3; 2], is: [glam::Vec3; 2], placed: Option<glam::Vec3>) -> bool {
    if let Some(target) = placed {
        let [low, high] = is;
        let margin = 0.1 * (high - low).max(glam::Vec3::ONE);
        let inside = target.cmpge(low - margin) & target.cmple(high + margin);
        let was_inside = target.cmpge(was[0] - margin) & target.cmple(was[1] + margin);
        return was_inside.all() && !inside.all();
    }
    let common = was[1].min(is[1]) - was[0].max(is[0]);
    let larger = (was[1] - was[0]).max(is[1] - is[0]).max(glam::Vec3::splat(0.1));
    common.cmplt(glam::Vec3::new(0.95, 0.95, 0.8) * larger).any()
}

fn aspect(rect: Rect) -> f32 {
    rect.width().max(1.0) / rect.height().max(1.0)
}

/// Returns the margin of the fitted box, which leaves room for the numbers beside it.
fn margin(rect: Rect) -> f32 {
    let shorter = rect.size().min_elem().max(1.0);
    1.0 / (1.0 - LABEL_ROOM / shorter).max(0.6)
}

/// Moves the camera over a place that is outside of the picture; for a place in the picture the
/// camera stays.
fn show_place(camera: &mut OrbitCamera, app: &App, mark: LogPlace, rect: Rect, scene: &CloudScene) {
    let Some([east_m, north_m]) = place::east_north(app, mark) else {
        return;
    };
    let [low, high] = scene.corners;
    let place = scene.local(east_m, north_m, 0.0).with_z(0.5 * (low.z + high.z));
    let ndc = camera.projection(aspect(rect)).project(place);
    if ndc.is_none_or(|ndc| ndc.truncate().abs().max_element() > 0.9) {
        camera.target = place;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_cloud_that_went_elsewhere_is_found_again_and_one_that_stayed_is_left() {
        let was = [Vec3::new(0.0, 0.0, -6.0), Vec3::new(80.0, 60.0, -1.0)];
        let nudged = was.map(|corner| corner + Vec3::new(1.0, -2.0, 0.2));
        // The size in Mercator metres at 37 degrees north.
        let larger = was.map(|corner| corner * Vec3::new(1.25, 1.25, 1.0) + Vec3::X * 30.0);
        assert!(!has_moved(was, nudged, None));
        assert!(has_moved(was, larger, None));
        let detail = Vec3::new(12.0, 8.0, -3.0);
        assert!(!has_moved(was, nudged, Some(detail)), "a detail is still there");
        assert!(has_moved(was, larger, Some(detail)));
        assert!(!has_moved(was, larger, Some(Vec3::new(50.0, 30.0, -3.0))));
        assert_eq!(shift([10.0, 20.0, 0.0], [4.0, 25.0, 0.0]), Vec3::new(6.0, -5.0, 0.0));
    }
}
