//! Places the depth labels along isobaths: upright, on straight pieces, without overlap.
//!
//! Labels keep their size on the screen, so the places where they fit depend on the zoom. They are
//! placed once for every octave of zoom, in a background thread, and move with the map in between.

use super::{GroundLine, IsobathLayer};
use bathyscope_log::support::progress::Progress;
use std::collections::HashMap;
use std::sync::Arc;

/// Width of a digit and of the margins of a label, and its height, points.
const DIGIT: f32 = 6.4;
const MARGIN: f32 = 8.0;
const HEIGHT: f32 = 15.0;
/// Distance along a line from one label to the next, points.
const SPACING: f32 = 340.0;
/// Least length of the chord of the line under a label, as a share of the label's width: a shorter
/// chord belongs to a line that bends too much.
const STRAIGHT: f32 = 0.94;
/// Number of places tried to each side of the best place of a label, and the step between them in
/// widths of the label.
const TRIES: i32 = 6;
const TRY_STEP: f32 = 0.6;
/// Largest number of labels of a map.
const MOST: usize = 20_000;
/// Room that a label takes at the far end of its octave, as a multiple of the room at the middle.
const ROOM: f32 = std::f32::consts::SQRT_2;

/// A depth on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IsobathLabel {
    /// Middle of the label, east and north of the layer's origin, metres.
    pub place: [f32; 2],
    /// Rotation clockwise from horizontal on the screen, radians, -quarter to quarter of a turn.
    pub angle_rad: f32,
    /// Index of the line that the label is on.
    pub line: usize,
}

/// The labels for an octave of zoom.
pub(crate) struct IsobathLabels {
    /// The lines that the labels are on.
    pub layer: Arc<IsobathLayer>,
    /// The labels.
    pub labels: Vec<IsobathLabel>,
}

/// Returns the octave of zoom whose middle is nearest.
pub(crate) fn octave(metres_per_point: f64) -> i32 {
    metres_per_point.log2().round().clamp(-64.0, 64.0) as i32
}

impl IsobathLabels {
    /// Places the labels of all lines, those of thick and of long lines first; `None` when
    /// cancelled.
    pub(crate) fn place(
        layer: Arc<IsobathLayer>,
        octave: i32,
        progress: &Progress,
    ) -> Option<Self> {
        let labels = place(&layer.lines, 2f32.powi(octave), progress)?;
        Some(Self { layer, labels })
    }
}

fn place(
    lines: &[GroundLine],
    metres_per_point: f32,
    progress: &Progress,
) -> Option<Vec<IsobathLabel>> {
    let mut ways: Vec<(usize, Way<'_>)> = lines.iter().map(Way::new).enumerate().collect();
    ways.sort_by(|(a, way_a), (b, way_b)| {
        let thick = |line: usize| lines[line].is_index;
        let longer = way_b.length_m().total_cmp(&way_a.length_m());
        thick(*b).cmp(&thick(*a)).then(longer)
    });
    let widest = lines.iter().map(width).fold(HEIGHT, f32::max);
    let mut ground = TakenGround::new(ROOM * widest * metres_per_point);
    let mut labels = Vec::new();
    for (line, way) in ways {
        progress.check().ok()?;
        let size_m = [width(&lines[line]), HEIGHT].map(|points| points * metres_per_point);
        let count = (way.length_m() / (SPACING * metres_per_point)).round().max(1.0);
        if way.length_m() < 1.5 * size_m[0] || count > MOST as f32 {
            continue;
        }
        for index in 0..count as usize {
            let best_m = (index as f32 + 0.5) / count * way.length_m();
            let tries = (0..=2 * TRIES).map(|n| if n % 2 == 0 { n / 2 } else { -(n + 1) / 2 });
            let free = tries
                .map(|step| best_m + step as f32 * TRY_STEP * size_m[0])
                .filter_map(|at_m| way.straight(at_m, size_m[0]))
                .find(|(place, along)| ground.take(*place, *along, size_m));
            if let Some((place, along)) = free {
                labels.push(IsobathLabel { place, angle_rad: upright(along), line });
            }
            if labels.len() >= MOST {
                return Some(labels);
            }
        }
    }
    Some(labels)
}

fn width(line: &GroundLine) -> f32 {
    DIGIT * line.text.len() as f32 + MARGIN
}

/// Returns the screen angle of a direction on the ground, turned so that the text is not upside
/// down.
fn upright([east, north]: [f32; 2]) -> f32 {
    let turn = if east < 0.0 { -1.0 } else { 1.0 };
    // On the screen, y points down.
    (-turn * north).atan2(turn * east)
}

/// A line with the distance along it of each of its points.
struct Way<'a> {
    points: &'a [[f32; 2]],
    metres: Vec<f32>,
}

impl<'a> Way<'a> {
    fn new(line: &'a GroundLine) -> Self {
        let mut metres = Vec::with_capacity(line.points.len());
        let mut sum_m = 0.0;
        for (index, point) in line.points.iter().enumerate() {
            if let Some(before) = index.checked_sub(1).and_then(|index| line.points.get(index)) {
                sum_m += (point[0] - before[0]).hypot(point[1] - before[1]);
            }
            metres.push(sum_m);
        }
        Self { points: &line.points, metres }
    }

    fn length_m(&self) -> f32 {
        self.metres.last().copied().unwrap_or(0.0)
    }

