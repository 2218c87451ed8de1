//! An offscreen picture with its own depth buffer.

/// Format of the picture: plain sRGB bytes, which the window shows unchanged.
pub(super) const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of the depth buffer. With infinite reverse-Z, floats spread their precision evenly over distance.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A colour picture, transparent where nothing is drawn, and its depth buffer. The window's own render pass has no depth
/// buffer that can be relied on, so 3D is drawn here and then shown as an image.
pub(crate) struct Target {
    size_px: [u32; 2],
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Target {
    /// A target of at least 1 x 1 and at most the device's largest texture.
    pub(crate) fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let size_px = Self::possible(device, size_px);
        Self {
            size_px,
            colour: texture(device, size_px, COLOUR_FORMAT),
            depth: texture(device, size_px, DEPTH_FORMAT),
        }
    }

    /// The size that a target of a requested size gets.
    pub(crate) fn possible(device: &wgpu::Device, size_px: [u32; 2]) -> [u32; 2] {
        let most = device.limits().max_texture_dimension_2d;
        size_px.map(|side| side.clamp(1, most))
    }

    /// Width and height in pixels.
    pub(crate) fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// The picture.
    pub(crate) fn colour(&self) -> &wgpu::TextureView {
        &self.colour
    }

    /// Starts a pass on a cleared target: transparent, and infinitely far (0 in reverse-Z).
    pub(crate) fn begin<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
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
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("offscreen"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        // A picture may be read back, too.
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// What a pipeline of a [`Target`] differs in from the others.
pub(super) struct PipelineParts<'a> {
    pub label: &'static str,
    pub shader: &'a str,
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub topology: wgpu::PrimitiveTopology,
    pub blend: Option<wgpu::BlendState>,
    pub writes_depth: bool,
}

/// A pipeline that draws into a [`Target`], with one uniform buffer at group 0, binding 0.
pub(super) fn offscreen_pipeline(
    device: &wgpu::Device,
    parts: PipelineParts<'_>,
) -> (wgpu::RenderPipeline, wgpu::BindGroupLayout) {
    let uniforms = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(parts.label),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(parts.label),
        bind_group_layouts: &[Some(&uniforms)],
        immediate_size: 0,
    });
    let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(parts.label),
        source: wgpu::ShaderSource::Wgsl(parts.shader.into()),
    });
    let compare = if parts.writes_depth {
        wgpu::CompareFunction::GreaterEqual
    } else {
        wgpu::CompareFunction::Always
    };
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(parts.label),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: parts.buffers,
        },
        fragment: Some(wgpu::FragmentState {
            module: &shader,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOUR_FORMAT,
                blend: parts.blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        primitive: wgpu::PrimitiveState {
            topology: parts.topology,
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(parts.writes_depth),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    });
    (pipeline, uniforms)
}

/// A uniform buffer and its bind group.
pub(super) fn uniform(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    size: usize,
) -> (wgpu::Buffer, wgpu::BindGroup) {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("uniform"),
        size: size as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("uniform"),
        layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: buffer.as_entire_binding(),
        }],
    });
    (buffer, group)
}

#[cfg(test)]
pub(super) mod tests {
    use wgpu::naga::{self, TypeInner};

    /// Size in bytes and byte offsets of the members of a struct of a shader.
    pub(crate) fn layout(shader: &str, name: &str) -> (u32, Vec<u32>) {
        let module = naga::front::wgsl::parse_str(shader).expect("a valid shader");
        let of_name = |inner: &naga::Type| inner.name.as_deref() == Some(name);
        let found = module.types.iter().find(|(_, inner)| of_name(inner));
        match &found.expect("a struct of this name").1.inner {
            TypeInner::Struct { members, span } => {
                (*span, members.iter().map(|member| member.offset).collect())
            }
            other => panic!("{name} is {other:?}"),
        }
    }
}
