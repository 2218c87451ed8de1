//! The time line: depth and speed over the whole log, where the views are, and where to go.

use super::strip::{Columns, columns, resampled, span};
use crate::app::{Command, Mark, Outcome, Task};
use crate::survey::{Navigation, Survey};
use crate::ui::{ViewContext, text, theme};
use egui::{Color32, Mesh, Pos2, Rect, Response, Sense, Stroke, Ui};
use std::sync::Arc;

/// Columns that a log is reduced to; more than any screen is wide.
const COLUMNS: usize = 2048;

/// Height of the panel, points.
pub const HEIGHT: f32 = 104.0;

/// What the strips show; computed on a worker for each survey and navigation.
struct Strips {
    from_s: f64,
    to_s: f64,
    depth: Columns,
    speed: Columns,
    warnings_s: Vec<f64>,
}

impl Strips {
    fn of(survey: &Survey, navigation: Option<&Navigation>) -> Option<Self> {
        let pings = &survey.side_scan;
        let soundings = &survey.soundings;
        let starts = [
            pings.first().map(|p| p.time_s),
            soundings.first().map(|s| s.time_s),
        ];
        let ends = [
            pings.last().map(|p| p.time_s),
            soundings.last().map(|s| s.time_s),
        ];
        let from_s = starts.into_iter().flatten().reduce(f64::min)?;
        let to_s = ends.into_iter().flatten().reduce(f64::max)?;
        let depths = soundings.iter().map(|s| (s.time_s, s.depth_m));
        let speeds = navigation.into_iter().flat_map(|navigation| {
            let here = pings.iter().zip(&navigation.pings);
            here.map(|(ping, here)| (ping.time_s, here.speed_mps as f32))
        });
        Some(Self {
            from_s,
            to_s,
            depth: columns(depths, from_s, to_s, column_count(soundings.len())),
            speed: columns(speeds, from_s, to_s, column_count(pings.len())),
            warnings_s: warning_times(survey),
        })
    }

    fn x(&self, rect: Rect, time_s: f64) -> f32 {
        let share = (time_s - self.from_s) / (self.to_s - self.from_s).max(f64::MIN_POSITIVE);
        rect.left() + rect.width() * share as f32
    }

    fn time_s(&self, rect: Rect, x: f32) -> f64 {
        let share = f64::from(((x - rect.left()) / rect.width()).clamp(0.0, 1.0));
        self.from_s + share * (self.to_s - self.from_s)
    }
}

/// Columns for a series of so many values: enough values in each that regular ones leave no gaps.
fn column_count(values: usize) -> usize {
    (values / 3).clamp(16, COLUMNS)
}

/// Times of the pings at which the log's warnings point; at most one a column.
fn warning_times(survey: &Survey) -> Vec<f64> {
    let offset = |ping: &crate::survey::SidePing, file: usize| {
        let span = ping.port.or(ping.starboard)?;
        (usize::from(span.file) == file).then_some(span.offset)
    };
    let places = survey.warnings.iter().filter_map(|warning| warning.place);
    places
        .take(COLUMNS)
        .filter_map(|(file, at)| {
            let after = survey
                .side_scan
                .partition_point(|ping| offset(ping, file).is_some_and(|offset| offset < at));
            survey.side_scan.get(after).map(|ping| ping.time_s)
        })
        .collect()
}

/// Which survey and navigation the strips belong to.
type Key = (u64, usize);

/// State of the time line: the strips of the open survey.
#[derive(Default)]
pub struct TimeLine {
    shown: Option<(Key, Option<Strips>)>,
    task: Option<(Key, Task<Option<Strips>>)>,
    /// The pointer was over the panel in the last frame.
    was_over: bool,
}

impl TimeLine {
    /// Whether the strips shown are those of the survey and its last result.
    pub fn is_settled(&self) -> bool {
        self.task.is_none()
    }

    fn refresh(&mut self, context: &ViewContext<'_>) {
        let app = context.app;
        let Some(survey) = &app.survey else {
            *self = Self::default();
            return;
        };
        let navigation = app
            .products
            .as_ref()
            .map(|products| products.navigation.clone());
        let address = navigation.as_ref().map_or(0, |n| Arc::as_ptr(n) as usize);
        let key = (app.survey_serial, address);
        let known = self.shown.as_ref().map(|(known, _)| *known);
        let coming = self.task.as_ref().map(|(coming, _)| *coming);
        if known != Some(key) && coming != Some(key) {
            let survey = survey.clone();
            let work = move |_: &_| Strips::of(&survey, navigation.as_deref());
            self.task = Some((key, Task::start(app.jobs(), work)));
        }
        if let Some((key, task)) = &self.task {
            match task.poll() {
                Outcome::Pending => {}
                Outcome::Done(strips) => {
                    self.shown = Some((*key, strips));
                    self.task = None;
                }
                Outcome::Failed => self.task = None,
            }
        }
    }

