//! Computes the lines over the picture, first return and recorded depth, with stored extremes of
//! every stretch of pings, so that a line over a whole log takes no longer to draw than one over a
//! screenful.

use crate::first_return::FirstReturns;
use bathyscope_log::survey::{Side, Survey};
use std::sync::Arc;

/// Number of halvings of the finest stored stretch (16 pings); in shorter stretches, values are
/// read one by one.
const STORED: u8 = 4;

/// Smallest and largest slant range of a stretch of pings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSpan {
    /// Smallest slant range, metres; infinite when the stretch has no value.
    pub min_m: f32,
    /// Largest slant range, metres; minus infinity when the stretch has no value.
    pub max_m: f32,
    /// True if all values of the stretch are doubtful: above-bottom returns, or depths with a
    /// fault.
    pub doubtful: bool,
}

impl LineSpan {
    /// Stretch without a value: a gap in the line.
    pub const GAP: LineSpan =
        LineSpan { min_m: f32::INFINITY, max_m: f32::NEG_INFINITY, doubtful: true };

    /// Creates the stretch of one value; a gap when it is not finite.
    fn value(range_m: f32, doubtful: bool) -> Self {
        if !range_m.is_finite() {
            return Self::GAP;
        }
        Self { min_m: range_m, max_m: range_m, doubtful }
    }

    /// Returns true if the stretch has no value.
    pub fn is_gap(&self) -> bool {
        self.min_m > self.max_m
    }

    /// Returns both ends of the stretch, extended until they touch those of the stretch before,
    /// metres.
    pub fn reaching(&self, before: &Self) -> [f32; 2] {
        if before.is_gap() {
            return [self.min_m, self.max_m];
        }
        [self.min_m.min(before.max_m), self.max_m.max(before.min_m)]
    }

    /// Returns the stretch with both ends converted by a function; a gap stays a gap.
    pub fn moved(&self, to: impl Fn(f32) -> f32) -> Self {
        if self.is_gap() {
            return *self;
        }
        Self { min_m: to(self.min_m), max_m: to(self.max_m), ..*self }
    }

    fn join(self, other: Self) -> Self {
        Self {
            min_m: self.min_m.min(other.min_m),
            max_m: self.max_m.max(other.max_m),
            doubtful: self.doubtful && other.doubtful,
        }
    }
}

/// Extremes of a line over every aligned stretch of 16, 32, 64 ... pings. They take about 1.5 bytes
/// a ping.
#[derive(Debug)]
pub struct RangeLine {
    levels: Vec<Vec<LineSpan>>,
}

impl RangeLine {
    fn new(pings: usize, at: impl Fn(usize) -> LineSpan) -> Self {
        let block = 1 << STORED;
        let mut levels: Vec<Vec<LineSpan>> = vec![
            (0..pings.div_ceil(block))
                .map(|index| {
                    let first = index * block;
                    join((first..(first + block).min(pings)).map(&at))
                })
                .collect(),
        ];
        while let Some(finer) = levels.last().filter(|level| level.len() > 1) {
            let coarser = finer.chunks(2).map(|two| join(two.iter().copied()));
            levels.push(coarser.collect());
        }
        Self { levels }
    }

    /// Creates the line of recorded depths.
    pub(crate) fn depth(survey: &Survey) -> Self {
        Self::new(survey.side_scan.len(), |ping| depth_at(survey, ping))
    }

    fn stored(&self, halvings: u8, index: usize) -> LineSpan {
        let level = usize::from(halvings.saturating_sub(STORED)).min(self.levels.len() - 1);
        let blocks = &self.levels[level];
        blocks.get(index).copied().unwrap_or(LineSpan::GAP)
    }
}

fn join(spans: impl Iterator<Item = LineSpan>) -> LineSpan {
    spans.fold(LineSpan::GAP, LineSpan::join)
}

/// Lines of the first returns of both sides, ready to be drawn at any zoom.
#[derive(Debug)]
pub struct PickLines {
    /// First returns that the lines were made from.
    pub returns: Arc<FirstReturns>,
    sides: [RangeLine; 2],
}

