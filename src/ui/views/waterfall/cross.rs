//! The cross that the arrow keys move over the waterfall with a tool in hand.

use super::lens::{Lens, LensPlace};
use crate::app::View;
use crate::ui::ViewContext;
use crate::ui::views::measured;
use egui::{Painter, Response, Ui, Vec2, vec2};

/// Place of the cross; `None` before a key has moved it, and after the pointer has moved.
#[derive(Default)]
pub(super) struct Cross {
    place: Option<LensPlace>,
}

impl Cross {
    /// Moves it by the keys of this frame; whether they moved it.
    pub(super) fn follow(
        &mut self,
        ui: &mut Ui,
        response: &Response,
        lens: &Lens,
        context: &ViewContext<'_>,
    ) -> bool {
        let hover = response.hover_pos();
        if hover.is_some() && ui.input(|input| input.pointer.delta() != Vec2::ZERO) {
            self.place = None;
        }
        let moved = match context.target {
            View::Waterfall => measured::arrows(ui),
            View::Map | View::Cloud | View::Objects => [0.0; 2],
        };
        if moved == [0.0; 2] {
            return false;
        }
        let from = self.place.or(hover.map(|at| lens.place_at(at)));
        let from = from.map_or(lens.rect.center(), |place| lens.screen_at(place));
        // Up on the screen is less of its y.
        let to = from + vec2(moved[0] as f32, -moved[1] as f32);
        self.place = Some(lens.place_at(to));
        true
    }

    /// Place of the cross, or else of the pointer.
    pub(super) fn or_pointer(&self, response: &Response, lens: &Lens) -> Option<LensPlace> {
        let under = response.hover_pos().map(|at| lens.place_at(at));
        self.place.or(under)
    }

    /// Place of the cross.
    pub(super) fn place(&self) -> Option<LensPlace> {
        self.place
    }

    /// Draws it.
    pub(super) fn draw(&self, painter: &Painter, lens: &Lens) {
        let Some(place) = self.place else {
            return;
        };
        measured::cross(painter, lens.screen_at(place));
    }
}
