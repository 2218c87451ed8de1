//! Draws the excluded stretches of the tracks.

use super::scene::MapScene;
use crate::app::{App, MapLayer, OpenLog};
use crate::ui::theme;
use bathyscope_log::survey::PingNav;
use egui::{Painter, Pos2, Rect, Shape, Stroke};

/// Largest number of places drawn along a stretch: enough for its bends at any scale that shows it
/// whole.
const MOST_PLACES: usize = 512;
/// Width of the line that hides the track's own colour under the dashes, points: the width of the
/// track's casing.
pub(super) const CASING: f32 = 4.6;
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
pub(super) fn places(scene: &MapScene<'_>, pings: &[PingNav]) -> Vec<Pos2> {
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
