//! How the side-scan of one log is shown: gain, stripes, levels, and where an echo lies across the track.
//!
//! ```text
//! FirstReturns + Calibration --PingScales--> altitude and scale of every ping and side
//! Survey --stripe_factors--> a factor for every ping and side
//! PingScales + GainTable + factors --LogPicture--> PingTable for the GPU, and sampled echoes
//! echoes + PictureSettings --Histogram--> Levels
//! ```
//!
//! Nothing here is computed per texel of a tile: a change of gain costs a few numbers, not new tiles.

mod histogram;
mod log_picture;
mod scales;
mod settings;
mod stripes;
mod table;

pub use histogram::Histogram;
pub use log_picture::LogPicture;
pub use scales::{Extremes, Geometry, PingScale, PingScales};
#[cfg(any(test, feature = "bench"))]
pub use settings::LEAST_RANGE_M;
pub use settings::{PictureSettings, Tone};
pub use stripes::stripe_factors;
pub use table::PingTable;
