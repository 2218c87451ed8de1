//! The gain normalisation of one log, which the mosaic and the waterfall share.

use crate::pipeline::{ProcessedLog, Same, mosaic_layout_by};
use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_bottom::mosaic::{GainTable, MosaicLayout, gain_table};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Exclusions, Navigation, Survey};

/// Inputs of the layout of a log's side-scan on the bottom; equal keys give equal layouts.
#[derive(Clone, PartialEq)]
pub(super) struct SideScanKey {
    survey: Same<Survey>,
    navigation: Same<Navigation>,
    bottom_line: Same<FirstReturns>,
    calibration: Same<Calibration>,
    exclusions: Same<Exclusions>,
    range_factor: f64,
}

impl SideScanKey {
    /// Creates the key from the results of a log.
    pub(super) fn of(ProcessedLog { survey, products }: &ProcessedLog) -> Self {
        Self {
            survey: Same(survey.clone()),
            navigation: Same(products.navigation.clone()),
            bottom_line: Same(products.bottom_line.clone()),
            calibration: Same(products.calibration.clone()),
            exclusions: Same(products.exclusions.clone()),
            range_factor: products.correction.range_factor(),
        }
    }
}

/// Inputs of a gain table; equal keys give equal tables.
#[derive(Clone, PartialEq)]
pub(super) struct GainKey {
    side_scan: SideScanKey,
    most_turn_deg_s: f64,
}

impl GainKey {
    /// Creates the key from the results of a log.
    pub(super) fn of(log: &ProcessedLog) -> Self {
        Self {
            side_scan: SideScanKey::of(log),
            most_turn_deg_s: log.products.settings.mosaic.most_turn_deg_s,
        }
    }
}

/// The table over the pings that a mosaic shows; over all of them where the boat's place is not
/// known.
pub(super) fn made(
    log: &ProcessedLog,
    progress: &Progress,
) -> Result<Option<GainTable>, Cancelled> {
    let ProcessedLog { survey, products } = log;
    let table = |layout: &MosaicLayout| {
        if layout.has_rays() { gain_table(survey, layout, progress).map(Some) } else { Ok(None) }
    };
    match table(&mosaic_layout_by(survey, products, |place| place))? {
        Some(made) => Ok(Some(made)),
        None => {
            let placeless =
                MosaicLayout::placeless(survey, &products.bottom_line, &products.calibration)
                    .with_range_factor(products.correction.range_factor());
            table(&placeless.without(&products.exclusions))
        }
    }
}
