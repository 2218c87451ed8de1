//! Draws the outline of a box: its state is shown by colour and line style.

use crate::ui::theme;
use bathyscope_objects::review::State;
use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, vec2};

/// Shorter side on the screen below which a box is drawn plainly, points.
const PLAIN: f32 = 8.0;
/// Half of the side of a handle, points.
const HANDLE: f32 = 3.0;
/// Radius of the ring of a point, points.
const POINT: f32 = 6.0;

/// Colour under lines, so that they are visible on any picture.
pub(crate) const RIM: Color32 = Color32::from_black_alpha(120);

/// Style of the line of a box.
#[derive(Clone, Copy, PartialEq)]
enum Line {
    /// Proposed box.
    Dashed,
    /// Accepted box.
    Solid,
    /// Rejected box, crossed out.
    Crossed,
    /// Box added by hand: corners only.
    Corners,
    /// Missed object, which no box has found.
    Dotted,
}

/// Colour and line style of a state.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    pub colour: Color32,
    line: Line,
}

impl Style {
    pub(crate) fn of(state: State) -> Self {
        let line = match state {
            State::Proposed => Line::Dashed,
            State::Accepted => Line::Solid,
            State::Rejected => Line::Crossed,
            State::Added => Line::Corners,
        };
        Self { colour: theme::box_colour(state), line }
    }

    /// Returns the style of an object that no box has found.
    pub(crate) fn missed() -> Self {
        Self { colour: theme::MISSED_COLOUR, line: Line::Dotted }
    }
}

/// Draws an outline over a dark rim that keeps it readable on any picture.
pub(crate) fn draw(painter: &Painter, rect: Rect, style: Style, is_selected: bool) {
    let width = if is_selected { 2.0 } else { 1.25 };
    let stroke = Stroke::new(width, style.colour);
    let rim = Stroke::new(width + 2.0, RIM);
    if is_selected {
        let halo = Stroke::new(2.0, theme::SELECTION_COLOUR);
        painter.rect_stroke(rect.expand(4.0), 3.0, halo, StrokeKind::Outside);
    }
    if rect.size().min_elem() < PLAIN {
        match style.line {
            // Without an outline around the cross: a small box has no room for both, and the cross
            // distinguishes it from the other states.
            Line::Crossed => cross(painter, rect.expand2(room(rect)), style.colour),
            _ => {
                painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Middle);
            }
        }
        return;
    }
    if style.line == Line::Corners {
        for line in corners(rect) {
            painter.add(Shape::line(line.to_vec(), rim));
            painter.add(Shape::line(line.to_vec(), stroke));
        }
        return;
    }
    painter.rect_stroke(rect, 0.0, rim, StrokeKind::Middle);
    match style.line {
        Line::Dashed => {
            painter.extend(Shape::dashed_line(&outline(rect), stroke, 6.0, 4.0));
        }
        Line::Dotted => {
            painter.extend(Shape::dashed_line(&outline(rect), stroke, 2.0, 3.0));
        }
        Line::Crossed => {
            painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Middle);
            cross(painter, rect, style.colour);
        }
        Line::Solid | Line::Corners => {
            painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Middle);
        }
    }
}

/// Draws both diagonals, over the same dark rim as an outline.
fn cross(painter: &Painter, rect: Rect, colour: Color32) {
    let [a, b, c, d, _] = outline(rect);
    for diagonal in [[a, c], [b, d]] {
        painter.line_segment(diagonal, Stroke::new(3.0, RIM));
        painter.line_segment(diagonal, Stroke::new(1.0, colour));
    }
}

/// Returns the margin by which a small box is enlarged at each edge so that a cross in it is
/// visible.
fn room(rect: Rect) -> egui::Vec2 {
    (0.5 * (vec2(PLAIN, PLAIN) - rect.size())).max(egui::Vec2::ZERO)
}

/// Draws a place without size: a ring with a dot, of the same size at any scale.
pub(crate) fn point(painter: &Painter, at: Pos2, style: Style, is_selected: bool) {
    let rim = Stroke::new(4.0, RIM);
    let stroke = Stroke::new(1.5, style.colour);
    for stroke in [rim, stroke] {
        painter.circle_stroke(at, POINT, stroke);
    }
    painter.circle_filled(at, 1.5, style.colour);
    if style.line == Line::Crossed {
        let rect = Rect::from_center_size(at, egui::Vec2::splat(2.0 * POINT));
        cross(painter, rect, style.colour);
    }
    if is_selected {
        let halo = Stroke::new(2.0, theme::SELECTION_COLOUR);
        painter.circle_stroke(at, POINT + 5.0, halo);
    }
}

