//! Draws one ping as a curve, port to the left and starboard to the right of the middle, as in the
//! paper's figures: raw and normalised intensity, threshold, dead zone and picks.
//!
//! Input: the state. Output: a plot of one ping, and commands.

mod curve;
mod marks;
mod plot;

use crate::app::{Command, LogPlace};
use crate::ui::raster::RasterTexture;
use crate::ui::{ViewContext, flat, place, stretch_text, theme};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::first_return::Pick;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{Side, SidePing, Survey};
use bathyscope_products::pipeline::settings::{ControlValue, rows};
use curve::ScaleJob;
use egui::{Rect, Response, Sense, vec2};
use plot::ProfilePlot;

/// Least readable height of the plot, points.
const LEAST_HEIGHT: f32 = 140.0;
/// Distance at which the pointer grips the threshold line, points.
const GRIP: f32 = 6.0;

/// State of the profile.
pub struct ProfileView {
    scale: ScaleJob,
    /// Enlargement about the nadir; 1 shows the whole range.
    zoom: f32,
    drags_threshold: bool,
    was_over: bool,
    /// The image of the curves on the screen.
    curves: Option<RasterTexture>,
}

impl Default for ProfileView {
    fn default() -> Self {
        Self {
            scale: ScaleJob::default(),
            zoom: 1.0,
            drags_threshold: false,
            was_over: false,
            curves: None,
        }
    }
}

/// Data that the profile shows.
struct Shown<'a> {
    survey: &'a Survey,
    reduction: Reduction<'a>,
    ping: usize,
    recorded: &'a SidePing,
    /// The bottom under the boat; `None` if it is unknown.
    bottom: Option<place::BottomBelow>,
    picks: [Option<Found>; 2],
    threshold: f32,
    dead_zone_m: f64,
    /// Reason why the ping is excluded; `None` if it is not excluded.
    excluded: Option<String>,
}

/// A first return.
#[derive(Clone, Copy)]
struct Found {
    pick: Pick,
    /// Slant range, metres.
    range_m: f64,
}

impl ProfileView {
    /// Returns true if the curve is drawn at its final scale.
    pub fn is_settled(&self) -> bool {
        self.scale.is_settled()
    }

    /// Draws the profile of the hovered ping, or else the selected one.
    pub fn ui(&mut self, ui: &mut egui::Ui, context: &mut ViewContext<'_>) {
        let available = ui.available_size();
        // No taller than wide: vertical stretching would hide how little most echoes differ.
        let height = available.y.min(available.x).max(LEAST_HEIGHT);
        let size = vec2(available.x, height);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        let canvas = theme::canvas_colour(context.options());
        flat::fill(&painter, rect, canvas, context.render_state);
        let survey = context.app.logs.shown.survey.clone();
        let mark = context.app.view.hover.or(context.app.view.selection);
        let Some((survey, mark)) = survey.zip(mark) else {
            let words = "move the pointer over the waterfall, or select a ping";
            return empty(&painter, rect, &response, words);
        };
        let Some(shown) = shown(&survey, mark.ping, context) else {
            return empty(&painter, rect, &response, "no side-scan ping here");
        };
        let normalisation = self.scale.of(context, &survey);
        self.zoom_at(ui, &response);
        let plot = ProfilePlot::new(rect, far_m(&shown) / f64::from(self.zoom));
        let (options, curves) = (context.options(), &mut self.curves);
        plot::axes(&painter, &plot, options);
        marks::dead_zone(&painter, &plot, shown.dead_zone_m, options);
        curve::draw(&painter, &plot, &shown, &normalisation, options, curves);
        marks::draw(&painter, &plot, &shown, options);
        self.drag_threshold(ui, &response, &plot, context);
        self.hover(&response, &plot, &shown, context);
        response.widget_info(|| {
            let name = accessible_name(&shown, context.units());
            egui::WidgetInfo::labeled(egui::Role::Image, true, name)
        });
    }

    fn zoom_at(&mut self, ui: &egui::Ui, response: &Response) {
        if response.double_clicked() {
            self.zoom = 1.0;
        }
        if response.hovered() {
            let wheel = ui.input(|input| input.smooth_scroll_delta().y);
            self.zoom = (self.zoom * (wheel / 200.0).exp()).clamp(1.0, 50.0);
        }
    }

