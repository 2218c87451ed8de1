//! Shows a channel that looks down, beside the side-scan or in its place: the same pings, with the
//! recorded and the found bottom.

use super::bottom::{self, WaterfallPen};
use super::camera::{Camera, PictureExtent, Size};
use super::drawing::{self, WaterfallDrawing};
use super::labels::{INK, WaterfallLabels};
use super::lens::{Arrangement, Lens};
use super::scales::{self, RangeLines};
use super::{Gpu, extent, move_camera, side_scan};
use crate::app::{App, Command, EchogramChannel, LogPlace, Orientation};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::waterfall::{LineStep, RangeAxis};
use bathyscope_log::survey::{Side, Survey};
use egui::{Align2, Painter, Rect, Response, Sense, Stroke, Ui};
use std::sync::Arc;

/// Share of the view that the channel covers beside the side-scan.
const SHARE: f32 = 0.36;

/// State of the picture of a channel that looks down.
#[derive(Default)]
pub(super) struct EchogramPart {
    shown: Option<Shown>,
    gpu: Option<Gpu>,
}

struct Shown {
    channel: EchogramChannel,
    survey_serial: u64,
    /// The log as opened.
    of: Arc<Survey>,
    /// The log with the samples of this channel; `None` if the log has no such channel.
    survey: Option<Arc<Survey>>,
    drawing: Option<WaterfallDrawing>,
    camera: Option<Camera>,
}

impl EchogramPart {
    /// Returns the parts of the view for the side-scan and for the channel; one of them may be
    /// empty.
    pub(super) fn divide(
        &mut self,
        whole: Rect,
        ctx: &egui::Context,
        context: &ViewContext<'_>,
    ) -> [Rect; 2] {
        let options = &context.options().waterfall;
        self.follow(ctx, context.app);
        if self.shown.as_ref().is_none_or(|shown| shown.survey.is_none()) {
            return [whole, Rect::NOTHING];
        }
        if options.echogram_alone || !place::has_side_scan(context.app) {
            return [Rect::NOTHING, whole];
        }
        let (side_scan, channel) = match options.orientation {
            Orientation::Horizontal => whole.split_top_bottom_at_fraction(1.0 - SHARE),
            Orientation::Vertical => whole.split_left_right_at_fraction(1.0 - SHARE),
        };
        [side_scan, channel]
    }

    /// Starts again for another log or channel.
    fn follow(&mut self, ctx: &egui::Context, app: &App) {
        let survey = app.logs.shown.survey.as_ref();
        let chosen = survey.map(|survey| channel_of(app, survey));
        let (Some(channel), Some(survey)) = (chosen, &app.logs.shown.survey) else {
            self.shown = None;
            return;
        };
        let Some(kind) = channel.kind() else {
            self.shown = None;
            return;
        };
        let is_it = |shown: &Shown| {
            shown.channel == channel && shown.survey_serial == app.view.survey_serial
        };
        if let Some(shown) = self.shown.as_mut().filter(|shown| is_it(shown)) {
            if !Arc::ptr_eq(&shown.of, survey) {
                shown.of = survey.clone();
                shown.survey = survey.looking_down(kind).map(Arc::new);
                if let (Some(drawing), Some(seen)) = (&mut shown.drawing, &shown.survey) {
                    drawing.follow(seen);
                }
            }
            return;
        }
        let seen = survey.looking_down(kind).map(Arc::new);
        self.shown = Some(Shown {
            channel,
            survey_serial: app.view.survey_serial,
            of: survey.clone(),
            drawing: (seen.clone()).map(|survey| WaterfallDrawing::start(survey, app, ctx)),
            survey: seen,
            camera: None,
        });
    }

