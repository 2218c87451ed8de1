//! Finds weed: stretches where first returns lie above the bottom on both sides. The brightness of
//! weed says nothing of the bed's slope.

use super::echoes::{LogEchoes, PingPlace};
use crate::nearest::Nearest;
use bathyscope_log::survey::Side;

/// Pings that are evaluated together.
const PINGS: usize = 15;
/// Share of them above the bottom from which on they are weed.
const SHARE: f64 = 0.5;
/// Echoes nearer than this to such a ping are left out, metres.
const REACH_M: f64 = 3.5;

/// Places of pings in stretches of weed.
pub(super) struct WeedPlaces(Option<Nearest>);

impl WeedPlaces {
    /// Creates the places from some logs, each with true for each of its pings that is in a stretch
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

/// Returns for each ping of a log true if it is in a stretch of weed. A slope makes the first
/// returns of one side alone nearer than the recorded depth, so both sides are required.
pub(super) fn is_weed(log: &LogEchoes<'_>) -> Vec<bool> {
    let [port, starboard] = Side::BOTH.map(|side| {
        let above = |ping: &PingPlace| ping.side(side).above_bottom;
        running_share(&log.pings.iter().map(above).collect::<Vec<bool>>())
    });
    let both = port.into_iter().zip(starboard);
    both.map(|(port, starboard)| port.min(starboard) > SHARE).collect()
}

/// Share of the pings around each; beyond both ends none lies above the bottom.
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
