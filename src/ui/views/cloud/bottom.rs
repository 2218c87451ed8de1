//! The bottom, ready to draw; uploaded off the window's thread.

use crate::app::{App, CloudOptions, Jobs};
use crate::pipeline::{Background, Bottom, Same};
use crate::render::{
    BOTTOM_TILE, BottomBuffers, BottomDraw, BottomVertex, Part, Projection, Uploader, towards_light,
};
use glam::Vec3;
use std::sync::Arc;

/// Width of an isobath on the bottom, points of the screen.
const LINE: f32 = 1.2;

/// A bottom on the GPU.
pub struct BottomScene {
    /// What the bottom is.
    pub bottom: Arc<Bottom>,
    /// Its tiles.
    pub buffers: BottomBuffers,
}

/// What is asked for: a bottom about an origin, metres.
type Key = (Same<Bottom>, [f64; 3]);

/// The bottom of the view, as it was uploaded last.
#[derive(Default)]
pub struct ShownBottom(Background<Key, Arc<BottomScene>>);

impl ShownBottom {
    /// Whether one is being uploaded.
    pub fn is_running(&self) -> bool {
        self.0.is_running()
    }

    /// Has the bottom of the survey uploaded where it changed; `None` where none is shown, or none is there yet.
    pub fn of(
        &mut self,
        app: &App,
        origin_m: [f64; 3],
        uploader: &Uploader,
    ) -> Option<&Arc<BottomScene>> {
        let Some(bottom) = app.bottom() else {
            self.0 = Background::default();
            return None;
        };
        let (key, bottom, uploader) = (
            (Same(bottom.clone()), origin_m),
            bottom.clone(),
            uploader.clone(),
        );
        let jobs: &Jobs = app.jobs();
        self.0.ask(key, jobs, move |progress| {
            let buffers = upload(&bottom, origin_m, &uploader);
            progress.check().ok()?;
            Some(Arc::new(BottomScene { bottom, buffers }))
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
            let place = Vec3::new(
                (east - east_m) as f32,
                (north - north_m) as f32,
                (up - up_m) as f32,
            );
            BottomVertex::new(place, corner.normal, corner.rgb, corner.is_known)
        });
        vertices.collect()
    });
    BottomBuffers::new(uploader, grid.cell_m as f32, down * across, tiles)
}

/// How the bottom is drawn.
pub fn draw(app: &App, projection: Projection, pixels_per_point: f32, part: Part) -> BottomDraw {
    let options: &CloudOptions = &app.options.cloud;
    let [azimuth_deg, altitude_deg] = options.light_deg;
    BottomDraw {
        projection,
        light: towards_light(azimuth_deg, altitude_deg),
        exaggeration: options.vertical_exaggeration.max(0.1),
        isobaths_m: app.bottom_isobaths_m(),
        line_px: LINE * pixels_per_point,
        part,
    }
}