    /// Lets the user drag the threshold line; the settings follow during the drag.
    fn drag_threshold(
        &mut self,
        ui: &egui::Ui,
        response: &Response,
        plot: &ProfilePlot,
        context: &mut ViewContext<'_>,
    ) {
        let line = plot.y(context.app.logs.shown.settings.first_return.threshold);
        let near = |at: egui::Pos2| plot.area.contains(at) && (at.y - line).abs() <= GRIP;
        if response.drag_started() {
            let origin = ui.input(|input| input.pointer.press_origin());
            self.drags_threshold = origin.is_some_and(near);
        }
        if self.drags_threshold || response.hover_pos().is_some_and(near) {
            ui.set_cursor_icon(egui::CursorIcon::ResizeVertical);
        }
        if !self.drags_threshold {
            return;
        }
        let live = !response.drag_stopped();
        if let Some(at) = response.interact_pointer_pos() {
            // Steps of a hundredth, like those of the slider and the keys.
            let threshold = (plot.level(at.y) * 100.0).round() / 100.0;
            let value = ControlValue::Number(Some(f64::from(threshold)));
            context.set(&rows::THRESHOLD, value, live);
        }
        self.drags_threshold = live;
    }

    /// Marks the place under the pointer in the other views; a click selects it.
    fn hover(
        &mut self,
        response: &Response,
        plot: &ProfilePlot,
        shown: &Shown<'_>,
        context: &mut ViewContext<'_>,
    ) {
        let at = response.hover_pos().filter(|at| plot.area.contains(*at));
        match at {
            Some(at) => {
                let mark = mark_at(shown, plot.across_m(at.x));
                if context.app.view.hover != Some(mark) {
                    context.push(Command::Hover(Some(mark)));
                }
                if response.clicked() {
                    context.push(Command::Select(Some(mark)));
                }
            }
            None if self.was_over => context.push(Command::Hover(None)),
            None => {}
        }
        self.was_over = at.is_some();
    }
}

fn shown<'a>(survey: &'a Survey, ping: usize, context: &ViewContext<'a>) -> Option<Shown<'a>> {
    let recorded = survey.side_scan.get(ping)?;
    let reduction = place::reduction(context.app);
    let found = |side| {
        let pick = context.app.logs.shown.returns()?.side(side).get(ping).copied()?;
        let range_m = reduction.range_m(recorded.side(side)?, f64::from(pick.sample));
        range_m.is_finite().then_some(Found { pick, range_m })
    };
    Some(Shown {
        survey,
        reduction,
        ping,
        recorded,
        bottom: place::bottom(context.app, ping),
        picks: Side::BOTH.map(found),
        threshold: context.app.logs.shown.settings.first_return.threshold,
        dead_zone_m: context.app.logs.shown.settings.first_return.dead_zone_m,
        excluded: stretch_text::excluded_at(context.app, context.app.logs.shown.id, ping),
    })
}

/// Returns the farthest slant range of both sides, metres; 1 where a damaged header gives none.
fn far_m(shown: &Shown<'_>) -> f64 {
    let far = Side::BOTH.map(|side| {
        let span = shown.recorded.side(side);
        span.map_or(0.0, |span| shown.reduction.range_m(span, f64::from(span.count)))
    });
    let far_m = far[0].max(far[1]);
    if far_m.is_finite() && far_m > 0.0 { far_m } else { 1.0 }
}

fn mark_at(shown: &Shown<'_>, across_m: f64) -> LogPlace {
    let side = place::side_at(across_m);
    let span = shown.recorded.side(side);
    let sample = span
        .map(|span| {
            let sample = shown.reduction.sample_at(span, across_m.abs());
            (sample, f64::from(span.count))
        })
        .filter(|(sample, count)| (0.0..*count).contains(sample))
        .map(|(sample, _)| sample as f32);
    LogPlace { side: sample.map(|_| side), sample, ..LogPlace::ping(shown.ping) }
}

fn empty(painter: &egui::Painter, rect: Rect, response: &Response, text: &str) {
    let colour = painter.ctx().global_style().visuals.weak_text_color();
    let font = egui::FontId::proportional(12.0);
    let room = (rect.width() - 16.0).max(1.0);
    let mut words = egui::text::LayoutJob::simple(text.to_owned(), font, colour, room);
    words.halign = egui::Align::Center;
    let galley = painter.layout_job(words);
    let top = rect.center() - vec2(0.0, galley.size().y / 2.0);
    painter.galley(top, galley, colour);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Profile, empty: {text}"))
    });
}

fn accessible_name(shown: &Shown<'_>, units: Units) -> String {
    let found = Side::BOTH.map(|side| {
        let found = shown.picks[side as usize];
        let range = found.map_or("none".to_owned(), |found| units.measure(found.range_m, 2));
        format!("{} first return {range}", side.name())
    });
    let depth = shown.bottom.map_or_else(String::new, |bottom| {
        let altitude = units.measure(bottom.altitude_m, 2);
        let by = bottom.by.name();
        format!(", bottom {altitude} below transducer by {by}")
    });
    let excluded = (shown.excluded.as_ref()).map_or_else(String::new, |why| format!(", {why}"));
    format!(
        "Profile of ping {}: {}, {}, threshold {:.2}{depth}{excluded}",
        shown.ping, found[0], found[1], shown.threshold
    )
}
