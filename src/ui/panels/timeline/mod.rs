//! Draws the time line: depth and speed over the whole log, the places that the views show, and the
//! pointer that selects a ping.
//!
//! The panel reads the state of the app, draws curves over time, and sends commands.

mod strips;

use crate::app::{Command, LogPlace};
use crate::ui::flat::{PaintedArea, RasterTexture};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::cloud::{Correction, PingDepth};
use bathyscope_bottom::presentation::ticks;
use bathyscope_log::survey::{Navigation, Survey};
use bathyscope_products::pipeline::{Background, Same};
use egui::{Color32, Pos2, Rect, Response, Sense, Stroke, Ui};
use strips::{ColumnExtremes, Strips, resampled, span};

/// Height of the panel, points.
pub(crate) const HEIGHT: f32 = 104.0;

/// The results from which the strips are made.
type StripResults = (Same<Navigation>, Same<Vec<PingDepth>>, Same<Correction>);

/// The survey and the results from which the strips are made.
type StripsKey = (Same<Survey>, Option<StripResults>);

/// State of the time line: the strips of the open survey.
#[derive(Default)]
pub(crate) struct TimeLine {
    /// The inner `None` means that the log has no times.
    strips: Background<StripsKey, Option<Strips>>,
    /// Textures of the drawn depth and speed.
    pictures: [Option<RasterTexture>; 2],
    seen_survey: u64,
    /// True if the pointer was over the panel in the last frame.
    was_over: bool,
}

impl TimeLine {
    /// Returns true if the drawn strips are those of the present survey and its last results.
    pub(crate) fn is_settled(&self) -> bool {
        !self.strips.is_running()
    }

    fn refresh(&mut self, context: &ViewContext<'_>) {
        let app = context.app;
        let Some(survey) = app.logs.shown.judged() else {
            *self = Self::default();
            return;
        };
        if self.seen_survey != app.view.survey_serial {
            // Without this reset, the strips of another log would be drawn until those of this log
            // exist.
            self.seen_survey = app.view.survey_serial;
            self.strips = Background::default();
        }
        let (survey, products) = (survey.clone(), app.logs.shown.products.clone());
        let results = products.as_ref().map(|products| {
            let correction = Same(products.correction.clone());
            (Same(products.navigation.clone()), Same(products.depths.clone()), correction)
        });
        let key = (Same(survey.clone()), results);
        let work = move |_: &_| Some(Strips::of(&survey, products.as_ref()));
        self.strips.ask(key, app.jobs.workers(), work);
    }

    /// Draws the panel.
    pub(crate) fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        self.refresh(context);
        let (outer, response) =
            ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let count = place::ping_count(context.app);
        let ping = context.app.view.selection.map_or(0, |mark| mark.ping);
        response.widget_info(|| {
            let strips = self.strips.result().and_then(Option::as_ref);
            let depth = strips.and_then(|strips| strips.deepest(context.units()));
            let depth = depth.map_or(String::new(), |depth| format!(", depth {depth}"));
            let excluded = place::and_stretches(context.app);
            let name = format!("Time line, ping {ping} of {count}{depth}{excluded}");
            egui::WidgetInfo::slider(true, ping as f64, name)
        });
        let Some(Some(strips)) = self.strips.result() else {
            return;
        };
        let frame = TimelineLayout::new(outer);
        frame.strips(ui, context, strips, &mut self.pictures);
        frame.marks(ui, context, strips);
        frame.pointer(&response, context, strips);
        if self.was_over && !response.hovered() {
            context.push(Command::Hover(None));
        }
        self.was_over = response.hovered();
    }
}

/// Areas of the parts of the panel.
struct TimelineLayout {
    depth: Rect,
    speed: Rect,
    all: Rect,
    axis_y: f32,
}

impl TimelineLayout {
    const GUTTER: f32 = 104.0;
    const AXIS: f32 = 14.0;

    /// Divides the area of the panel.
    fn new(outer: Rect) -> Self {
        let mut all = outer;
        all.min.x += Self::GUTTER;
        all.max.x -= 8.0;
        all.max.y -= Self::AXIS;
        let (mut depth, mut speed) = all.split_top_bottom_at_fraction(0.64);
        depth.max.y -= 1.0;
        speed.min.y += 1.0;
        Self { depth, speed, all, axis_y: all.max.y }
    }

