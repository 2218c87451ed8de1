//! Defines the data that the method reads of a log (the place of every ping, the ranges of its
//! samples and its first returns), and finds the stretches of weed from them.

use crate::nearest::Nearest;
use bathyscope_log::survey::{Side, Survey};

/// Source of the samples of a log, which are read one ping at a time.
pub trait SampleSource: Sync {
    /// Replaces `out` with the samples of a side of a ping, nearest first; `out` is empty where
    /// there are none.
    fn read(&self, ping: usize, side: Side, out: &mut Vec<u8>);
}

/// Number of pings that are evaluated together for weed.
const PINGS: usize = 15;
/// Share of these pings with above-bottom returns from which on a ping is in weed.
const SHARE: f64 = 0.5;
/// Distance from a ping in weed within which echoes are left out, metres.
const REACH_M: f64 = 3.5;

impl SampleSource for Survey {
    fn read(&self, ping: usize, side: Side, out: &mut Vec<u8>) {
        out.clear();
        if let Some(samples) = self.samples(ping, side) {
            samples.copy_outward(out);
        }
    }
}

/// Log with its pings in the plane of a surface.
#[derive(Clone)]
pub struct LogEchoes<'a> {
    /// Source of the levels of the recording.
    pub levels: &'a dyn SampleSource,
    /// One entry for each side-scan ping.
    pub pings: Vec<PingPlace>,
}

/// Place of a ping, and the ranges of its samples.
#[derive(Clone, Copy, Debug)]
pub struct PingPlace {
    /// Time of the ping in the log, seconds.
    pub time_s: f64,
    /// Place in the plane, east and north, metres; NaN where the place is unknown or the ping is
    /// excluded.
    pub place_m: [f64; 2],
    /// Unit vector to starboard, east and north; NaN without a heading.
    pub starboard: [f64; 2],
    /// Depth of the transducer below the zero level of the surface's depths, metres.
    pub transducer_m: f64,
    /// Ranges and first returns of both sides, port first.
    pub sides: [SideEchoes; 2],
}

/// Ranges and first return of one side of a ping.
#[derive(Clone, Copy, Debug)]
pub struct SideEchoes {
    /// Slant range of the near edge of the first sample, metres; NaN where the side was not
    /// recorded.
    pub near_m: f64,
    /// Slant range that a sample covers, metres.
    pub step_m: f64,
    /// First return, in samples; NaN where there is none.
    pub first_return: f64,
    /// True if the first return is above the recorded depth.
    pub above_bottom: bool,
}

impl PingPlace {
    /// Returns true if the echoes of the ping have a place.
    pub fn is_placed(&self) -> bool {
        let numbers = [self.place_m, self.starboard, [self.transducer_m, self.time_s]];
        numbers.as_flattened().iter().all(|number| number.is_finite())
    }

    /// Returns the unit vector outward on a side, east and north.
    pub fn outward(&self, side: Side) -> [f64; 2] {
        self.starboard.map(|part| side.to_starboard(part))
    }

    /// Returns the ranges and the first return of a side.
    pub fn side(&self, side: Side) -> &SideEchoes {
        &self.sides[side as usize]
    }
}

impl SideEchoes {
    /// Returns true if the samples have ranges.
    pub(crate) fn has_ranges(&self) -> bool {
        self.near_m.is_finite() && self.step_m.is_finite() && self.step_m > 0.0
    }
}

impl LogEchoes<'_> {
    /// Replaces `out` with the samples of a side of a ping, nearest first; returns false where
    /// there are none.
    pub fn read(&self, ping: usize, side: Side, out: &mut Vec<u8>) -> bool {
        self.levels.read(ping, side, out);
        !out.is_empty()
    }
}

/// Places of pings in stretches of weed; `None` without such pings.
pub(super) struct WeedPlaces(Option<Nearest>);

impl WeedPlaces {
    /// Creates the places from some logs, each with a list that is true for its pings in a stretch
    /// of weed.
    pub(super) fn of<'a>(logs: impl Iterator<Item = (&'a LogEchoes<'a>, &'a [bool])>) -> Self {
        let in_weed = |(log, is_weed): (&LogEchoes<'_>, &[bool])| -> Vec<[f64; 2]> {
            let pings = log.pings.iter().zip(is_weed);
            let pings = pings.filter(|(ping, is_weed)| **is_weed && ping.is_placed());
            pings.map(|(ping, _)| ping.place_m).collect()
        };
        let places: Vec<[f64; 2]> = logs.flat_map(in_weed).collect();
        Self(Nearest::of(&places))
    }

    /// Returns true if a place east and north is far from all weed.
    pub(super) fn is_far_from(&self, place: [f64; 2]) -> bool {
        let nearest = self.0.as_ref();
        nearest.is_none_or(|nearest| nearest.at(place).1 >= REACH_M * REACH_M)
    }
}

/// Returns a list that is true for each ping of a log in a stretch of weed. A slope makes the first
/// returns of one side alone nearer than the recorded depth, so above-bottom returns on both sides
/// are required.
///
/// The brightness of weed holds no information about the slope of the bed.
pub(super) fn is_weed(log: &LogEchoes<'_>) -> Vec<bool> {
    let [port, starboard] = Side::BOTH.map(|side| {
        let above = |ping: &PingPlace| ping.side(side).above_bottom;
        running_share(&log.pings.iter().map(above).collect::<Vec<bool>>())
    });
    let both = port.into_iter().zip(starboard);
    both.map(|(port, starboard)| port.min(starboard) > SHARE).collect()
}

/// Returns the share of above-bottom returns in the pings around each ping; pings beyond both ends
/// count as without.
fn running_share(above: &[bool]) -> Vec<f64> {
    let half = PINGS / 2;
    let around =
        |ping: usize| &above[ping.saturating_sub(half)..(ping + half + 1).min(above.len())];
    let count = |ping: usize| around(ping).iter().filter(|above| **above).count();
    (0..above.len()).map(|ping| count(ping) as f64 / PINGS as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_counts_the_pings_on_both_sides() {
        let above: Vec<bool> = (0..40).map(|ping| (10..20).contains(&ping)).collect();
        let shares = running_share(&above);
        assert_eq!(shares[15], 10.0 / 15.0);
        assert_eq!(shares[6], 4.0 / 15.0);
        assert_eq!(shares[39], 0.0);
    }
}
