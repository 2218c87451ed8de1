//! Manages the picture of one survey: the worker that makes its tiles, the tiles that have arrived
//! and wait for the GPU, the visible tiles, which the renderer draws inside egui's pass, and the
//! parameters of the renderer, which follow from the picture settings of the shown log.

use super::lens::Lens;
use super::tiles::ResidentTiles;
use crate::app::{App, Jobs, Orientation};
use crate::ui::render::waterfall::{
    DrawnTile, EchoStyle, GainBuffer, Quad, TILE_ROWS, TileRow, TileRows, TileTexture,
    WaterfallPicture,
};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_bottom::picture::{LogPicture, PictureGeometry};
use bathyscope_bottom::waterfall::{
    Levels, Made, PickLines, RangeAxis, RangeLine, Tiler, WaterfallTile,
};
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::Same;
use bytemuck::Zeroable as _;
use eframe::egui_wgpu::{
    Callback, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor,
};
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

/// Share of the maximum in the picture: large enough for a bright spot of one sample to stay
/// visible in an overview, small enough to preserve the texture of the ground.
const HIGHLIGHT: f32 = 0.3;
/// Least difference of white and black, as a share of the colours.
const LEAST_CONTRAST: f32 = 1e-3;
/// Bits of [`EchoStyle::filters`].
const GAIN: u32 = 1;
const STRIPES: u32 = 2;
const MEDIAN: u32 = 4;

/// The gain of a log on the GPU.
pub(super) struct UploadedGain {
    of: Option<Same<LogPicture>>,
    pub gain: GainBuffer,
}

impl UploadedGain {
    /// Returns true if the gain was uploaded for this picture.
    pub(super) fn is_of(&self, picture: Option<&Arc<LogPicture>>) -> bool {
        self.of == picture.cloned().map(Same)
    }
}

/// Puts on the GPU the gain that a log is shown with.
pub(super) fn upload(
    renderer: &WaterfallPicture,
    state: &RenderState,
    picture: Option<&Arc<LogPicture>>,
) -> UploadedGain {
    let gain = picture.and_then(|picture| picture.gain.as_ref());
    let [port, starboard] =
        Side::BOTH.map(|side| gain.map_or((&[][..], &[][..]), |gain| gain.curves(side)));
    let curves = [port.0, port.1, starboard.0, starboard.1];
    UploadedGain {
        of: picture.cloned().map(Same),
        gain: renderer.upload_gain(&state.device, &state.queue, curves),
    }
}

/// Returns the parameters of the renderer. `first` are the levels that suit the echoes as recorded;
/// they are used until the levels with gain have been counted.
pub(super) fn look(
    app: &App,
    lens: &Lens,
    picture: Option<&LogPicture>,
    first: Levels,
) -> EchoStyle {
    let settings = &app.logs.shown.settings.picture;
    let tone = settings.tone();
    let automatic = app.histogram().map_or(first, |counted| counted.automatic);
    let level = |fixed: Option<f64>, automatic: f32| {
        fixed.map_or(automatic, |level| (level / 255.0) as f32)
    };
    let black = level(settings.black, automatic.black);
    let white = level(settings.white, automatic.white);
    let gain = picture.and_then(|picture| picture.gain.as_deref());
    let filter = |is_on: bool, bit: u32| if is_on { bit } else { 0 };
    // Gain depends on the scales of the pings, which are not known without a picture.
    let known = picture.is_some();
    let [port, starboard] = tone.sides;
    EchoStyle {
        geometry: match lens.geometry() {
            PictureGeometry::Slant => 0,
            PictureGeometry::SlantBeyondWater => 1,
            PictureGeometry::Ground => 2,
        },
        filters: filter(tone.is_normalised && gain.is_some(), GAIN)
            + filter(tone.is_even && known, STRIPES)
            + filter(settings.despeckle, MEDIAN),
        spreading: if known { tone.spreading_db } else { 0.0 },
        absorption: if known { tone.absorption_db_m } else { 0.0 },
        middle_m: picture.map_or(1.0, |picture| picture.middle_m),
        port,
        starboard,
        curve_far_m: gain.map_or(1.0, |gain| gain.far_m as f32),
        curve_factor: gain.map_or(1.0, |gain| gain.stretch),
        ..plain_look(app, lens, Levels { black, white })
    }
}

/// Returns the parameters for echoes as recorded, with levels that suit them.
pub(super) fn plain_look(app: &App, lens: &Lens, levels: Levels) -> EchoStyle {
    EchoStyle {
        gamma: app.logs.shown.settings.picture.gamma.max(0.01) as f32,
        highlight: HIGHLIGHT,
        black: levels.black,
        white: levels.white.max(levels.black + LEAST_CONTRAST),
        time_is_down: u32::from(lens.orientation == Orientation::Vertical),
        middle_m: 1.0,
        port: 1.0,
        starboard: 1.0,
        curve_far_m: 1.0,
        curve_factor: 1.0,
        ..EchoStyle::zeroed()
    }
}

#[cfg(test)]
mod tests {
    use bathyscope_bottom::mosaic::GainTable;
    use bathyscope_bottom::picture::LEAST_RANGE_M;

    #[test]
    fn the_shader_knows_the_curves_as_they_are() {
        let source = include_str!("../../../../shaders/waterfall.wgsl");
        let constant = |name: &str| -> f32 {
            let line = source.lines().find(|line| line.contains(&format!("const {name}:")));
            let value = line.and_then(|line| line.split(['=', ';']).nth(1));
            value.and_then(|value| value.trim().parse().ok()).expect(name)
        };
        assert_eq!(constant("RANGE_BINS"), GainTable::RANGES as f32);
        assert_eq!(constant("ANGLE_BINS"), GainTable::ANGLES as f32);
        assert_eq!(constant("LEAST_FACTOR"), GainTable::BOUNDS[0]);
        assert_eq!(constant("MOST_FACTOR"), GainTable::BOUNDS[1]);
        assert_eq!(constant("LEAST_RANGE_M"), LEAST_RANGE_M);
    }
}
