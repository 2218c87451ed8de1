//! Implements the tools that are dragged along a track: one excludes pings, one proposes them for
//! the scale. Draws the excluded stretches of the tracks.

use super::MapScene;
use super::pointer::REACH;
use super::track::TrackLayer;
use super::transform::MapTransform;
use crate::app::{App, Command, ExclusionEdit, LogId, MapLayer, OpenLog, Tool};
use crate::ui::views::legend;
use crate::ui::views::tool::{self, Does};
use crate::ui::{ViewContext, theme};
use bathyscope_log::survey::{LogPart, PingNav};
use egui::{Align2, CursorIcon, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, vec2};

/// State of both tools; `None` while there is no drag.
#[derive(Default)]
pub(super) struct StretchTool {
    drag: Option<Drag>,
}

struct Drag {
    log: LogId,
    /// Ping where the drag began, and ping where it is now.
    ends: [usize; 2],
    does: Does,
}

impl Drag {
    fn pings(&self) -> [usize; 2] {
        let [one, other] = self.ends;
        [one.min(other), one.max(other)]
    }
}

/// Area of the map on the screen, and its transform.
type MapPosition = (Rect, MapTransform);

impl StretchTool {
    /// Handles a drag or a click with the selected tool; returns true if the drag must not move the
    /// map. Beside the tracks, with the middle button or with Space held, a drag moves the map with
    /// any tool.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        (rect, transform): MapPosition,
        track: &TrackLayer,
        context: &mut ViewContext<'_>,
    ) -> bool {
        if !is_in_hand(context.app) {
            self.drag = None;
            return false;
        }
        let is_calibrating = context.app.logs.shown.reviewing.tool == Tool::Calibrate;
        let shown = context.app.logs.shown.id;
        let ground = |at: Pos2| transform.to_ground(rect, at);
        let reach_m = f64::from(REACH) * transform.metres_per_point;
        // Only the log in the panels has a scale to propose.
        let under = |at: Pos2| {
            let near = track.nearest_ping(ground(at), reach_m, shown);
            near.filter(|(log, _)| !is_calibrating || *log == shown)
        };
        if response.hover_pos().and_then(under).is_some() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        if let Some((log, ping)) = tool::begun(ui, response).and_then(under) {
            let edit = tool::exclusion_edit(ui.input(|input| input.modifiers));
            let does = if is_calibrating { Does::Propose } else { Does::Exclusion(edit) };
            let ends = [ping, ping];
            self.drag = Some(Drag { log, ends, does });
        }
        let clicked = response.clicked().then(|| response.interact_pointer_pos());
        if let Some((log, ping)) = clicked.flatten().and_then(under)
            && let Some(stretch) = context.app.logs.excluded_at(log, ping)
            && !is_calibrating
        {
            let (part, edit) = (stretch.part(), ExclusionEdit::Include);
            context.push(Command::Exclude { log, part, edit });
        }
        if tool::is_given_up(ui, response) {
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
            context.push(drag.does.command(drag.log, drag.pings()));
        }
        true
    }

    /// Draws the drag in progress, and describes the stretch that it covers.
    pub(super) fn draw(&self, painter: &Painter, scene: &MapScene<'_>, app: &App) {
        let Some((drag, log)) =
            (self.drag.as_ref()).and_then(|drag| Some((drag, app.logs.get(drag.log)?)))
        else {
            return;
        };
        let Some((survey, products)) = log.survey.as_ref().zip(log.products.as_ref()) else {
            return;
        };
        let sailed = LogPart::Pings(drag.pings()).places(survey, &products.navigation);
        let line = places(scene, sailed);
        let last = line.last().copied();
        let stroke = Stroke::new(CASING, drag.does.colour());
        painter.add(Shape::line(line, stroke));
        if let Some((at, text)) = last.zip(drag.does.words(app, drag.log, drag.pings())) {
            let at = at + vec2(14.0, 14.0);
            legend::words(painter, scene.options, at, Align2::LEFT_TOP, &text);
        }
    }
}

/// Returns true if one of the tools is selected.
pub(super) fn is_in_hand(app: &App) -> bool {
    matches!(app.logs.shown.reviewing.tool, Tool::Exclude | Tool::Calibrate)
}

/// Largest number of places drawn along a stretch: enough for its bends at any scale that shows it
/// whole.
const MOST_PLACES: usize = 512;
/// Width of the line that hides the track's own colour under the dashes, points: the width of the
/// track's casing.
const CASING: f32 = 4.6;
/// Width of the dashes, points.
const WIDTH: f32 = 1.8;
/// Length of the dashes and of the gaps between them, points.
const DASH: f32 = 3.0;

/// Draws the excluded stretches of all visible logs as fine grey dashes over their tracks.
pub(super) fn paint(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    if !scene.shows(MapLayer::Track) {
        return;
    }
    let casing = Stroke::new(CASING, theme::canvas_colour(scene.options));
    let dashes = Stroke::new(WIDTH, theme::excluded_colour(scene.options));
    for log in app.logs.visible() {
        for sailed in stretches(log) {
            stroke(painter, &places(scene, sailed), casing, dashes);
        }
    }
}

/// Returns the places of the boat in the excluded stretches of a log.
fn stretches(log: &OpenLog) -> impl Iterator<Item = &[PingNav]> {
    let found = log.survey.as_ref().zip(log.products.as_ref());
    let found = found.zip(log.exclusions()).into_iter();
    found.flat_map(|((survey, products), found)| {
        let stretches = found.exclusions.stretches.iter();
        stretches.map(|stretch| stretch.part().places(survey, &products.navigation))
    })
}

/// Returns the number of excluded side-scan pings of all visible logs.
pub(super) fn ping_count(app: &App) -> usize {
    let found = app.logs.visible().filter_map(OpenLog::exclusions);
    found.map(|found| found.exclusions.ping_count()).sum()
}

/// Returns places of the boat on the screen, at most about [`MOST_PLACES`].
fn places(scene: &MapScene<'_>, pings: &[PingNav]) -> Vec<Pos2> {
    let step = pings.len().div_ceil(MOST_PLACES).max(1);
    let last = pings.last();
    let shown = pings.iter().step_by(step).chain(last);
    let is_placed = |ping: &&PingNav| (ping.east_m + ping.north_m).is_finite();
    shown.filter(is_placed).map(|ping| scene.at([ping.east_m, ping.north_m])).collect()
}

/// Draws the visible parts of a line: dashes far outside of the view would cost as much as those
/// inside.
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
