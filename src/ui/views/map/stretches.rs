//! Draws stretches of the tracks: the excluded ones; the ranked flat ones with their numbers; the
//! one that the calibration was measured on; and the proposed one. Implements the tools that are
//! dragged along a track: one excludes pings, one proposes them for the scale.

use super::MapScene;
use super::track::TrackLayer;
use super::transform::MapTransform;
use crate::app::{App, LogId, MapLayer, OpenLog, Tool};
use crate::ui::views::legend;
use crate::ui::views::tool::{self, Does};
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::calibration::FlatSpot;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{LogPart, PingNav};
use egui::{
    Align2, Color32, CursorIcon, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, Vec2, vec2,
};
use std::ops::Range;

/// Greatest distance of the pointer from the track, points.
pub(super) const REACH: f32 = 30.0;

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
            && !is_calibrating
        {
            place::include_again(context, log, ping);
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
        let Some((survey, products)) = log.results() else {
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
pub(super) fn paint_excluded(painter: &Painter, scene: &MapScene<'_>, app: &App) {
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
    let found = log.results().zip(log.exclusions()).into_iter();
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

/// Radius of a number's plate, points.
const BADGE: f32 = 8.5;
/// Number of places drawn along a stretch.
const MOST_FLAT_PLACES: usize = 48;
/// Least distance between two drawn places of a stretch on the screen, points.
const LEAST_STEP: f32 = 2.0;

/// Positions of a stretch's name relative to its middle, best first; the number of the stretch is
/// above the name.
const SIDES: [(Vec2, Align2); 4] = [
    (vec2(10.0, 6.0), Align2::LEFT_TOP),
    (vec2(-10.0, 6.0), Align2::RIGHT_TOP),
    (vec2(10.0, -26.0), Align2::LEFT_BOTTOM),
    (vec2(-10.0, -26.0), Align2::RIGHT_BOTTOM),
];

/// Draws the stretches.
pub(super) fn paint_flat(painter: &Painter, scene: &MapScene<'_>) {
    if scene.shows_flat_stretches {
        let colour = theme::flat_spot_colour(scene.options);
        for (rank, spot) in scene.products.flat_spots.iter().enumerate() {
            stretch(painter, scene, &spot.pings, colour);
            badge(painter, scene, spot, &(rank + 1).to_string());
        }
    }
    if let Some(spot) = measured(scene) {
        stretch(painter, scene, &spot.pings, theme::CALIBRATION_COLOUR);
    }
    if let Some(pings) = scene.proposed {
        let pings = pings.start..pings.end;
        stretch(painter, scene, &pings, theme::PROPOSAL_COLOUR);
    }
}

/// Returns the stretch that the calibration was measured on, if it is drawn.
fn measured<'a>(scene: &'a MapScene<'_>) -> Option<&'a FlatSpot> {
    let calibration = &scene.products.calibration;
    let is_shown = scene.options.shows_measured_stretch(calibration.mode);
    calibration.flat_spot.as_ref().filter(|_| is_shown)
}

/// Names the stretch that the calibration was measured on, beside it where nothing else is drawn.
/// If there is no such place, only the colour marks the stretch.
pub(super) fn name_calibrated(painter: &Painter, scene: &MapScene<'_>, covered: &[Rect]) {
    let Some(spot) = measured(scene) else {
        return;
    };
    let Some(middle) = middle(scene, &spot.pings).filter(|_| legend::has_room(scene.rect)) else {
        return;
    };
    let text = place::calibrated_name(scene.products.calibration.mode);
    let colour = theme::CALIBRATION_COLOUR;
    let size = legend::plate_size(painter, text);
    let plate_at = |(offset, anchor): (Vec2, Align2)| anchor.anchor_size(middle + offset, size);
    let free = SIDES.into_iter().filter(|side| {
        let plate = plate_at(*side);
        scene.rect.contains_rect(plate) && !covered.iter().any(|other| other.intersects(plate))
    });
    if let Some((offset, anchor)) = free.min_by_key(|side| badges_under(scene, plate_at(*side))) {
        let at = middle + offset;
        legend::plate(painter, scene.options, at, anchor, text, colour);
    }
}

fn badges_under(scene: &MapScene<'_>, plate: Rect) -> usize {
    if !scene.shows_flat_stretches {
        return 0;
    }
    let badges = scene.products.flat_spots.iter();
    badges
        .filter_map(|spot| badge_at(scene, &spot.pings))
        .filter(|at| plate.expand(BADGE).contains(*at))
        .count()
}

/// Returns the stretch whose number is under the pointer, with its index by rank.
pub(super) fn under<'a>(scene: &'a MapScene<'_>, pointer: Pos2) -> Option<(usize, &'a FlatSpot)> {
    if !scene.shows_flat_stretches {
        return None;
    }
    scene.products.flat_spots.iter().enumerate().find(|(_, spot)| {
        badge_at(scene, &spot.pings).is_some_and(|at| at.distance(pointer) <= BADGE + 2.0)
    })
}

/// Describes a stretch in a few lines.
pub(super) fn describe(rank: usize, spot: &FlatSpot, units: Units) -> String {
    let number = rank + 1;
    let spot = units.sentence(&spot.summary());
    format!("flat stretch {number}: {spot}")
}

fn flat_places(scene: &MapScene<'_>, pings: &Range<usize>) -> Vec<Pos2> {
    let navigation = &scene.products.navigation.pings;
    let end = pings.end.min(navigation.len());
    let start = pings.start.min(end);
    let step = ((end - start) / MOST_FLAT_PLACES).max(1);
    let along = navigation[start..end].iter().step_by(step);
    let known = along.filter(|ping| ping.east_m.is_finite() && ping.north_m.is_finite());
    let places = known.map(|ping| scene.at([ping.east_m, ping.north_m]));
    let mut line: Vec<Pos2> = Vec::new();
    for place in places {
        // Nearer places show nothing more.
        if line.last().is_none_or(|last| last.distance(place) >= LEAST_STEP) {
            line.push(place);
        }
    }
    line
}

fn stretch(painter: &Painter, scene: &MapScene<'_>, pings: &Range<usize>, colour: Color32) {
    let line = flat_places(scene, pings);
    // Wide and faint, so that the track's own colour stays readable under it.
    let [halo, core] = [9.0, 1.2];
    let faint = Stroke::new(halo, colour.gamma_multiply(0.3));
    painter.add(Shape::line(line.clone(), faint));
    painter.add(Shape::line(line, Stroke::new(core, colour)));
}

fn middle(scene: &MapScene<'_>, pings: &Range<usize>) -> Option<Pos2> {
    let line = flat_places(scene, pings);
    line.get(line.len() / 2).copied()
}

/// Returns the place of a stretch's number: beside the middle of the stretch, not on it.
fn badge_at(scene: &MapScene<'_>, pings: &Range<usize>) -> Option<Pos2> {
    Some(middle(scene, pings)? + vec2(0.0, -BADGE - 7.0))
}

fn badge(painter: &Painter, scene: &MapScene<'_>, spot: &FlatSpot, number: &str) {
    let Some(at) = badge_at(scene, &spot.pings) else {
        return;
    };
    let plate = theme::flat_spot_colour(scene.options);
    painter.circle_filled(at, BADGE, plate);
    let ink = theme::canvas_colour(scene.options);
    painter.text(at, Align2::CENTER_CENTER, number, legend::font(), ink);
}
