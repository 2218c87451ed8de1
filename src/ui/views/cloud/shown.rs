//! Collects the contents of one frame of the cloud view (the open log, and the scenes made for the
//! view), and draws bottom and points on the GPU, only when camera or data have changed.

use super::axes::BoxAxes;
use super::bottom::{self, BottomScene};
use super::clip;
use super::pointer::PickScene;
use super::scene::{CloudScene, SceneBox};
use crate::app::App;
use crate::ui::flat::ViewTexture;
use crate::ui::render::{
    BottomDraw, BottomRenderer, CameraProjection, CloudDraw, CloudRenderer, RenderTarget,
};
use crate::ui::text;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{Products, Same};
use eframe::egui_wgpu::RenderState;
use egui::{Painter, Rect};
use std::sync::Arc;

/// Share of their distance by which points are drawn nearer when the bottom is shown: they are on
/// the bottom, and half of each would be hidden in it.
const NEARER: f32 = 0.004;

/// Contents of a frame of the view.
pub(super) struct ShownCloud<'a> {
    pub survey: &'a Survey,
    pub products: &'a Products,
    pub scene: &'a Arc<CloudScene>,
    pub bottom: Option<&'a Arc<BottomScene>>,
    /// The box around points and bottom.
    pub all: SceneBox,
}

impl<'a> ShownCloud<'a> {
    pub(super) fn new(
        survey: &'a Survey,
        products: &'a Products,
        scene: &'a Arc<CloudScene>,
        bottom: Option<&'a Arc<BottomScene>>,
    ) -> Self {
        let all = match bottom.and_then(|bottom| bottom.wide) {
            Some(wide) => scene.extent().as_wide_as(wide),
            None => scene.extent(),
        };
        Self { survey, products, scene, bottom, all }
    }

    /// Returns the contents that the pointer picks from.
    pub(super) fn pick_scene(&self) -> PickScene<'a> {
        PickScene { scene: self.scene, bottom: self.bottom.map(|bottom| &**bottom), all: self.all }
    }

    /// Returns the box with axes that is drawn around the contents.
    pub(super) fn axes<'b>(
        &self,
        app: &'b App,
        rect: Rect,
        projection: CameraProjection,
    ) -> BoxAxes<'b> {
        let options = &app.view.options;
        BoxAxes {
            rect,
            projection,
            part: clip::scene_part(app, self.scene, projection.eye),
            corners: clip::part(self.all, options.cloud.clip),
            origin_m: self.scene.origin_m,
            options,
        }
    }

    /// Returns the drawing for the GPU.
    pub(super) fn drawing(
        &self,
        app: &App,
        axes: &BoxAxes<'_>,
        pixels_per_point: f32,
    ) -> CloudDrawing {
        let options = &axes.options.cloud;
        let points = CloudDraw {
            clip_from_world: axes.projection.clip_from_world,
            radius_px: (0.5 * options.point_size * pixels_per_point).max(0.5),
            count: self.scene.shown(options.outlier_preview),
            nearer: if self.bottom.is_some() { NEARER } else { 0.0 },
            part: axes.part,
        };
        let bottom = self.bottom.map(|scene| {
            let (of, part) = (&*scene.bottom, axes.part);
            let draw = bottom::draw(app, of, axes.projection, pixels_per_point, part);
            (Same(scene.clone()), draw)
        });
        let points = options.points.then(|| (Same(self.scene.clone()), points));
        CloudDrawing { points, bottom }
    }

    /// Returns the accessible name of the view.
    pub(super) fn name(&self) -> String {
        let points = name(self.scene);
        match self.bottom {
            Some(bottom) => format!("{points}, bottom by {}", bottom.bottom.colour.name()),
            None => points,
        }
    }
}

/// Returns the accessible name of the view if it has points only.
pub(super) fn name(scene: &CloudScene) -> String {
    format!(
        "3D point cloud, {} points, {} removed ({:.1} %)",
        text::count(scene.counts.kept()),
        text::count(scene.classes.noise()),
        100.0 * scene.classes.noise_share()
    )
}

/// Bottom and points to draw, with their parameters.
#[derive(Clone, Default, PartialEq)]
pub(super) struct CloudDrawing {
    /// The bottom; `None` if it is not shown.
    pub bottom: Option<(Same<BottomScene>, BottomDraw)>,
    /// The points; `None` if they are not shown.
    pub points: Option<(Same<CloudScene>, CloudDraw)>,
}

/// Renderers of bottom and points.
struct Renderers {
    bottom: BottomRenderer,
    points: CloudRenderer,
}

/// GPU objects of one cloud view.
#[derive(Default)]
pub(super) struct CloudPicture {
    picture: ViewTexture<CloudDrawing>,
    renderers: Option<Renderers>,
}

impl CloudPicture {
    /// Draws the picture if something has changed, and shows it.
    pub(super) fn show(
        &mut self,
        painter: &Painter,
        rect: Rect,
        state: &RenderState,
        drawing: CloudDrawing,
    ) {
        let renderers = self.renderers.get_or_insert_with(|| Renderers {
            bottom: BottomRenderer::new(&state.device),
            points: CloudRenderer::new(&state.device),
        });
        self.picture.show(painter, rect, state, drawing, |target, drawing| {
            renderers.draw(state, target, drawing);
        });
    }
}

impl Renderers {
    fn draw(&self, state: &RenderState, target: &RenderTarget, drawing: &CloudDrawing) {
        let mut encoder = state.device.create_command_encoder(&Default::default());
        {
            let mut pass = target.begin(&mut encoder);
            if let Some((scene, draw)) = &drawing.bottom {
                let queue = &state.queue;
                self.bottom.draw(queue, target, &mut pass, &scene.0.buffers, draw);
            }
            if let Some((scene, draw)) = &drawing.points
                && let Some(points) = &scene.0.buffers
            {
                let queue = &state.queue;
                self.points.draw(queue, target, &mut pass, points, draw);
            }
        }
        state.queue.submit([encoder.finish()]);
    }
}
