//! Draws long lines on the map on the GPU, only when the lines or the view have changed.

use super::transform::MapTransform;
use crate::ui::flat::ViewTexture;
use crate::ui::render::{
    LineDraw, LinePyramid, LineRenderer, LineUniform, Specks, TrackBuffers, Vertex,
};
use bathyscope_products::pipeline::Same;
use eframe::egui_wgpu::RenderState;
use egui::{Color32, Painter, Rect};
use std::sync::Arc;

/// A line with its levels of detail.
pub(super) struct MapLine {
    /// Origin of the places of `pyramid`, metres.
    pub origin_m: [f64; 2],
    /// The levels of detail.
    pub pyramid: LinePyramid,
    /// The levels on the GPU; `None` without a GPU.
    pub buffers: Option<TrackBuffers>,
}

impl MapLine {
    /// Builds the levels of a line and uploads them.
    pub(super) fn new(
        origin_m: [f64; 2],
        vertices: Vec<Vertex>,
        specks: Specks,
        uploader: Option<&crate::ui::render::Uploader>,
    ) -> Self {
        let mut buffers = uploader.map(|_| TrackBuffers::default());
        let pyramid = LinePyramid::new(vertices, specks, |vertices| {
            if let Some((uploader, buffers)) = uploader.zip(buffers.as_mut()) {
                buffers.add(uploader, vertices);
            }
        });
        Self { origin_m, pyramid, buffers }
    }
}

/// Style of a line: two strokes, the first below.
#[derive(Clone, Copy)]
pub(super) struct MapPen {
    /// Widths of the strokes, points.
    pub widths: [f32; 2],
    /// Colours of the strokes; `None` for the line's own colours.
    pub colours: [Option<Color32>; 2],
    /// Largest number of segments drawn in a frame: beyond it, a coarser level is used.
    pub most_segments: u32,
}

/// GPU objects of one picture of lines. `T` owns the lines.
pub(super) struct LinePicture<T> {
    picture: ViewTexture<(Same<T>, Vec<LineDraw>)>,
    renderer: Option<LineRenderer>,
}

impl<T> Default for LinePicture<T> {
    fn default() -> Self {
        Self { picture: ViewTexture::default(), renderer: None }
    }
}

impl<T> LinePicture<T> {
    /// Draws the lines of `of` if the lines or their view have changed, and shows them; the first
    /// line is below.
    pub(super) fn show<const N: usize>(
        &mut self,
        painter: &Painter,
        state: &RenderState,
        (rect, transform): (Rect, &MapTransform),
        of: &Arc<T>,
        lines: [(&MapLine, MapPen); N],
    ) {
        let pixels_per_point = painter.pixels_per_point();
        let draws: Vec<LineDraw> = lines
            .iter()
            .map(|(line, pen)| line_draw(pixels_per_point, (rect, transform), line, *pen))
            .collect();
        let renderer = self.renderer.get_or_insert_with(|| LineRenderer::new(&state.device));
        let now = (Same(of.clone()), draws);
        self.picture.show(painter, rect, state, now, |target, (_, draws)| {
            let buffers = lines.iter().map(|(line, _)| line.buffers.as_ref());
            let drawn: Vec<(&TrackBuffers, &LineDraw)> =
                buffers.zip(draws).filter_map(|(buffers, draw)| Some((buffers?, draw))).collect();
            renderer.draw(&state.device, &state.queue, target, &drawn);
        });
    }
}

fn line_draw(
    pixels_per_point: f32,
    (rect, transform): (Rect, &MapTransform),
    line: &MapLine,
    pen: MapPen,
) -> LineDraw {
    let [east_m, north_m] = line.origin_m;
    let widest = pen.widths[0].max(pen.widths[1]);
    let margin_m = f64::from(widest) * transform.metres_per_point;
    let [west, south, east, north] = transform.visible(rect);
    let view = [
        (west - east_m - margin_m) as f32,
        (south - north_m - margin_m) as f32,
        (east - east_m + margin_m) as f32,
        (north - north_m + margin_m) as f32,
    ];
    let metres_per_px = transform.metres_per_point as f32 / pixels_per_point;
    let (level, runs) = line.pyramid.choose(metres_per_px, view, pen.most_segments);
    let px_from_world = transform.pixels(rect, pixels_per_point, line.origin_m);
    let stroke = |index: usize| {
        let [r, g, b, a] = pen.colours[index]
            .unwrap_or(Color32::TRANSPARENT)
            .to_srgba_unmultiplied()
            .map(|byte| f32::from(byte) / 255.0);
        LineUniform {
            px_from_world,
            size_px: [0.0; 2],
            half_width_px: 0.5 * pen.widths[index] * pixels_per_point,
            plain: f32::from(u8::from(pen.colours[index].is_some())),
            // Gamma-encoded, like the target.
            colour: [r, g, b, a],
        }
    };
    LineDraw { level, runs, strokes: [stroke(0), stroke(1)] }
}
