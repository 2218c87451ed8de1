//! Data that the method reads of a log: the place of every ping, the range of its samples and its
//! first returns.

use bathyscope_log::survey::{Side, Survey};

/// Source of the samples of a log, read a ping at a time.
pub trait SampleSource: Sync {
    /// Replaces `out` with the samples of a side of a ping, nearest first; none where there are
    /// none.
    fn read(&self, ping: usize, side: Side, out: &mut Vec<u8>);
}

impl SampleSource for Survey {
    fn read(&self, ping: usize, side: Side, out: &mut Vec<u8>) {
        out.clear();
        if let Some(samples) = self.samples(ping, side) {
            samples.copy_outward(out);
        }
    }
}

/// A log in the plane of a surface.
#[derive(Clone)]
pub struct LogEchoes<'a> {
    /// The recording.
    pub levels: &'a dyn SampleSource,
    /// One entry a side-scan ping.
    pub pings: Vec<PingPlace>,
}

/// Place of a ping, and the ranges of its samples.
#[derive(Clone, Copy, Debug)]
pub struct PingPlace {
    /// Seconds of the log.
    pub time_s: f64,
    /// East and north in the plane, metres; NaN where the place is unknown or the ping counts for
    /// nothing.
    pub place_m: [f64; 2],
    /// Unit vector to starboard, east and north; NaN without a heading.
    pub starboard: [f64; 2],
    /// The transducer's depth below the level that the surface's depths count from, metres.
    pub transducer_m: f64,
    /// Port first.
    pub sides: [SideEchoes; 2],
}

/// One side of a ping.
#[derive(Clone, Copy, Debug)]
pub struct SideEchoes {
    /// Slant range of the near edge of the first sample, metres; NaN where the side was not
    /// recorded.
    pub near_m: f64,
    /// Slant range that a sample covers, metres.
    pub step_m: f64,
    /// The first return, counted in samples; NaN where there is none.
    pub first_return: f64,
    /// True if it lies above the recorded depth.
    pub above_bottom: bool,
}

impl PingPlace {
    /// Returns true if its echoes have a place.
    pub fn is_placed(&self) -> bool {
        let numbers = [self.place_m, self.starboard, [self.transducer_m, self.time_s]];
        numbers.as_flattened().iter().all(|number| number.is_finite())
    }

    /// Unit vector outward on a side, east and north.
    pub fn outward(&self, side: Side) -> [f64; 2] {
        self.starboard.map(|part| side.to_starboard(part))
    }

    /// Returns the ranges and the first return of a side.
    pub fn side(&self, side: Side) -> &SideEchoes {
        &self.sides[side as usize]
    }
}

impl SideEchoes {
    /// Returns true if its samples have ranges.
    pub(crate) fn has_ranges(&self) -> bool {
        self.near_m.is_finite() && self.step_m.is_finite() && self.step_m > 0.0
    }
}

impl LogEchoes<'_> {
    /// Replaces `out` with the samples of a side of a ping, nearest first; false where there are
    /// none.
    pub fn read(&self, ping: usize, side: Side, out: &mut Vec<u8>) -> bool {
        self.levels.read(ping, side, out);
        !out.is_empty()
    }
}
