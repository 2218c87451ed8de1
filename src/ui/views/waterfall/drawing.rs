//! Data of the picture of one survey: the worker that makes it, the tiles that have arrived, those
//! that still have to go to the GPU, and the tiles in view, which are handed to the renderer inside
//! egui's pass.

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

/// Tiles copied to the GPU in a frame: half a megabyte each, so that a frame stays a frame.
const UPLOADS: usize = 4;

/// The picture of one survey.
pub(super) struct WaterfallDrawing {
    pub survey_serial: u64,
    /// True if port and starboard are exchanged in it.
    pub swapped_sides: bool,
    survey: Arc<Survey>,
    tiler: Tiler,
    tiles: ResidentTiles,
    arrived: VecDeque<WaterfallTile>,
    /// Outer `None`: not known yet. Inner `None`: there is nothing to draw.
    axis: Option<Option<RangeAxis>>,
    requested_returns: Option<Arc<FirstReturns>>,
    wants_tiles: bool,
    /// The worker ended before the picture was made.
    pub has_failed: bool,
    pub picks: Option<Arc<PickLines>>,
    pub depth: Option<RangeLine>,
    /// Levels that suit the survey.
    pub levels: Levels,
}

impl WaterfallDrawing {
    /// Starts the worker, which wakes the window when something arrives. Where jobs run inside
    /// their call, the picture's extent is waited for.
    pub(super) fn start(survey: Arc<Survey>, app: &App, ctx: &egui::Context) -> Self {
        let ctx = ctx.clone();
        let waker = move || ctx.request_repaint_after(std::time::Duration::from_millis(1));
        let tiler = Tiler::start(survey.clone(), waker);
        let axis = match app.jobs() {
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

    /// The picture's extent, once it is known.
    pub(super) fn axis(&self) -> Option<RangeAxis> {
        self.axis.flatten()
    }

    /// Goes on with a later state of the survey, if it is one.
    pub(super) fn follow(&mut self, survey: &Arc<Survey>) {
        if !Arc::ptr_eq(&self.survey, survey) {
            self.survey = survey.clone();
            self.tiler.grow(survey.clone());
        }
    }

    /// Collects what arrived; asks for lines when the first returns are others than before.
    pub(super) fn poll(&mut self, returns: Option<&Arc<FirstReturns>>) {
        // Asked before what it has sent is taken: what it sent last is here then.
        let has_ended = self.tiler.has_ended();
        while let Some(made) = self.tiler.poll() {
            match made {
                Made::Axis(axis) => self.axis = Some(axis),
                Made::Levels(levels) => self.levels = levels,
                Made::WaterfallTile(tile) => self.arrived.push_back(tile),
                Made::Grown { mut axis, unchanged } => {
                    // A usual step that changes with every ping would stretch the picture a little
                    // each time.
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
        // Without a usable range there is nothing to make, and the worker ends by itself.
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

    /// Copies a few of the tiles that arrived to the GPU.
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

    /// The tiles to draw with this; asks the worker for those that are missing. `upload` puts what
    /// the rows of a tile are brought to one level by on the GPU.
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
            // Nothing more will come.
            _ if self.has_failed => true,
            None => false,
            Some(None) => true,
            Some(Some(_)) => !self.wants_tiles && picks_made && self.depth.is_some(),
        }
    }
}

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
