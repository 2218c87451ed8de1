//! Chooses the depths of isobaths.

use super::Smoothing;
use crate::presentation::ticks;
use crate::presentation::units::LengthUnit;
use bathyscope_log::survey::WaterArea;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// Number of isobaths from one that is thick and labelled to the next, counted from depth 0.
pub const INDEX: f64 = 5.0;
/// Largest number of isobaths: more are a mistake, not a map.
const MOST_LEVELS: f64 = 1000.0;
/// Approximate number of isobaths where the settings do not determine it.
const TARGET_LEVELS: f64 = 10.0;
/// Least interval of isobaths in standard deviations of the depth, where the settings do not
/// determine it: two thirds of the places on a line then have depths nearer to this line's than to
/// another's.
const SIGMAS_APART: f64 = 2.0;

/// The depths of a map that isobaths are drawn through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthExtent {
    /// The shallowest and the deepest depth, metres.
    pub range_m: [f64; 2],
    /// Median of the standard deviations of measured depths, metres; 0 where none is stated.
    pub error_m: f64,
}

impl DepthExtent {
    /// Returns an interval that is round in a unit of `unit_m` metres, makes about ten levels, and
    /// is no finer than the errors of measured depths; NaN for a level bottom.
    fn usual_interval_m(self, unit_m: f64) -> f64 {
        let [least_m, most_m] = self.range_m;
        if most_m > least_m {
            let apart_m = ((most_m - least_m) / TARGET_LEVELS).max(SIGMAS_APART * self.error_m);
            unit_m * ticks::round_up(apart_m / unit_m)
        } else {
            f64::NAN
        }
    }

    /// Returns true if isobaths at this interval are no finer than the errors of measured depths.
    pub fn allows(self, interval_m: f64) -> bool {
        interval_m >= SIGMAS_APART * self.error_m
    }
}

/// `isobaths.*` settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IsobathSettings {
    /// Unit in which the depths of the isobaths are round, and are written along the lines.
    pub unit: LengthUnit,
    /// Metres from one isobath to the next, counted from depth 0, rounded to two digits of the
    /// unit; when not given, 1, 2 or 5 times a power of ten of the unit that makes about ten.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_m: Option<f64>,
    /// Depths of the isobaths, metres; when there are any, the interval does not count.
    pub depths_m: Vec<f64>,
    /// Number of times the corners of the lines are cut; 0 leaves them as measured.
    pub smooth: u32,
    /// True if every depth that is shallower than a line lies on its shallow side.
    pub shoal_safe: bool,
    /// Least distance between spot soundings, metres; when not given, a round distance by the
    /// extent of the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spot_radius_m: Option<f64>,
    /// File of the area at whose edges isobaths, the areas between them and spot soundings end;
    /// when not given, they are wherever there are depths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<PathBuf>,
    /// Area in the file, once it has been read.
    #[serde(skip)]
    pub area: Option<Arc<WaterArea>>,
}

/// Reason why there are no isobaths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoIsobaths {
    /// The interval would draw more isobaths than anybody can read.
    #[error(
        "isobaths.interval_m is {interval_m}, which over depths from {least_m:.2} to {most_m:.2} m makes more than 1000 isobaths; choose a larger one"
    )]
    TooMany {
        /// The interval, metres.
        interval_m: f64,
        /// The shallowest depth, metres.
        least_m: f64,
        /// The deepest depth, metres.
        most_m: f64,
    },
    /// The file that `isobaths.clip` names was not found when the settings were read.
    #[error("the area of isobaths.clip has not been read; choose its file again: {}", path.display())]
    AreaNotRead {
        /// File of the area.
        path: PathBuf,
    },
    /// The area belongs to another water.
    #[error("the area of isobaths.clip lies elsewhere than the depths; choose that of this water: {}", path.display())]
    AreaElsewhere {
        /// File of the area.
        path: PathBuf,
    },
}

/// Returns the interval of rising depths and the first of them, metres; `None` where the depths are
/// not equally far apart, and without depths. A single depth has an interval of 1000 km.
pub fn evenly_apart_m(levels_m: &[f64]) -> Option<[f64; 2]> {
    const ALONE_M: f64 = 1e6;
    let first_m = *levels_m.first()?;
    let apart_m = levels_m.get(1).map_or(ALONE_M, |next_m| next_m - first_m);
    let mut steps = levels_m.windows(2).map(|pair| pair[1] - pair[0]);
    let is_even = steps.all(|step_m| (step_m - apart_m).abs() < 1e-6 * apart_m.abs().max(1.0));
    is_even.then_some([apart_m, first_m])
}

impl IsobathSettings {
    /// Returns the settings with an interval that is round in a unit of `unit_m` metres, where they
    /// have no interval.
    pub fn round_in(&self, unit_m: f64, depths: DepthExtent) -> Self {
        // A unit in the settings applies to files and the display alike.
        let unit_m = match self.unit {
            LengthUnit::Metres => unit_m,
            other => other.metres(),
        };
        let chosen_m = || depths.usual_interval_m(unit_m);
        Self { interval_m: Some(self.interval_m.unwrap_or_else(chosen_m)), ..self.clone() }
    }

