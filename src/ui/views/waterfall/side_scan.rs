//! Draws a frame of the side-scan: the selected tools, the picture, and everything over it in the
//! right order; and describes it for screen readers and tests, also while there is no picture.

use super::drawing::WaterfallDrawing;
use super::labels::WaterfallLabels;
use super::lens::{Lens, LensPlace};
use super::scales::{self, RangeLines};
use super::{WaterfallView, bottom, boxes, extent, pointer, stretches};
use crate::app::{App, Command, LogPlace, Tool, View};
use crate::ui::views::{legend, tool};
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::first_return::BottomLine;
use bathyscope_bottom::picture::PictureGeometry;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_bottom::waterfall::LineStep;
use bathyscope_log::survey::{Side, SideScanState, Survey};
use egui::{Align2, Color32, Painter, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo, vec2};
use std::ops::Range;

/// Use of the pointer by the selected tools.
#[derive(Clone, Copy, Default)]
struct ToolsInUse {
    /// True while a box is being moved or drawn.
    hold_box: bool,
    /// True while a line, a stretch or a measurement is being drawn.
    draw: bool,
}

impl WaterfallView {
    /// Draws the side-scan with everything over it.
    pub(super) fn side_scan(&mut self, ui: &mut Ui, rect: Rect, context: &mut ViewContext<'_>) {
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        let survey = context.app.logs.shown.survey.clone();
        let axis = self.drawing.as_ref().and_then(WaterfallDrawing::axis);
        let Some((survey, axis)) = survey.zip(axis) else {
            self.settled = self.drawing.as_ref().is_none_or(WaterfallDrawing::is_settled);
            without_picture(ui, context, rect, &response, !self.settled);
            return;
        };
        let arrangement = self.arrangement(context.app);
        let before = (self.camera).map(|camera| Lens::arranged(camera, rect, &arrangement));
        let in_use = match &before {
            Some(lens) => self.follow_tools(ui, &response, lens, &survey, context),
            None => ToolsInUse::default(),
        };
        let extent = extent(&axis);
        let drag_moves = !in_use.hold_box && !in_use.draw;
        let lens = self.aim(ui, &response, &extent, &arrangement, context, drag_moves);
        self.draw_picture(&painter, &lens, context);
        let place = self.follow_pointer(&response, &lens, &survey, context);
        let banner = tool::in_view(ui, context.app, View::Waterfall, rect);
        let shown = ShownOverlay {
            app: context.app,
            survey: &survey,
            drawing: self.drawing.as_ref(),
            far_m: axis.far_m,
            // The place under this view's own pointer reaches the state only after this frame.
            hover: self.was_over.or(context.app.view.hover),
            boxes: &boxes::in_view(&lens, context.app),
            missed: &boxes::Missed::in_view(&lens, context.app),
            has_gpu: context.render_state.is_some(),
            banner: banner.as_ref().map(|banner| banner.plate),
            stretch: self.camera.and_then(|camera| camera.stretch(&extent)),
        };
        draw(&painter, &lens, &shown);
        self.draw_tools(&painter, &response, &lens, context.app);
        self.measure.strip(ui, context, rect);
        if let Some(banner) = &banner {
            banner.draw(ui);
        }
        let read_out = place.and_then(|place| pointer::describe(context.app, &survey, place));
        // While something is drawn, the read-out would hide what is ahead of the pointer.
        if let Some(text) = read_out.as_ref().filter(|_| !in_use.draw) {
            self.draw_read_out(&painter, &response, &lens, &shown, text);
        }
        let visible = lens.visible(survey.side_scan.len());
        let seen = boxes::words(shown.boxes, shown.missed, context.app);
        describe(&response, &visible, &survey, context, &seen, read_out.as_deref());
        if context.app.view.visible != visible {
            context.push(Command::Visible(visible));
        }
    }

    /// Lets each tool handle pointer and keys, in the view of the frame before; returns which tools
    /// use the pointer.
    fn follow_tools(
        &mut self,
        ui: &mut Ui,
        response: &Response,
        lens: &Lens,
        survey: &Survey,
        context: &mut ViewContext<'_>,
    ) -> ToolsInUse {
        let hold_box = self.boxes.follow(ui, response, lens, context);
        let draws_bottom = self.pen.follow(ui, response, lens, context);
        let draws_stretch = self.stretch.follow(ui, response, lens, context);
        let measures = self.measure.follow(ui, response, lens, survey, context);
        self.aim_at_target(ui, response, lens, survey, context);
        ToolsInUse { hold_box, draw: draws_bottom || draws_stretch || measures }
    }

