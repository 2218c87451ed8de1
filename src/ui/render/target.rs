//! Provides an offscreen picture with its own depth buffer, and the pipelines that draw into it.

use super::pipeline::{
    PipelineParts, bind_group, bind_group_layout, buffer, pipeline, uniform_entry,
};
use bytemuck::Pod;

/// Format of the picture: plain sRGB bytes, which the window shows unchanged.
const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of the depth buffer. With infinite reverse-Z, floats spread their precision evenly over
/// distance.
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A colour picture, transparent where nothing is drawn, and its depth buffer. The window's own
/// render pass has no reliable depth buffer, so 3D is drawn here and then shown as an image.
pub struct RenderTarget {
    size_px: [u32; 2],
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl RenderTarget {
    /// Creates a target of at least 1 x 1 and at most the device's largest texture.
    pub fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let size_px = Self::possible(device, size_px);
        Self {
            size_px,
            colour: texture(device, size_px, COLOUR_FORMAT),
            depth: texture(device, size_px, DEPTH_FORMAT),
        }
    }

    /// Returns the size that a target of a requested size gets.
    pub(crate) fn possible(device: &wgpu::Device, size_px: [u32; 2]) -> [u32; 2] {
        let most = device.limits().max_texture_dimension_2d;
        size_px.map(|side| side.clamp(1, most))
    }

    /// Returns width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Returns the picture.
    pub fn colour(&self) -> &wgpu::TextureView {
        &self.colour
    }

    /// Starts a pass on a cleared target: transparent, and infinitely far (0 in reverse-Z).
    pub fn begin<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("offscreen"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}

fn texture(
    device: &wgpu::Device,
    size: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::TextureView {
    // The picture may be read back, too.
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::COPY_SRC;
    plain_texture(device, size, format, usage).create_view(&Default::default())
}

/// Creates a texture of two dimensions and one level.
pub(super) fn plain_texture(
    device: &wgpu::Device,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Returns the size of a texture of two dimensions.
pub fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
}

/// A pipeline that draws into a [`RenderTarget`], with one uniform block at group 0, binding 0.
pub(super) struct OffscreenPipeline {
    pub pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

impl OffscreenPipeline {
    /// Creates the pipeline. If `tests_depth`, nearer parts hide those behind them; otherwise each
    /// drawing covers the earlier ones.
    pub(super) fn new(device: &wgpu::Device, parts: PipelineParts<'_>, tests_depth: bool) -> Self {
        let layout = bind_group_layout(device, &[uniform_entry(0)]);
        let depth_compare = if tests_depth {
            wgpu::CompareFunction::GreaterEqual
        } else {
            wgpu::CompareFunction::Always
        };
        let depth = wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(tests_depth),
            depth_compare: Some(depth_compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        };
        let pipeline = pipeline(device, &[Some(&layout)], parts, COLOUR_FORMAT, Some(depth));
        Self { pipeline, layout }
    }

    /// Creates a uniform block for the pipeline.
    pub(super) fn uniform(&self, device: &wgpu::Device, size: usize) -> Uniform {
        let buffer = buffer(device, size, wgpu::BufferUsages::UNIFORM);
        let group = bind_group(device, &self.layout, &[buffer.as_entire_binding()]);
        Uniform { buffer, group }
    }
}

/// A uniform block at group 0.
pub(super) struct Uniform {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Uniform {
    /// Writes the block and binds it for the next draw calls.
    pub(super) fn set(&self, queue: &wgpu::Queue, pass: &mut wgpu::RenderPass<'_>, to: &impl Pod) {
        queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(to));
        pass.set_bind_group(0, &self.group, &[]);
    }
}