    /// Draws both strips and the axis; `pictures` holds the textures of the strips.
    fn strips(
        &self,
        ui: &Ui,
        context: &ViewContext<'_>,
        strips: &Strips,
        pictures: &mut [Option<RasterTexture>; 2],
    ) {
        let look = context.theme();
        let well = ui.visuals().extreme_bg_color;
        let [mut above, mut below] =
            [self.depth, self.speed].map(|rect| PaintedArea::new(ui.painter(), rect, well));
        let high = |columns: &ColumnExtremes| span(columns).map(|[_, high]| high);
        let known = [high(&strips.depth), high(&strips.side_scan)];
        let deepest = known.into_iter().flatten().reduce(f32::max);
        let deepest = deepest.or_else(|| high(&strips.lost));
        let fastest = high(&strips.speed);
        // The body of the depth extends down from the surface, the body of the speed up from its
        // base line.
        let depth =
            SeriesBand { rect: self.depth, reach: deepest.unwrap_or(0.0) * 1.08, hanging: true };
        let speed =
            SeriesBand { rect: self.speed, reach: fastest.unwrap_or(0.0) * 1.1, hanging: false };
        let lost = theme::stale_colour(look).gamma_multiply(0.5);
        depth.paint(&mut above, &strips.lost, Color32::TRANSPARENT, lost);
        let colour = theme::depth_strip_colour(look);
        let body = colour.gamma_multiply(0.35);
        depth.paint(&mut above, &strips.depth, body, colour);
        // A line without a body marks depths from side-scan only.
        let body = colour.gamma_multiply(0.12);
        depth.paint(&mut above, &strips.side_scan, body, colour);
        let colour = theme::speed_strip_colour(look);
        let body = colour.gamma_multiply(0.35);
        speed.paint(&mut below, &strips.speed, body, colour);
        above.show(ui.painter(), &mut pictures[0]);
        below.show(ui.painter(), &mut pictures[1]);
        let units = context.units();
        let reach = |high: Option<f32>, written: &dyn Fn(f64) -> String| match high {
            Some(high) => format!("to {}", written(f64::from(high))),
            None => text::NONE.to_owned(),
        };
        let to_depth = reach(deepest, &|depth_m| units.measure(depth_m, 1));
        let to_speed = reach(fastest, &|speed_mps| units.speed(speed_mps, 1));
        self.gutter(ui, self.depth, "Depth", to_depth);
        // The gutter has no space for the reference of the depths; the strip of depths is mostly
        // empty at its lower edge.
        ui.painter().text(
            self.depth.right_bottom() - egui::vec2(4.0, 1.0),
            egui::Align2::RIGHT_BOTTOM,
            strips.reference.name(),
            egui::FontId::proportional(10.0),
            ui.visuals().weak_text_color(),
        );
        self.gutter(ui, self.speed, "Speed", to_speed);
        self.axis(ui, context, strips);
    }

    fn gutter(&self, ui: &Ui, strip: Rect, name: &str, reach: String) {
        let x = strip.left() - 8.0;
        let small = egui::FontId::proportional(theme::SMALL);
        let strong = ui.visuals().text_color();
        let weak = ui.visuals().weak_text_color();
        let y = strip.center().y;
        let right = egui::Align2::RIGHT_CENTER;
        if strip.height() < 27.0 {
            // A low window has no space for two lines, nor for both words beside the buttons: the
            // unit alone identifies the quantity.
            ui.painter().text(egui::pos2(x, y), right, reach, small, strong);
            return;
        }
        ui.painter().text(egui::pos2(x, y - 7.0), right, name, small.clone(), strong);
        ui.painter().text(egui::pos2(x, y + 7.0), right, reach, small, weak);
    }

    fn axis(&self, ui: &Ui, context: &ViewContext<'_>, strips: &Strips) {
        let survey = context.app.logs.shown.survey.as_ref();
        let start = survey.and_then(|survey| survey.start_unix_s);
        // In a window too narrow for the strips their width is negative: without this limit there
        // would be a tick each second.
        let width = f64::from(self.all.width().max(1.0));
        let step_s = ticks::time_step_s((strips.to_s - strips.from_s) * 90.0 / width);
        let weak = ui.visuals().weak_text_color();
        let font = egui::FontId::proportional(10.0);
        // Ticks are at round times of day if the recorder stored the time.
        let zero = start.map_or(0.0, |start| start.rem_euclid(86_400.0));
        let mut tick = ((strips.from_s + zero) / step_s).ceil() * step_s - zero;
        while tick <= strips.to_s {
            let x = strips.x(self.all, tick);
            let line = [egui::pos2(x, self.axis_y), egui::pos2(x, self.axis_y + 3.0)];
            ui.painter().line_segment(line, Stroke::new(1.0, weak));
            let label = text::clock(start, tick);
            let label = label.trim_end_matches(" UTC");
            if x + 50.0 < self.all.right() {
                let at = egui::pos2(x + 3.0, self.axis_y + Self::AXIS / 2.0 + 1.0);
                ui.painter().text(at, egui::Align2::LEFT_CENTER, label, font.clone(), weak);
            }
            tick += step_s;
        }
    }

