//! The left-out stretches of the tracks, and the tool that leaves them out: pressed on a track, dragged along it.

use super::layers::TrackLayer;
use super::overlay::Scene;
use super::pointer::REACH;
use super::transform::MapTransform;
use crate::app::{App, Command, Leave, LogId, MapLayer, OpenLog, Tool};
use crate::survey::{LogPart, PingNav};
use crate::ui::views::drag;
use crate::ui::{ViewContext, left_out_words, theme};
use egui::{CursorIcon, Painter, Pos2, Rect, Response, Shape};
use egui::{Stroke, Ui, vec2};

/// Places drawn along a stretch: enough for its bends at any scale that shows it whole.
const MOST_PLACES: usize = 512;
/// Width of what hides the track's own colour under the dashes, points: the track's casing.
const CASING: f32 = 4.6;
/// Width of the dashes, points.
const WIDTH: f32 = 1.8;
/// Length of the dashes and of the room between them, points.
const DASH: f32 = 3.0;

/// The drag under way.
#[derive(Default)]
pub struct LeaveOutTool {
    drag: Option<Drag>,
}

struct Drag {
    log: LogId,
    /// Pings where it began and where it is.
    ends: [usize; 2],
    leave: Leave,
}

impl Drag {
    fn part(&self) -> LogPart {
        let [one, other] = self.ends;
        LogPart::Pings([one.min(other), one.max(other)])
    }
}

/// Where the map lies on the screen.
type View = (Rect, MapTransform);

impl LeaveOutTool {
    /// Follows a drag or a click with the tool in hand; returns whether a drag must not move the map. Beside the tracks, with the
    /// middle button or with Space held, it moves the map in any tool.
    pub fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        (rect, transform): View,
        track: &TrackLayer,
        context: &mut ViewContext<'_>,
    ) -> bool {
        if !is_in_hand(context.app) {
            self.drag = None;
            return false;
        }
        let ground = |at: Pos2| transform.to_ground(rect, at);
        let reach_m = f64::from(REACH) * transform.metres_per_point;
        let under = |at: Pos2| track.nearest_ping(ground(at), reach_m, context.app.log.id);
        if response.hover_pos().and_then(under).is_some() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        if let Some((log, ping)) = drag::begun(ui, response).and_then(under) {
            self.drag = Some(Drag {
                log,
                ends: [ping, ping],
                leave: drag::leave_by(ui.input(|input| input.modifiers)),
            });
        }
        let clicked = response.clicked().then(|| response.interact_pointer_pos());
        if let Some((log, ping)) = clicked.flatten().and_then(under)
            && let Some(stretch) = context.app.left_out_at(log, ping)
        {
            let (part, leave) = (stretch.part(), Leave::In);
            context.push(Command::LeaveOut { log, part, leave });
        }
        if drag::is_given_up(ui, response) {
            self.drag = None;
        }
        let Some(drag) = &mut self.drag else {
            return false;
        };
        let at = response.interact_pointer_pos().or(response.hover_pos());
        if let Some(ping) = at.and_then(|at| track.ping_of(drag.log, ground(at))) {
            drag.ends[1] = ping;
        }
        if response.drag_stopped()
            && let Some(drag) = self.drag.take()
        {
            let (log, part, leave) = (drag.log, drag.part(), drag.leave);
            context.push(Command::LeaveOut { log, part, leave });
        }
        true
    }

    /// Draws the drag under way, with what it covers.
    pub fn draw(&self, painter: &Painter, scene: &Scene<'_>, app: &App) {
        let Some((drag, log)) =
            (self.drag.as_ref()).and_then(|drag| Some((drag, app.open_log(drag.log)?)))
        else {
            return;
        };
        let Some((survey, products)) = log.survey.as_ref().zip(log.products.as_ref()) else {
            return;
        };
        let sailed = drag.part().places(survey, &products.navigation);
        let line = places(scene, sailed);
        let last = line.last().copied();
        let stroke = Stroke::new(CASING, theme::hand_colour());
        painter.add(Shape::line(line, stroke));
        if let Some((at, extent)) = last.zip(app.extent_of(drag.log, drag.part())) {
            let text = left_out_words::of_drag(drag.leave, &extent, app.options.units);
            let (at, ink) = (at + vec2(14.0, 14.0), scene.text_colour());
            let anchor = egui::Align2::LEFT_TOP;
            crate::ui::views::legend::plate(painter, scene.options, at, anchor, &text, ink);
        }
    }
}

/// Whether the tool is in hand, on any of the open logs' tracks.
pub fn is_in_hand(app: &App) -> bool {
    app.log.reviewing.tool == Tool::LeaveOut
}

/// Draws the left-out stretches of all visible logs as fine grey dashes over their tracks.
pub fn paint(painter: &Painter, scene: &Scene<'_>, app: &App) {
    if !scene.shows(MapLayer::Track) {
        return;
    }
    let casing = Stroke::new(CASING, theme::canvas_colour(scene.options));
    let dashes = Stroke::new(WIDTH, theme::left_out_colour(scene.options));
    for log in app.visible_logs() {
        for sailed in stretches(log) {
            stroke(painter, &places(scene, sailed), casing, dashes);
        }
    }
}

/// Where the boat was in the left-out stretches of a log.
fn stretches(log: &OpenLog) -> impl Iterator<Item = &[PingNav]> {
    let found = log.survey.as_ref().zip(log.products.as_ref());
    let found = found.zip(log.left_out()).into_iter();
    found.flat_map(|((survey, products), found)| {
        let stretches = found.left_out.stretches.iter();
        stretches.map(|stretch| stretch.part().places(survey, &products.navigation))
    })
}

/// Side-scan pings of all visible logs that are left out.
pub fn ping_count(app: &App) -> usize {
    let found = app.visible_logs().filter_map(OpenLog::left_out);
    found.map(|found| found.left_out.ping_count()).sum()
}

/// Where the boat's places lie on the screen.
fn places(scene: &Scene<'_>, pings: &[PingNav]) -> Vec<Pos2> {
    let step = pings.len().div_ceil(MOST_PLACES).max(1);
    let last = pings.last();
    let shown = pings.iter().step_by(step).chain(last);
    let is_placed = |ping: &&PingNav| (ping.east_m + ping.north_m).is_finite();
    shown
        .filter(is_placed)
        .map(|ping| scene.at([ping.east_m, ping.north_m]))
        .collect()
}

/// Draws the parts of a line that are in view: dashes far outside of it would cost as much as those inside.
fn stroke(painter: &Painter, line: &[Pos2], casing: Stroke, dashes: Stroke) {
    let view = painter.clip_rect().expand(CASING);
    let is_seen = |pair: &[Pos2]| Rect::from_two_pos(pair[0], pair[1]).intersects(view);
    let mut seen: Vec<Pos2> = Vec::new();
    let flush = |seen: &mut Vec<Pos2>| {
        let line = std::mem::take(seen);
        if line.len() > 1 {
            painter.add(Shape::line(line.clone(), casing));
            painter.extend(Shape::dashed_line(&line, dashes, DASH, DASH));
        }
    };
    for pair in line.windows(2) {
        match is_seen(pair) {
            true if seen.is_empty() => seen.extend(pair),
            true => seen.push(pair[1]),
            false => flush(&mut seen),
        }
    }
    flush(&mut seen);
}
