//! Collects the contents of one frame of the cloud view: the open log, and the scenes made for the
//! view.

use super::axes::BoxAxes;
use super::bottom::{self, BottomScene};
use super::picture::CloudDrawing;
use super::pointer::PickScene;
use super::scene::{CloudScene, SceneBox};
use super::{clip, section};
use crate::app::App;
use crate::ui::render::{CameraProjection, CloudDraw};
use crate::ui::text;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::Products;
use egui::Rect;
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
            part: section::part(app, self.scene, projection.eye),
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
            (scene.clone(), draw)
        });
        CloudDrawing { points: options.points.then(|| (self.scene.clone(), points)), bottom }
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
