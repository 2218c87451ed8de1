//! The bottom, ready to draw; uploaded in a background thread.

use crate::app::{App, CloudOptions};
use crate::ui::render::{
    BOTTOM_TILE, BottomBuffers, BottomDraw, BottomPart, BottomVertex, CameraProjection, ScenePart,
    Uploader, towards_light,
};
use bathyscope_products::pipeline::{Background, Bottom, BottomColour, CornerGround, Same};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// Width of an isobath on the bottom, points of the screen.
const LINE: f32 = 1.2;
/// Brightness of a bottom that is turned away from the light: relief is plain to see, and colours
/// can still be told apart.
const DARKEST: f32 = 0.25;
/// The same under the mosaic, whose echoes have light and shade of their own.
const DARKEST_ECHO: f32 = 0.6;
/// Steps in which the bottom under the pointer is looked for: each comes nearer as many times as
/// the view is steeper than the bottom.
const STEPS: usize = 6;

/// A bottom on the GPU.
pub(super) struct BottomScene {
    /// The bottom itself.
    pub bottom: Arc<Bottom>,
    /// Its tiles.
    pub buffers: BottomBuffers,
    /// The box around it, in the places of the scene, where it reaches farther than the points do.
    pub wide: Option<[Vec3; 2]>,
    origin_m: [f64; 3],
}

impl BottomScene {
    /// The place on the bottom that is seen at a place of the picture; `None` where there is none.
    pub(super) fn under(&self, projection: &CameraProjection, ndc: Vec2) -> Option<Vec3> {
        let [east_m, north_m, up_m] = self.origin_m;
        let [least_m, most_m] = self.bottom.range_m;
        let towards = projection.towards(ndc)?;
        // From the middle of all depths to that of the place, and from there to that of the place
        // where this one is.
        let mut z = (-0.5 * (least_m + most_m) - up_m) as f32;
        let mut found = None;
        for _ in 0..STEPS {
            let ahead = (z - projection.eye.z) / towards.z;
            let place = projection.eye + ahead * towards;
            let [x, y] = [place.x, place.y].map(f64::from);
            let place = self.at([east_m + x, north_m + y])?;
            if ahead <= 0.0 {
                return None;
            }
            z = place.z;
            found = Some(place);
        }
        found
    }

    /// The bottom at a place east and north of the survey's origin, metres; `None` where there is
    /// none.
    pub(super) fn at(&self, place_m: [f64; 2]) -> Option<Vec3> {
        let [east_m, north_m, up_m] = self.origin_m;
        let depth_m = f64::from(self.bottom.depth_at(place_m)?);
        let local = [place_m[0] - east_m, place_m[1] - north_m, -depth_m - up_m];
        Some(Vec3::from(local.map(|metres| metres as f32)))
    }
}

/// Key of a scene: a bottom and its origin, metres.
type BottomSceneKey = (Same<Bottom>, [f64; 3]);

/// The bottom of the view, as it was uploaded last.
#[derive(Default)]
pub(super) struct ShownBottom(Background<BottomSceneKey, Arc<BottomScene>>);

impl ShownBottom {
    /// Returns true if one is being uploaded.
    pub(super) fn is_running(&self) -> bool {
        self.0.is_running()
    }

    /// Has the bottom of the survey uploaded where it changed; `None` where none is shown, or none
    /// is there yet.
    pub(super) fn of(
        &mut self,
        app: &App,
        origin_m: [f64; 3],
        uploader: &Uploader,
    ) -> Option<&Arc<BottomScene>> {
        let Some(bottom) = app.bottom() else {
            self.0 = Background::default();
            return None;
        };
        let key = (Same(bottom.clone()), origin_m);
        let (bottom, uploader) = (bottom.clone(), uploader.clone());
        self.0.ask(key, app.jobs(), move |progress| {
            let buffers = upload(&bottom, origin_m, &uploader);
            progress.check().ok()?;
            Some(Arc::new(BottomScene {
                wide: buffers.extent().filter(|_| bottom.has_flat_extrapolation),
                bottom,
                buffers,
                origin_m,
            }))
        });
        self.0.result()
    }
}

fn upload(
    bottom: &Bottom,
    [east_m, north_m, up_m]: [f64; 3],
    uploader: &Uploader,
) -> BottomBuffers {
    let grid = &bottom.surface().grid;
    let [down, across] = [grid.rows, grid.columns]
        .map(|corners| corners.saturating_sub(1).div_ceil(BOTTOM_TILE).max(1));
    let tiles = (0..down * across).map(|tile| {
        let [row, column] = [tile / across, tile % across].map(|place| place * BOTTOM_TILE);
        let corners = bottom.corners(row..row + BOTTOM_TILE + 1, column..column + BOTTOM_TILE + 1);
        let vertices = corners.map(|corner| {
            let [east, north, up] = corner.place_m;
            let place = [east - east_m, north - north_m, up - up_m];
            let place = Vec3::from(place.map(|metres| metres as f32));
            let part = match corner.ground {
                CornerGround::Unknown => BottomPart::None,
                CornerGround::Level => BottomPart::Plain,
                CornerGround::Depth => BottomPart::Lit,
            };
            BottomVertex::new(place, corner.normal, corner.rgb, part)
                .with_far_colour(corner.far_rgb)
        });
        vertices.collect()
    });
    BottomBuffers::new(uploader, grid.cell_m as f32, tiles)
}

/// Parameters of the picture of a bottom.
pub(super) fn draw(
    app: &App,
    bottom: &Bottom,
    projection: CameraProjection,
    pixels_per_point: f32,
    part: ScenePart,
) -> BottomDraw {
    let options: &CloudOptions = &app.view.options.cloud;
    let [azimuth_deg, altitude_deg] = options.light_deg;
    BottomDraw {
        projection,
        light: towards_light(azimuth_deg, altitude_deg),
        exaggeration: options.vertical_exaggeration.max(0.1),
        isobaths_m: app.bottom_isobaths_m(),
        line_px: LINE * pixels_per_point,
        darkest: match bottom.colour {
            BottomColour::Mosaic => DARKEST_ECHO,
            _ => DARKEST,
        },
        part,
    }
}