    /// Draws warnings, the visible pings, the pointer of other views and the play head.
    fn marks(&self, ui: &Ui, context: &ViewContext<'_>, strips: &Strips) {
        let app = context.app;
        let Some(survey) = &app.logs.shown.survey else {
            return;
        };
        let x_of = |ping: usize| {
            let ping = survey.side_scan.get(ping)?;
            Some(strips.x(self.all, ping.time_s))
        };
        let painter = ui.painter().with_clip_rect(self.all.expand(6.0));
        self.exclusions(ui, context, strips);
        for &time_s in &strips.warnings_s {
            let at = egui::pos2(strips.x(self.all, time_s), self.all.top() + 3.0);
            painter.circle_filled(at, 2.0, theme::stale_colour(app.view.options.theme));
        }
        let visible = &app.view.visible;
        let ends = x_of(visible.start).zip(x_of(visible.end.saturating_sub(1)));
        if let Some((from, to)) = ends.filter(|_| !visible.is_empty()) {
            self.window(ui, from, to);
        }
        if let Some(x) = app.view.hover.and_then(|mark| x_of(mark.ping)) {
            painter.vline(x, self.all.y_range(), Stroke::new(1.0, theme::HOVER_COLOUR));
        }
        if let Some(x) = app.view.selection.and_then(|mark| x_of(mark.ping)) {
            let colour = theme::SELECTION_COLOUR;
            painter.vline(x, self.all.y_range(), Stroke::new(1.5, colour));
            let top = self.all.top();
            let head = vec![
                egui::pos2(x - 5.0, top - 5.0),
                egui::pos2(x + 5.0, top - 5.0),
                egui::pos2(x, top + 2.0),
            ];
            painter.add(egui::Shape::convex_polygon(head, colour, Stroke::NONE));
        }
    }

    /// Shades the excluded stretches, with a bar above in the colour of exclusions.
    fn exclusions(&self, ui: &Ui, context: &ViewContext<'_>, strips: &Strips) {
        let painter = ui.painter().with_clip_rect(self.all);
        let veil = ui.visuals().extreme_bg_color.gamma_multiply(0.75);
        let bar = theme::excluded_colour(context.options());
        let found = context.app.logs.shown.exclusions().into_iter();
        for stretch in found.flat_map(|found| &found.exclusions.stretches) {
            let [from, to] = stretch.time_s.map(|time_s| strips.x(self.all, time_s));
            let x = from..=to.max(from + 1.0);
            let area = Rect::from_x_y_ranges(x, self.all.y_range());
            painter.rect_filled(area, 0.0, veil);
            let top = egui::Rect::from_min_size(area.min, egui::vec2(area.width(), 3.0));
            painter.rect_filled(top, 0.0, bar);
        }
    }

    /// Shades the pings that the waterfall does not show.
    fn window(&self, ui: &Ui, from: f32, to: f32) {
        let to = to.max(from + 2.0);
        let shade = ui.visuals().panel_fill.gamma_multiply(0.62);
        let mut before = self.all;
        before.max.x = from;
        let mut after = self.all;
        after.min.x = to;
        for rect in [before, after] {
            if rect.is_positive() {
                ui.painter().rect_filled(rect, 0.0, shade);
            }
        }
        let edge = Stroke::new(1.0, ui.visuals().strong_text_color().gamma_multiply(0.6));
        let seen = Rect::from_x_y_ranges(from..=to, self.all.y_range());
        ui.painter().rect_stroke(seen, 1.0, edge, egui::StrokeKind::Inside);
    }

    /// Marks and selects the ping under the pointer.
    fn pointer(&self, response: &Response, context: &mut ViewContext<'_>, strips: &Strips) {
        let ping_at = |at: Pos2| {
            let pings = &context.app.logs.shown.survey.as_ref()?.side_scan;
            let time_s = strips.time_s(self.all, at.x);
            let after = pings.partition_point(|ping| ping.time_s < time_s);
            (!pings.is_empty()).then(|| after.min(pings.len() - 1))
        };
        let acts = response.clicked() || response.dragged();
        if let Some(ping) = response.interact_pointer_pos().filter(|_| acts).and_then(ping_at) {
            context.push(Command::Reveal(LogPlace::ping(ping)));
        } else if let Some(ping) = response.hover_pos().and_then(ping_at) {
            context.push(Command::Hover(Some(LogPlace::ping(ping))));
        }
    }
}

/// Area and scale of a series: from 0 to `reach`, from the top downwards if `hanging`, else from
/// the bottom upwards.
struct SeriesBand {
    rect: Rect,
    reach: f32,
    hanging: bool,
}

impl SeriesBand {
    fn y(&self, value: f32) -> f32 {
        let share = (value / self.reach).clamp(0.0, 1.0);
        if self.hanging {
            self.rect.top() + share * self.rect.height()
        } else {
            self.rect.bottom() - share * self.rect.height()
        }
    }

    /// Paints a body up to the series, and the band of its lowest and highest values on the edge.
    fn paint(
        &self,
        raster: &mut PaintedArea,
        columns: &ColumnExtremes,
        body: Color32,
        edge: Color32,
    ) {
        if self.reach <= 0.0 {
            return;
        }
        let base = self.y(0.0);
        // Each column of pixels gets the extremes of all columns in it.
        for (x, column) in resampled(columns, raster.width()).enumerate() {
            let Some([low, high]) = column else {
                continue;
            };
            let (near, far) = (self.y(low), self.y(high));
            raster.span(x, base, far, body);
            let [top, bottom] = [near.min(far), near.max(far)];
            raster.span(x, top - 0.75, bottom + 0.75, edge);
        }
    }
}
