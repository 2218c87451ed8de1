//! Places of the echoes of one log in its own plane, which the mosaic on the screen and the search
//! for passes share.

use super::gain::SideScanKey;
use crate::pipeline::{ProcessedLog, Same};
use bathyscope_log::survey::Relief;

/// Inputs of the layout of a log; equal keys give equal layouts.
#[derive(Clone, PartialEq)]
pub(super) struct LayoutKey {
    side_scan: SideScanKey,
    relief: Same<Relief>,
    most_turn_deg_s: f64,
    water_column: bool,
}

impl LayoutKey {
    /// Creates the key from the results of a log.
    pub(super) fn of(log: &ProcessedLog) -> Self {
        let settings = &log.products.settings.mosaic;
        Self {
            side_scan: SideScanKey::of(log),
            relief: Same(log.products.relief.clone()),
            most_turn_deg_s: settings.most_turn_deg_s,
            water_column: settings.water_column,
        }
    }
}
