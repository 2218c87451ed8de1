//! Finds the ping nearest to a place. The boat cannot jump: a few hundred pings in a row lie close
//! together, and a box around them shows whether they need to be looked at.

use super::transform::{GroundBounds, around, away_m};
use bathyscope_log::survey::{Navigation, PingNav};
use std::sync::Arc;

/// Pings in a box.
const PINGS: usize = 256;

/// Boxes around the pings of a track.
pub(super) struct PingBoxes {
    navigation: Arc<Navigation>,
    boxes: Vec<GroundBounds>,
}

impl PingBoxes {
    /// One pass over the pings.
    pub(super) fn new(navigation: Arc<Navigation>) -> Self {
        let places = |pings: &[PingNav]| around(pings.iter().map(|one| [one.east_m, one.north_m]));
        let boxes = navigation.pings.chunks(PINGS).map(places);
        Self { boxes: boxes.collect(), navigation }
    }

    /// The ping nearest to a place and its distance, metres, if one is within `reach_m`.
    pub(super) fn nearest(&self, place: [f64; 2], reach_m: f64) -> Option<(usize, f64)> {
        let away = self.boxes.iter().map(|bounds| {
            let [beside, beyond] = away_m(place, bounds);
            beside * beside + beyond * beyond
        });
        let away = away.enumerate();
        // The nearest box first: what it holds rules out most of the others.
        let (first, _) = away.clone().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut best = (reach_m * reach_m, None);
        self.look_into(first, place, &mut best);
        for (index, square) in away {
            if square <= best.0 && index != first {
                self.look_into(index, place, &mut best);
            }
        }
        Some((best.1?, best.0.sqrt()))
    }

    fn look_into(
        &self,
        index: usize,
        [east_m, north_m]: [f64; 2],
        best: &mut (f64, Option<usize>),
    ) {
        let start = index * PINGS;
        let pings = self.navigation.pings.iter().skip(start).take(PINGS);
        for (ping, place) in (start..).zip(pings) {
            let square = (place.east_m - east_m).powi(2) + (place.north_m - north_m).powi(2);
            if square < best.0 || (square == best.0 && best.1.is_none()) {
                *best = (square, Some(ping));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_that_of_a_look_at_all() {
        let place = |ping: usize| {
            let (sin, cos) = (ping as f64 * 0.013).sin_cos();
            let reach_m = 5.0 + ping as f64 * 0.02;
            PingNav {
                east_m: if ping % 400 < 3 { f64::NAN } else { reach_m * cos },
                north_m: reach_m * sin,
                heading_rad: 0.0,
                speed_mps: 1.0,
            }
        };
        let pings: Vec<PingNav> = (0..3000).map(place).collect();
        let navigation = Navigation::of_pings(pings.clone());
        let boxes = PingBoxes::new(Arc::new(navigation));
        for step in 0..200 {
            let (sin, cos) = f64::from(step).sin_cos();
            let at = [0.5 * f64::from(step) * cos, 0.5 * f64::from(step) * sin];
            let off = |ping: &PingNav| (ping.east_m - at[0]).hypot(ping.north_m - at[1]);
            let all = pings.iter().map(off).filter(|off| off.is_finite());
            let least_m = all.fold(f64::MAX, f64::min);
            let found = boxes.nearest(at, 20.0);
            assert_eq!(found.is_some(), least_m <= 20.0, "{at:?}");
            assert!(
                found.is_none_or(|(ping, away_m)| {
                    off(&pings[ping]) == least_m && (away_m - least_m).abs() < 1e-9
                }),
                "{at:?}"
            );
        }
    }
}
