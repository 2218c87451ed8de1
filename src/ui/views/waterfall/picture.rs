//! Hands the tiles in view to the renderer inside egui's pass.

use crate::ui::render::waterfall::{DrawnTile, EchoStyle, GainBuffer, Quad, WaterfallPicture};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, ScreenDescriptor};
use egui::{Painter, Rect};
use std::sync::Arc;
use std::time::Duration;

/// One frame's picture. Holds its renderer itself: two waterfalls never share a buffer.
pub(super) struct PictureCallback {
    pub picture: Arc<WaterfallPicture>,
    pub look: EchoStyle,
    pub gain: GainBuffer,
    pub tiles: Vec<(Quad, DrawnTile)>,
}

impl PictureCallback {
    /// Adds it to what is painted; `has_uploads` says that tiles wait for the next frame.
    pub(super) fn add_to(self, painter: &Painter, rect: Rect, has_uploads: bool) {
        if has_uploads {
            // Not "at once": a harness that waits for stillness may stop here and look again later.
            let soon = Duration::from_millis(1);
            painter.ctx().request_repaint_after(soon);
        }
        painter.add(Callback::new_paint_callback(rect, self));
    }
}

impl CallbackTrait for PictureCallback {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let quads = self.tiles.iter().map(|(quad, _)| quad);
        self.picture.prepare(queue, self.look, quads);
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        self.picture.paint(pass, &self.gain, self.tiles.iter().map(|(_, tile)| tile));
    }
}
