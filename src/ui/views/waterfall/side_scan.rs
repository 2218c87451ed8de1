//! A frame of the side-scan: the tools in hand, the picture, and what lies over it.

use super::lens::{Lens, LensPlace};
use super::{WaterfallDrawing, WaterfallView, accessibility, boxes, extent, overlay, pointer};
use crate::app::{App, Command, Tool, View};
use crate::ui::ViewContext;
use crate::ui::views::tool_banner;
use bathyscope_log::survey::Survey;
use egui::{Painter, Rect, Response, Sense, Ui};

/// Use of the pointer by the tools in hand.
#[derive(Clone, Copy, Default)]
struct ToolsInUse {
    /// A box is being moved or drawn.
    hold_box: bool,
    /// A line, a stretch or a measurement is being drawn.
    draw: bool,
}

impl WaterfallView {
    /// The side-scan with all that lies over it.
    pub(super) fn side_scan(&mut self, ui: &mut Ui, rect: Rect, context: &mut ViewContext<'_>) {
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        let survey = context.app.log.survey.clone();
        let axis = self.drawing.as_ref().and_then(WaterfallDrawing::axis);
        let Some((survey, axis)) = survey.zip(axis) else {
            self.settled = self.drawing.as_ref().is_none_or(WaterfallDrawing::is_settled);
            accessibility::without_picture(ui, context, rect, &response, !self.settled);
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
            // The pointer's own mark reaches the state only after this frame.
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
        // A hand that draws wants to see what lies ahead.
        if let Some(text) = read_out.as_ref().filter(|_| !in_use.draw) {
            self.draw_read_out(&painter, &response, &lens, &shown, text);
        }
        let visible = lens.visible(survey.side_scan.len());
        let seen = boxes::words(shown.boxes, shown.missed, context.app);
        accessibility::describe(&response, &visible, &survey, context, &seen, read_out.as_deref());
        if context.app.view.visible != visible {
            context.push(Command::Visible(visible));
        }
    }

    /// Each tool does what the pointer and the keys ask of it, in the picture as the frame before
    /// showed it.
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

    /// Moves the cross of the tool for targets by the arrow keys; the place under it becomes the
    /// one that keys act on.
    fn aim_at_target(
        &mut self,
        ui: &mut Ui,
        response: &Response,
        lens: &Lens,
        survey: &Survey,
        context: &mut ViewContext<'_>,
    ) {
        if context.app.log.reviewing.tool != Tool::Point {
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

    /// Pushes what the pointer asks for; returns the place under it.
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

    /// Draws what the tools have in hand.
    fn draw_tools(&self, painter: &Painter, response: &Response, lens: &Lens, app: &App) {
        self.boxes.draw(painter, response.interact_pointer_pos());
        self.pen.draw(painter, lens, app);
        self.stretch.draw(painter, lens, app);
        self.measure.draw(painter, lens, app);
        self.cross.draw(painter, lens);
    }

    /// Writes beside the pointer what is under it, clear of what is being worked on.
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
