//! Building blocks of all pipelines: buffers, bind groups and their layouts, and the pipeline
//! itself.

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

/// A buffer that is written from the CPU.
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

/// A uniform block, in both shaders.
pub(super) fn uniform_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    entry(binding, wgpu::ShaderStages::VERTEX_FRAGMENT, ty)
}

/// A texture that the fragment shader loads texels of.
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

/// The layout of a group with these entries.
pub(super) fn bind_group_layout(
    device: &wgpu::Device,
    entries: &[wgpu::BindGroupLayoutEntry],
) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
}

/// A group of resources, whose bindings are their places.
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

#[cfg(test)]
pub(super) mod tests {
    use wgpu::naga::{self, TypeInner};

    /// Size in bytes and byte offsets of the members of a struct of a shader.
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

    /// Asserts that the struct of a shader lies in memory as ours does, whose members are listed.
    macro_rules! assert_laid_out {
        ($shader:literal, $name:literal, $ours:ident { $($member:ident),* $(,)? }) => {{
            let shader = include_str!(concat!("../../../shaders/", $shader));
            let ours = vec![$(std::mem::offset_of!($ours, $member)),*];
            let found = crate::ui::render::pipeline::tests::layout(shader, $name);
            assert_eq!(found, (size_of::<$ours>(), ours));
        }};
    }
    pub(crate) use assert_laid_out;
}
