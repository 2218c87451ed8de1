//! Draws the waterfall view: the picture of all pings, port and starboard of the nadir, with the
//! first return over it. Wheel, drag, keys and a log that is being followed move its camera.
//!
//! Input: the state. Output: the picture with lines, boxes and marks, and commands.

mod bottom;
mod boxes;
mod camera;
mod drawing;
mod echogram;
mod labels;
mod lens;
mod measure;
mod pointer;
mod scales;
mod side_scan;
mod stretches;
mod tiles;

pub(crate) use boxes::outline;

use crate::app::{App, Command, Enlarged, LogPlace, Orientation, Tool, ViewOptions};
use crate::ui::render::waterfall::{EchoStyle, WaterfallPicture};
use crate::ui::{ViewContext, ViewRequest, flat, theme};
use bathyscope_bottom::picture::{LogPicture, PictureGeometry};
use bathyscope_bottom::presentation::colours::ColourMap;
use bathyscope_bottom::waterfall::RangeAxis;
use camera::{Camera, PictureExtent, Size};
use drawing::{PictureCallback, UploadedGain, WaterfallDrawing};
use eframe::egui_wgpu::RenderState;
use egui::{Key, PointerButton, Sense, emath::GuiRounding as _};
use lens::{Arrangement, Lens, LensPlace};
use std::ops::Range;
use std::sync::Arc;

/// State of the waterfall view: its camera, and the drawing of the open survey.
#[derive(Default)]
pub struct WaterfallView {
    drawing: Option<WaterfallDrawing>,
    gpu: Option<Gpu>,
    camera: Option<Camera>,
    /// Ends along and across of the view that the first frame is to show; `None` for the usual
    /// first view.
    aim: Option<[f64; 4]>,
    /// Size of the view in the last frame.
    size: Option<Size>,
    requests: Vec<Request>,
    reveal_serial: u64,
    was_over: Option<LogPlace>,
    boxes: boxes::BoxGrab,
    pen: bottom::BottomPen,
    stretch: stretches::StretchTool,
    measure: measure::MeasureTool,
    /// Cross that the arrow keys move to mark a target.
    cross: measure::Cross,
    echogram: echogram::EchogramPart,
    settled: bool,
    end: NewestPing,
}

/// Requests that wait for the next frame, in which the size of the view is known.
enum Request {
    View(ViewRequest),
    Pings(Range<usize>),
}

/// GPU resources of one picture.
struct Gpu {
    picture: Arc<WaterfallPicture>,
    palette: Option<ColourMap>,
    gain: Option<UploadedGain>,
}

impl WaterfallView {
    /// Draws the view into all of `ui` and pushes the commands of the user.
    pub fn ui(&mut self, ui: &mut egui::Ui, context: &mut ViewContext<'_>) {
        let whole = ui.available_rect_before_wrap().round_to_pixels(ui.pixels_per_point());
        let canvas = theme::canvas_colour(context.options());
        flat::fill(ui.painter(), whole, canvas, context.render_state);
        self.follow_survey(ui.ctx(), context);
        if whole.width() < 1.0 || whole.height() < 1.0 {
            ui.allocate_rect(whole, Sense::hover());
            self.settled = true;
            return;
        }
        let [rect, below] = self.echogram.divide(whole, ui.ctx(), context);
        if rect.is_positive() {
            self.side_scan(ui, rect, context);
        } else {
            self.settled = true;
        }
        if below.is_positive() {
            self.begin(below);
            let mut along = self.camera.unwrap_or_default();
            let drawing = self.drawing.as_ref();
            let settled = self.echogram.ui(ui, below, &mut along, drawing, context);
            self.settled &= settled;
            let survey = context.app.logs.shown.survey.as_ref();
            // A side-scan that is still being read must start at its own beginning; without a
            // side-scan, only the channel moves the camera.
            if self.camera.is_some() || survey.is_some_and(|survey| !survey.has_side_scan()) {
                self.camera = Some(along);
            }
        }
    }

    /// Creates the camera at the beginning of the side-scan, although the side-scan is not shown
    /// yet.
    fn begin(&mut self, rect: egui::Rect) {
        let axis = self.drawing.as_ref().and_then(WaterfallDrawing::axis);
        if let (None, Some(axis)) = (self.camera, axis) {
            let size = Size::of(rect.size(), Orientation::Horizontal);
            self.camera = Some(Camera::start(&extent(&axis), size));
        }
    }

