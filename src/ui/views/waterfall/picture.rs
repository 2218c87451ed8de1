//! The waterfall as an image of the window: it is drawn beside the window's own pass, and only where it changed.

use crate::ui::render::waterfall::WaterfallPicture;
use crate::ui::render::{ScrolledWaterfall, Target, WaterfallFrame};
use eframe::egui_wgpu::{RenderState, Renderer};
use egui::mutex::RwLock;
use egui::{Color32, Painter, Rect, TextureId, emath::GuiRounding as _, pos2};
use std::sync::Arc;
use std::time::Duration;

/// The picture of one view, registered with the window's painter.
#[derive(Default)]
pub(super) struct ShownPicture {
    shown: Option<Shown>,
}

struct Shown {
    picture: ScrolledWaterfall,
    texture: TextureId,
    renderer: Arc<RwLock<Renderer>>,
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.renderer.write().free_texture(&self.texture);
    }
}

impl ShownPicture {
    /// Draws a frame as far as it is new, and shows it; `has_uploads` says that tiles wait for the next one.
    pub fn show(
        &mut self,
        painter: &Painter,
        rect: Rect,
        state: &RenderState,
        renderer: &WaterfallPicture,
        frame: WaterfallFrame,
        has_uploads: bool,
    ) {
        if has_uploads {
            // Not "at once": a harness that waits for stillness may stop here and look again later.
            let soon = Duration::from_millis(1);
            painter.ctx().request_repaint_after(soon);
        }
        let pixels_per_point = painter.pixels_per_point();
        let rect = rect.round_to_pixels(pixels_per_point);
        let size = rect.size() * pixels_per_point;
        let size_px = [size.x.round() as u32, size.y.round() as u32];
        let size_px = Target::possible(&state.device, size_px);
        let is_of_size = |shown: &Shown| shown.picture.size_px() == size_px;
        if !self.shown.as_ref().is_some_and(is_of_size) {
            let picture = ScrolledWaterfall::new(&state.device, size_px);
            let mut painters = state.renderer.write();
            let filter = wgpu::FilterMode::Nearest;
            let texture = painters.register_native_texture(&state.device, &picture.view(), filter);
            drop(painters);
            self.shown = Some(Shown {
                picture,
                texture,
                renderer: state.renderer.clone(),
            });
        }
        let Some(Shown {
            picture, texture, ..
        }) = &mut self.shown
        else {
            return;
        };
        if picture.draw(&state.device, &state.queue, renderer, frame) {
            let mut painters = state.renderer.write();
            painters.update_egui_texture_from_wgpu_texture(
                &state.device,
                &picture.view(),
                wgpu::FilterMode::Nearest,
                *texture,
            );
        }
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(*texture, rect, whole, Color32::WHITE);
    }
}