    /// Draws the channel for the pings that `along` shows, and moves `along` by wheel, drag and
    /// keys; `side_scan` is the drawing of the log's first returns. Returns true if everything is
    /// drawn.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        along: &mut Camera,
        side_scan: Option<&WaterfallDrawing>,
        context: &mut ViewContext<'_>,
    ) -> bool {
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let Self { shown, gpu } = self;
        let Some(Shown { survey: Some(survey), drawing: Some(drawing), camera, channel, .. }) =
            shown
        else {
            return true;
        };
        drawing.poll(None);
        let Some(axis) = drawing.axis() else {
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Image, true, "Echogram, being read")
            });
            return drawing.is_settled();
        };
        let lens = aim(ui, &response, rect, &axis, camera, along, context.app);
        let painter = ui.painter_at(rect);
        let settled = match context.render_state {
            Some(state) => {
                let gpu = gpu.get_or_insert_with(|| Gpu::new(state));
                let look = drawing::plain_look(context.app, &lens, drawing.levels);
                gpu.draw(state, drawing, None, look, (&painter, &lens), context.options())
            }
            None => true,
        };
        let over =
            EchogramOverlay { survey, drawing, side_scan, far_m: axis.far_m, name: channel.name() };
        over.draw(&painter, &lens, context.app);
        let read_out = point(&response, &lens, survey, context);
        if let Some((at, text)) = response.hover_pos().zip(read_out.as_ref()) {
            super::pointer::read_out(&painter, &lens, at, text, &[]);
        }
        describe(&response, channel.name(), &lens, survey, read_out);
        settled
    }
}

/// Returns the chosen channel; in a log without side-scan, an existing one if none is chosen.
fn channel_of(app: &App, survey: &Survey) -> EchogramChannel {
    let chosen = app.view.options.waterfall.echogram;
    if chosen != EchogramChannel::None || !survey.side_scan.is_empty() {
        return chosen;
    }
    let has = |channel: &EchogramChannel| {
        let kind = channel.kind();
        kind.is_some_and(|kind| survey.has_echogram(kind))
    };
    let there = EchogramChannel::ALL.into_iter().find(has);
    there.unwrap_or(EchogramChannel::None)
}

/// Moves the camera by wheel, drag and keys; along the track it has the same view as `along`, which
/// moves with it.
fn aim(
    ui: &Ui,
    response: &Response,
    rect: Rect,
    axis: &RangeAxis,
    camera: &mut Option<Camera>,
    along: &mut Camera,
    app: &App,
) -> Lens {
    let arrangement = Arrangement {
        orientation: app.view.options.waterfall.orientation,
        flip: app.logs.shown.settings.picture.flip,
        ..Arrangement::default()
    };
    let extent = PictureExtent { near_m: 0.0, ..extent(axis) };
    let size = Size::of(rect.size(), arrangement.orientation);
    let camera = camera.get_or_insert_with(|| Camera::start(&extent, size));
    camera.share_along(along, &extent, size);
    move_camera(camera, ui, response, &arrangement, &extent, true, true);
    camera.settle_across(&extent, size);
    along.take_along(camera);
    Lens::arranged(*camera, rect, &arrangement)
}

/// Describes the picture for screen readers and tests; the value of the view is the read-out under
/// the pointer.
fn describe(
    response: &Response,
    channel: &str,
    lens: &Lens,
    survey: &Survey,
    read_out: Option<String>,
) {
    let visible = lens.visible(survey.side_scan.len());
    let name = format!(
        "Echogram, {channel}, pings {} to {} of {}",
        visible.start,
        visible.end.saturating_sub(1),
        survey.side_scan.len()
    );
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: read_out.clone(),
        ..egui::WidgetInfo::labeled(egui::Role::Image, true, &name)
    });
}

/// The lines and texts over the echoes.
struct EchogramOverlay<'a> {
    survey: &'a Survey,
    drawing: &'a WaterfallDrawing,
    side_scan: Option<&'a WaterfallDrawing>,
    far_m: f64,
    name: &'static str,
}