    /// Moves the cross of the tool for targets by the arrow keys; the place of the cross becomes
    /// the hovered place, on which keys act.
    fn aim_at_target(
        &mut self,
        ui: &mut Ui,
        response: &Response,
        lens: &Lens,
        survey: &Survey,
        context: &mut ViewContext<'_>,
    ) {
        if context.app.logs.shown.reviewing.tool != Tool::Point {
            if std::mem::take(&mut self.cross).place().is_some() {
                context.push(Command::Hover(None));
            }
            return;
        }
        if self.cross.follow(ui, response, lens, context) {
            let mark = self.cross.place().map(|place| pointer::mark_at(survey, place));
            context.push(Command::Hover(mark.flatten()));
        }
    }

    /// Handles the pointer; returns the place under it.
    fn follow_pointer(
        &mut self,
        response: &Response,
        lens: &Lens,
        survey: &Survey,
        context: &mut ViewContext<'_>,
    ) -> Option<LensPlace> {
        let followed = pointer::follow(response, lens, survey, &mut self.was_over, context);
        if let Some(ping) = followed.equal_scales_at
            && let Some(metres) = pointer::metres_per_ping(context.app, survey, ping)
            && let Some(camera) = &mut self.camera
        {
            camera.equal_scales(metres, ping as f64 + 0.5);
        }
        followed.place
    }

    /// Draws what the tools are working on.
    fn draw_tools(&self, painter: &Painter, response: &Response, lens: &Lens, app: &App) {
        self.boxes.draw(painter, response.interact_pointer_pos());
        self.pen.draw(painter, lens, app);
        self.stretch.draw(painter, lens, app);
        self.measure.draw(painter, lens, app);
        self.cross.draw(painter, lens);
    }

    /// Writes what is under the pointer, without covering the box or the measurement that is being
    /// worked on.
    fn draw_read_out(
        &self,
        painter: &Painter,
        response: &Response,
        lens: &Lens,
        shown: &ShownOverlay<'_>,
        text: &str,
    ) {
        let Some(at) = response.hover_pos() else {
            return;
        };
        let edited = shown.boxes.iter().filter_map(|shown| shown.edited());
        let measured = self.measure.area(lens, shown.app);
        let covered = shown.banner.into_iter();
        let clear: Vec<Rect> = covered.chain(edited).chain(measured).collect();
        pointer::read_out(painter, lens, at, text, &clear);
    }
}

/// Fills a view that has no picture, or not yet: shows the reason.
fn without_picture(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    response: &Response,
    is_reading: bool,
) {
    let survey = context.app.logs.shown.survey.clone();
    let said = match survey {
        None => "open a survey to see its side-scan here".to_owned(),
        Some(_) if is_reading => {
            legend::say(ui, context, rect, "The side-scan is being read.");
            "reading the survey".to_owned()
        }
        Some(survey) => {
            let text = warning(&survey, context.units())
                .unwrap_or_else(|| "no side-scan: no ping has a usable range".to_owned());
            banner(&ui.painter_at(rect), rect, &text);
            text
        }
    };
    response.widget_info(|| {
        WidgetInfo::labeled(Role::Image, true, format!("Waterfall, empty: {said}"))
    });
}

/// Describes the picture for screen readers; the value of the view is the read-out under the
/// pointer.
fn describe(
    response: &Response,
    visible: &Range<usize>,
    survey: &Survey,
    context: &ViewContext<'_>,
    boxes: &str,
    read_out: Option<&str>,
) {
    response.widget_info(|| WidgetInfo {
        current_text_value: read_out.map(str::to_owned),
        ..WidgetInfo::labeled(Role::Image, true, name(visible, survey, context) + boxes)
    });
}