impl PickLines {
    /// Creates the lines in one pass over the picks.
    pub fn new(survey: &Survey, returns: Arc<FirstReturns>) -> Self {
        let line = |side| {
            RangeLine::new(survey.side_scan.len(), |ping| pick_at(survey, &returns, side, ping))
        };
        let sides = Side::BOTH.map(line);
        Self { returns, sides }
    }
}

/// Source of a drawn line: the values themselves where few pings share a column, or else the stored
/// extremes.
#[derive(Clone, Copy)]
pub enum LineStep<'a> {
    /// First returns of a side. While the threshold is dragged, the stored extremes may be those of
    /// older picks.
    Picks {
        /// First returns to draw.
        returns: &'a FirstReturns,
        /// Stored extremes of first returns; `None` until they are made.
        lines: Option<&'a PickLines>,
        /// Side of the boat.
        side: Side,
    },
    /// Recorded depths, with their stored extremes; `None` until they are made.
    Depth(Option<&'a RangeLine>),
}

impl LineStep<'_> {
    /// Returns the extremes over the aligned stretch number `index` of `2^halvings` pings. Reads at
    /// most 8 pings.
    pub fn span(&self, survey: &Survey, halvings: u8, index: usize) -> LineSpan {
        if halvings >= STORED {
            return match self {
                LineStep::Picks { lines, side, .. } => lines.map_or(LineSpan::GAP, |lines| {
                    lines.sides[*side as usize].stored(halvings, index)
                }),
                LineStep::Depth(line) => {
                    line.map_or(LineSpan::GAP, |line| line.stored(halvings, index))
                }
            };
        }
        let first = index << halvings;
        join((first..first + (1 << halvings)).map(|ping| match self {
            LineStep::Picks { returns, side, .. } => pick_at(survey, returns, *side, ping),
            LineStep::Depth(_) => depth_at(survey, ping),
        }))
    }
}

fn pick_at(survey: &Survey, returns: &FirstReturns, side: Side, ping: usize) -> LineSpan {
    returns.side(side).get(ping).map_or(LineSpan::GAP, |pick| {
        LineSpan::value(returns.range_m(survey, ping, side) as f32, pick.above_bottom)
    })
}

fn depth_at(survey: &Survey, ping: usize) -> LineSpan {
    survey
        .side_scan
        .get(ping)
        .map_or(LineSpan::GAP, |ping| LineSpan::value(ping.depth_m, ping.depth_fault.is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_extremes_equal_those_of_the_values() {
        let values: Vec<f32> = (0..1000)
            .map(|n| if n % 7 == 0 { f32::NAN } else { ((n * 37) % 101) as f32 })
            .collect();
        let line = RangeLine::new(values.len(), |n| LineSpan::value(values[n], false));
        for halvings in 4..11_u8 {
            for (index, chunk) in values.chunks(1 << halvings).enumerate() {
                let span = line.stored(halvings, index);
                let finite = chunk.iter().copied().filter(|value| value.is_finite());
                assert_eq!(span.min_m, finite.clone().fold(f32::INFINITY, f32::min));
                assert_eq!(span.max_m, finite.fold(f32::NEG_INFINITY, f32::max));
            }
        }
    }

    #[test]
    fn stretches_reach_to_the_one_before_and_not_over_a_gap() {
        let span = |min_m, max_m| LineSpan { min_m, max_m, doubtful: false };
        assert_eq!(span(5.0, 6.0).reaching(&span(1.0, 2.0)), [2.0, 6.0]);
        assert_eq!(span(1.0, 2.0).reaching(&span(5.0, 6.0)), [1.0, 5.0]);
        assert_eq!(span(1.0, 4.0).reaching(&span(2.0, 3.0)), [1.0, 4.0]);
        assert_eq!(span(1.0, 2.0).reaching(&LineSpan::GAP), [1.0, 2.0]);
    }

    #[test]
    fn a_stretch_without_a_value_is_a_gap() {
        let line =
            RangeLine::new(40, |n| LineSpan::value(if n < 16 { f32::NAN } else { 1.0 }, true));
        assert!(line.stored(4, 0).is_gap());
        assert!(!line.stored(4, 1).is_gap());
        assert!(line.stored(4, 99).is_gap());
    }
}