    /// Returns the interval of the settings, metres, round in the unit: 1.52 m are 5 feet.
    fn given_m(&self) -> Option<f64> {
        let unit_m = self.unit.metres();
        let interval_m = self.interval_m?;
        Some(match self.unit {
            LengthUnit::Metres => interval_m,
            _ => unit_m * two_digits(interval_m / unit_m),
        })
    }

    /// Returns the smoothing of the lines.
    pub fn smoothing(&self) -> Smoothing {
        Smoothing { passes: self.smooth, toward_deep: self.shoal_safe }
    }

    /// Returns a depth in the unit of the lines, to a ten thousandth of the unit.
    pub fn in_unit(&self, depth_m: f64) -> f64 {
        // Adding zero makes minus zero zero.
        (depth_m / self.unit.metres() * 1e4).round() / 1e4 + 0.0
    }

    /// Returns a depth as charts print it: to a tenth of a metre or of a fathom or to a whole foot,
    /// and never deeper than it is.
    pub fn charted(&self, depth_m: f64) -> String {
        let decimals = match self.unit {
            LengthUnit::Metres | LengthUnit::Fathoms => 1,
            LengthUnit::Feet => 0,
        };
        let steps = 10f64.powi(decimals);
        // A rounding error of the quotient must not cost a step; adding zero makes minus zero zero.
        let whole = (depth_m / self.unit.metres() * steps + 1e-6).floor() / steps + 0.0;
        format!("{whole:.*}", decimals as usize)
    }

    /// Returns true if an isobath is an index isobath, which is every fifth, at an interval of
    /// `step_m`.
    pub fn is_index(depth_m: f64, step_m: f64) -> bool {
        let count = (depth_m / step_m).round();
        (count / INDEX).fract() == 0.0
    }

    /// Returns the metres from one isobath to the next; `None` where their depths were listed.
    pub fn step_m(&self, levels_m: &[f64]) -> Option<f64> {
        if !self.depths_m.is_empty() {
            return None;
        }
        let first_two = levels_m.first().zip(levels_m.get(1));
        self.given_m().or(first_two.map(|(first, second)| second - first))
    }

    /// Returns the levels that a map makes thick and labels: every fifth level; all levels where
    /// none of them is a fifth, or their depths were listed.
    pub fn index_levels_m(&self, levels_m: &[f64]) -> Vec<f64> {
        let step_m = self.step_m(levels_m);
        let fifth = |level_m: &&f64| step_m.is_some_and(|step_m| Self::is_index(**level_m, step_m));
        let index: Vec<f64> = levels_m.iter().filter(fifth).copied().collect();
        if index.is_empty() { levels_m.to_vec() } else { index }
    }

    /// Returns the metres from one isobath to the next for some depths, where none are listed; NaN
    /// for depths that are all equal.
    pub fn interval_m(&self, depths: DepthExtent) -> f64 {
        self.given_m().unwrap_or_else(|| depths.usual_interval_m(self.unit.metres()))
    }

    /// Returns the levels for some depths, metres, ascending.
    ///
    /// # Errors
    /// When the interval makes more than 1000 levels.
    pub fn levels_m(&self, depths: DepthExtent) -> Result<Vec<f64>, NoIsobaths> {
        let [least_m, most_m] = depths.range_m;
        if !self.depths_m.is_empty() {
            let mut levels_m = self.depths_m.clone();
            levels_m.sort_by(f64::total_cmp);
            levels_m.dedup();
            return Ok(levels_m);
        }
        let interval_m = self.interval_m(depths);
        let [first, last] = [(least_m / interval_m).ceil(), (most_m / interval_m).floor()];
        if last - first >= MOST_LEVELS {
            return Err(NoIsobaths::TooMany { interval_m, least_m, most_m });
        }
        // A level bottom has an interval of NaN, and no isobath.
        let count = if interval_m > 0.0 && first <= last { (last - first) as usize + 1 } else { 0 };
        // Rounded to the micrometre, so that three times 0.1 is 0.3.
        let level_m = |step: usize| ((first + step as f64) * interval_m * 1e6).round() / 1e6;
        Ok((0..count).map(level_m).collect())
    }
}

