//! Draws flat parts of a pass of the window: areas of one colour, and pictures with one texel per
//! pixel.
//!
//! The window's painter draws both as triangles of a filtered texture. A driver without a graphics
//! card takes some 40 ns for each pixel of these, and most pixels of the window are flat.

use super::pipeline::{
    PipelineParts, bind_group, bind_group_layout, pipeline, texture_entry, uniform_entry,
};
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
pub type Rgba = [u8; 4];

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
        let tint_layout = bind_group_layout(device, &[uniform_entry(0)]);
        let picture_layout = bind_group_layout(device, &[texture_entry(0)]);
        let over = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;
        let both = [Some(&tint_layout), Some(&picture_layout)];
        Self {
            fill: draw_with(device, &both[..1], "fs_fill", None, target),
            picture: draw_with(device, &both, "fs_picture", Some(over), target),
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
            bind_group(device, layout, &[buffer.as_entire_binding()])
        });
    }

    /// Creates the bind group by which [`FlatRenderer::show`] reads a picture.
    pub(crate) fn bind_picture(
        &self,
        device: &wgpu::Device,
        picture: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let view = wgpu::BindingResource::TextureView(picture);
        bind_group(device, &self.picture_layout, &[view])
    }

    /// Fills the viewport with a colour; does nothing if the colour is not prepared.
    pub(crate) fn fill(&self, pass: &mut wgpu::RenderPass<'_>, colour: Rgba) {
        self.draw(pass, &self.fill, colour);
    }

    /// Shows a picture of the size of the viewport, multiplied by a colour; does nothing if the
    /// colour is not prepared.
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

fn draw_with(
    device: &wgpu::Device,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    fragment: &'static str,
    blend: Option<wgpu::BlendState>,
    target: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let parts = PipelineParts {
        label: "flat",
        shader: include_str!("../../../shaders/flat.wgsl"),
        entries: ["vs_main", fragment],
        buffers: &[],
        topology: wgpu::PrimitiveTopology::TriangleList,
        blend,
    };
    pipeline(device, layouts, parts, target, None)
}

#[cfg(test)]
mod tests {
    use super::super::pipeline::tests::assert_laid_out;
    use super::*;

    #[test]
    fn the_shader_reads_the_tint_as_it_is_written() {
        assert_laid_out!("flat.wgsl", "Tint", Tint { colour, linear_target });
    }
}
