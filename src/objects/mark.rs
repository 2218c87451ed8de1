//! Boxes in the survey's own terms.

use bathyscope_log::survey::{Side, Survey};
use std::ops::Range;

/// A box on one side of the survey. Slant ranges are by the recorder's scale, so that a box keeps
/// its place whatever the calibration says, and over pings of different ranges.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The side.
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

impl Mark {
    /// A box by its side, its pings, and the slant ranges of its edges, metres.
    pub fn new(side: Side, pings: Range<usize>, [near_m, far_m]: [f64; 2]) -> Self {
        Self { side, pings, near_m, far_m }
    }

    /// The samples that the box covers in its middle ping, the end excluded; empty where that ping
    /// has no such side.
    pub fn samples(&self, survey: &Survey) -> Range<u32> {
        let middle = usize::midpoint(self.pings.start, self.pings.end);
        let Some(span) = survey.span(middle, self.side) else {
            return 0..0;
        };
        let sample = |range_m: f64| span.sample_at(range_m).clamp(0.0, f64::from(span.count));
        // `as` saturates, and the clamp holds the value in range.
        sample(self.near_m).floor() as u32..sample(self.far_m).ceil() as u32
    }
}
