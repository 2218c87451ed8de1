//! Provides the building blocks of all renderers: buffers, bind groups and their layouts, and the
//! pipeline itself; the part of a scene that is drawn; the uploader, which fills buffers; and an
//! offscreen picture with its own depth buffer and the pipelines that draw into it.

use bytemuck::Pod;
use glam::{Vec2, Vec3, Vec4};

/// Properties that differ between the pipelines.
pub(super) struct PipelineParts<'a> {
    pub label: &'static str,
    pub shader: &'a str,
    /// Names of the vertex shader and of the fragment shader.
    pub entries: [&'static str; 2],
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub topology: wgpu::PrimitiveTopology,
    pub blend: Option<wgpu::BlendState>,
}

/// Builds a pipeline that draws into a target of this format.
pub(super) fn pipeline(
    device: &wgpu::Device,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    parts: PipelineParts<'_>,
    target: wgpu::TextureFormat,
    depth_stencil: Option<wgpu::DepthStencilState>,
) -> wgpu::RenderPipeline {
    let label = Some(parts.label);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(parts.shader.into()),
    });
    let [vertex, fragment] = parts.entries.map(Some);
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: vertex,
            compilation_options: Default::default(),
            buffers: parts.buffers,
        },
        primitive: wgpu::PrimitiveState { topology: parts.topology, ..Default::default() },
        depth_stencil,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: fragment,
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: target,
                blend: parts.blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Creates a buffer that is written from the CPU.
pub(super) fn buffer(
    device: &wgpu::Device,
    bytes: usize,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Returns the layout entry of a uniform block that both shaders read.
pub(super) fn uniform_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    entry(binding, wgpu::ShaderStages::VERTEX_FRAGMENT, ty)
}

/// Returns the layout entry of a texture whose texels the fragment shader loads.
pub(super) fn texture_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    entry(binding, wgpu::ShaderStages::FRAGMENT, ty)
}

fn entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BindingType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

/// Creates the layout of a group with these entries.
pub(super) fn bind_group_layout(
    device: &wgpu::Device,
    entries: &[wgpu::BindGroupLayoutEntry],
) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
}

/// Creates a group of resources; the binding of each is its index.
pub(super) fn bind_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries.collect::<Vec<_>>(),
    })
}

/// Bytes uploaded at once. The graphics library keeps a copy of each piece until the GPU has it.
const PIECE: usize = 1 << 20;

/// Part of a scene inside a box and on one side of a vertical plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScenePart {
    /// Corners of the box outside of which nothing is drawn, metres.
    pub corners: [Vec3; 2],
    /// The plane beyond which nothing is drawn; `None` for no plane.
    pub cut: Option<Cut>,
}

/// A vertical plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Unit vector perpendicular to the plane, towards the part that is left out: east and north.
    pub outward: Vec2,
    /// Distance of the plane from the origin along `outward`, metres.
    pub at_m: f32,
}

impl ScenePart {
    /// The whole scene.
    pub const WHOLE: Self = Self { corners: [Vec3::MIN, Vec3::MAX], cut: None };

    /// Returns true if a place is drawn.
    pub fn holds(&self, place: Vec3) -> bool {
        let [low, high] = self.corners;
        let is_beyond = |cut: Cut| cut.outward.dot(place.truncate()) > cut.at_m;
        (place.cmpge(low) & place.cmple(high)).all() && !self.cut.is_some_and(is_beyond)
    }

    /// Returns the part as the shaders read it: the corners, and the plane as its unit vector and
    /// its distance along that vector.
    pub(super) fn uniform(&self) -> [Vec4; 3] {
        let [low, high] = self.corners.map(|corner| corner.extend(0.0));
        let cut = self
            .cut
            .map_or(Vec4::ZERO.with_z(f32::MAX), |cut| cut.outward.extend(cut.at_m).extend(0.0));
        [low, high, cut]
    }
}

/// A device and the queue that fills its buffers, a piece at a time, so that not all vertices are
/// in memory at once. It can be used from a worker.
#[derive(Clone)]
pub struct Uploader {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Uploader {
    /// Creates an uploader for this device.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self { device: device.clone(), queue: queue.clone() }
    }

    /// Creates a buffer with the first `count` of `vertices`, which are vertices or indices of
    /// vertices. Missing ones are zeros.
    pub(super) fn buffer<T: Pod>(
        &self,
        label: &str,
        usage: wgpu::BufferUsages,
        count: usize,
        vertices: impl Iterator<Item = T>,
    ) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (count * size_of::<T>()) as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut vertices = vertices.take(count);
        let mut piece = Vec::with_capacity(count.min(PIECE / size_of::<T>()));
        let mut offset = 0;
        loop {
            piece.clear();
            piece.extend(vertices.by_ref().take(piece.capacity()));
            if piece.is_empty() {
                return buffer;
            }
            let bytes = bytemuck::cast_slice(&piece);
            self.queue.write_buffer(&buffer, offset, bytes);
            // Sends the piece to the GPU; without this, all pieces would wait for the next frame.
            self.queue.submit([]);
            offset += bytes.len() as u64;
        }
    }

    /// Returns the size of the largest buffer that the device can hold, bytes.
    pub(super) fn most_bytes(&self) -> u64 {
        self.device.limits().max_buffer_size
    }
}

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
    plain_texture(device, size, format, usage, &[]).create_view(&Default::default())
}

/// Creates a texture of two dimensions and one level, with views in its own format or in one of
/// `view_formats`.
pub(crate) fn plain_texture(
    device: &wgpu::Device,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
    view_formats: &[wgpu::TextureFormat],
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats,
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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use wgpu::naga::{self, TypeInner};

    /// Returns size in bytes and byte offsets of the members of a struct of a shader.
    pub(crate) fn layout(shader: &str, name: &str) -> (usize, Vec<usize>) {
        let module = naga::front::wgsl::parse_str(shader).expect("a valid shader");
        let of_name = |inner: &naga::Type| inner.name.as_deref() == Some(name);
        let found = module.types.iter().find(|(_, inner)| of_name(inner));
        match &found.expect("a struct of this name").1.inner {
            TypeInner::Struct { members, span } => {
                let offsets = members.iter().map(|member| member.offset as usize);
                (*span as usize, offsets.collect())
            }
            other => panic!("{name} is {other:?}"),
        }
    }

    /// Asserts that a struct of a shader has the memory layout of the Rust struct whose members are
    /// listed.
    macro_rules! assert_laid_out {
        ($shader:literal, $name:literal, $ours:ident { $($member:ident),* $(,)? }) => {{
            let shader = include_str!(concat!("../../../shaders/", $shader));
            let ours = vec![$(std::mem::offset_of!($ours, $member)),*];
            let found = crate::ui::render::pipeline::tests::layout(shader, $name);
            assert_eq!(found, (size_of::<$ours>(), ours));
        }};
    }
    pub(crate) use assert_laid_out;

    #[test]
    fn a_part_ends_at_its_box_and_at_its_plane() {
        let part = ScenePart {
            corners: [Vec3::splat(-2.0), Vec3::splat(2.0)],
            cut: Some(Cut { outward: Vec2::Y, at_m: 1.0 }),
        };
        let holds = |east, north, up| part.holds(Vec3::new(east, north, up));
        assert!(holds(2.0, 1.0, -2.0));
        assert!(!holds(0.0, 1.1, 0.0), "beyond the plane");
        assert!(!holds(2.1, 0.0, 0.0), "beside the box");
        assert!(ScenePart::WHOLE.holds(Vec3::splat(1e9)));
    }
}