fn name(visible: &Range<usize>, survey: &Survey, context: &ViewContext<'_>) -> String {
    let options = &context.options().waterfall;
    let source = context.app.logs.shown.settings.first_return.bottom_line;
    let first_return = match (context.app.logs.shown.bottom_line(), options.first_return, source) {
        (_, false, _) => "first return hidden",
        (None, true, _) => "first return not yet found",
        (Some(_), true, BottomLine::Search) => "first return shown",
        (Some(_), true, BottomLine::Recorded) => "bottom line at the recorded depth shown",
    };
    let units = context.units();
    let warning = warning(survey, units).map_or_else(String::new, |text| format!(", {text}"));
    let excluded = place::and_stretches(context.app);
    let products = context.app.logs.shown.products.as_ref();
    let ranges = products
        .and_then(|products| products.calibration.range_change())
        .map_or_else(String::new, |change| format!(", {}", units.sentence(&change)));
    format!(
        "Waterfall, pings {} to {} of {}, {first_return}{ranges}{excluded}{warning}",
        visible.start,
        visible.end.saturating_sub(1),
        survey.side_scan.len()
    )
}

/// Width of the line of the first return, points.
const FIRST_RETURN_WIDTH: f32 = 1.5;

/// Inputs of everything over the picture.
struct ShownOverlay<'a> {
    pub app: &'a App,
    pub survey: &'a Survey,
    pub drawing: Option<&'a WaterfallDrawing>,
    /// Farthest slant range of the picture, metres.
    pub far_m: f64,
    pub hover: Option<LogPlace>,
    /// The visible boxes.
    pub boxes: &'a [boxes::ShownBox<'a>],
    /// The visible missed objects.
    pub missed: &'a [boxes::Missed<'a>],
    pub has_gpu: bool,
    /// Area of the banner of a tool; `None` without one.
    pub banner: Option<egui::Rect>,
    /// Length of a metre along the track divided by that of one across, as drawn; `None` if it is
    /// unknown.
    pub stretch: Option<f64>,
}

/// Draws everything over the picture.
fn draw(painter: &Painter, lens: &Lens, shown: &ShownOverlay<'_>) {
    let options = &shown.app.view.options;
    let ink = theme::picture_ink(options);
    let wants_range_lines = options.waterfall.range_lines;
    let reduction = place::reduction(shown.app);
    let units = options.units;
    let range_lines = wants_range_lines
        .then(|| RangeLines::in_view(lens, shown.survey, reduction, shown.far_m, units));
    if let Some(lines) = &range_lines {
        lines.draw(painter, ink);
    }
    let stretches = stretches::flat_in_view(lens, shown.app);
    for stretch in &stretches {
        stretch.draw(painter);
    }
    // Without the water column, the first return is at the middle of the picture.
    let shows_water = lens.geometry() == PictureGeometry::Slant;
    if let Some(drawing) = shown.drawing.filter(|_| shows_water) {
        draw_lines(painter, lens, shown, drawing);
    }
    let veiled = stretches::excluded_in_view(lens, shown.app);
    for stretch in &veiled {
        stretch.draw(painter);
    }
    let marked =
        [(shown.app.view.selection, theme::SELECTION_COLOUR), (shown.hover, theme::HOVER_COLOUR)];
    for (mark, colour) in marked {
        if let Some(mark) = mark {
            cross_hair(painter, lens, shown.survey, &mark, colour);
        }
    }
    for missed in shown.missed {
        missed.draw(painter);
    }
    for shown_box in shown.boxes {
        shown_box.draw(painter, lens, &shown.app.logs.shown.reviewing);
    }
    if shown.app.view.options.waterfall.boxes {
        boxes::draw_shape(painter, lens, shown.app);
    }
    let mut labels = WaterfallLabels::new(painter);
    let mut below = lens.rect;
    if let Some(banner) = shown.banner {
        labels.keep_clear(banner);
        below.min.y = banner.bottom();
    }
    if let Some(text) = shown_warning(shown) {
        labels.keep_clear(banner(painter, below, &text));
    }
    // The geometry of the across direction is written first, because labels written later make way
    // for it.
    scales::geometry(&mut labels, lens, shown.stretch);
    if let Some(lines) = &range_lines {
        lines.label(&mut labels, lens);
    }
    for missed in shown.missed {
        missed.label(&mut labels);
    }
    for shown_box in shown.boxes.iter().rev() {
        shown_box.label(&mut labels, &shown.app.logs.shown.reviewing.review);
    }
    scales::sides(&mut labels, lens, options);
    let products = shown.app.logs.shown.products.as_ref();
    if let Some(change) = products.and_then(|products| products.calibration.range_change()) {
        scales::range_change(&mut labels, lens, &units.sentence(&change));
    }
    scales::ticks(painter, &mut labels, lens, shown.survey, ink);
    for stretch in &veiled {
        stretch.label(&mut labels);
    }
    for stretch in &stretches {
        stretch.label(&mut labels);
    }
}

