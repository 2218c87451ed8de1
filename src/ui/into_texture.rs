//! Draws what egui paints into a texture, outside of the window's own pass.

use eframe::egui_wgpu::{RenderState, ScreenDescriptor};
use egui::epaint::ClippedShape;
use egui::{ClippedPrimitive, TexturesDelta};

/// Makes new and changed textures of egui ready to be drawn with, and takes them out of `textures`.
pub(super) fn upload(gpu: &RenderState, textures: &mut TexturesDelta) {
    let mut renderer = gpu.renderer.write();
    for (id, images) in textures.set.drain() {
        for image in images {
            renderer.update_texture(&gpu.device, &gpu.queue, id, &image);
        }
    }
}

/// Draws shapes, in their order, over what `load` leaves of a texture of the size of `screen`.
pub(super) fn draw(
    gpu: &RenderState,
    ctx: &egui::Context,
    shapes: Vec<ClippedShape>,
    screen: &ScreenDescriptor,
    target: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) {
    let primitives: Vec<ClippedPrimitive> = ctx.tessellate(shapes, screen.pixels_per_point);
    let RenderState { device, queue, .. } = gpu;
    let mut renderer = gpu.renderer.write();
    let mut encoder = device.create_command_encoder(&Default::default());
    let own = renderer.update_buffers(device, queue, &mut encoder, &primitives, screen);
    let attachment = wgpu::RenderPassColorAttachment {
        view: target,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        depth_slice: None,
    };
    let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("egui into a texture"),
        color_attachments: &[Some(attachment)],
        ..Default::default()
    });
    renderer.render(&mut pass.forget_lifetime(), &primitives, screen);
    queue.submit(own.into_iter().chain([encoder.finish()]));
}
