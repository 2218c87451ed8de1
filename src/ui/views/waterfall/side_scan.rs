//! Draws a frame of the side-scan: the selected tools, the picture, and everything over it; and
//! describes it for screen readers and tests, also while there is no picture.

use super::lens::{Lens, LensPlace};
use super::{WaterfallDrawing, WaterfallView, boxes, extent, overlay, pointer};
use crate::app::{App, Command, Tool, View};
use crate::ui::views::{empty, tool_banner};
use crate::ui::{ViewContext, stretch_text};
use bathyscope_bottom::first_return::BottomLine;
use bathyscope_log::survey::Survey;
use egui::{Painter, Rect, Response, Role, Sense, Ui, WidgetInfo};
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
        let banner = tool_banner::in_view(ui, context.app, View::Waterfall, rect);
        let shown = overlay::ShownOverlay {
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
        overlay::draw(&painter, &lens, &shown);
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
        shown: &overlay::ShownOverlay<'_>,
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

/// Fills a view that has no picture, or not yet: shows the reason, and offers to open a log if none
/// is open.
fn without_picture(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    response: &Response,
    is_reading: bool,
) {
    let survey = context.app.logs.shown.survey.clone();
    let said = match survey {
        None => {
            empty::first_steps(ui, context, rect);
            "open a survey to see its side-scan here".to_owned()
        }
        Some(_) if is_reading => {
            empty::say(ui, context, rect, "The side-scan is being read.");
            "reading the survey".to_owned()
        }
        Some(survey) => {
            let text = overlay::warning(&survey, context.units())
                .unwrap_or_else(|| "no side-scan: no ping has a usable range".to_owned());
            overlay::banner(&ui.painter_at(rect), rect, &text);
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
    let warning =
        overlay::warning(survey, units).map_or_else(String::new, |text| format!(", {text}"));
    let excluded = stretch_text::and_stretches(context.app);
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
