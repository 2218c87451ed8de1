//! Draws objects on the map: a mark by state for each box, and the footprint where it is large
//! enough.

use super::MapScene;
use crate::app::{App, LocatedObject, LogBox, MapLayer, OpenLog};
use crate::ui::theme;
use crate::ui::views::legend;
use bathyscope_objects::review::{Reviewed, State};
use egui::{Align2, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, vec2};
use std::sync::Arc;

/// Half of the size of a mark, points.
const HALF: f32 = 4.5;
/// Greatest distance of a click from a mark, points.
const REACH: f32 = 8.0;
/// Least longer side of a footprint on the screen that is drawn, points.
const FOOTPRINT: f32 = 12.0;

/// Returns the visible boxes in the queues of all visible logs, with their place. Those of the log
/// in the panels are last, and the selected box is at the end.
fn placed<'a>(scene: &MapScene<'_>, app: &'a App) -> impl Iterator<Item = Seen<'a>> {
    let (rect, transform) = (scene.rect.expand(2.0 * HALF), scene.transform);
    let frame = scene.rect;
    let own = app.logs.visible().filter(|log| log.id == app.logs.shown.id);
    let others = app.logs.visible().filter(|log| log.id != app.logs.shown.id);
    let logs = others.chain(own);
    logs.flat_map(move |log| {
        let reviewing = &log.reviewing;
        let others = reviewing.in_line();
        let others = others.filter(|review_box| Some(review_box.id) != reviewing.selected);
        let all = others.chain(reviewing.selected_box());
        all.filter_map(move |review_box| {
            let placed = reviewing.placed(review_box.id)?;
            let at = transform.to_screen(frame, [placed.target.east_m, placed.target.north_m]);
            rect.contains(at).then_some(Seen { log, review_box, placed, at })
        })
    })
}

/// A box on the map.
struct Seen<'a> {
    log: &'a OpenLog,
    review_box: &'a Reviewed,
    placed: &'a Arc<LocatedObject>,
    /// Middle of the box on the screen.
    at: Pos2,
}

/// Draws the boxes, and lines from the place of the selected object to the boxes that show it.
pub(super) fn paint(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    sightings(painter, scene, app);
    for seen in placed(scene, app) {
        let Seen { log, review_box, placed, at } = seen;
        let is_selected =
            log.id == app.logs.shown.id && Some(review_box.id) == log.reviewing.selected;
        let colour = theme::box_colour_on_panel(scene.options.theme, review_box.state);
        let footprint = placed.corners.map(|corner| scene.at(corner));
        if Rect::from_points(&footprint).size().max_elem() >= FOOTPRINT {
            let stroke = Stroke::new(1.0, colour);
            match review_box.state {
                State::Rejected => {
                    let [a, b, c, d] = footprint;
                    painter.extend(Shape::dashed_line(&[a, b, c, d, a], stroke, 4.0, 4.0));
                }
                _ => {
                    painter.add(Shape::closed_line(footprint.to_vec(), stroke));
                }
            }
        }
        mark(painter, at, review_box.state, colour);
        if is_selected {
            let ring = Stroke::new(2.0, theme::SELECTION_COLOUR);
            painter.circle_stroke(at, HALF + 4.0, ring);
            let sigma = (placed.target.sigma_m / scene.transform.metres_per_point) as f32;
            if sigma > HALF + 4.0 && sigma.is_finite() {
                let faint = Stroke::new(1.0, theme::SELECTION_COLOUR.gamma_multiply(0.6));
                painter.circle_stroke(at, sigma, faint);
            }
            let name = log.reviewing.review.class_name(review_box.class);
            let corner = at + vec2(HALF + 8.0, 0.0);
            let (options, beside) = (scene.options, Align2::LEFT_CENTER);
            legend::plate(painter, options, corner, beside, name, colour);
        }
    }
}

/// Joins the place of the selected object with the places of its boxes, if it has more than one.
fn sightings(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    let Some(object) = app.selected_object().filter(|object| object.boxes.len() > 1) else {
        return;
    };
    let middle = scene.at(object.place_m);
    let stroke = Stroke::new(1.0, theme::SELECTION_COLOUR);
    for id in &object.boxes {
        let placed = app.logs.get(id.log);
        if let Some(placed) = placed.and_then(|log| log.reviewing.placed(id.id)) {
            let at = scene.at([placed.target.east_m, placed.target.north_m]);
            painter.line_segment([middle, at], stroke);
        }
    }
}

/// Draws a ring for a proposed box, a disc for an accepted one, a square for one drawn by hand, a
/// cross for a rejected one.
fn mark(painter: &Painter, at: Pos2, state: State, colour: egui::Color32) {
    let stroke = Stroke::new(1.5, colour);
    let rim = Stroke::new(3.5, egui::Color32::from_black_alpha(120));
    match state {
        State::Proposed => {
            painter.circle_stroke(at, HALF, rim);
            painter.circle_stroke(at, HALF, stroke);
        }
        State::Accepted => {
            painter.circle(at, HALF, colour, Stroke::new(1.0, egui::Color32::BLACK));
        }
        State::Added => {
            let square = Rect::from_center_size(at, egui::Vec2::splat(2.0 * HALF));
            painter.rect_filled(square, 0.0, colour);
            let edge = Stroke::new(1.0, egui::Color32::BLACK);
            painter.rect_stroke(square, 0.0, edge, StrokeKind::Outside);
        }
        State::Rejected => {
            for across in [vec2(HALF, HALF), vec2(HALF, -HALF)] {
                let small = 0.7 * across;
                painter.line_segment([at - small, at + small], stroke);
            }
        }
    }
}

/// Returns the box whose mark is under the pointer, with its log.
pub(super) fn under(scene: &MapScene<'_>, app: &App, at: Pos2) -> Option<LogBox> {
    if !scene.shows(MapLayer::Boxes) {
        return None;
    }
    placed(scene, app)
        .map(|seen| (seen.at.distance(at), seen))
        .filter(|(distance, _)| *distance <= REACH)
        .min_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, seen)| LogBox { log: seen.log.id, id: seen.review_box.id })
}