    /// Draws the panel.
    pub fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        self.refresh(context);
        let (outer, response) =
            ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let count = context
            .app
            .survey
            .as_ref()
            .map_or(0, |survey| survey.side_scan.len());
        let ping = context.app.selection.map_or(0, |mark| mark.ping);
        response.widget_info(|| {
            let name = format!("Time line, ping {ping} of {count}");
            egui::WidgetInfo::slider(true, ping as f64, name)
        });
        let Some((_, Some(strips))) = &self.shown else {
            let empty = "Time line: depth and speed over the log appear here.";
            let font = egui::FontId::proportional(theme::SMALL);
            let weak = ui.visuals().weak_text_color();
            ui.painter().text(
                outer.center(),
                egui::Align2::CENTER_CENTER,
                empty,
                font,
                weak,
            );
            return;
        };
        let frame = Frame::new(outer);
        frame.strips(ui, context, strips);
        frame.marks(ui, context, strips);
        frame.pointer(&response, context, strips);
        if self.was_over && !response.hovered() {
            context.push(Command::Hover(None));
        }
        self.was_over = response.hovered();
    }
}

/// Where the parts of the panel lie.
struct Frame {
    depth: Rect,
    speed: Rect,
    all: Rect,
    axis_y: f32,
}

impl Frame {
    const GUTTER: f32 = 104.0;
    const AXIS: f32 = 14.0;

    fn new(outer: Rect) -> Self {
        let mut all = outer;
        all.min.x += Self::GUTTER;
        all.max.x -= 8.0;
        all.max.y -= Self::AXIS;
        let (mut depth, mut speed) = all.split_top_bottom_at_fraction(0.64);
        depth.max.y -= 1.0;
        speed.min.y += 1.0;
        Self {
            depth,
            speed,
            all,
            axis_y: all.max.y,
        }
    }

    fn strips(&self, ui: &Ui, context: &ViewContext<'_>, strips: &Strips) {
        let look = context.app.options.theme;
        let well = ui.visuals().extreme_bg_color;
        for rect in [self.depth, self.speed] {
            ui.painter().rect_filled(rect, 0.0, well);
        }
        let [_, deepest] = span(&strips.depth).unwrap_or([0.0, 0.0]);
        let [_, fastest] = span(&strips.speed).unwrap_or([0.0, 0.0]);
        // Depth hangs from the surface, speed stands on its base line.
        band(
            ui,
            self.depth,
            &strips.depth,
            deepest * 1.08,
            true,
            theme::depth_strip_colour(look),
        );
        band(
            ui,
            self.speed,
            &strips.speed,
            fastest * 1.1,
            false,
            theme::speed_strip_colour(look),
        );
        self.gutter(ui, self.depth, "Depth", format!("to {deepest:.1} m"));
        self.gutter(ui, self.speed, "Speed", format!("to {fastest:.1} m/s"));
        self.axis(ui, context, strips);
    }

    fn gutter(&self, ui: &Ui, strip: Rect, name: &str, reach: String) {
        let x = strip.left() - 8.0;
        let small = egui::FontId::proportional(theme::SMALL);
        let strong = ui.visuals().text_color();
        let weak = ui.visuals().weak_text_color();
        let y = strip.center().y;
        let right = egui::Align2::RIGHT_CENTER;
        ui.painter()
            .text(egui::pos2(x, y - 7.0), right, name, small.clone(), strong);
        ui.painter()
            .text(egui::pos2(x, y + 7.0), right, reach, small, weak);
    }

