//! Draws the box around the cloud, with lengths on its edges.

use super::scene::ShownPoints;
use crate::app::ViewOptions;
use crate::ui::render::{CameraProjection, ScenePart};
use crate::ui::theme;
use crate::ui::views::{legend, ticks};
use egui::{Align2, Color32, Painter, Pos2, Rect, Shape, Stroke, Vec2, vec2};
use glam::Vec3;

/// Least distance between labels, points; closer labels are left out. First along a horizontal
/// edge, then along a vertical one.
const LABEL_SPACING: [f32; 2] = [44.0, 16.0];

/// The box with its axes, and the camera that shows it.
pub(super) struct BoxAxes<'a> {
    pub rect: Rect,
    pub projection: CameraProjection,
    /// Corners, metres from the origin.
    pub corners: [Vec3; 2],
    /// Metres of the survey at the scene's zero.
    pub origin_m: [f64; 3],
    pub options: &'a ViewOptions,
    /// The part of the scene that is drawn.
    pub part: ScenePart,
}

/// A side of the box: the axis perpendicular to it, and whether it is the higher one of the two.
type Face = (usize, bool);
/// An edge of the box: the axis that it runs along, and the two faces that meet in it.
type Edge = (usize, Face, Face);

/// Returns the faces whose inner side is visible: the walls behind the cloud.
fn walls(corners: [Vec3; 2], eye: Vec3) -> Vec<Face> {
    let mut walls = Vec::new();
    for axis in 0..3 {
        if eye[axis] > corners[0][axis] {
            walls.push((axis, false));
        }
        if eye[axis] < corners[1][axis] {
            walls.push((axis, true));
        }
    }
    walls
}

/// Returns the edges along an axis where a wall ends: labels beside these are not crossed by the
/// box.
fn outline(axis: usize, walls: &[Face]) -> Vec<Edge> {
    let [a, b] = others(axis);
    let sides = [(false, false), (false, true), (true, false), (true, true)];
    let edges = sides.map(|(of_a, of_b)| (axis, (a, of_a), (b, of_b)));
    edges.into_iter().filter(|(_, a, b)| walls.contains(a) != walls.contains(b)).collect()
}

/// Writes a text unless it would overlap a covered area.
fn write_atomically_at(
    painter: &Painter,
    covered: &[Rect],
    at: Pos2,
    anchor: Align2,
    text: String,
    colour: Color32,
) {
    let galley = painter.layout_no_wrap(text, legend::font(), colour);
    let rect = anchor.anchor_size(at, galley.size());
    if !covered.iter().any(|plate| plate.intersects(rect)) {
        painter.galley(rect.min, galley, colour);
    }
}