    /// Sets a corner of the figure at the pointer or at the cross.
    pub(crate) fn set_corner(&mut self) {
        self.measure.set_corner();
    }

    /// Carries out a request from menu, key or palette.
    pub fn request(&mut self, request: ViewRequest) {
        self.requests.push(Request::View(request));
        self.settled = false;
    }

    /// Returns true if everything on screen is drawn at its final quality.
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// Shows exactly these pings (`snapshot --pings`).
    pub fn show_pings(&mut self, pings: Range<usize>) {
        self.requests.push(Request::Pings(pings));
        self.settled = false;
    }

    /// Returns a view of the same pings and ranges, for a picture of any size.
    pub(crate) fn for_picture(&self) -> Self {
        Self {
            aim: self.camera.zip(self.size).map(|(camera, size)| camera.seen(size)),
            ..Self::default()
        }
    }

    /// Starts again when another survey is open; when the sides are exchanged, the camera is kept.
    fn follow_survey(&mut self, ctx: &egui::Context, context: &mut ViewContext<'_>) {
        let app = context.app;
        let serial = app.logs.shown.survey.as_ref().map(|_| app.view.survey_serial);
        let is_other = self.drawing.as_ref().map(|drawing| drawing.survey_serial) != serial;
        let sides = app.logs.shown.survey.as_ref().map(|survey| survey.swapped_sides);
        let turned = self.drawing.as_ref().map(|drawing| drawing.swapped_sides) != sides;
        if is_other {
            self.camera = None;
        }
        if is_other || turned {
            self.settled = false;
            let survey = app.logs.shown.survey.as_ref();
            self.drawing = survey.map(|survey| WaterfallDrawing::start(survey.clone(), app, ctx));
        }
        if let (Some(drawing), Some(survey)) = (&mut self.drawing, &app.logs.shown.survey) {
            drawing.follow(survey);
        }
        if let Some(drawing) = &mut self.drawing {
            let had_failed = drawing.has_failed;
            drawing.poll(app.logs.shown.bottom_line());
            if drawing.has_failed && !had_failed {
                let text = "a part of the waterfall could not be drawn; open the log again";
                context.push(Command::Notify(text.to_owned()));
            }
        }
    }

    /// Returns the layout of the picture. While the bottom is drawn by hand, the water above it is
    /// shown.
    fn arrangement(&self, app: &App) -> Arrangement {
        let options = &app.view.options.waterfall;
        let picture = &app.logs.shown.settings.picture;
        Arrangement {
            orientation: options.orientation,
            geometry: match app.logs.shown.reviewing.tool {
                Tool::Bottom => PictureGeometry::Slant,
                _ => options.geometry(),
            },
            flip: picture.flip,
            starboard_first: picture.starboard_first,
            scales: app.picture().map(|picture| picture.scales.clone()),
        }
    }

