//! The points, drawn by the GPU and only when camera or data changed.

use super::scene::CloudScene;
use crate::render::{CloudDraw, CloudRenderer};
use crate::ui::views::picture::Picture;
use eframe::egui_wgpu::RenderState;
use egui::{Painter, Rect};
use std::sync::Arc;

/// GPU objects of one cloud view.
#[derive(Default)]
pub struct CloudPicture {
    picture: Picture,
    renderer: Option<CloudRenderer>,
    drawn: Option<(Arc<CloudScene>, CloudDraw)>,
}

impl CloudPicture {
    /// Draws the points if something changed, and shows them.
    pub fn show(
        &mut self,
        painter: &Painter,
        rect: Rect,
        state: &RenderState,
        scene: &Arc<CloudScene>,
        draw: CloudDraw,
    ) {
        let is_new = self.picture.resize(state, rect, painter.pixels_per_point());
        let same = self
            .drawn
            .as_ref()
            .is_some_and(|(drawn, with)| Arc::ptr_eq(drawn, scene) && *with == draw);
        if (is_new || !same)
            && let (Some(target), Some(points)) = (self.picture.target(), &scene.buffers)
        {
            let renderer = self
                .renderer
                .get_or_insert_with(|| CloudRenderer::new(&state.device));
            renderer.draw(&state.device, &state.queue, target, points, &draw);
            self.drawn = Some((scene.clone(), draw));
        }
        self.picture.paint(painter, rect);
    }
}
