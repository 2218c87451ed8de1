//! The track, drawn by the GPU and only when something about it changed.

use super::layers::TrackLayer;
use super::overlay::Scene;
use crate::render::{LineDraw, LineRenderer, LineUniform};
use crate::ui::theme;
use crate::ui::views::picture::Picture;
use crate::ui::views::{empty, legend};
use eframe::egui_wgpu::RenderState;
use egui::{Align2, Painter};
use std::sync::Arc;

/// Most segments drawn in a frame: beyond, a coarser level is taken.
const MOST_SEGMENTS: u32 = 5_000;
/// Width of the track and of the dark line under it, points.
const WIDTHS: [f32; 2] = [3.0, 4.6];
/// Opacity of the line under the track.
const CASING_OPACITY: f32 = 0.75;

/// GPU objects of one map view.
#[derive(Default)]
pub struct TrackPicture {
    picture: Picture,
    renderer: Option<LineRenderer>,
    drawn: Option<(Arc<TrackLayer>, LineDraw)>,
}

impl TrackPicture {
    /// Draws the track if it changed, and shows it.
    pub fn show(&mut self, painter: &Painter, state: Option<&RenderState>, scene: &Scene<'_>) {
        let Some(state) = state else {
            let text = theme::canvas_text_colour(scene.options);
            let at = scene.rect.center();
            painter.text(
                at,
                Align2::CENTER_CENTER,
                empty::NO_GPU,
                legend::font(),
                text,
            );
            return;
        };
        let is_new = self
            .picture
            .resize(state, scene.rect, painter.pixels_per_point());
        let draw = line_draw(painter.pixels_per_point(), scene);
        let same = self
            .drawn
            .as_ref()
            .is_some_and(|(track, drawn)| Arc::ptr_eq(track, scene.track) && *drawn == draw);
        if (is_new || !same)
            && let (Some(target), Some(buffers)) = (self.picture.target(), &scene.track.buffers)
        {
            let renderer = self
                .renderer
                .get_or_insert_with(|| LineRenderer::new(&state.device));
            renderer.draw(&state.device, &state.queue, target, buffers, &draw);
            self.drawn = Some((scene.track.clone(), draw));
        }
        self.picture.paint(painter, scene.rect);
    }
}

fn line_draw(pixels_per_point: f32, scene: &Scene<'_>) -> LineDraw {
    let [east_m, north_m] = scene.track.origin_m;
    let margin_m = f64::from(WIDTHS[1]) * scene.transform.metres_per_point;
    let [west, south, east, north] = scene.transform.visible(scene.rect);
    let view = [
        (west - east_m - margin_m) as f32,
        (south - north_m - margin_m) as f32,
        (east - east_m + margin_m) as f32,
        (north - north_m + margin_m) as f32,
    ];
    let metres_per_px = scene.transform.metres_per_point as f32 / pixels_per_point;
    let (level, runs) = scene
        .track
        .pyramid
        .choose(metres_per_px, view, MOST_SEGMENTS);
    let stroke = |width: f32, plain: f32| LineUniform {
        px_from_world: scene
            .transform
            .pixels(scene.rect, pixels_per_point, scene.track.origin_m),
        size_px: [0.0; 2],
        half_width_px: 0.5 * width * pixels_per_point,
        plain,
        colour: casing(scene),
    };
    LineDraw {
        level,
        runs,
        strokes: [stroke(WIDTHS[1], 1.0), stroke(WIDTHS[0], 0.0)],
    }
}

/// The line under the track sets it off from the depth map, whose colours it shares. Gamma-encoded, as the target is.
fn casing(scene: &Scene<'_>) -> [f32; 4] {
    let colour = theme::canvas_colour(scene.options);
    let [r, g, b, _] = colour.to_array().map(|byte| f32::from(byte) / 255.0);
    [r, g, b, CASING_OPACITY]
}