/// Returns a number rounded to two digits.
fn two_digits(value: f64) -> f64 {
    let unit = 10f64.powf(value.abs().log10().floor() - 1.0);
    if unit.is_normal() { (value / unit).round() * unit } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Depths without errors.
    fn exact(range_m: [f64; 2]) -> DepthExtent {
        DepthExtent { range_m, error_m: 0.0 }
    }

    fn levels(interval_m: Option<f64>, range_m: [f64; 2]) -> Vec<f64> {
        let settings = IsobathSettings { interval_m, ..IsobathSettings::default() };
        settings.levels_m(exact(range_m)).unwrap()
    }

    #[test]
    fn isobaths_are_no_finer_than_the_error_unless_somebody_asks() {
        let mut settings = IsobathSettings::default();
        let depths = DepthExtent { range_m: [2.0, 3.0], error_m: 0.11 };
        assert_eq!(settings.levels_m(depths), Ok(vec![2.0, 2.5, 3.0]));
        settings.interval_m = Some(0.1);
        assert_eq!(settings.levels_m(depths).map(|levels_m| levels_m.len()), Ok(11));
        assert!(!depths.allows(0.1) && depths.allows(0.5));
    }

    #[test]
    fn an_interval_counts_from_zero() {
        assert_eq!(levels(Some(0.1), [0.15, 0.4]), [0.2, 0.3, 0.4]);
        assert_eq!(levels(Some(0.5), [-0.7, 0.6]), [-0.5, 0.0, 0.5]);
        assert_eq!(levels(Some(5.0), [1.0, 4.0]), [0.0; 0]);
    }

    #[test]
    fn every_fifth_isobath_is_thick_counted_from_zero() {
        let levels_m: Vec<f64> = (-3..12).map(|count| 0.2 * f64::from(count)).collect();
        let mut settings = IsobathSettings::default();
        assert_eq!(settings.index_levels_m(&levels_m), [0.0, 1.0, 2.0]);
        assert_eq!(settings.index_levels_m(&levels_m[4..7]).len(), 3, "none is a fifth");
        settings.depths_m = vec![1.0, 2.5];
        assert_eq!(settings.index_levels_m(&settings.depths_m), [1.0, 2.5]);
    }

    #[test]
    fn without_one_there_are_about_ten() {
        assert_eq!(levels(None, [1.03, 3.02]).len(), 10);
        assert_eq!(levels(None, [1.0, 8.9])[..2], [1.0, 2.0]);
        assert_eq!(levels(None, [2.0, 2.0]), [0.0; 0]);
    }

    #[test]
    fn the_interval_of_a_unit_is_round_in_it() {
        let depths = exact([1.0, 8.9]);
        let feet = IsobathSettings::default().round_in(0.3048, depths);
        let levels_m = feet.levels_m(depths).unwrap();
        assert_eq!(levels_m[..2], [1.524, 3.048], "5 and 10 feet");
        let metres = IsobathSettings::default().round_in(1.0, depths);
        assert_eq!(metres.levels_m(depths), IsobathSettings::default().levels_m(depths));
    }

    #[test]
    fn the_unit_of_the_settings_rounds_what_is_given_and_what_is_not() {
        let mut settings = IsobathSettings {
            unit: LengthUnit::Feet,
            interval_m: Some(1.52),
            ..IsobathSettings::default()
        };
        let in_feet = |settings: &IsobathSettings| -> Vec<f64> {
            let levels_m = settings.levels_m(exact([1.0, 8.9])).unwrap();
            levels_m.iter().map(|level_m| settings.in_unit(*level_m)).collect()
        };
        assert_eq!(in_feet(&settings), [5.0, 10.0, 15.0, 20.0, 25.0]);
        assert_eq!(settings.step_m(&[]).map(|step_m| settings.in_unit(step_m)), Some(5.0));
        settings.interval_m = None;
        assert_eq!(in_feet(&settings)[..2], [5.0, 10.0]);
        // The window's unit does not count then.
        let shown = settings.round_in(1.0, exact([1.0, 8.9]));
        assert_eq!(in_feet(&shown), in_feet(&settings));
        settings.unit = LengthUnit::Fathoms;
        assert_eq!(in_feet(&settings)[..2], [1.0, 1.5]);
        assert_eq!([two_digits(0.0), two_digits(4.987)], [0.0, 5.0]);
    }

    #[test]
    fn a_charted_depth_is_never_deeper_than_the_depth() {
        let charted = |unit: LengthUnit, depth_m: f64| {
            let settings = IsobathSettings { unit, ..IsobathSettings::default() };
            settings.charted(depth_m)
        };
        let metres = |depth_m| charted(LengthUnit::Metres, depth_m);
        assert_eq!([metres(2.39), metres(2.3), metres(-0.02)], ["2.3", "2.3", "-0.1"]);
        assert_eq!(charted(LengthUnit::Feet, 3.0), "9");
        assert_eq!(charted(LengthUnit::Feet, 3.048), "10");
        assert_eq!(charted(LengthUnit::Fathoms, 1.8288), "1.0");
    }

    #[test]
    fn a_list_wins_and_a_flood_is_refused() {
        let mut settings = IsobathSettings { interval_m: Some(1e-4), ..IsobathSettings::default() };
        assert!(settings.levels_m(exact([0.0, 3.0])).is_err());
        settings.depths_m = vec![3.0, 1.0, 3.0];
        assert_eq!(settings.levels_m(exact([0.0, 3.0])), Ok(vec![1.0, 3.0]));
    }
}
