//! Defines boxes by side, pings and slant range, and the extents of the objects in them.

use bathyscope_log::survey::{Side, Survey};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A box on one side of the survey. Slant ranges are in the recorder's scale, so that a box keeps
/// its place under any calibration, and over pings of different ranges.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Side of the survey.
    pub side: Side,
    /// Side-scan pings, the end excluded.
    pub pings: Range<usize>,
    /// Slant range of the near edge, metres.
    pub near_m: f64,
    /// Slant range of the far edge, metres.
    pub far_m: f64,
}

/// Box that a detector proposes, in pings and slant ranges of the survey. It holds the echo and its
/// shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// Index into the model's names ([`super::Model::names`]).
    pub class: usize,
    /// Score, 0 to 1.
    pub score: f32,
    /// Side, pings and slant ranges of the box.
    pub mark: Mark,
}

/// Half of the slant range that the mark of a point covers, metres: a box without size could not be
/// drawn or clicked.
const POINT_HALF_M: f64 = 0.05;

impl Mark {
    /// Creates a box from its side, its pings, and the slant ranges of its edges, metres.
    pub fn new(side: Side, pings: Range<usize>, [near_m, far_m]: [f64; 2]) -> Self {
        Self { side, pings, near_m, far_m }
    }

    /// Creates the mark of a point at a ping and a slant range in the recorder's scale, metres.
    pub fn point(side: Side, ping: usize, range_m: f64) -> Self {
        let edges_m = [(range_m - POINT_HALF_M).max(0.0), range_m + POINT_HALF_M];
        Self::new(side, ping..ping + 1, edges_m)
    }

    /// Returns the samples that the box covers in its middle ping, the end excluded; empty if this
    /// ping has no data of the side.
    pub fn samples(&self, survey: &Survey) -> Range<u32> {
        let middle = usize::midpoint(self.pings.start, self.pings.end);
        let Some(span) = survey.span(middle, self.side) else {
            return 0..0;
        };
        let sample = |range_m: f64| span.sample_at(range_m).clamp(0.0, f64::from(span.count));
        // `as` saturates, and the clamp keeps the value in range.
        sample(self.near_m).floor() as u32..sample(self.far_m).ceil() as u32
    }
}

/// Source of the extent of the object in a box. Slant ranges are in the recorder's scale, as in
/// [`Mark`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ObjectExtent {
    /// The program finds the echo and the shadow in the box.
    #[default]
    Found,
    /// The analyst has set the edges: the echo is between the box's near edge and the border, the
    /// shadow between the border and the far edge, both on all pings of the box. A border on the
    /// far edge means that there is no shadow.
    Drawn {
        /// Slant range of the border between echo and shadow, metres.
        border_m: f64,
    },
    /// The object is a point in the middle of the box, without size.
    Point,
}

/// A shadow that the analyst measured on one ping of a box. It replaces the shadow that is found or
/// drawn with the box: the height of the object is the height of the part that casts this shadow.
/// The echo of a hull with a list, for example, reaches farther than its upper gunwale, behind
/// which the shadow begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredShadow {
    /// Index of the ping; the side is that of the box.
    pub ping: usize,
    /// Slant range of the top of the object, where the shadow begins, in the recorder's scale,
    /// metres.
    pub top_m: f64,
    /// Slant range of the shadow's end in the recorder's scale, metres.
    pub end_m: f64,
}

impl MeasuredShadow {
    /// Returns true if the shadow can belong to a box: it is on one of the box's pings, and has a
    /// length.
    pub fn fits(&self, mark: &Mark) -> bool {
        mark.pings.contains(&self.ping)
            && 0.0 < self.top_m
            && self.top_m < self.end_m
            && self.end_m.is_finite()
    }
}

impl ObjectExtent {
    /// Returns the border between echo and shadow that the analyst has set, metres of slant range;
    /// `None` if there is none.
    pub fn border_m(self) -> Option<f64> {
        match self {
            ObjectExtent::Drawn { border_m } => Some(border_m),
            ObjectExtent::Found | ObjectExtent::Point => None,
        }
    }

    /// Returns the extent of the same object after its box was moved or resized: the border moves
    /// with a box that keeps its width in slant range, and stays where it is if only one edge was
    /// moved.
    pub fn moved(self, from: &Mark, to: &Mark) -> Self {
        let ObjectExtent::Drawn { border_m } = self else {
            return self;
        };
        let [before_m, after_m] = [from, to].map(|mark| mark.far_m - mark.near_m);
        let by_m = if (after_m - before_m).abs() < 1e-9 { to.near_m - from.near_m } else { 0.0 };
        ObjectExtent::Drawn { border_m: (border_m + by_m).clamp(to.near_m, to.far_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::Side;

    fn mark(near_m: f64, far_m: f64) -> Mark {
        Mark::new(Side::Port, 3..9, [near_m, far_m])
    }

    #[test]
    fn a_border_moves_with_its_box_and_stays_between_its_edges() {
        let drawn = ObjectExtent::Drawn { border_m: 5.0 };
        let moved = drawn.moved(&mark(4.0, 7.0), &mark(4.5, 7.5));
        assert_eq!(moved.border_m(), Some(5.5));
        let longer = drawn.moved(&mark(4.0, 7.0), &mark(4.0, 9.0));
        assert_eq!(longer.border_m(), Some(5.0));
        let shorter = drawn.moved(&mark(4.0, 7.0), &mark(4.0, 4.5));
        assert_eq!(shorter.border_m(), Some(4.5));
        let found = ObjectExtent::Found.moved(&mark(4.0, 7.0), &mark(4.5, 7.5));
        assert_eq!(found, ObjectExtent::Found);
    }

    #[test]
    fn a_point_lies_in_the_middle_of_its_mark() {
        let point = Mark::point(Side::Port, 12, 6.0);
        assert_eq!(point.pings, 12..13);
        assert!((0.5 * (point.near_m + point.far_m) - 6.0).abs() < 1e-12);
        assert_eq!(Mark::point(Side::Port, 0, 0.01).near_m, 0.0);
    }
}