    fn at(&self, at_m: f32) -> Option<[f32; 2]> {
        if !(0.0..=self.length_m()).contains(&at_m) {
            return None;
        }
        let after = self.metres.partition_point(|metres| *metres < at_m);
        let after = after.clamp(1, self.points.len() - 1);
        let (a, b) = (self.points[after - 1], self.points[after]);
        let step_m = self.metres[after] - self.metres[after - 1];
        let share = if step_m > 0.0 { (at_m - self.metres[after - 1]) / step_m } else { 0.0 };
        Some([0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * share))
    }

    /// Returns the middle and the unit direction of a piece of this width around `at_m`; `None` if
    /// the piece is not straight enough for a text.
    fn straight(&self, at_m: f32, width_m: f32) -> Option<([f32; 2], [f32; 2])> {
        let [from, to] = [-0.5, 0.5].map(|half| self.at(at_m + half * width_m));
        let (from, to) = (from?, to?);
        let chord = [to[0] - from[0], to[1] - from[1]];
        let chord_m = chord[0].hypot(chord[1]);
        let middle = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
        (chord_m >= STRAIGHT * width_m).then(|| (middle, chord.map(|step| step / chord_m)))
    }
}

/// Ground that is taken by labels: boxes around them, in squares.
struct TakenGround {
    square_m: f32,
    squares: HashMap<[i32; 2], Vec<[f32; 4]>>,
}

impl TakenGround {
    fn new(square_m: f32) -> Self {
        Self { square_m: square_m.max(f32::MIN_POSITIVE), squares: HashMap::new() }
    }

    /// Takes the ground of a label and returns true, unless another label is there.
    fn take(&mut self, place: [f32; 2], along: [f32; 2], [width_m, height_m]: [f32; 2]) -> bool {
        let half = [0, 1].map(|axis| {
            0.5 * ROOM * (along[axis].abs() * width_m + along[1 - axis].abs() * height_m)
        });
        let [west, south] = [0, 1].map(|axis| place[axis] - half[axis]);
        let [east, north] = [0, 1].map(|axis| place[axis] + half[axis]);
        let square = |metres: f32| (metres / self.square_m).floor() as i32;
        let squares: Vec<[i32; 2]> = (square(west)..=square(east))
            .flat_map(|x| (square(south)..=square(north)).map(move |y| [x, y]))
            .collect();
        let hits = |other: &[f32; 4]| {
            west < other[2] && other[0] < east && south < other[3] && other[1] < north
        };
        let mut neighbours = squares.iter().filter_map(|square| self.squares.get(square));
        let is_free = neighbours.all(|others| !others.iter().any(hits));
        if is_free {
            for square in squares {
                let others = self.squares.entry(square).or_default();
                others.push([west, south, east, north]);
            }
        }
        is_free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: Vec<[f32; 2]>, is_index: bool) -> GroundLine {
        GroundLine { text: "2.5".to_owned(), is_index, points }
    }

    /// Returns the box around a label, metres, at the middle of its octave.
    fn spans(label: &IsobathLabel, metres_per_point: f32) -> [f32; 4] {
        let (sin, cos) = label.angle_rad.sin_cos();
        let [w, h] = [27.0 * metres_per_point, HEIGHT * metres_per_point];
        let half = [0.5 * (cos.abs() * w + sin.abs() * h), 0.5 * (sin.abs() * w + cos.abs() * h)];
        let [x, y] = label.place;
        [x - half[0], y - half[1], x + half[0], y + half[1]]
    }

    #[test]
    fn labels_lie_on_their_lines_upright_and_apart() {
        // Rings as on a hill, a metre apart, and a straight line through them.
        let ring = |radius: f32| {
            let point = |step: i32| {
                let (sin, cos) = (step as f32 * std::f32::consts::TAU / 720.0).sin_cos();
                [radius * cos, radius * sin]
            };
            line((0..=720).map(point).collect(), radius as i32 % 5 == 0)
        };
        let mut lines: Vec<GroundLine> = (1..60).map(|radius| ring(radius as f32)).collect();
        lines.push(line((-80..=80).map(|x| [x as f32, 3.0]).collect(), false));
        for metres_per_point in [0.01, 0.1, 0.5] {
            let labels = place(&lines, metres_per_point, &Progress::new()).unwrap();
            assert!(labels.len() > 3, "{metres_per_point}: {}", labels.len());
            for (index, label) in labels.iter().enumerate() {
                assert!(label.angle_rad.abs() <= std::f32::consts::FRAC_PI_2 + 1e-5);
                let points = lines[label.line].points.iter();
                let near = points
                    .map(|point| (point[0] - label.place[0]).hypot(point[1] - label.place[1]));
                let off_m = near.fold(f32::MAX, f32::min);
                assert!(off_m < 0.6 + 4.0 * metres_per_point, "{off_m}");
                let span = spans(label, metres_per_point);
                for other in &labels[..index] {
                    let other_span = spans(other, metres_per_point);
                    let apart = span[2] < other_span[0]
                        || other_span[2] < span[0]
                        || span[3] < other_span[1]
                        || other_span[3] < span[1];
                    assert!(apart, "{label:?} and {other:?}");
                }
            }
        }
    }

    #[test]
    fn a_bend_sharper_than_a_label_carries_none() {
        let zigzag = (0..200).map(|n| [n as f32 * 0.1, (n % 2) as f32]).collect();
        let labels = place(&[line(zigzag, true)], 0.05, &Progress::new()).unwrap();
        assert!(labels.is_empty(), "{labels:?}");
    }

    #[test]
    fn text_never_stands_on_its_head() {
        assert_eq!(upright([1.0, 0.0]), 0.0);
        assert_eq!(upright([-1.0, 0.0]), 0.0);
        let up = upright([0.6, 0.8]);
        assert!(up < 0.0 && (upright([-0.6, -0.8]) - up).abs() < 1e-6);
    }
}
