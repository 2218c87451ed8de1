//! An offscreen picture shown as an image of the window.

use crate::ui::render::Target;
use eframe::egui_wgpu::{RenderState, Renderer};
use egui::mutex::RwLock;
use egui::{Color32, Painter, Rect, TextureId, emath::GuiRounding as _};
use std::sync::Arc;

/// A target that follows the size of a view and is registered with the window's painter.
#[derive(Default)]
pub struct ViewTexture {
    shown: Option<Shown>,
}

struct Shown {
    target: Target,
    texture: TextureId,
    renderer: Arc<RwLock<Renderer>>,
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.renderer.write().free_texture(&self.texture);
    }
}

impl ViewTexture {
    /// Makes the target as large as `rect` on screen; whether it is a new one that has to be drawn.
    pub fn resize(&mut self, state: &RenderState, rect: Rect, pixels_per_point: f32) -> bool {
        let size = rect.round_to_pixels(pixels_per_point).size() * pixels_per_point;
        let requested = [size.x.round() as u32, size.y.round() as u32];
        let requested = Target::possible(&state.device, requested);
        match &mut self.shown {
            Some(shown) if shown.target.size_px() == requested => false,
            Some(shown) => {
                shown.target = Target::new(&state.device, requested);
                state
                    .renderer
                    .write()
                    .update_egui_texture_from_wgpu_texture(
                        &state.device,
                        shown.target.colour(),
                        wgpu::FilterMode::Nearest,
                        shown.texture,
                    );
                true
            }
            none => {
                let target = Target::new(&state.device, requested);
                let texture = state.renderer.write().register_native_texture(
                    &state.device,
                    target.colour(),
                    wgpu::FilterMode::Nearest,
                );
                *none = Some(Shown {
                    target,
                    texture,
                    renderer: state.renderer.clone(),
                });
                true
            }
        }
    }

    /// What to draw into.
    pub fn target(&self) -> Option<&Target> {
        self.shown.as_ref().map(|shown| &shown.target)
    }

    /// Shows the picture.
    pub fn paint(&self, painter: &Painter, rect: Rect) {
        if let Some(shown) = &self.shown {
            let rect = rect.round_to_pixels(painter.pixels_per_point());
            let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            painter.image(shown.texture, rect, whole, Color32::WHITE);
        }
    }
}