/// Returns the reason why there is no picture of the bottom, if there is one.
fn shown_warning(shown: &ShownOverlay<'_>) -> Option<String> {
    let no_gpu = || "no picture: there is no graphics adapter that can draw it".to_owned();
    warning(shown.survey, shown.app.view.options.units).or_else(|| (!shown.has_gpu).then(no_gpu))
}

fn draw_lines(
    painter: &Painter,
    lens: &Lens,
    shown: &ShownOverlay<'_>,
    drawing: &WaterfallDrawing,
) {
    let options = &shown.app.view.options;
    if options.waterfall.depth_line {
        let pen = bottom::WaterfallPen::new(theme::DEPTH_LINE_COLOUR, 1.0);
        let reduction = place::reduction(shown.app);
        let judged = shown.app.logs.shown.judged().map_or(shown.survey, |survey| &**survey);
        bottom::depth(painter, lens, judged, drawing, reduction, pen);
    }
    let returns = shown.app.logs.shown.bottom_line();
    let Some(returns) = returns.filter(|_| options.waterfall.first_return) else {
        return;
    };
    for side in Side::BOTH {
        let pen = bottom::WaterfallPen::new(theme::side_colour(options, side), FIRST_RETURN_WIDTH);
        let step = LineStep::Picks { returns, lines: drawing.picks.as_deref(), side };
        bottom::first_return(painter, lens, shown.survey, step, side, pen);
    }
    bottom::drawn(painter, lens, shown.app);
}

/// Draws a thin line at the ping and, where the mark has a sample, one at its range.
fn cross_hair(painter: &Painter, lens: &Lens, survey: &Survey, mark: &LogPlace, colour: Color32) {
    let ping = mark.ping as f64 + 0.5;
    painter.line_segment(lens.line_at_ping(ping), Stroke::new(1.0, colour));
    let Some((side, sample)) = mark.side.zip(mark.sample) else {
        return;
    };
    let recorded = survey.side_scan.get(mark.ping);
    if let Some(span) = recorded.and_then(|recorded| recorded.side(side)) {
        let place = LensPlace::of(ping, side, span.range_m(f64::from(sample)));
        let faint = colour.gamma_multiply(0.6);
        let along = lens.line_at_range(place.across_m);
        painter.line(along, Stroke::new(1.0, faint));
        let at = lens.screen_at(place);
        painter.circle_stroke(at, 5.0, Stroke::new(1.5, colour));
    }
}

/// Writes on the picture a sentence that changes the meaning of the picture; returns the covered
/// area.
pub(super) fn banner(painter: &Painter, rect: Rect, text: &str) -> Rect {
    let (font, colour) = (egui::FontId::proportional(14.0), theme::OUTLIER_COLOUR);
    let width = (rect.width() - 40.0).max(60.0);
    let galley = painter.layout(text.to_owned(), font, colour, width);
    let area = Align2::CENTER_TOP.anchor_size(rect.center_top() + vec2(0.0, 14.0), galley.size());
    let ground = area.expand(8.0);
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(200));
    painter.galley(area.min, galley, Color32::PLACEHOLDER);
    ground
}

/// Returns the reason why the picture does not show the bottom; `None` if it does.
pub(super) fn warning(survey: &Survey, units: Units) -> Option<String> {
    match survey.side_scan_state {
        SideScanState::Usable => None,
        SideScanState::Absent => {
            Some("no side-scan: this log holds no side-scan frames".to_owned())
        }
        SideScanState::Noise { range_m } => Some(format!(
            "no side-scan: range stuck at ±{}, noise; was a transducer connected?",
            units.measure(f64::from(range_m), 1)
        )),
    }
}