    fn axis(&self, ui: &Ui, context: &ViewContext<'_>, strips: &Strips) {
        let start = context
            .app
            .survey
            .as_ref()
            .and_then(|survey| survey.start_unix_s);
        let step_s =
            tick_step_s((strips.to_s - strips.from_s) * 90.0 / f64::from(self.all.width()));
        let weak = ui.visuals().weak_text_color();
        let font = egui::FontId::proportional(10.0);
        // Ticks stand on round times of day when the recorder knew the time.
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
                ui.painter()
                    .text(at, egui::Align2::LEFT_CENTER, label, font.clone(), weak);
            }
            tick += step_s;
        }
    }

    fn marks(&self, ui: &Ui, context: &ViewContext<'_>, strips: &Strips) {
        let app = context.app;
        let Some(survey) = &app.survey else {
            return;
        };
        let x_of = |ping: usize| {
            let ping = survey.side_scan.get(ping)?;
            Some(strips.x(self.all, ping.time_s))
        };
        let painter = ui.painter().with_clip_rect(self.all.expand(6.0));
        for &time_s in &strips.warnings_s {
            let at = egui::pos2(strips.x(self.all, time_s), self.all.top() + 3.0);
            painter.circle_filled(at, 2.0, theme::stale_colour(app.options.theme));
        }
        let seen = (
            x_of(app.visible.start),
            x_of(app.visible.end.saturating_sub(1)),
        );
        if let (Some(from), Some(to), false) = (seen.0, seen.1, app.visible.is_empty()) {
            self.window(ui, from, to);
        }
        if let Some(x) = app.hover.and_then(|mark| x_of(mark.ping)) {
            painter.vline(
                x,
                self.all.y_range(),
                Stroke::new(1.0, theme::hover_colour()),
            );
        }
        if let Some(x) = app.selection.and_then(|mark| x_of(mark.ping)) {
            let colour = theme::selection_colour();
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

    /// Shades what the waterfall does not show.
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
        ui.painter()
            .rect_stroke(seen, 1.0, edge, egui::StrokeKind::Inside);
    }

    fn pointer(&self, response: &Response, context: &mut ViewContext<'_>, strips: &Strips) {
        let ping_at = |at: Pos2| {
            let pings = &context.app.survey.as_ref()?.side_scan;
            let time_s = strips.time_s(self.all, at.x);
            let after = pings.partition_point(|ping| ping.time_s < time_s);
            (!pings.is_empty()).then(|| after.min(pings.len() - 1))
        };
        let acts = response.clicked() || response.dragged();
        if let Some(ping) = response
            .interact_pointer_pos()
            .filter(|_| acts)
            .and_then(ping_at)
        {
            context.push(Command::Reveal(Mark::ping(ping)));
        } else if let Some(ping) = response.hover_pos().and_then(ping_at) {
            context.push(Command::Hover(Some(Mark::ping(ping))));
        }
    }
}

/// A round step in time that is at least `least_s` long.
fn tick_step_s(least_s: f64) -> f64 {
    const ROUND_S: [f64; 12] = [
        1.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0, 21_600.0, 86_400.0,
    ];
    ROUND_S
        .into_iter()
        .find(|step| *step >= least_s)
        .unwrap_or(86_400.0 * (least_s / 86_400.0).ceil().max(1.0))
}

/// A series as a filled body with its low-to-high band on the edge, hanging from the top or standing on the bottom.
fn band(ui: &Ui, rect: Rect, columns: &Columns, reach: f32, hanging: bool, colour: Color32) {
    if reach <= 0.0 {
        return;
    }
    let y_of = |value: f32| {
        let share = (value / reach).clamp(0.0, 1.0);
        if hanging {
            rect.top() + share * rect.height()
        } else {
            rect.bottom() - share * rect.height()
        }
    };
    let base = if hanging { rect.top() } else { rect.bottom() };
    let body = colour.gamma_multiply(0.35);
    let mut mesh = Mesh::default();
    // One strip a screen point, each with the extremes of all columns under it.
    let count = rect.width().round().max(1.0) as usize;
    for (index, column) in resampled(columns, count).enumerate() {
        let Some([low, high]) = column else {
            continue;
        };
        let left = rect.left().round() + index as f32;
        let x = left..=left + 1.0;
        let (near, far) = (y_of(low), y_of(high));
        mesh.add_colored_rect(Rect::from_x_y_ranges(x.clone(), sorted(base, far)), body);
        let edge = sorted(near, far);
        let edge = *edge.start() - 0.75..=*edge.end() + 0.75;
        mesh.add_colored_rect(Rect::from_x_y_ranges(x, edge), colour);
    }
    ui.painter().add(mesh);
}

fn sorted(a: f32, b: f32) -> std::ops::RangeInclusive<f32> {
    a.min(b)..=a.max(b)
}

#[cfg(test)]
mod tests {
    use super::tick_step_s;

    #[test]
    fn ticks_are_round_and_never_too_close() {
        assert_eq!(tick_step_s(0.3), 1.0);
        assert_eq!(tick_step_s(12.0), 30.0);
        assert_eq!(tick_step_s(4000.0), 7200.0);
        assert_eq!(tick_step_s(100_000.0), 172_800.0);
    }
}
