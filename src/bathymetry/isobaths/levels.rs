//! Which depths isobaths are drawn at.

use crate::presentation::ticks;
use serde::{Deserialize, Serialize};

/// More isobaths than this are a mistake, not a map.
const MOST_LEVELS: f64 = 1000.0;
/// About so many are drawn where nobody says how many.
const TARGET_LEVELS: f64 = 10.0;

/// `isobaths.*` settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IsobathSettings {
    /// Metres from one isobath to the next, counted from depth 0; when not given, 1, 2 or 5 times a power of ten that makes
    /// about ten.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_m: Option<f64>,
    /// Depths of the isobaths, metres; when there are any, the interval does not count.
    pub depths_m: Vec<f64>,
    /// How often the corners of the lines are cut; 0 leaves them as measured.
    pub smooth: u32,
}

/// The interval would draw more isobaths than anybody can read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "isobaths.interval_m is {interval_m}, which over depths from {least_m:.2} to {most_m:.2} m makes more than 1000 isobaths; choose a larger one"
)]
pub struct TooManyLevels {
    interval_m: f64,
    least_m: f64,
    most_m: f64,
}

/// Metres from one of some rising depths to the next, and the first of them; `None` where they are not equally far apart, and of none.
pub fn evenly_apart_m(levels_m: &[f64]) -> Option<[f64; 2]> {
    const ALONE_M: f64 = 1e6;
    let first_m = *levels_m.first()?;
    let apart_m = levels_m.get(1).map_or(ALONE_M, |next_m| next_m - first_m);
    let mut steps = levels_m.windows(2).map(|pair| pair[1] - pair[0]);
    let is_even = steps.all(|step_m| (step_m - apart_m).abs() < 1e-6 * apart_m.abs().max(1.0));
    is_even.then_some([apart_m, first_m])
}

impl IsobathSettings {
    /// The same with an interval that is round in a unit of so many metres, where it is left to the depths between two.
    pub fn round_in(&self, unit_m: f64, [least_m, most_m]: [f64; 2]) -> Self {
        let chosen_m = || unit_m * readable((most_m - least_m) / TARGET_LEVELS / unit_m);
        Self {
            interval_m: Some(self.interval_m.unwrap_or_else(chosen_m)),
            ..self.clone()
        }
    }

    /// The levels, ascending, for depths between two.
    pub fn levels_m(&self, [least_m, most_m]: [f64; 2]) -> Result<Vec<f64>, TooManyLevels> {
        if !self.depths_m.is_empty() {
            let mut levels_m = self.depths_m.clone();
            levels_m.sort_by(f64::total_cmp);
            levels_m.dedup();
            return Ok(levels_m);
        }
        let interval_m = self
            .interval_m
            .unwrap_or_else(|| readable((most_m - least_m) / TARGET_LEVELS));
        let [first, last] = [(least_m / interval_m).ceil(), (most_m / interval_m).floor()];
        if last - first >= MOST_LEVELS {
            return Err(TooManyLevels {
                interval_m,
                least_m,
                most_m,
            });
        }
        // A level bottom has an interval that is no number, and no isobath.
        let count = match interval_m > 0.0 && first <= last {
            true => (last - first) as usize + 1,
            false => 0,
        };
        Ok((0..count)
            .map(|step| tidy((first + step as f64) * interval_m))
            .collect())
    }
}

/// A round interval, at least so long; no number for a level bottom.
fn readable(at_least_m: f64) -> f64 {
    match at_least_m > 0.0 {
        true => ticks::round_up(at_least_m),
        false => f64::NAN,
    }
}

/// To the micrometre: three times 0.1 is 0.3.
fn tidy(metres: f64) -> f64 {
    (metres * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(interval_m: Option<f64>, range_m: [f64; 2]) -> Vec<f64> {
        let settings = IsobathSettings {
            interval_m,
            ..IsobathSettings::default()
        };
        settings.levels_m(range_m).unwrap()
    }

    #[test]
    fn an_interval_counts_from_zero() {
        assert_eq!(levels(Some(0.1), [0.15, 0.4]), [0.2, 0.3, 0.4]);
        assert_eq!(levels(Some(0.5), [-0.7, 0.6]), [-0.5, 0.0, 0.5]);
        assert_eq!(levels(Some(5.0), [1.0, 4.0]), [0.0; 0]);
    }

    #[test]
    fn without_one_there_are_about_ten() {
        assert_eq!(levels(None, [1.03, 3.02]).len(), 10);
        assert_eq!(levels(None, [1.0, 8.9])[..2], [1.0, 2.0]);
        assert_eq!(levels(None, [2.0, 2.0]), [0.0; 0]);
    }

    #[test]
    fn the_interval_of_a_unit_is_round_in_it() {
        let range_m = [1.0, 8.9];
        let feet = IsobathSettings::default().round_in(0.3048, range_m);
        let levels_m = feet.levels_m(range_m).unwrap();
        assert_eq!(levels_m[..2], [1.524, 3.048], "5 and 10 feet");
        let metres = IsobathSettings::default().round_in(1.0, range_m);
        assert_eq!(
            metres.levels_m(range_m),
            IsobathSettings::default().levels_m(range_m)
        );
    }

    #[test]
    fn a_list_wins_and_a_flood_is_refused() {
        let mut settings = IsobathSettings {
            interval_m: Some(1e-4),
            ..IsobathSettings::default()
        };
        assert!(settings.levels_m([0.0, 3.0]).is_err());
        settings.depths_m = vec![3.0, 1.0, 3.0];
        assert_eq!(settings.levels_m([0.0, 3.0]), Ok(vec![1.0, 3.0]));
    }
}
