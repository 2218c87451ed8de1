//! Computes how the side-scan of one log is shown: the places of its echoes, which the mosaic on
//! the screen and the search for passes share; its gain normalisation, which the mosaic and the
//! waterfall share; and the scales, gain and stripe filter of its picture.

use crate::pipeline::{ProcessedLog, Products, Same};
use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_bottom::mosaic::{Gain, GainTable, MosaicLayout, gain_table};
use bathyscope_bottom::picture::{LogPicture, PingScales, stripe_factors};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Exclusions, Navigation, Relief, Survey};
use std::sync::Arc;

/// Inputs of the layout of a log's side-scan on the bottom: equal keys give equal layouts.
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

/// Inputs of a gain table: equal keys give equal tables.
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

/// Inputs of the layout of a log: equal keys give equal layouts.
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

/// Inputs of the picture of a log. Levels, balance and time-varied gain are not in the key: they
/// are applied when the picture is drawn.
#[derive(Clone, PartialEq)]
pub struct PictureKey {
    of: GainKey,
    /// True if gain is normalised.
    pub(super) is_normalised: bool,
    /// True if the stripe filter is on.
    pub(super) is_even: bool,
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
}

/// Computes the places of the echoes of a log in the plane of a map.
pub fn mosaic_layout(survey: &Survey, products: &Products, map: &MapPlane) -> MosaicLayout {
    let navigation = &products.navigation;
    mosaic_layout_by(survey, products, |[east_m, north_m]| {
        map.place(navigation.to_lon_lat(&survey.track, east_m, north_m))
    })
}

/// Computes the places of the echoes of a log in the plane to which `place` transforms from the
/// plane of the survey.
pub fn mosaic_layout_by(
    survey: &Survey,
    products: &Products,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> MosaicLayout {
    MosaicLayout::new(
        survey,
        &products.navigation,
        &products.bottom_line,
        &products.calibration,
        &products.settings.mosaic,
        place,
    )
    .with_range_factor(products.correction.range_factor())
    .with_relief(&products.relief)
    .without(&products.exclusions)
}

/// Computes the gain table over the pings that a mosaic shows; over all pings if the boat's place
/// is unknown.
pub(super) fn made_gain(
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

/// Makes the picture of a log with a gain table; with the factors of the stripe filter if
/// `is_even`.
pub(super) fn made_picture(
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