    /// Moves the camera by requests, reveals, wheel, drag and keys since the last frame; returns
    /// its lens.
    fn aim(
        &mut self,
        ui: &egui::Ui,
        response: &egui::Response,
        extent: &PictureExtent,
        arrangement: &Arrangement,
        context: &ViewContext<'_>,
        drag_moves: bool,
    ) -> Lens {
        let rect = response.rect;
        let size = Size::of(rect.size(), arrangement.orientation);
        let mut camera = *self.camera.get_or_insert_with(|| Camera::start(extent, size));
        if let Some(before) = self.size {
            camera.keep_start(before, size);
        }
        if let Some(seen) = self.aim.take() {
            camera.show(seen, size);
        }
        for request in self.requests.drain(..) {
            match request {
                Request::Pings(pings) => camera.show_pings(&pings, size),
                Request::View(request) => carry_out(&mut camera, request, extent, size),
            }
        }
        if let Some(reveal) = context.app.view.reveal
            && reveal.serial != self.reveal_serial
        {
            self.reveal_serial = reveal.serial;
            match reveal.close_up {
                Some(close_up) => {
                    let pings = close_up.pings.map(|ping| ping as f64);
                    let lens = Lens::arranged(camera, rect, arrangement);
                    let shown_m = shown_m(&lens, &pings, close_up.across_m);
                    let survey = context.app.logs.shown.survey.as_deref();
                    let metres = survey.and_then(|survey| {
                        pointer::metres_per_ping(context.app, survey, reveal.mark.ping)
                    });
                    match close_up.enlarged {
                        Enlarged::Third => camera.close_up(pings, shown_m, metres, size),
                        Enlarged::AsItIs => camera.bring_in(pings, shown_m, size),
                        Enlarged::OneToOne => {
                            camera.sample_to_point((pings, shown_m), metres, extent, size);
                        }
                    }
                }
                None => camera.reveal(reveal.mark.ping as f64 + 0.5, size),
            }
        }
        self.end.keep(&mut camera, extent, size, context.app);
        let fits = context.app.map.measuring.tool.is_none();
        move_camera(&mut camera, ui, response, arrangement, extent, drag_moves, fits);
        camera.settle(extent, size);
        self.end.note(&camera, extent, size);
        self.camera = Some(camera);
        self.size = Some(size);
        Lens::arranged(camera, rect, arrangement)
    }

    fn draw_picture(&mut self, painter: &egui::Painter, lens: &Lens, context: &ViewContext<'_>) {
        let (Some(drawing), Some(render_state)) = (&mut self.drawing, context.render_state) else {
            self.settled = true;
            return;
        };
        let gpu = self.gpu.get_or_insert_with(|| Gpu::new(render_state));
        let shown = context.app.picture();
        let look = drawing::look(context.app, lens, shown.map(Arc::as_ref), drawing.levels);
        let place = (painter, lens);
        self.settled = gpu.draw(render_state, drawing, shown, look, place, context.options());
    }
}

/// Returns the extent of both sides of all pings.
fn extent(axis: &RangeAxis) -> PictureExtent {
    PictureExtent {
        pings: axis.pings as f64,
        near_m: -axis.far_m,
        far_m: axis.far_m,
        bin_m: axis.bin_m,
        ping_m: axis.ping_m,
    }
}

impl Gpu {
    fn new(render_state: &RenderState) -> Self {
        let (device, target) = (&render_state.device, render_state.target_format);
        Self { picture: Arc::new(WaterfallPicture::new(device, target)), palette: None, gain: None }
    }

    /// Draws the echoes with the values of a picture and in a look; returns true if all of them are
    /// drawn.
    fn draw(
        &mut self,
        state: &RenderState,
        drawing: &mut WaterfallDrawing,
        shown: Option<&Arc<LogPicture>>,
        look: EchoStyle,
        (painter, lens): (&egui::Painter, &Lens),
        options: &ViewOptions,
    ) -> bool {
        let map = options.waterfall.colour_map;
        if self.palette.replace(map) != Some(map) {
            self.picture.set_palette(&state.queue, &map.palette());
        }
        let (renderer, RenderState { device, queue, .. }) = (&self.picture, state);
        drawing.upload(|size, texels| renderer.upload(device, queue, size, texels));
        let uploaded = match self.gain.take().filter(|uploaded| uploaded.is_of(shown)) {
            Some(uploaded) => uploaded,
            None => drawing::upload(renderer, state, shown),
        };
        let upload = |rows: &_| renderer.upload_rows(device, queue, rows);
        let tiles = drawing.plan(lens, shown, painter.pixels_per_point(), upload);
        let (picture, gain) = (renderer.clone(), uploaded.gain.clone());
        self.gain = Some(uploaded);
        let has_uploads = drawing.has_uploads();
        PictureCallback { picture, look, gain, tiles }.add_to(painter, lens.rect, has_uploads);
        drawing.is_settled()
    }
}

/// Returns the distances from the middle at which slant ranges are shown, metres, the smaller
/// first, for the ping in the middle of some pings.
fn shown_m(lens: &Lens, pings: &[f64; 2], across_m: [f64; 2]) -> [f64; 2] {
    let ping = 0.5 * (pings[0] + pings[1]);
    let [a, b] = across_m.map(|across_m| {
        let side = LensPlace { ping, across_m }.side();
        lens.signed_m(side, lens.distance_m(side, ping, across_m.abs()))
    });
    [a.min(b), a.max(b)]
}

