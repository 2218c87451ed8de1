//! Counts the first returns, faults and points of a result once on a worker thread, so that no
//! panel counts points while it is drawn.

use super::above_bottom::AboveBottom;
use bathyscope_bottom::cloud::{ClassCounts, Residuals, residuals};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{FaultCounts, Side, Survey};
use bathyscope_products::pipeline::Products;

/// Counts and residuals of a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// First returns found to port.
    pub port_picks: usize,
    /// First returns found to starboard.
    pub starboard_picks: usize,
    /// The counts of first returns above the recorded depth.
    pub above_bottom: AboveBottom,
    /// Soundings with a fault, whether or not a first return confirms them.
    pub faults: FaultCounts,
    /// Points of the cloud by their classes.
    pub classes: ClassCounts,
    /// Elevation of side-scan points minus that of the recorded depth at the same ping.
    pub residuals: Option<Residuals>,
}

impl Figures {
    /// Counts the figures of the results of a log.
    pub fn of(
        survey: &Survey,
        products: &Products,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let found = |side| picks(&products.returns, side);
        progress.check()?;
        Ok(Self {
            port_picks: found(Side::Port),
            starboard_picks: found(Side::Starboard),
            above_bottom: AboveBottom::of(survey, products),
            faults: FaultCounts::of(survey.soundings.iter().filter_map(|sounding| sounding.fault)),
            classes: ClassCounts::of(&products.cloud, &products.classes),
            residuals: residuals(survey, &products.cloud, &products.correction, &products.classes),
        })
    }
}

fn picks(returns: &FirstReturns, side: Side) -> usize {
    let picks = returns.side(side).iter();
    picks.filter(|pick| pick.is_some()).count()
}
