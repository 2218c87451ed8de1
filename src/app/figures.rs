//! Counts of a result, taken once on a worker so that no panel counts points in a frame.

use crate::cloud::{Outliers, Residuals, residuals};
use crate::first_return::FirstReturns;
use crate::pipeline::Products;
use crate::progress::{Cancelled, Progress};
use crate::survey::{Side, Survey};

/// How much of everything there is in a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// First returns found to port.
    pub port_picks: usize,
    /// First returns found to starboard.
    pub starboard_picks: usize,
    /// Above-bottom returns, both sides.
    pub above_bottom: usize,
    /// Points of the cloud.
    pub points: usize,
    /// Points of first returns that are less sure than the least confidence.
    pub unsure: usize,
    /// Side-scan points, and those that the outlier filter removes.
    pub outliers: Outliers,
    /// Elevation of side-scan points minus that of the recorded depth at the same ping.
    pub residuals: Option<Residuals>,
}

impl Figures {
    /// Counts.
    pub fn of(
        survey: &Survey,
        products: &Products,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let found = |side| picks(&products.returns, side);
        let points = &products.cloud.points;
        progress.check()?;
        let min_confidence = products.settings.first_return.min_confidence;
        Ok(Self {
            port_picks: found(Side::Port),
            starboard_picks: found(Side::Starboard),
            above_bottom: points.iter().filter(|point| point.above_bottom).count(),
            points: points.len(),
            unsure: products.cloud.unsure(min_confidence),
            outliers: products.cloud.outliers(&products.kept, min_confidence),
            residuals: residuals(
                survey,
                &products.cloud,
                &products.correction,
                &products.kept,
            ),
        })
    }
}

fn picks(returns: &FirstReturns, side: Side) -> usize {
    let picks = returns.side(side).iter();
    picks.filter(|pick| pick.is_some()).count()
}