impl EchogramOverlay<'_> {
    fn draw(&self, painter: &Painter, lens: &Lens, app: &App) {
        let options = &app.view.options;
        let ink = theme::picture_ink(options);
        let as_recorded = Reduction::default();
        let range_lines = options.waterfall.range_lines.then(|| {
            RangeLines::in_view(lens, self.survey, as_recorded, self.far_m, options.units)
        });
        if let Some(lines) = &range_lines {
            lines.draw(painter, ink);
        }
        self.bottom(painter, lens, app);
        let marked =
            [(app.view.selection, theme::SELECTION_COLOUR), (app.view.hover, theme::HOVER_COLOUR)];
        for (mark, colour) in marked {
            if let Some(mark) = mark {
                let line = lens.line_at_ping(mark.ping as f64 + 0.5);
                painter.line_segment(line, Stroke::new(1.0, colour));
            }
        }
        let edge = match lens.orientation {
            Orientation::Horizontal => [lens.rect.left_top(), lens.rect.right_top()],
            Orientation::Vertical => [lens.rect.left_top(), lens.rect.left_bottom()],
        };
        painter.line_segment(edge, Stroke::new(1.0, ink));
        let mut labels = WaterfallLabels::new(painter);
        let log = app.logs.shown.survey.as_ref();
        if let Some(text) = log.and_then(|log| side_scan::warning(log, options.units)) {
            labels.keep_clear(side_scan::banner(painter, lens.rect, &text));
        }
        let corner = lens.rect.shrink(6.0).right_bottom();
        labels.write(corner, Align2::RIGHT_BOTTOM, self.name, INK);
        if let Some(lines) = &range_lines {
            lines.label(&mut labels, lens);
        }
        scales::ticks(painter, &mut labels, lens, self.survey, ink);
    }

    /// Draws the recorded bottom, and the bottom that the side-scan found on both sides.
    fn bottom(&self, painter: &Painter, lens: &Lens, app: &App) {
        let pen = |colour| WaterfallPen::new(colour, 1.0);
        let depth = pen(theme::DEPTH_LINE_COLOUR);
        let as_recorded = Reduction::default();
        bottom::depth(painter, lens, self.survey, self.drawing, as_recorded, depth);
        let returns =
            app.logs.shown.bottom_line().filter(|_| app.view.options.waterfall.first_return);
        let (Some(returns), Some(side_scan), Some(log)) =
            (returns, self.side_scan, &app.logs.shown.survey)
        else {
            return;
        };
        for side in Side::BOTH {
            let step = LineStep::Picks { returns, lines: side_scan.picks.as_deref(), side };
            let found = pen(theme::side_colour(&app.view.options, side));
            // A channel that looks down is shown in the place of starboard.
            bottom::first_return(painter, lens, log, step, Side::Starboard, found);
        }
    }
}

/// Handles hover and selection; returns the text beside the pointer.
fn point(
    response: &Response,
    lens: &Lens,
    survey: &Survey,
    context: &mut ViewContext<'_>,
) -> Option<String> {
    let place = lens.place_at(response.hover_pos()?);
    let ping = (place.ping >= 0.0).then_some(place.ping as usize)?;
    let recorded = survey.side_scan.get(ping)?;
    if ping < place::ping_count(context.app) {
        let mark = LogPlace::ping(ping);
        if context.app.view.hover != Some(mark) {
            context.push(Command::Hover(Some(mark)));
        }
        if response.clicked() {
            context.push(Command::Select(Some(mark)));
        }
    }
    let units = context.units();
    let clock = text::clock(survey.start_unix_s, recorded.time_s);
    let depth = units.measure(place.across_m.abs(), 2);
    let mut words = format!("ping {ping}  {clock}\n{depth} below the transducer");
    if let (Some(span), Some(samples)) =
        (survey.span(ping, Side::Starboard), survey.samples(ping, Side::Starboard))
    {
        let sample = span.sample_at(place.across_m.abs());
        if sample >= 0.0 && (sample as usize) < samples.len() {
            let echo = samples.get(sample as usize);
            words += &format!("\nsample {}, echo {echo}", sample as usize);
        }
    }
    if recorded.depth_m.is_finite() {
        let depth = units.measure(f64::from(recorded.depth_m), 2);
        words += &format!("\nrecorded depth {depth}");
    }
    Some(words)
}
