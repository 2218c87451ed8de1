//! Manages the picture of one survey: the worker that makes its tiles, the tiles that have arrived
//! and wait for the GPU, and the visible tiles, which the renderer draws inside egui's pass.

use super::lens::Lens;
use super::tiles::ResidentTiles;
use crate::app::{App, Jobs};
use crate::ui::render::waterfall::{
    DrawnTile, EchoStyle, GainBuffer, Quad, TILE_ROWS, TileRow, TileRows, TileTexture,
    WaterfallPicture,
};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_bottom::picture::LogPicture;
use bathyscope_bottom::waterfall::{
    Levels, Made, PickLines, RangeAxis, RangeLine, Tiler, WaterfallTile,
};
use bathyscope_log::survey::Survey;
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, ScreenDescriptor};
use egui::{Painter, Rect};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

/// Number of tiles copied to the GPU in a frame: half a megabyte each, so that the frame stays
/// short.
const UPLOADS: usize = 4;

/// The picture of one survey.
pub(super) struct WaterfallDrawing {
    pub survey_serial: u64,
    /// True if port and starboard are exchanged in the picture.
    pub swapped_sides: bool,
    survey: Arc<Survey>,
    tiler: Tiler,
    tiles: ResidentTiles,
    arrived: VecDeque<WaterfallTile>,
    /// Extent of the picture; outer `None` while it is not known, inner `None` if there is nothing
    /// to draw.
    axis: Option<Option<RangeAxis>>,
    requested_returns: Option<Arc<FirstReturns>>,
    wants_tiles: bool,
    /// True if the worker ended before the picture was complete.
    pub has_failed: bool,
    pub picks: Option<Arc<PickLines>>,
    pub depth: Option<RangeLine>,
    /// Levels of black and white that suit the survey.
    pub levels: Levels,
}

impl WaterfallDrawing {
    /// Starts the worker, which requests a repaint when data arrive. If jobs run inside their call,
    /// this waits for the extent of the picture.
    pub(super) fn start(survey: Arc<Survey>, app: &App, ctx: &egui::Context) -> Self {
        let ctx = ctx.clone();
        let waker = move || ctx.request_repaint_after(std::time::Duration::from_millis(1));
        let tiler = Tiler::start(survey.clone(), waker);
        let axis = match app.jobs.workers() {
            Jobs::Threads(_) => None,
            Jobs::Inline => tiler.wait_for_axis(),
        };
        Self {
            survey_serial: app.view.survey_serial,
            swapped_sides: survey.swapped_sides,
            tiler,
            survey,
            tiles: ResidentTiles::new(),
            arrived: VecDeque::new(),
            axis,
            requested_returns: None,
            wants_tiles: true,
            has_failed: false,
            picks: None,
            depth: None,
            levels: Levels::RECORDED,
        }
    }

    /// Returns the extent of the picture; `None` if it is not known or there is nothing to draw.
    pub(super) fn axis(&self) -> Option<RangeAxis> {
        self.axis.flatten()
    }

    /// Continues with a newer state of the survey, if `survey` is one.
    pub(super) fn follow(&mut self, survey: &Arc<Survey>) {
        if !Arc::ptr_eq(&self.survey, survey) {
            self.survey = survey.clone();
            self.tiler.grow(survey.clone());
        }
    }

