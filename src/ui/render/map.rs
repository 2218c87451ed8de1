//! Draws a track with levels of detail into a [`RenderTarget`].

use super::Uploader;
use super::lod::Vertex;
use super::pipeline::{OffscreenPipeline, PipelineParts, RenderTarget, Uniform};
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// The uniform block `Line` of `track.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LineUniform {
    /// Scale and offset from metres to pixels: scale x, scale y (negative: north is up), offset x,
    /// offset y.
    pub px_from_world: [f32; 4],
    /// Size of the picture in pixels; set by [`LineRenderer::draw`].
    pub size_px: [f32; 2],
    /// Half of the line's width, pixels.
    pub half_width_px: f32,
    /// Above 0: `colour` replaces the colours of the segments.
    pub plain: f32,
    /// sRGB and alpha, 0 to 1.
    pub colour: [f32; 4],
}

/// All levels of a track on the GPU.
#[derive(Default)]
pub(crate) struct TrackBuffers {
    levels: Vec<Option<wgpu::Buffer>>,
}

impl TrackBuffers {
    /// Uploads one more level, coarser than those before. A level that no buffer can hold is not
    /// drawn.
    pub(crate) fn add(&mut self, uploader: &Uploader, vertices: &[Vertex]) {
        let fits = size_of_val(vertices) as u64 <= uploader.most_bytes();
        let buffer = (vertices.len() > 1 && fits).then(|| {
            let (usage, all) = (wgpu::BufferUsages::VERTEX, vertices.iter().copied());
            uploader.buffer("track", usage, vertices.len(), all)
        });
        self.levels.push(buffer);
    }
}

/// Parameters of a line: a level, its runs of segments, and the strokes drawn over each other, the
/// lowest first.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LineDraw {
    /// Index of the level.
    pub level: usize,
    /// Runs of segments to draw.
    pub runs: Vec<Range<u32>>,
    /// Uniforms of the casing, then of the coloured line.
    pub strokes: [LineUniform; 2],
}

/// The pipeline for lines, with the uniforms of one picture.
pub(crate) struct LineRenderer {
    pipeline: OffscreenPipeline,
    /// Uniforms, two for each line drawn so far.
    strokes: Vec<Uniform>,
}

impl LineRenderer {
    /// Builds the pipeline.
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let pipeline = OffscreenPipeline::new(
            device,
            PipelineParts {
                label: "track",
                shader: include_str!("../../../shaders/track.wgsl"),
                entries: ["vertex", "fragment"],
                // The same buffer twice, offset by one vertex: a segment joins each vertex to the
                // next.
                buffers: &[
                    Some(vertices(&wgpu::vertex_attr_array![0 => Float32x2, 2 => Unorm8x4])),
                    Some(vertices(&wgpu::vertex_attr_array![1 => Float32x2, 3 => Unorm8x4])),
                ],
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                topology: wgpu::PrimitiveTopology::TriangleStrip,
            },
            false,
        );
        Self { pipeline, strokes: Vec::new() }
    }

    /// Clears the target and draws the strokes of every line into it, the first line below.
    pub(crate) fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target: &RenderTarget,
        lines: &[(&TrackBuffers, &LineDraw)],
    ) {
        while self.strokes.len() < 2 * lines.len() {
            let stroke = self.pipeline.uniform(device, size_of::<LineUniform>());
            self.strokes.push(stroke);
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = target.begin(&mut encoder);
            for ((buffers, draw), uniforms) in lines.iter().zip(self.strokes.chunks_exact(2)) {
                let Some(Some(vertices)) = buffers.levels.get(draw.level) else {
                    continue;
                };
                pass.set_pipeline(&self.pipeline.pipeline);
                pass.set_vertex_buffer(0, vertices.slice(..));
                pass.set_vertex_buffer(1, vertices.slice(size_of::<Vertex>() as u64..));
                for (uniform, stroke) in uniforms.iter().zip(&draw.strokes) {
                    let size_px = target.size_px().map(|side| side as f32);
                    let stroke = LineUniform { size_px, ..*stroke };
                    uniform.set(queue, &mut pass, &stroke);
                    for run in &draw.runs {
                        pass.draw(0..4, run.clone());
                    }
                }
            }
        }
        queue.submit([encoder.finish()]);
    }
}

fn vertices(attributes: &[wgpu::VertexAttribute]) -> wgpu::VertexBufferLayout<'_> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes,
    }
}

#[cfg(test)]
mod tests {
    use super::super::pipeline::tests::assert_laid_out;
    use super::*;

    #[test]
    fn the_shader_reads_the_line_as_it_is_written() {
        assert_laid_out!(
            "track.wgsl",
            "Line",
            LineUniform { px_from_world, size_px, half_width_px, plain, colour }
        );
    }
}
