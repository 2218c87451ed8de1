//! Draws points in a pass of a [`RenderTarget`].

use super::Uploader;
use super::pipeline::{OffscreenPipeline, PipelineParts, RenderTarget, ScenePart, Uniform};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};

/// A point, as the shader reads it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PointVertex {
    /// Metres from the cloud's origin: east, north, up.
    pub place: [f32; 3],
    /// sRGB and alpha (unused).
    pub colour: [u8; 4],
}

/// The uniform block `View` of `cloud.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ViewUniform {
    clip_from_world: Mat4,
    size_px: [f32; 2],
    radius_px: f32,
    nearer: f32,
    low: Vec4,
    high: Vec4,
    cut: Vec4,
}

/// Points in one buffer: 64 MB, a quarter of what every device grants.
const POINTS_A_BUFFER: usize = 1 << 22;

/// Points on the GPU.
pub(crate) struct CloudBuffers {
    buffers: Vec<(wgpu::Buffer, u32)>,
}

impl CloudBuffers {
    /// Uploads the first `count` of `points`.
    pub(crate) fn new(
        uploader: &Uploader,
        count: usize,
        mut points: impl Iterator<Item = PointVertex>,
    ) -> Self {
        let upload = |start: usize| {
            let held = POINTS_A_BUFFER.min(count - start);
            let buffer =
                uploader.buffer("points", wgpu::BufferUsages::VERTEX, held, points.by_ref());
            (buffer, held as u32)
        };
        Self { buffers: (0..count).step_by(POINTS_A_BUFFER).map(upload).collect() }
    }
}

/// Parameters of a picture of the cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CloudDraw {
    /// Matrix from metres to clip space.
    pub clip_from_world: Mat4,
    /// Radius of a point, pixels.
    pub radius_px: f32,
    /// Number of points to draw, from the first on.
    pub count: usize,
    /// Share of their distance by which the points are drawn nearer, so that points are visible on
    /// a bottom that runs through them.
    pub nearer: f32,
    /// The part that is drawn.
    pub part: ScenePart,
}

/// The pipeline for points, with the uniforms of one view.
pub(crate) struct CloudRenderer {
    pipeline: OffscreenPipeline,
    view: Uniform,
}

impl CloudRenderer {
    /// Builds the pipeline.
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let pipeline = OffscreenPipeline::new(
            device,
            PipelineParts {
                label: "cloud",
                shader: include_str!("../../../shaders/cloud.wgsl"),
                entries: ["vertex", "fragment"],
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<PointVertex>() as u64,
                    step_mode: wgpu::VertexStepMode::Instance,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Unorm8x4],
                })],
                blend: None,
                topology: wgpu::PrimitiveTopology::TriangleStrip,
            },
            true,
        );
        let view = pipeline.uniform(device, size_of::<ViewUniform>());
        Self { pipeline, view }
    }

    /// Draws the points in a pass of the target.
    pub(crate) fn draw(
        &self,
        queue: &wgpu::Queue,
        target: &RenderTarget,
        pass: &mut wgpu::RenderPass<'_>,
        points: &CloudBuffers,
        draw: &CloudDraw,
    ) {
        let [low, high, cut] = draw.part.uniform();
        let uniform = ViewUniform {
            clip_from_world: draw.clip_from_world,
            size_px: target.size_px().map(|side| side as f32),
            radius_px: draw.radius_px,
            nearer: draw.nearer,
            low,
            high,
            cut,
        };
        pass.set_pipeline(&self.pipeline.pipeline);
        self.view.set(queue, pass, &uniform);
        let mut left = draw.count;
        for (buffer, count) in &points.buffers {
            let drawn = left.min(*count as usize);
            pass.set_vertex_buffer(0, buffer.slice(..));
            pass.draw(0..4, 0..drawn as u32);
            left -= drawn;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pipeline::tests::assert_laid_out;
    use super::*;

    #[test]
    fn the_shader_reads_the_view_as_it_is_written() {
        assert_laid_out!(
            "cloud.wgsl",
            "View",
            ViewUniform { clip_from_world, size_px, radius_px, nearer, low, high, cut }
        );
    }
}
