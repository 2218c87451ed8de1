//! Residuals: what was measured against a reference, and what an international standard would say
//! of it.
//!
//! In: points with elevations, and a reference. Out: their differences with statistics, and the
//! share within each order of IHO S-44.
//!
//! `matching` finds the reference of each measured point, `orders` holds the limits of IHO S-44,
//! `tables` sorts differences by what they may hang on. Everywhere a difference is measured minus
//! reference elevation, so that up is positive: a bottom measured too shallow gives more than 0.

mod matching;
mod orders;
mod tables;

pub use matching::{Match, Matching, ReferencePoints, match_points};
pub(crate) use orders::ORDERS;
pub use orders::SurveyOrder;
pub use tables::{Bin, DifferenceHistogram, binned, suited_width};

use crate::cloud::Residuals;
use serde::Serialize;

/// Agreement of a measurement with a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Measured points.
    pub measured: usize,
    /// Measured points without a reference near enough.
    pub unmatched: usize,
    /// Statistics of the differences, measured minus reference elevation; absent where nothing was
    /// matched.
    #[serde(flatten)]
    pub residuals: Option<Residuals>,
    /// Share of the matched points within each order's limit; empty where nothing was matched.
    pub orders: Vec<OrderShare>,
}

/// Share of the points within an order's limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderShare {
    /// The order.
    #[serde(flatten)]
    pub order: SurveyOrder,
    /// Share of the points within its limit at their own depth, 0 to 1. The order asks for 0.95.
    pub share: f64,
}

impl Comparison {
    /// Compares `measured` points, of which those in `matches` have a reference; the water's
    /// surface is at `water_level_m` in their elevations.
    pub fn new(measured: usize, matches: &[Match], water_level_m: f64) -> Self {
        let mut differences: Vec<f64> = matches.iter().map(|one| one.difference_m).collect();
        let within = |order: SurveyOrder| {
            let holds = |one: &&Match| {
                let depth_m = (water_level_m - one.reference_z_m).max(0.0);
                one.difference_m.abs() <= order.limit_m(depth_m)
            };
            OrderShare {
                order,
                share: matches.iter().filter(holds).count() as f64 / matches.len() as f64,
            }
        };
        Self {
            measured,
            unmatched: measured - matches.len(),
            orders: match matches {
                [] => Vec::new(),
                _ => ORDERS.into_iter().map(within).collect(),
            },
            residuals: Residuals::of(&mut differences),
        }
    }
}
