//! Scales, gain and stripe filter that the picture of one log is shown with.

use super::gain::GainKey;
use crate::pipeline::ProcessedLog;
use bathyscope_bottom::mosaic::{Gain, GainTable};
use bathyscope_bottom::picture::{LogPicture, PingScales, stripe_factors};
use bathyscope_log::support::progress::{Cancelled, Progress};
use std::sync::Arc;

/// Inputs of the picture of a log; levels, balance and time-varied gain are numbers that act on
/// top.
#[derive(Clone, PartialEq)]
pub struct PictureKey {
    of: GainKey,
    is_normalised: bool,
    is_even: bool,
}

impl PictureKey {
    /// Creates the key from the results of a log and its picture settings.
    pub fn of(log: &ProcessedLog) -> Self {
        let picture = &log.products.settings.picture;
        Self {
            of: GainKey::of(log),
            is_normalised: picture.gain == Gain::Empirical,
            is_even: picture.stripe_filter,
        }
    }

    /// Returns true if gain is normalised.
    pub fn is_normalised(&self) -> bool {
        self.is_normalised
    }

    /// Returns true if the stripe filter is on.
    pub(super) fn is_even(&self) -> bool {
        self.is_even
    }
}

/// Makes the picture of a log with a gain table; with the factors of the stripe filter if
/// `is_even`.
pub(super) fn made(
    ProcessedLog { survey, products }: &ProcessedLog,
    gain: Option<Arc<GainTable>>,
    is_even: bool,
    progress: &Progress,
) -> Result<LogPicture, Cancelled> {
    let factor = products.correction.range_factor();
    let scales = PingScales::new(survey, &products.bottom_line, &products.calibration, factor);
    let factors = if is_even { Some(stripe_factors(survey, &scales, progress)?) } else { None };
    LogPicture::new(survey, Arc::new(scales), gain, factors, progress)
}
