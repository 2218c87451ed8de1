//! Provides the building blocks of all renderers: buffers, bind groups and their layouts, and the
//! pipeline itself; the part of a scene that is drawn; and the uploader, which fills buffers.

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

impl Default for ScenePart {
    /// Returns the whole scene.
    fn default() -> Self {
        Self::WHOLE
    }
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
