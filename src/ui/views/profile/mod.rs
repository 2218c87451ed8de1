//! Draws one ping as a curve, port to the left and starboard to the right of the middle, as in the
//! paper's figures: raw and normalised intensity, threshold, dead zone and picks.
//!
//! Input: the state. Output: a plot of one ping, and commands.

mod curve;

use crate::app::{Command, LogPlace, ViewOptions};
use crate::ui::flat::{self, RasterTexture};
use crate::ui::{OwnHover, ViewContext, place, theme};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::first_return::Pick;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{Side, SidePing, Survey};
use bathyscope_products::pipeline::settings::{ControlValue, rows};
use curve::ScaleJob;
use egui::{Align2, FontId, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, pos2, vec2};

/// Least readable height of the plot, points.
const LEAST_HEIGHT: f32 = 90.0;
/// Distance at which the pointer grips the threshold line, points.
const GRIP: f32 = 6.0;

/// State of the profile.
pub struct ProfileView {
    scale: ScaleJob,
    /// Enlargement about the nadir; 1 shows the whole range.
    zoom: f32,
    drags_threshold: bool,
    hover: OwnHover,
    /// The image of the curves on the screen.
    curves: Option<RasterTexture>,
}

impl Default for ProfileView {
    fn default() -> Self {
        Self {
            scale: ScaleJob::default(),
            zoom: 1.0,
            drags_threshold: false,
            hover: OwnHover::default(),
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
        !self.scale.is_running()
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
        let normalisation = curve::normalisation(&mut self.scale, context, &survey);
        self.zoom_at(ui, &response);
        let plot = ProfilePlot::new(rect, far_m(&shown) / f64::from(self.zoom));
        let (options, curves) = (context.options(), &mut self.curves);
        draw_axes(&painter, &plot, options);
        dead_zone(&painter, &plot, shown.dead_zone_m, options);
        curve::draw(&painter, &plot, &shown, &normalisation, options, curves);
        draw_marks(&painter, &plot, &shown, options);
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
        let mark = at.map(|at| mark_at(shown, plot.across_m(at.x)));
        self.hover.tell(context, mark);
        if mark.is_some() && response.clicked() {
            context.push(Command::Select(mark));
        }
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
        excluded: place::excluded_at(context.app, context.app.logs.shown.id, ping),
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
    let sample = shown.recorded.side(side).and_then(|span| {
        place::recorded_sample(span, shown.reduction.sample_at(span, across_m.abs()))
    });
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

/// Room for the numbers of the vertical axes, points.
const SIDE: f32 = 26.0;
/// Room for the numbers of the range axis, points.
const BELOW: f32 = 16.0;
/// Room for the words above, points.
const ABOVE: f32 = 16.0;

/// Transform between values and the screen.
struct ProfilePlot {
    /// Area of the curves.
    pub area: Rect,
    far_m: f64,
}

impl ProfilePlot {
    /// Creates a plot of both sides up to `far_m`.
    fn new(rect: Rect, far_m: f64) -> Self {
        let min = rect.min + vec2(SIDE, ABOVE);
        let max = rect.max - vec2(SIDE, BELOW);
        Self { area: Rect::from_min_max(min, max.max(min + vec2(1.0, 1.0))), far_m }
    }

    /// Returns the screen x of a slant range, port negative.
    fn x(&self, across_m: f64) -> f32 {
        self.area.center().x + (across_m / self.far_m) as f32 * self.area.width() / 2.0
    }

    /// Returns the slant range at a screen x, port negative; inverse of [`ProfilePlot::x`].
    fn across_m(&self, x: f32) -> f64 {
        f64::from((x - self.area.center().x) / (self.area.width() / 2.0)) * self.far_m
    }

    /// Returns the screen y of a level, 0 to 1.
    fn y(&self, level: f32) -> f32 {
        self.area.bottom() - level * self.area.height()
    }

    /// Returns the level at a screen y, limited to 0 to 1; inverse of [`ProfilePlot::y`].
    fn level(&self, y: f32) -> f32 {
        ((self.area.bottom() - y) / self.area.height()).clamp(0.0, 1.0)
    }

    /// Returns the metres between ticks that leave room for their numbers.
    fn step_m(&self, units: Units) -> f64 {
        let per_point = 2.0 * self.far_m / f64::from(self.area.width());
        units.round_up_m(per_point * 44.0)
    }
}

/// Draws the axes with numbers: normalised left, raw right, slant range below.
fn draw_axes(painter: &Painter, plot: &ProfilePlot, options: &ViewOptions) {
    let ink = theme::plot_ink(options);
    let faint = Stroke::new(1.0, ink.gamma_multiply(0.25));
    let font = FontId::proportional(10.0);
    let write = |at: Pos2, anchor: Align2, text: String| {
        painter.text(at, anchor, text, font.clone(), ink);
    };
    let area = plot.area;
    for (level, raw) in [(0.0, "0"), (0.5, "128"), (1.0, "255")] {
        let y = plot.y(level);
        painter.hline(area.x_range(), y, faint);
        let normalised = format!("{level}");
        write(pos2(area.left() - 4.0, y), Align2::RIGHT_CENTER, normalised);
        let right = pos2(area.right() + 4.0, y);
        write(right, Align2::LEFT_CENTER, raw.to_owned());
    }
    let step_m = plot.step_m(options.units);
    let ticks = (plot.far_m / step_m).floor() as i32;
    for tick in -ticks..=ticks {
        let across_m = f64::from(tick) * step_m;
        let x = plot.x(across_m);
        let tick = area.bottom()..=area.bottom() + 3.0;
        painter.vline(x, tick, Stroke::new(1.0, ink));
        let label = options.units.tick_with_unit(across_m.abs(), step_m);
        write(pos2(x, area.bottom() + 3.0), Align2::CENTER_TOP, label);
    }
    painter.vline(area.center().x, area.y_range(), faint);
    let top = area.top() + 2.0;
    let port = pos2(area.left() + 4.0, top);
    write(port, Align2::LEFT_TOP, "port".to_owned());
    let starboard = pos2(area.right() - 4.0, top);
    write(starboard, Align2::RIGHT_TOP, "starboard".to_owned());
}

/// Draws the range around the transducer that is ignored.
fn dead_zone(painter: &Painter, plot: &ProfilePlot, dead_zone_m: f64, options: &ViewOptions) {
    let x = plot.x(-dead_zone_m)..=plot.x(dead_zone_m);
    let zone = Rect::from_x_y_ranges(x, plot.area.y_range()).intersect(plot.area);
    painter.rect_filled(zone, 0.0, theme::plot_ink(options).gamma_multiply(0.15));
}

/// Draws depth, threshold and picks, the picks on top.
fn draw_marks(painter: &Painter, plot: &ProfilePlot, shown: &Shown<'_>, options: &ViewOptions) {
    let altitude_m = shown.bottom.map_or(f64::NAN, |bottom| bottom.altitude_m);
    for across_m in [-altitude_m, altitude_m] {
        let stroke = Stroke::new(1.0, theme::DEPTH_LINE_COLOUR);
        vertical(painter, plot, across_m, stroke);
    }
    threshold(painter, plot, shown.threshold, options);
    for side in Side::BOTH {
        pick(painter, plot, shown, side, options);
    }
    if let Some(why) = &shown.excluded {
        let at = plot.area.center_bottom() - vec2(0.0, 4.0);
        let ink = theme::plot_ink(options);
        let font = FontId::proportional(10.5);
        painter.text(at, Align2::CENTER_BOTTOM, why, font, ink);
    }
}

fn threshold(painter: &Painter, plot: &ProfilePlot, level: f32, options: &ViewOptions) {
    let y = plot.y(level);
    let colour = theme::accent_colour(options.theme);
    let ends = [pos2(plot.area.left(), y), pos2(plot.area.right(), y)];
    let stroke = Stroke::new(1.5, colour);
    painter.extend(Shape::dashed_line(&ends, stroke, 6.0, 3.0));
    let (words, font) = (format!("threshold {level:.2}"), FontId::proportional(10.0));
    let galley = painter.layout_no_wrap(words, font, colour);
    // Above the line, or below it at the top of the plot; on a background, because the curve
    // crosses the text.
    let above = y - galley.size().y > plot.area.top();
    let anchor = if above { Align2::RIGHT_BOTTOM } else { Align2::RIGHT_TOP };
    let text = anchor.anchor_size(pos2(plot.area.right() - 2.0, y), galley.size());
    let ground = theme::canvas_colour(options).gamma_multiply(0.75);
    painter.rect_filled(text.expand2(vec2(2.0, 0.0)), 2.0, ground);
    painter.galley(text.min, galley, colour);
}

fn pick(
    painter: &Painter,
    plot: &ProfilePlot,
    shown: &Shown<'_>,
    side: Side,
    options: &ViewOptions,
) {
    let Some(found) = shown.picks[side as usize] else {
        return;
    };
    let across_m = place::across_m(side, found.range_m);
    let colour = theme::side_colour(options, side);
    if !vertical(painter, plot, across_m, Stroke::new(2.0, colour)) {
        return;
    }
    let above_bottom = if found.pick.above_bottom { ", above the sounding" } else { "" };
    let label = format!("{}{above_bottom}", options.units.measure(found.range_m, 2));
    let anchor = match side {
        Side::Port => Align2::RIGHT_BOTTOM,
        Side::Starboard => Align2::LEFT_BOTTOM,
    };
    // Beside its line; a label that is too long for its side begins at the edge of the plot.
    let galley = painter.layout_no_wrap(label, FontId::proportional(10.5), colour);
    let at = pos2(plot.x(across_m), plot.area.top() - 2.0);
    let text = anchor.anchor_size(at, galley.size());
    let room = painter.clip_rect().x_range();
    let x = text.left().min(room.max - galley.size().x).max(room.min);
    painter.galley(pos2(x, text.top()), galley, colour);
}

/// Draws a line at a range if the plot shows that range; returns true if it does.
fn vertical(painter: &Painter, plot: &ProfilePlot, across_m: f64, stroke: Stroke) -> bool {
    let x = plot.x(across_m);
    let in_view = plot.area.x_range().contains(x);
    if in_view {
        painter.vline(x, plot.area.y_range(), stroke);
    }
    in_view
}