fn others(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

impl BoxAxes<'_> {
    /// Returns the selection of the points that are drawn.
    pub(super) fn shown(&self) -> ShownPoints {
        ShownPoints { outliers: self.options.cloud.outlier_preview, part: self.part }
    }

    /// Returns a place on the screen; `None` behind the camera.
    pub(super) fn at(&self, place: Vec3) -> Option<Pos2> {
        let ndc = self.projection.project(place)?;
        let half = 0.5 * self.rect.size();
        Some(self.rect.center() + Vec2::new(ndc.x, -ndc.y) * half)
    }

    /// Paints the walls with their grid; to be called before the points are painted.
    pub(super) fn walls(&self, painter: &Painter) {
        let line = Stroke::new(1.0, theme::grid_colour(self.options));
        for (axis, high) in walls(self.corners, self.projection.eye) {
            let mut start = self.corners[0];
            start[axis] = self.corners[usize::from(high)][axis];
            for (along, across) in [(0, 1), (1, 0)].map(|(i, j)| (others(axis)[i], others(axis)[j]))
            {
                let ends = [self.corners[0][along], self.corners[1][along]];
                for value in self.ticks(along).chain(ends) {
                    start[along] = value;
                    self.line(painter, start, across, line);
                }
                start[along] = self.corners[0][along];
            }
        }
    }

    fn line(&self, painter: &Painter, mut from: Vec3, axis: usize, stroke: Stroke) {
        from[axis] = self.corners[0][axis];
        let mut to = from;
        to[axis] = self.corners[1][axis];
        if let (Some(from), Some(to)) = (self.at(from), self.at(to)) {
            painter.add(Shape::line_segment([from, to], stroke));
        }
    }

    /// Paints lengths along the outline, with the names of the axes; to be called after the points
    /// are painted. Nothing is written over `covered` areas.
    pub(super) fn labels(&self, painter: &Painter, covered: &[Rect]) {
        let walls = walls(self.corners, self.projection.eye);
        for (axis, name) in ["east", "north", "elevation"].into_iter().enumerate() {
            let edges = outline(axis, &walls);
            let place = |edge: &Edge| self.at(self.on(edge, 0.5)).map(|at| (at, *edge));
            let places = edges.iter().filter_map(place);
            // Horizontal lengths are below the cloud, elevations to its left.
            let chosen = match axis {
                2 => places.min_by(|a, b| a.0.x.total_cmp(&b.0.x)),
                _ => places.max_by(|a, b| a.0.y.total_cmp(&b.0.y)),
            };
            if let Some((_, edge)) = chosen {
                let unit = self.options.units.symbol();
                self.label_edge(painter, &edge, &format!("{name}, {unit}"), covered);
            }
        }
    }

    /// Returns the place at a share of the length of an edge.
    fn on(&self, (axis, a, b): &Edge, share: f32) -> Vec3 {
        let mut place = self.corners[0];
        for (face, high) in [a, b] {
            place[*face] = self.corners[usize::from(*high)][*face];
        }
        let [low, high] = self.corners;
        place[*axis] = low[*axis] + share * (high[*axis] - low[*axis]);
        place
    }

    fn label_edge(&self, painter: &Painter, edge: &Edge, name: &str, covered: &[Rect]) {
        let axis = edge.0;
        let middle = 0.5 * (self.corners[0] + self.corners[1]);
        let (Some(from), Some(to), Some(centre)) =
            (self.at(self.on(edge, 0.0)), self.at(self.on(edge, 1.0)), self.at(middle))
        else {
            return;
        };
        let along = (to - from).normalized();
        let mut outward = along.rot90();
        if outward.dot(from.lerp(to, 0.5) - centre) < 0.0 {
            outward = -outward;
        }
        let text = theme::canvas_text_colour(self.options);
        let step_m = self.step_m(axis);
        let [level, upright] = LABEL_SPACING;
        let spacing = level + (upright - level) * along.y.abs();
        let mut last: Option<Pos2> = None;
        for value in self.ticks(axis) {
            let mut place = self.on(edge, 0.0);
            place[axis] = value;
            let Some(at) = self.at(place) else {
                continue;
            };
            if last.is_some_and(|last| last.distance(at) < spacing) {
                continue;
            }
            last = Some(at);
            painter.line_segment([at, at + 4.0 * outward], Stroke::new(1.0, text));
            let at_m = self.origin_m[axis] + f64::from(value);
            let label = self.options.units.tick(at_m, step_m);
            let at = at + 15.0 * outward;
            write_atomically_at(painter, covered, at, Align2::CENTER_CENTER, label, text);
        }
        if !legend::has_room(self.rect) {
            return;
        }
        let (at, anchor) = match axis {
            // Above the upper end: beside the numbers, the name would need much room.
            2 => (to + vec2(0.0, -8.0), Align2::CENTER_BOTTOM),
            // Words are wide: beside a vertical edge they need more room than under a horizontal
            // one.
            _ => {
                let away = 32.0 + 34.0 * outward.x.abs();
                (from.lerp(to, 0.5) + away * outward, Align2::CENTER_CENTER)
            }
        };
        let faint = text.gamma_multiply(0.75);
        write_atomically_at(painter, covered, at, anchor, name.to_owned(), faint);
    }

    fn step_m(&self, axis: usize) -> f64 {
        let extent = self.corners[1] - self.corners[0];
        let units = self.options.units;
        match axis {
            2 => units.round_step_m(f64::from(extent.z), 4.0),
            // East and north share a step, so that the grid shows squares.
            _ => units.round_step_m(f64::from(extent.x.max(extent.y)), 6.0),
        }
    }

    /// Returns round lengths of the survey inside the box, as coordinates of the scene.
    fn ticks(&self, axis: usize) -> impl Iterator<Item = f32> {
        let zero = self.origin_m[axis];
        let [low, high] = self.corners.map(|corner| f64::from(corner[axis]) + zero);
        ticks::multiples(low, high, self.step_m(axis)).map(move |metres| (metres - zero) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 2] = [Vec3::new(-10.0, -5.0, -4.0), Vec3::new(10.0, 5.0, 0.0)];

    #[test]
    fn the_walls_are_behind_the_cloud() {
        let from_south_east_above = Vec3::new(60.0, -50.0, 30.0);
        let walls = walls(CORNERS, from_south_east_above);
        assert_eq!(walls, [(0, false), (1, true), (2, false)]);
    }

    #[test]
    fn from_above_elevations_have_no_edge_to_stand_at() {
        let walls = walls(CORNERS, Vec3::new(0.0, 0.0, 80.0));
        assert!(outline(2, &walls).is_empty());
        assert_eq!(outline(0, &walls).len(), 2);
    }
}
