//! Counts neighbours in a tree of boxes: for points among so many others that testing each would
//! take too long.
//!
//! A box that lies within the radius as a whole is counted by its number of points, and a box that
//! lies beyond is skipped, so that a million points at one place cost one test. Rounding is
//! monotonic: the square of the distance to the far corner of a box, computed as for a point, is
//! never below that of a point in the box, so that the result is the same as by testing each point.

use std::collections::VecDeque;
use std::ops::Range;

/// Largest number of points of a box that is not halved.
const LEAF: usize = 16;

/// Boxes around runs of points, halves of each other.
pub(super) struct Tree {
    /// Points, those of a box side by side.
    points: Vec<[f64; 3]>,
    /// The box around all points, then both halves of each box: box `n` has the halves `2 n + 1`
    /// and `2 n + 2`.
    boxes: Vec<PointBounds>,
}

/// Smallest and largest coordinates of some points.
#[derive(Clone, Copy, Debug)]
struct PointBounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl PointBounds {
    const NONE: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    fn of(points: &[[f64; 3]]) -> Self {
        points.iter().fold(Self::NONE, |Self { low, high }, point| {
            let pick = |of: fn(f64, f64) -> f64, bound: [f64; 3]| {
                [0, 1, 2].map(|axis| of(bound[axis], point[axis]))
            };
            Self { low: pick(f64::min, low), high: pick(f64::max, high) }
        })
    }

    fn longest_axis(&self) -> usize {
        let length = |axis: &usize| self.high[*axis] - self.low[*axis];
        let longest = (0..3).max_by(|a, b| length(a).total_cmp(&length(b)));
        longest.unwrap_or(0)
    }

    /// Returns the squares of the distances from a place to the nearest and the farthest point of
    /// the box.
    fn distance_squares(&self, at: &[f64; 3]) -> [f64; 2] {
        let (mut near, mut far) = ([0.0_f64; 3], [0.0_f64; 3]);
        for axis in 0..3 {
            let [low, high] = [at[axis] - self.low[axis], self.high[axis] - at[axis]];
            near[axis] = 0.0_f64.max(-low).max(-high);
            far[axis] = low.max(high);
        }
        [near, far].map(|[x, y, z]| x * x + y * y + z * z)
    }
}

impl Tree {
    /// Creates a tree of points that are all finite.
    pub(super) fn new(mut points: Vec<[f64; 3]>) -> Self {
        let mut boxes = Vec::new();
        halve(&mut points, 0, &mut boxes);
        Self { points, boxes }
    }

    /// Returns true if at least `enough` points lie strictly within the radius, of which the square
    /// is given. Large boxes are tested first, so that the answer is often known before any point
    /// is tested.
    pub(super) fn has_enough(&self, at: &[f64; 3], square: f64, enough: usize) -> bool {
        let (mut found, mut possible) = (0, self.points.len());
        let mut open = VecDeque::from([(0, 0..self.points.len())]);
        while let Some((index, range)) = open.pop_front() {
            let [near, far] = self.boxes[index].distance_squares(at);
            let inside = match halves(&range) {
                _ if far < square => range.len(),
                _ if near >= square => 0,
                Some([left, right]) => {
                    open.push_back((2 * index + 1, left));
                    open.push_back((2 * index + 2, right));
                    continue;
                }
                None => {
                    let points = self.points[range.clone()].iter();
                    points.filter(|point| distance_square(at, point) < square).count()
                }
            };
            found += inside;
            possible -= range.len() - inside;
            if found >= enough {
                return true;
            }
            if possible < enough {
                return false;
            }
        }
        false
    }
}

/// Returns the halves of a run of points; `None` for a run that is not halved.
fn halves(range: &Range<usize>) -> Option<[Range<usize>; 2]> {
    let middle = range.start + range.len() / 2;
    (range.len() > LEAF).then_some([range.start..middle, middle..range.end])
}

fn halve(points: &mut [[f64; 3]], index: usize, boxes: &mut Vec<PointBounds>) {
    if boxes.len() <= index {
        boxes.resize(index + 1, PointBounds::NONE);
    }
    boxes[index] = PointBounds::of(points);
    let Some([left, _]) = halves(&(0..points.len())) else {
        return;
    };
    let axis = boxes[index].longest_axis();
    points.select_nth_unstable_by(left.end, |a, b| a[axis].total_cmp(&b[axis]));
    let (left, right) = points.split_at_mut(left.end);
    halve(left, 2 * index + 1, boxes);
    halve(right, 2 * index + 2, boxes);
}

/// Returns the square of the distance between two points.
pub(super) fn distance_square(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_counts_as_testing_each_point_does() {
        // A lattice, so that many points lie at the radius exactly, some of it twice, with a crowd
        // at one place.
        let lattice = (0..4096).map(|i| [i % 16, i / 16 % 16, i / 256].map(f64::from));
        let crowd = std::iter::repeat_n([7.5, 7.5, 7.25], 3000);
        let points: Vec<[f64; 3]> =
            lattice.clone().chain(lattice.step_by(3)).chain(crowd).collect();
        let tree = Tree::new(points.clone());
        for square in [1.0, 4.0, 6.75, 81.0, f64::INFINITY] {
            for at in points.iter().step_by(97) {
                let near = |point: &&[f64; 3]| distance_square(at, point) < square;
                let count = points.iter().filter(near).count();
                assert!(tree.has_enough(at, square, count));
                assert!(!tree.has_enough(at, square, count + 1), "{at:?} {square}");
            }
        }
    }
}
