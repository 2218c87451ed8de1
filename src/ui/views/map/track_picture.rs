//! The track: a line of its depths' colours over a dark one.

use super::layers::TrackLayer;
use super::lines::{LinePicture, MapPen};
use super::scene::MapScene;
use crate::ui::theme;
use crate::ui::views::{empty, legend};
use eframe::egui_wgpu::RenderState;
use egui::{Align2, Painter};

/// Most segments drawn in a frame: beyond, a coarser level is taken.
const MOST_SEGMENTS: u32 = 5_000;
/// Width of the line under the track and of the track, points.
const WIDTHS: [f32; 2] = [4.6, 3.0];
/// Opacity of the line under the track.
const CASING_OPACITY: f32 = 0.75;

/// Draws the track if it changed, and shows it.
pub(super) fn show(
    picture: &mut LinePicture<TrackLayer>,
    painter: &Painter,
    state: Option<&RenderState>,
    scene: &MapScene<'_>,
) {
    let Some(state) = state else {
        let (at, middle) = (scene.rect.center(), Align2::CENTER_CENTER);
        let colour = theme::canvas_text_colour(scene.options);
        painter.text(at, middle, empty::NO_GPU, legend::font(), colour);
        return;
    };
    // The line under the track sets it off from the depth map, whose colours it shares.
    let casing = theme::canvas_colour(scene.options).gamma_multiply(CASING_OPACITY);
    let pen =
        MapPen { widths: WIDTHS, colours: [Some(casing), None], most_segments: MOST_SEGMENTS };
    let (view, lines) = ((scene.rect, &scene.transform), [(&scene.track.line, pen)]);
    picture.show(painter, state, view, scene.track, lines);
}
