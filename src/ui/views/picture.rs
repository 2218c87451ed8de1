//! An offscreen picture shown in the window.

use crate::ui::flat;
use crate::ui::render::Target;
use eframe::egui_wgpu::RenderState;
use egui::{Painter, Rect, emath::GuiRounding as _};

/// A target that follows the size of a view.
#[derive(Default)]
pub(super) struct ViewTexture {
    shown: Option<Shown>,
}

struct Shown {
    target: Target,
    /// How the window's pass reads it.
    binding: wgpu::BindGroup,
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
        let requested = Target::possible(&state.device, requested);
        if self.target().is_some_and(|now| now.size_px() == requested) {
            return false;
        }
        let target = Target::new(&state.device, requested);
        self.shown = Some(Shown {
            binding: flat::bind_picture(state, target.colour()),
            target,
        });
        true
    }

    /// What to draw into.
    pub(super) fn target(&self) -> Option<&Target> {
        self.shown.as_ref().map(|shown| &shown.target)
    }

    /// Shows the picture over what lies below, as faded as the painter is.
    pub(super) fn paint(&self, painter: &Painter, rect: Rect, state: &RenderState) {
        if let Some(shown) = &self.shown {
            let rect = rect.round_to_pixels(painter.pixels_per_point());
            flat::picture(painter, rect, &shown.binding, state);
        }
    }
}