/// Enlargement of one press of the zoom keys.
const KEY_STEP: f64 = 1.25;
/// Wheel points that enlarge by a factor of e.
const WHEEL_POINTS: f64 = 200.0;
/// Share of the view by which the newest ping may be beyond its edge and still counts as visible.
const NEAR: f64 = 0.02;

/// Carries out a request from menu, key or palette.
fn carry_out(camera: &mut Camera, request: ViewRequest, extent: &PictureExtent, size: Size) {
    let middle = Size::both(0.0);
    match request {
        ViewRequest::Fit => camera.fit(extent, size),
        ViewRequest::OneToOne => camera.toggle_one_to_one(extent, size),
        ViewRequest::ZoomIn => camera.zoom(Size::both(KEY_STEP), middle),
        ViewRequest::ZoomOut => camera.zoom(Size::both(1.0 / KEY_STEP), middle),
        ViewRequest::Top | ViewRequest::Side => {}
    }
}

/// Moves the camera by pointer and keys. The wheel zooms at the pointer; with Shift it moves along
/// the track, with Ctrl it zooms the track only, with Alt the range only. A drag with the main
/// button (only if `drag_moves`; otherwise that button has another use) or with the middle one, or
/// a move with Space held, pans. A double-click shows everything (only if `fits`; otherwise it ends
/// a measurement).
fn move_camera(
    camera: &mut Camera,
    ui: &egui::Ui,
    response: &egui::Response,
    arrangement: &Arrangement,
    extent: &PictureExtent,
    drag_moves: bool,
    fits: bool,
) {
    let size = Size::of(response.rect.size(), arrangement.orientation);
    if response.double_clicked() && fits {
        return camera.fit(extent, size);
    }
    let space = response.hovered() && ui.input(|input| input.key_down(Key::Space));
    let held = (drag_moves && response.dragged_by(PointerButton::Primary))
        || response.dragged_by(PointerButton::Middle)
        || space;
    if held {
        let by = ui.input(|input| input.pointer.delta());
        camera.pan(arrangement.size(by));
    }
    let Some(pointer) = response.hover_pos() else {
        return;
    };
    let (scroll, modifiers) = ui.input(|input| (input.smooth_scroll_delta(), input.modifiers));
    let zoom = f64::from(ui.input(|input| input.zoom_delta()));
    let offset = Lens::arranged(*camera, response.rect, arrangement).offset(pointer);
    let wheel = (f64::from(scroll.y) / WHEEL_POINTS).exp();
    let factor = match (modifiers.alt, modifiers.command) {
        (true, _) => Size::new(1.0, wheel),
        (_, true) => Size::new(zoom, 1.0),
        _ => Size::both(wheel * zoom),
    };
    camera.zoom(factor, offset);
    // egui turns the wheel sideways while Shift is held.
    let sideways = f64::from(scroll.x);
    let sideways = if arrangement.flip { -sideways } else { sideways };
    camera.pan(Size::new(sideways, 0.0));
}

/// Keeps the newest ping of a followed log in the view until the user moves the view elsewhere.
#[derive(Default)]
struct NewestPing {
    /// Number of pings in the last frame; `None` if the last of them was not visible.
    seen: Option<f64>,
    serial: u64,
}

impl NewestPing {
    /// Moves the view to the end of the log when pings were added and the newest ping was visible,
    /// and when a log begins to be followed.
    fn keep(&mut self, camera: &mut Camera, extent: &PictureExtent, size: Size, app: &App) {
        let begins =
            std::mem::replace(&mut self.serial, app.following.serial) != app.following.serial;
        if !app.is_following() {
            return;
        }
        if begins || self.seen.is_some_and(|pings| pings < extent.pings) {
            camera.show_end(extent.pings, size);
        }
    }

    /// Records whether the newest ping is visible now.
    fn note(&mut self, camera: &Camera, extent: &PictureExtent, size: Size) {
        let [from, to, ..] = camera.seen(size);
        let is_seen = to >= extent.pings - NEAR * (to - from);
        self.seen = is_seen.then_some(extent.pings);
    }
}
