//! Hands the tiles in view to the renderer inside egui's pass.

use crate::render::waterfall::{Look, Quad, Tables, TileTexture, WaterfallPicture};
use eframe::egui_wgpu::{CallbackResources, CallbackTrait, ScreenDescriptor};
use std::sync::Arc;

/// One frame's picture. Holds its renderer itself: two waterfalls never share a buffer.
pub(super) struct PictureCallback {
    pub picture: Arc<WaterfallPicture>,
    pub look: Look,
    pub tables: Tables,
    pub tiles: Vec<(Quad, TileTexture)>,
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
        self.picture
            .paint(pass, &self.tables, self.tiles.iter().map(|(_, tile)| tile));
    }
}
