//! Prepares the bottom for drawing; uploads it in a background thread.

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
/// Brightness of a bottom that is turned away from the light: dark enough to show relief, bright
/// enough to tell colours apart.
const DARKEST: f32 = 0.25;
/// Brightness, away from the light, of a bottom under the mosaic, whose echoes have light and shade
/// of their own.
const DARKEST_ECHO: f32 = 0.6;
/// Steps of the search for the bottom under the pointer. Each step divides the error by the ratio
/// of the steepness of the view to that of the bottom.
const STEPS: usize = 6;

/// A bottom on the GPU.
pub(super) struct BottomScene {
    /// The bottom itself.
    pub bottom: Arc<Bottom>,
    /// Tiles of the bottom on the GPU.
    pub buffers: BottomBuffers,
    /// The box around the bottom, in coordinates of the scene; `None` unless the mosaic extends
    /// beyond known depths, on a level bed.
    pub wide: Option<[Vec3; 2]>,
    origin_m: [f64; 3],
}

impl BottomScene {
    /// Returns the place on the bottom that is visible at a place of the picture; `None` where
    /// there is no bottom.
    pub(super) fn under(&self, projection: &CameraProjection, ndc: Vec2) -> Option<Vec3> {
        let [east_m, north_m, up_m] = self.origin_m;
        let [least_m, most_m] = self.bottom.range_m;
        let towards = projection.towards(ndc)?;
        // Starts at the middle of all depths, and then repeats with the depth of the bottom at the
        // place found last.
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

    /// Returns the bottom at a place east and north of the survey's origin, metres; `None` where
    /// there is no bottom.
    pub(super) fn at(&self, place_m: [f64; 2]) -> Option<Vec3> {
        let [east_m, north_m, up_m] = self.origin_m;
        let depth_m = f64::from(self.bottom.depth_at(place_m)?);
        let local = [place_m[0] - east_m, place_m[1] - north_m, -depth_m - up_m];
        Some(Vec3::from(local.map(|metres| metres as f32)))
    }
}

/// The bottom of the view that was uploaded last; its key is the bottom and its origin, metres.
pub(super) type ShownBottom = Background<(Same<Bottom>, [f64; 3]), Arc<BottomScene>>;

/// Returns the bottom of the survey, and starts its upload where it changed; `None` where no bottom
/// is shown, or before the first upload has ended.
pub(super) fn of<'a>(
    shown: &'a mut ShownBottom,
    app: &App,
    origin_m: [f64; 3],
    uploader: &Uploader,
) -> Option<&'a Arc<BottomScene>> {
    let Some(bottom) = app.bottom() else {
        *shown = Background::default();
        return None;
    };
    let key = (Same(bottom.clone()), origin_m);
    let (bottom, uploader) = (bottom.clone(), uploader.clone());
    shown.ask(key, app.jobs.workers(), move |progress| {
        let buffers = upload(&bottom, origin_m, &uploader);
        progress.check().ok()?;
        Some(Arc::new(BottomScene {
            wide: buffers.extent().filter(|_| bottom.has_flat_extrapolation),
            bottom,
            buffers,
            origin_m,
        }))
    });
    shown.result()
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

/// Returns the parameters of the picture of a bottom.
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
