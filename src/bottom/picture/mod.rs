//! Prepares the display of the side-scan of one log: gain, stripe filter, levels, and the place of
//! an echo across the track.
//!
//! In: a survey with its first returns and calibration. Out: tables of gain and scale for each
//! ping, and levels.
//!
//! ```text
//! FirstReturns + Calibration --PingScales--> altitude and scale of every ping and side
//! Survey --stripe_factors--> a factor for every ping and side
//! PingScales + GainTable + factors --LogPicture--> what a row of a tile is levelled by, and sampled echoes
//! echoes + PictureSettings --LevelHistogram--> Levels
//! ```
//!
//! Nothing here is computed for each texel of a tile: a change of gain changes a few numbers and
//! needs no new tiles.

mod log_picture;
mod scales;
mod stripes;

pub use log_picture::{LevelHistogram, LogPicture};
pub use scales::{Extremes, PictureGeometry, PingScale, PingScales};
pub use stripes::stripe_factors;

use crate::mosaic::Gain;
use bathyscope_log::survey::Side;
use serde::{Deserialize, Serialize};

/// `picture.*` settings. Each log has its own; they change no result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PictureSettings {
    /// Gain normalisation: levels are shown as recorded, or divided by the log's own mean at their
    /// range and angle, as in the mosaic.
    pub gain: Gain,
    /// Time-varied gain for spreading, dB for each decade of slant range: `k log10 r`.
    pub spreading_db: f64,
    /// Time-varied gain for absorption, dB for each metre of the path of sound: `2 alpha r`.
    pub absorption_db_m: f64,
    /// Brightening of starboard against port, dB.
    pub balance_db: f64,
    /// True if each echo is replaced by the median of the 3 x 3 echoes around it.
    pub despeckle: bool,
    /// True if pings that are brighter or darker than the pings around them are scaled to their
    /// level.
    pub stripe_filter: bool,
    /// Level shown as 0, of 255; `None` for an automatic level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub black: Option<f64>,
    /// Level shown as 1, of 255; `None` for an automatic level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub white: Option<f64>,
    /// Gamma: the shown brightness is raised to 1 / gamma, so that a gamma above 1 brightens dark
    /// echoes.
    pub gamma: f64,
    /// True if later pings are shown to the left, or above.
    pub flip: bool,
    /// True if port is shown where starboard is, and starboard where port is. The data stay as they
    /// are.
    pub starboard_first: bool,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            gain: Gain::Empirical,
            spreading_db: 0.0,
            absorption_db_m: 0.0,
            balance_db: 0.0,
            despeckle: false,
            stripe_filter: false,
            black: None,
            white: None,
            gamma: 1.0,
            flip: false,
            starboard_first: false,
        }
    }
}

/// Numbers of the settings for the echoes of a log: those that a histogram depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// True if levels are multiplied by the gain table.
    pub is_normalised: bool,
    /// True if levels are multiplied by the factors of the stripe filter.
    pub is_even: bool,
    /// Time-varied gain for spreading, dB for each decade of slant range.
    pub spreading_db: f32,
    /// Time-varied gain for absorption, dB for each metre of the path of sound, there and back.
    pub absorption_db_m: f32,
    /// Balance: factors of port and starboard.
    pub sides: [f32; 2],
}

impl PictureSettings {
    /// Returns the numbers of the settings for the echoes.
    pub fn tone(&self) -> Tone {
        let half = 10f64.powf(self.balance_db / 40.0) as f32;
        Tone {
            is_normalised: self.gain == Gain::Empirical,
            is_even: self.stripe_filter,
            spreading_db: self.spreading_db as f32,
            absorption_db_m: self.absorption_db_m as f32,
            sides: [1.0 / half, half],
        }
    }

    /// Returns the settings after `Reset`: levels, gain and filters as for a new log, with the
    /// arrangement of the picture kept.
    pub fn reset(&self) -> Self {
        Self { flip: self.flip, starboard_first: self.starboard_first, ..Self::default() }
    }
}

impl Tone {
    /// Returns true if echoes are shown as they were recorded.
    pub fn is_plain(&self) -> bool {
        let plain = PictureSettings { gain: Gain::Recorded, ..PictureSettings::default() };
        *self == plain.tone()
    }

    /// Returns the factor of time-varied gain and balance on echoes of a side at a slant range,
    /// metres: `k log10 r + 2 alpha r` dB of amplitude, 0 dB at `middle_m`.
    pub fn factor(&self, side: Side, range_m: f32, middle_m: f32) -> f32 {
        let range_m = range_m.max(LEAST_RANGE_M);
        let spreading = self.spreading_db * (range_m / middle_m).log10();
        let absorption = 2.0 * self.absorption_db_m * (range_m - middle_m);
        let of_side = self.sides[side as usize];
        of_side * 10f32.powf((spreading + absorption) / 20.0)
    }
}

/// Slant range below which time-varied gain is constant, metres: only the transmit pulse is
/// detected there.
pub const LEAST_RANGE_M: f32 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_varied_gain_is_that_of_the_equation() {
        let settings = PictureSettings {
            spreading_db: 30.0,
            absorption_db_m: 0.1,
            balance_db: 6.0,
            ..PictureSettings::default()
        };
        let tone = settings.tone();
        let db = |side, range_m| 20.0 * tone.factor(side, range_m, 20.0).log10();
        assert!((db(Side::Starboard, 20.0) - 3.0).abs() < 1e-4);
        assert!((db(Side::Port, 20.0) + 3.0).abs() < 1e-4);
        // 30 log10(2) + 2 x 0.1 x 20
        let expected = 9.0309 + 4.0;
        let farther = db(Side::Port, 40.0) - db(Side::Port, 20.0);
        assert!((farther - expected).abs() < 1e-3, "{farther}");
        assert!(tone.factor(Side::Port, 0.0, 20.0).is_finite());
        assert!(!tone.is_plain());
    }
}
