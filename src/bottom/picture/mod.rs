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
mod settings;
mod stripes;

pub use log_picture::{LevelHistogram, LogPicture};
pub use scales::{Extremes, PictureGeometry, PingScale, PingScales};
pub use settings::{LEAST_RANGE_M, PictureSettings, Tone};
pub use stripes::stripe_factors;
