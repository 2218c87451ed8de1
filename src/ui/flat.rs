//! Areas of one colour, and pictures, drawn in the window's pass without its painter: see [`FlatRenderer`].

use super::render::{FlatRenderer, Rgba};
use eframe::egui_wgpu::{
    Callback, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor,
};
use egui::{Color32, Painter, Rect};

/// Fills an area with an opaque colour.
pub(super) fn fill(painter: &Painter, rect: Rect, colour: Color32, state: Option<&RenderState>) {
    match state {
        Some(state) => add(painter, rect, colour, state, None),
        None => {
            painter.rect_filled(rect, 0.0, colour);
        }
    }
}

/// Shows a picture of the size of an area, as faded as the painter is.
pub(super) fn picture(
    painter: &Painter,
    rect: Rect,
    picture: &wgpu::BindGroup,
    state: &RenderState,
) {
    let tint = Color32::WHITE.gamma_multiply(painter.opacity());
    add(painter, rect, tint, state, Some(picture.clone()));
}

/// What [`picture`] reads a picture by.
pub(super) fn bind_picture(state: &RenderState, picture: &wgpu::TextureView) -> wgpu::BindGroup {
    let mut renderer = state.renderer.write();
    flat_renderer(
        &mut renderer.callback_resources,
        &state.device,
        state.target_format,
    )
    .bind_picture(&state.device, picture)
}

fn add(
    painter: &Painter,
    rect: Rect,
    colour: Color32,
    state: &RenderState,
    picture: Option<wgpu::BindGroup>,
) {
    let flat = Flat {
        target: state.target_format,
        colour: colour.to_array(),
        picture,
    };
    painter.add(Callback::new_paint_callback(rect, flat));
}

/// The one of the window; all its views share it.
fn flat_renderer<'r>(
    resources: &'r mut CallbackResources,
    device: &wgpu::Device,
    target: wgpu::TextureFormat,
) -> &'r mut FlatRenderer {
    resources
        .entry::<FlatRenderer>()
        .or_insert_with(|| FlatRenderer::new(device, target))
}

/// One area of one frame.
struct Flat {
    target: wgpu::TextureFormat,
    colour: Rgba,
    picture: Option<wgpu::BindGroup>,
}

impl CallbackTrait for Flat {
    fn prepare(
        &self,
        device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        flat_renderer(resources, device, self.target).prepare(device, self.colour);
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some(renderer) = resources.get::<FlatRenderer>() else {
            return;
        };
        match &self.picture {
            Some(picture) => renderer.show(pass, picture, self.colour),
            None => renderer.fill(pass, self.colour),
        }
    }
}
