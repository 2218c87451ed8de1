//! Computes the uncertainty that all depths of a survey have in common. Left-out soundings do not
//! show it, since the depths that remain have the same error.

use super::joint::crossing_error;
use super::{ProcessedLog, Products};
use bathyscope_bottom::bathymetry::{CrossingError, Spread, Surface};
use bathyscope_bottom::calibration::Calibration;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use serde::Serialize;

/// Standard deviation of a sound speed from the settings, as a share of it: a change of water
/// temperature of 1 °C changes it by about 3 m/s.
const SPEED_SHARE: f64 = 0.002;
/// Standard deviation of a draft and of a water level from the settings, metres, as both are read
/// off a scale.
const READING_M: f64 = 0.02;
/// Smallest error of the edge of a first return, samples.
const EDGE_SAMPLES: f64 = 0.25;

/// Parts of a depth's uncertainty that are common to a survey, one standard deviation each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CommonUncertainty {
    /// Standard deviation of the constant between first-return ranges and recorded depths, with the
    /// part of the constant that remains after its correction, metres.
    pub range_offset_m: f64,
    /// Standard deviation of the sound speed, as a share of the depth; 0 if no speed is set: depths
    /// are then as the recorder computed them.
    pub sound_speed_share: f64,
    /// Standard deviation of the draft, metres; 0 if no draft is set: depths then count from the
    /// transducer.
    pub draft_m: f64,
    /// Standard deviation of the water level, metres; 0 if no level is set.
    pub water_level_m: f64,
    /// Error of depths that crossings of tracks with themselves and each other show: waves, levels,
    /// positions, delays and wide beams together; 0 without crossings.
    pub crossings: CrossingError,
    /// Standard deviation of positions along the ground, metres, by the remaining part of the
    /// recorder's rounding: multiplied by the slope of the bottom it is an error of the depth.
    pub position_m: f64,
    /// Least angle by which the beam of the sounder is wider than that of the side-scan, radians; 0
    /// where it is not. On a slope soundings are then those of nearer ground.
    pub sounder_beam_rad: f64,
}

impl CommonUncertainty {
    /// Computes the uncertainty of one log, without its crossings.
    pub(crate) fn of_log(products: &Products) -> Self {
        let Products { navigation, calibration, correction, .. } = products;
        let where_given = |sigma: f64, is_given: bool| if is_given { sigma } else { 0.0 };
        Self {
            range_offset_m: range_offset_m(calibration),
            sound_speed_share: where_given(SPEED_SHARE, correction.knows_sound_speed()),
            draft_m: where_given(READING_M, correction.knows_draft()),
            water_level_m: where_given(READING_M, correction.knows_level())
                .hypot(correction.gap_sigma_m()),
            crossings: CrossingError::default(),
            position_m: navigation.rounding_m,
            sounder_beam_rad: calibration.beams.wider_rad,
        }
    }

    /// Computes the uncertainty of the logs of a survey: the root mean square of the uncertainties
    /// of the logs, and the error that their crossings show.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn of(logs: &[ProcessedLog], progress: &Progress) -> Result<Self, Cancelled> {
        let each = logs.iter().map(|log| Self::of_log(&log.products));
        let each: Vec<Self> = each.collect();
        let rms = |of: fn(&Self) -> f64| {
            let squares: f64 = each.iter().map(|log| of(log).powi(2)).sum();
            (squares / each.len().max(1) as f64).sqrt()
        };
        let crossings = crossing_error(logs, progress)?.unwrap_or_default();
        Ok(Self {
            range_offset_m: rms(|log| log.range_offset_m),
            sound_speed_share: rms(|log| log.sound_speed_share),
            draft_m: rms(|log| log.draft_m),
            water_level_m: rms(|log| log.water_level_m),
            crossings,
            position_m: rms(|log| log.position_m),
            sounder_beam_rad: rms(|log| log.sounder_beam_rad),
        })
    }

    /// Returns the standard deviation at a depth on a slope (metres a metre), metres: the root of
    /// the sum of squares, as in the total vertical uncertainty of IHO S-44.
    pub fn at(&self, depth_m: f64, slope: f64) -> f64 {
        let parts = [
            self.range_offset_m,
            self.sound_speed_share * depth_m,
            self.draft_m,
            self.water_level_m,
            self.crossings.at(slope),
            self.position_m * slope,
            nearer_share(slope, self.sounder_beam_rad) * depth_m,
        ];
        parts.iter().map(|part| part * part).sum::<f64>().sqrt()
    }

    /// Adds this uncertainty to the stated error of every cell of a surface; a surface whose
    /// spreads are not errors stays unchanged.
    pub fn add_to(&self, surface: &mut Surface) {
        if surface.spread_is != Spread::OfError {
            return;
        }
        let columns = surface.grid.columns;
        let spreads_m = (0..surface.spread_m.len()).into_par_iter().map(|cell| {
            if surface.spread_m[cell].is_nan() {
                return f32::NAN;
            }
            let [east, north, up] = surface.normal(cell / columns, cell % columns);
            let slope = f64::from(east.hypot(north) / up);
            let common_m = self.at(f64::from(surface.depth_m[cell]), slope);
            f64::from(surface.spread_m[cell]).hypot(common_m) as f32
        });
        surface.spread_m = spreads_m.collect();
    }
}

/// Returns the share of the depth by which the nearest ground within `beam_rad` of straight below
/// is nearer, on a slope (metres a metre).
fn nearer_share(slope: f64, beam_rad: f64) -> f64 {
    let slope_rad = slope.atan();
    if beam_rad > 0.0 { 1.0 - slope_rad.cos() / (slope_rad - beam_rad).max(0.0).cos() } else { 0.0 }
}

/// Returns the standard deviation of the constant between first-return ranges and recorded depths,
/// with the part of the constant that remains after its correction, metres.
fn range_offset_m(calibration: &Calibration) -> f64 {
    let Some([left_m, two_sigma_m]) = calibration.remaining_offset_m() else {
        return 0.0;
    };
    let edge_m = (calibration.header).map_or(0.0, |scale| EDGE_SAMPLES / scale.px_per_m);
    left_m.hypot(0.5 * two_sigma_m).hypot(edge_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_beam_takes_the_nearest_ground_of_a_slope() {
        let of = |sounder_beam_rad: f64| {
            let parts = CommonUncertainty { sounder_beam_rad, ..CommonUncertainty::default() };
            [0.0, 5f64, 30.0].map(|slope_deg| parts.at(10.0, slope_deg.to_radians().tan()))
        };
        assert_eq!(of(0.0), [0.0; 3]);
        // On 5 degrees the nearest ground lies within the beam, on 30 at its edge.
        let expected_m =
            [0.0, 10.0 * (1.0 - 5f64.to_radians().cos()), 10.0 * (1.0 - 0.866_03 / 0.939_69)];
        for (found_m, expected_m) in of(10f64.to_radians()).into_iter().zip(expected_m) {
            assert!((found_m - expected_m).abs() < 1e-4, "{found_m} {expected_m}");
        }
    }
}
