//! An offscreen picture shown in the window.

use crate::ui::flat::FlatPicture;
use crate::ui::render::RenderTarget;
use eframe::egui_wgpu::RenderState;
use egui::{Color32, Painter, Rect, emath::GuiRounding as _};

/// A target that follows the size of a view.
#[derive(Default)]
pub(super) struct ViewTexture {
    shown: Option<Shown>,
}

struct Shown {
    target: RenderTarget,
    picture: FlatPicture,
}

impl ViewTexture {
    /// Makes the target as large as `rect` on screen; whether it is a new one that has to be drawn.
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
        self.shown = Some(Shown { picture: FlatPicture::new(state, target.colour()), target });
        true
    }

    /// Returns the target to draw into, and marks the picture as changed.
    pub(super) fn target(&mut self) -> Option<&RenderTarget> {
        let shown = self.shown.as_mut()?;
        shown.picture.has_changed();
        Some(&shown.target)
    }

    /// Shows the picture over what lies below, as faded as the painter is.
    pub(super) fn paint(&mut self, painter: &Painter, rect: Rect, state: &RenderState) {
        if let Some(shown) = &mut self.shown {
            let rect = rect.round_to_pixels(painter.pixels_per_point());
            let tint = Color32::WHITE.gamma_multiply(painter.opacity());
            painter.add(shown.picture.shape(rect, tint, state));
        }
    }
}
