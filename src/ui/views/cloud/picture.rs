//! Draws the bottom and the points on the GPU, only when camera or data have changed.

use super::bottom::BottomScene;
use super::scene::CloudScene;
use crate::ui::flat::ViewTexture;
use crate::ui::render::{BottomDraw, BottomRenderer, CloudDraw, CloudRenderer, RenderTarget};
use eframe::egui_wgpu::RenderState;
use egui::{Painter, Rect};
use std::sync::Arc;

/// Bottom and points to draw, with their parameters.
#[derive(Clone, Default)]
pub(super) struct CloudDrawing {
    /// The bottom; `None` if it is not shown.
    pub bottom: Option<(Arc<BottomScene>, BottomDraw)>,
    /// The points; `None` if they are not shown.
    pub points: Option<(Arc<CloudScene>, CloudDraw)>,
}

/// Two drawings are equal if they draw the same allocation with equal parameters; contents are not
/// compared.
impl PartialEq for CloudDrawing {
    fn eq(&self, other: &Self) -> bool {
        fn same<S, D: PartialEq>(a: &Option<(Arc<S>, D)>, b: &Option<(Arc<S>, D)>) -> bool {
            match (a, b) {
                (Some((a, of_a)), Some((b, of_b))) => Arc::ptr_eq(a, b) && of_a == of_b,
                (None, None) => true,
                _ => false,
            }
        }
        same(&self.bottom, &other.bottom) && same(&self.points, &other.points)
    }
}

/// Renderers of bottom and points.
struct Renderers {
    bottom: BottomRenderer,
    points: CloudRenderer,
}

/// GPU objects of one cloud view.
#[derive(Default)]
pub(super) struct CloudPicture {
    picture: ViewTexture,
    renderers: Option<Renderers>,
    drawn: Option<CloudDrawing>,
}

impl CloudPicture {
    /// Draws the picture if something has changed, and shows it.
    pub(super) fn show(
        &mut self,
        painter: &Painter,
        rect: Rect,
        state: &RenderState,
        drawing: CloudDrawing,
    ) {
        let is_new = self.picture.resize(state, rect, painter.pixels_per_point());
        if (is_new || self.drawn.as_ref() != Some(&drawing))
            && let Some(target) = self.picture.target()
        {
            let renderers = self.renderers.get_or_insert_with(|| Renderers {
                bottom: BottomRenderer::new(&state.device),
                points: CloudRenderer::new(&state.device),
            });
            renderers.draw(state, target, &drawing);
            self.drawn = Some(drawing);
        }
        self.picture.paint(painter, rect, state);
    }
}

impl Renderers {
    fn draw(&self, state: &RenderState, target: &RenderTarget, drawing: &CloudDrawing) {
        let mut encoder = state.device.create_command_encoder(&Default::default());
        {
            let mut pass = target.begin(&mut encoder);
            if let Some((scene, draw)) = &drawing.bottom {
                let queue = &state.queue;
                self.bottom.draw(queue, target, &mut pass, &scene.buffers, draw);
            }
            if let Some((scene, draw)) = &drawing.points
                && let Some(points) = &scene.buffers
            {
                let queue = &state.queue;
                self.points.draw(queue, target, &mut pass, points, draw);
            }
        }
        state.queue.submit([encoder.finish()]);
    }
}
