//! Draws the side-scan mosaic tile by tile: every echo at its place on the ground.
//!
//! In: a survey with its navigation, first returns, calibration and relief. Out: gain tables,
//! layouts, and tiles of the mosaic.
//!
//! ```text
//! FirstReturns --altitudes_m--> height over the ground of every ping and side
//! Navigation --layout--> MosaicLayout: rays in the plane of the map, which tiles they cross
//! Survey --gain--> GainTable: what level the ground has by range and angle
//! MosaicLayout + GainTable --line--> levels of each ping at even steps on the ground
//! lines --paint, canvas--> Tile of 256 x 256 cells
//!                            '--part--> what one log shows of a tile, to be joined with those of others later
//! ```
//!
//! The ground to the side of the boat comes from the log's own depths
//! ([`bathyscope_log::survey::Relief`]), adjusted to the first return, which comes from the nearest
//! ground. Where no depth is known, the ground is level at the altitude `h` of the first return, so
//! an echo at slant range `r` comes from `g = sqrt(r^2 - h^2)` across-track. Between two pings the
//! ray turns and moves evenly, so that the strips close without gaps on the outer side of a bend.
//! The time and memory for a tile are in proportion to the ground that it shows; nothing grows with
//! the area of the mosaic.

mod canvas;
mod gain;
mod joint;
mod layout;
mod line;
mod paint;

pub use canvas::Overlap;
pub use gain::{GainTable, gain_table};
pub use joint::{
    LEVEL_CELL_M, footprint, joint_bounds, joint_grid, level_differences, level_factor,
    match_levels,
};
pub use layout::{Bounds, MosaicLayout, MosaicRay, TILE_CELLS, TileIndex, joined_way_m};
pub use paint::{MosaicLog, MosaicPart, join_parts, joint_tile, joint_window, part, window};

use crate::calibration::Calibration;
use crate::first_return::FirstReturns;
use crate::presentation::colours;
use bathyscope_log::support::statistics::median_of;
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Method of evening out the levels across the track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gain {
    /// Levels as recorded.
    Recorded,
    /// Levels divided by the survey's own mean level of each side, a curve by range times a curve
    /// by angle (empirical gain normalisation), and scaled to one brightness. Shadows stay dark.
    #[default]
    Empirical,
}

/// Colours of the exported picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Colours {
    /// Black to white.
    #[default]
    Grey,
    /// Black to copper, as fish-finders show it: red saturates at 81 %.
    Copper,
}

impl Colours {
    /// Returns the colour of a level, transparent where nothing was insonified (level 0).
    pub fn rgba(self, level: u8) -> [u8; 4] {
        let [r, g, b] = match (level, self) {
            (0, _) => return [0; 4],
            (_, Colours::Grey) => colours::grey(level),
            (_, Colours::Copper) => colours::copper(level),
        };
        [r, g, b, 255]
    }
}

/// `mosaic.*` settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MosaicSettings {
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Colours of the exported picture.
    pub colours: Colours,
    /// Rule for cells that were insonified more than once.
    pub overlap: Overlap,
    /// Method of evening out the levels across the track.
    pub gain: Gain,
    /// True if the water column is shown: slant ranges are then used as distances on the ground.
    pub water_column: bool,
    /// Angle from straight down within which the ground is left out, degrees; 0 fills the gap under
    /// the boat with the little ground that was insonified there.
    pub nadir_gap_deg: f64,
    /// Turn rate of the boat above which pings are left out, degrees a second: their far ends sweep
    /// over the ground.
    pub most_turn_deg_s: f64,
}

impl Default for MosaicSettings {
    fn default() -> Self {
        Self {
            cell_m: 0.1,
            colours: Colours::Grey,
            overlap: Overlap::Later,
            gain: Gain::Empirical,
            water_column: false,
            nadir_gap_deg: 0.0,
            most_turn_deg_s: 6.0,
        }
    }
}

/// Number of pings before and after a ping that the median is taken over, so that a fish or a lost
/// pick does not change the ground.
const HALF_PINGS: usize = 6;

/// Returns the altitude of every ping on one side, metres: the median over nearby pings of the
/// first returns, or of the recorded depth where there is no first return or it is an above-bottom
/// return. Gaps are filled by linear interpolation over the pings. NaN for all pings where none has
/// a first return or a depth.
pub fn altitudes_m(
    survey: &Survey,
    returns: &FirstReturns,
    calibration: &Calibration,
    side: Side,
) -> Vec<f32> {
    let measured: Vec<f64> = (0..survey.side_scan.len())
        .map(|ping| {
            let is_above = returns.side(side).get(ping).is_some_and(|pick| pick.above_bottom);
            let range_m = calibration.first_return_m(survey, returns, ping, side);
            if range_m > 0.0 && !is_above { range_m } else { f64::from(survey.good_depth_m(ping)) }
        })
        .collect();
    let mut steady: Vec<f32> = (0..measured.len())
        .into_par_iter()
        .map(|ping| {
            let near = ping.saturating_sub(HALF_PINGS)..(ping + HALF_PINGS + 1).min(measured.len());
            median_of(measured[near].iter().copied().filter(|m| m.is_finite())) as f32
        })
        .collect();
    bridge(&mut steady);
    steady
}

/// Fills NaN linearly between its neighbours, and with the nearest value at both ends.
fn bridge(values: &mut [f32]) {
    let known: Vec<usize> = (0..values.len()).filter(|&i| !values[i].is_nan()).collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        return;
    };
    let (head, tail) = (values[first], values[last]);
    values[..first].fill(head);
    values[last..].fill(tail);
    for pair in known.windows(2) {
        let (from, to) = (values[pair[0]], values[pair[1]]);
        let steps = (pair[1] - pair[0]) as f32;
        for (step, value) in values[pair[0]..pair[1]].iter_mut().enumerate().skip(1) {
            *value = from + (to - from) * step as f32 / steps;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Colours, bridge};

    #[test]
    fn the_mosaic_is_coloured_as_the_waterfall_is() {
        // matplotlib.colormaps["copper"](206): red is almost full, and is full from 207 on.
        assert_eq!(Colours::Copper.rgba(206), [254, 161, 102, 255]);
        assert_eq!(Colours::Grey.rgba(206), [206, 206, 206, 255]);
        assert_eq!(Colours::Copper.rgba(0), [0; 4]);
    }

    #[test]
    fn gaps_are_bridged_and_ends_held() {
        let nan = f32::NAN;
        let mut values = [nan, 2.0, nan, nan, 5.0, nan];
        bridge(&mut values);
        assert_eq!(values, [2.0, 2.0, 3.0, 4.0, 5.0, 5.0]);
        let mut none = [nan, nan];
        bridge(&mut none);
        assert!(none.iter().all(|value| value.is_nan()));
    }
}
