//! Draws areas of one colour, and pictures, in the window's pass without egui's painter: see
//! [`FlatRenderer`].

use super::render::{FlatRenderer, RenderTarget, Rgba};
use eframe::egui_wgpu::{
    Callback, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor,
};
use egui::emath::GuiRounding as _;
use egui::{Color32, Context, PaintCallback, Painter, Rect, Shape};
use std::any::Any;
use std::collections::HashMap;
use std::sync::Arc;

/// Paint callback of an area; where two frames share the callback, they look the same.
type Drawing = Arc<dyn Any + Send + Sync>;

/// Fills an area with an opaque colour.
pub(super) fn fill(painter: &Painter, rect: Rect, colour: Color32, state: Option<&RenderState>) {
    match state {
        Some(state) => painter.add(filled(painter.ctx(), rect, colour, state)),
        None => painter.rect_filled(rect, 0.0, colour),
    };
}

/// Returns a shape that fills an area with an opaque colour.
pub(super) fn filled(ctx: &Context, rect: Rect, colour: Color32, state: &RenderState) -> Shape {
    let callback = ctx.data_mut(|data| {
        let fills = data.get_temp_mut_or_default::<Fills>(egui::Id::NULL);
        let fill = fills.0.entry(colour);
        fill.or_insert_with(|| drawing(colour, state, None)).clone()
    });
    Shape::Callback(PaintCallback { rect, callback })
}

/// The fills that the window has used so far, by colour.
#[derive(Clone, Default)]
struct Fills(HashMap<Color32, Drawing>);

/// A texture that the window's pass shows with one texel per pixel.
pub(super) struct FlatPicture {
    binding: wgpu::BindGroup,
    drawing: Option<(Color32, Drawing)>,
}

impl FlatPicture {
    /// Creates a picture that shows what is drawn into a texture.
    pub(super) fn new(state: &RenderState, texture: &wgpu::TextureView) -> Self {
        let mut renderer = state.renderer.write();
        let resources = &mut renderer.callback_resources;
        let flat = flat_renderer(resources, &state.device, state.target_format);
        Self { binding: flat.bind_picture(&state.device, texture), drawing: None }
    }

    /// Marks the content of the texture as new, so that the next shape gets a new callback.
    fn has_changed(&mut self) {
        self.drawing = None;
    }

    /// Returns a shape that shows the picture in an area of its size, multiplied by a colour.
    pub(super) fn shape(&mut self, rect: Rect, tint: Color32, state: &RenderState) -> Shape {
        let before = self.drawing.take().filter(|(last, _)| *last == tint);
        let new = || (tint, drawing(tint, state, Some(self.binding.clone())));
        let (_, callback) = self.drawing.insert(before.unwrap_or_else(new));
        let callback = callback.clone();
        Shape::Callback(PaintCallback { rect, callback })
    }
}

fn drawing(colour: Color32, state: &RenderState, picture: Option<wgpu::BindGroup>) -> Drawing {
    let flat = Flat { target: state.target_format, colour: colour.to_array(), picture };
    Callback::new_paint_callback(Rect::NOTHING, flat).callback
}

/// Returns the renderer of the window, which all its views share; builds it on the first call.
fn flat_renderer<'r>(
    resources: &'r mut CallbackResources,
    device: &wgpu::Device,
    target: wgpu::TextureFormat,
) -> &'r mut FlatRenderer {
    resources.entry::<FlatRenderer>().or_insert_with(|| FlatRenderer::new(device, target))
}

/// Paint callback of one area: a colour, or a picture multiplied by a colour.
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

/// An offscreen picture shown in the window: a target that follows the size of a view.
#[derive(Default)]
pub(super) struct ViewTexture {
    shown: Option<ShownTexture>,
}

struct ShownTexture {
    target: RenderTarget,
    picture: FlatPicture,
}

impl ViewTexture {
    /// Makes the target as large as `rect` on screen; returns true if the target is new and has to
    /// be drawn.
    pub(super) fn resize(
        &mut self,
        state: &RenderState,
        rect: Rect,
        pixels_per_point: f32,
    ) -> bool {
        let size = rect.round_to_pixels(pixels_per_point).size() * pixels_per_point;
        let requested = [size.x.round() as u32, size.y.round() as u32];
        let requested = RenderTarget::possible(&state.device, requested);
        let now = self.shown.as_ref().map(|shown| shown.target.size_px());
        if now == Some(requested) {
            return false;
        }
        let target = RenderTarget::new(&state.device, requested);
        self.shown =
            Some(ShownTexture { picture: FlatPicture::new(state, target.colour()), target });
        true
    }

    /// Returns the target to draw into, and marks the picture as changed.
    pub(super) fn target(&mut self) -> Option<&RenderTarget> {
        let shown = self.shown.as_mut()?;
        shown.picture.has_changed();
        Some(&shown.target)
    }

    /// Shows the picture over what was drawn before, with the opacity of the painter.
    pub(super) fn paint(&mut self, painter: &Painter, rect: Rect, state: &RenderState) {
        if let Some(shown) = &mut self.shown {
            let rect = rect.round_to_pixels(painter.pixels_per_point());
            let tint = Color32::WHITE.gamma_multiply(painter.opacity());
            painter.add(shown.picture.shape(rect, tint, state));
        }
    }
}