    /// Collects the data that have arrived, and requests new lines if the first returns have
    /// changed.
    pub(super) fn poll(&mut self, returns: Option<&Arc<FirstReturns>>) {
        // Checked before the messages are read, so that the last message of an ended worker is read
        // too.
        let has_ended = self.tiler.has_ended();
        while let Some(made) = self.tiler.poll() {
            match made {
                Made::Axis(axis) => self.axis = Some(axis),
                Made::Levels(levels) => self.levels = levels,
                Made::WaterfallTile(tile) => self.arrived.push_back(tile),
                Made::Grown { mut axis, unchanged } => {
                    // If the usual step changed with every ping, the picture would be stretched a
                    // little each time.
                    axis.ping_m = self.axis().and_then(|axis| axis.ping_m).or(axis.ping_m);
                    self.axis = Some(Some(axis));
                    let stays = |tile: &WaterfallTile| {
                        unchanged.is_some_and(|to| tile.key.end_ping() <= to)
                    };
                    self.arrived.retain(stays);
                    self.tiles.outdate(unchanged);
                }
                Made::Picks(picks) => self.picks = Some(picks),
                Made::Depth(depth) => self.depth = Some(depth),
            }
        }
        // Without a usable range there is nothing to make, and the worker ends without a fault.
        self.has_failed = has_ended && self.axis != Some(None);
        let Some(returns) = returns else {
            return;
        };
        let is_new = |old: &Arc<FirstReturns>| !Arc::ptr_eq(old, returns);
        if self.requested_returns.as_ref().is_none_or(is_new) {
            self.requested_returns = Some(returns.clone());
            self.tiler.want_picks(returns.clone());
        }
    }

    /// Copies a few of the tiles that have arrived to the GPU.
    pub(super) fn upload(&mut self, mut upload: impl FnMut([u32; 2], &[[u8; 2]]) -> TileTexture) {
        for tile in self.arrived.drain(..self.arrived.len().min(UPLOADS)) {
            if !tile.texels.is_empty() {
                let size = [tile.width as u32, tile.height as u32];
                let texture = upload(size, &tile.texels);
                self.tiles.insert(&tile, texture);
            }
        }
    }

    /// Returns true if tiles wait for the next frame.
    pub(super) fn has_uploads(&self) -> bool {
        !self.arrived.is_empty()
    }

    /// Returns the tiles to draw, and requests the missing ones from the worker. `upload` puts on
    /// the GPU the values that bring the rows of a tile to one level.
    pub(super) fn plan(
        &mut self,
        lens: &Lens,
        picture: Option<&Arc<LogPicture>>,
        pixels_per_point: f32,
        upload: impl FnMut(&[TileRow; TILE_ROWS]) -> TileRows,
    ) -> Vec<(Quad, DrawnTile)> {
        let Some(axis) = self.axis() else {
            return Vec::new();
        };
        self.tiles.level_by(picture);
        let plan = self.tiles.plan(&axis, lens, pixels_per_point, upload);
        let mut want = plan.want;
        want.retain(|want| self.arrived.iter().all(|tile| tile.key != want.key));
        self.wants_tiles = !want.is_empty() || self.has_uploads();
        self.tiler.want(want);
        plan.draw
    }

    /// Returns true if nothing more is expected from the worker.
    pub(super) fn is_settled(&self) -> bool {
        let picks_made = match (&self.requested_returns, &self.picks) {
            (None, _) => true,
            (Some(requested), Some(made)) => Arc::ptr_eq(requested, &made.returns),
            (Some(_), None) => false,
        };
        match self.axis {
            // A failed worker sends nothing more.
            _ if self.has_failed => true,
            None => false,
            Some(None) => true,
            Some(Some(_)) => !self.wants_tiles && picks_made && self.depth.is_some(),
        }
    }
}

/// The picture of one frame. It has its own renderer, because two waterfalls must not share a
/// buffer.
pub(super) struct PictureCallback {
    pub picture: Arc<WaterfallPicture>,
    pub look: EchoStyle,
    pub gain: GainBuffer,
    pub tiles: Vec<(Quad, DrawnTile)>,
}

impl PictureCallback {
    /// Adds the picture to the painter; `has_uploads` is true if tiles wait for the next frame.
    pub(super) fn add_to(self, painter: &Painter, rect: Rect, has_uploads: bool) {
        if has_uploads {
            // Not "at once": a test harness that waits for a quiet frame may stop here and continue
            // later.
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
