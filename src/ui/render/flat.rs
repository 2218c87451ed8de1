//! Draws flat parts of a pass of the window: areas of one colour, and pictures that lie texel by pixel.
//!
//! The window's painter draws both as triangles of a filtered texture. A driver without a graphics card takes some 40 ns for each pixel
//! of these, and most pixels of the window are flat.

use bytemuck::{Pod, Zeroable};
use std::collections::HashMap;
use wgpu::util::{BufferInitDescriptor, DeviceExt as _};

/// The uniform block `Tint` of `flat.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Tint {
    colour: [f32; 4],
    linear_target: u32,
    padding: [u32; 3],
}

/// A colour: red, green and blue of sRGB, multiplied by the alpha that follows.
pub(crate) type Rgba = [u8; 4];

/// Pipelines and colours of one window.
pub(crate) struct FlatRenderer {
    fill: wgpu::RenderPipeline,
    picture: wgpu::RenderPipeline,
    tint_layout: wgpu::BindGroupLayout,
    picture_layout: wgpu::BindGroupLayout,
    tints: HashMap<Rgba, wgpu::BindGroup>,
    linear_target: bool,
}

impl FlatRenderer {
    /// Builds the pipelines for targets of this format.
    pub(crate) fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Self {
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let tint_layout = layout(device, uniform);
        let picture_layout = layout(device, texture);
        let over = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;
        let both = [Some(&tint_layout), Some(&picture_layout)];
        Self {
            fill: pipeline(device, &both[..1], "fs_fill", None, target),
            picture: pipeline(device, &both, "fs_picture", Some(over), target),
            tint_layout,
            picture_layout,
            tints: HashMap::new(),
            linear_target: target.is_srgb(),
        }
    }

    /// Makes a colour ready for [`FlatRenderer::fill`] and [`FlatRenderer::show`].
    pub(crate) fn prepare(&mut self, device: &wgpu::Device, colour: Rgba) {
        let (layout, linear_target) = (&self.tint_layout, self.linear_target);
        self.tints.entry(colour).or_insert_with(|| {
            let tint = Tint {
                colour: colour.map(|byte| f32::from(byte) / 255.0),
                linear_target: u32::from(linear_target),
                padding: [0; 3],
            };
            let buffer = device.create_buffer_init(&BufferInitDescriptor {
                label: Some("flat tint"),
                contents: bytemuck::bytes_of(&tint),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            bind(device, layout, buffer.as_entire_binding())
        });
    }

    /// What [`FlatRenderer::show`] reads a picture by.
    pub(crate) fn bind_picture(
        &self,
        device: &wgpu::Device,
        picture: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let view = wgpu::BindingResource::TextureView(picture);
        bind(device, &self.picture_layout, view)
    }

    /// Fills the viewport with a colour that is prepared.
    pub(crate) fn fill(&self, pass: &mut wgpu::RenderPass<'_>, colour: Rgba) {
        self.draw(pass, &self.fill, colour);
    }

    /// Shows a picture of the size of the viewport, multiplied by a colour that is prepared.
    pub(crate) fn show(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        picture: &wgpu::BindGroup,
        colour: Rgba,
    ) {
        pass.set_bind_group(1, picture, &[]);
        self.draw(pass, &self.picture, colour);
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline, colour: Rgba) {
        let Some(tint) = self.tints.get(&colour) else {
            return;
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, tint, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn layout(device: &wgpu::Device, ty: wgpu::BindingType) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("flat"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        }],
    })
}

fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resource: wgpu::BindingResource<'_>,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("flat"),
        layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource,
        }],
    })
}

fn pipeline(
    device: &wgpu::Device,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    fragment: &str,
    blend: Option<wgpu::BlendState>,
    target: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("../../../shaders/flat.wgsl"));
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("flat"),
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("flat"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_main"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: target,
                blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::super::target::tests::layout;
    use super::*;
    use std::mem::offset_of;

    #[test]
    fn the_shader_reads_the_tint_as_it_is_written() {
        let (size, offsets) = layout(include_str!("../../../shaders/flat.wgsl"), "Tint");
        assert_eq!(size as usize, size_of::<Tint>());
        let ours = [offset_of!(Tint, colour), offset_of!(Tint, linear_target)];
        assert_eq!(offsets, ours.map(|offset| offset as u32));
    }
}