/// Draws the line between echo and shadow, with a handle in its middle while it can be dragged.
pub(crate) fn border(painter: &Painter, line: [Pos2; 2], colour: Color32, has_handle: bool) {
    painter.line_segment(line, Stroke::new(3.0, RIM));
    let stroke = Stroke::new(1.5, colour);
    painter.extend(Shape::dashed_line(&line, stroke, 4.0, 3.0));
    if has_handle {
        handle(painter, line[0].lerp(line[1], 0.5), colour);
    }
}

/// Draws the edge that the arrow keys move.
pub(crate) fn held(painter: &Painter, line: [Pos2; 2]) {
    painter.line_segment(line, Stroke::new(3.0, theme::SELECTION_COLOUR));
}

/// Draws squares at the corners and in the middle of the edges.
pub(crate) fn handles(painter: &Painter, rect: Rect, colour: Color32) {
    // In a small box, handles on the edges would hide the box.
    let is_small = rect.size().min_elem() < 10.0 * HANDLE;
    for across in [0.0, 0.5, 1.0] {
        for down in [0.0, 0.5, 1.0] {
            let is_middle = across == 0.5 || down == 0.5;
            if is_middle && (is_small || across == down) {
                continue;
            }
            let at = rect.lerp_inside(vec2(across, down));
            handle(painter, at, colour);
        }
    }
}

fn handle(painter: &Painter, at: Pos2, colour: Color32) {
    let square = Rect::from_center_size(at, egui::Vec2::splat(2.0 * HANDLE));
    painter.rect_filled(square, 0.0, colour);
    let edge = Stroke::new(1.0, Color32::BLACK);
    painter.rect_stroke(square, 0.0, edge, StrokeKind::Outside);
}

/// Returns the corners in order, ending with the first one again.
fn outline(rect: Rect) -> [Pos2; 5] {
    let start = rect.left_top();
    [start, rect.right_top(), rect.right_bottom(), rect.left_bottom(), start]
}

fn corners(rect: Rect) -> [[Pos2; 3]; 4] {
    let arm = (0.3 * rect.size().min_elem()).max(4.0);
    let inward = [
        (rect.left_top(), vec2(1.0, 1.0)),
        (rect.right_top(), vec2(-1.0, 1.0)),
        (rect.right_bottom(), vec2(-1.0, -1.0)),
        (rect.left_bottom(), vec2(1.0, -1.0)),
    ];
    inward.map(|(corner, to)| {
        [corner + vec2(arm * to.x, 0.0), corner, corner + vec2(0.0, arm * to.y)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Context, LayerId, RawInput, pos2};

    /// Returns how many rectangles and how many lines a box is drawn with.
    fn drawn(state: State, size: f32) -> [usize; 2] {
        let rect = Rect::from_min_size(pos2(100.0, 100.0), vec2(size, size));
        let ctx = Context::default();
        let output = ctx.run_ui(RawInput::default(), |ui| {
            let painter = ui.ctx().layer_painter(LayerId::background());
            draw(&painter, rect, Style::of(state), false);
        });
        let count = |is: fn(&Shape) -> bool| {
            let shapes = output.shapes.iter().map(|clipped| &clipped.shape);
            shapes.filter(|shape| is(shape)).count()
        };
        [
            count(|shape| matches!(shape, Shape::Rect(_))),
            count(|shape| matches!(shape, Shape::LineSegment { .. })),
        ]
    }

    #[test]
    fn a_rejected_box_is_crossed_out_however_small() {
        for size in [3.0, 40.0] {
            let [_, lines] = drawn(State::Rejected, size);
            assert!(lines >= 2, "{size}: {lines} lines");
            assert_eq!(drawn(State::Accepted, size)[1], 0, "{size}");
        }
        assert_eq!(drawn(State::Rejected, 3.0)[0], 0, "a frame would hide it");
    }
}
