//! Computes how the side-scan of one log is shown: the places of its echoes, which the mosaic on
//! the screen and the search for passes share, and the passes over a place; its gain normalisation,
//! which the mosaic and the waterfall share; and the scales, gain and stripe filter of its picture.

use super::Derived;
use crate::pipeline::{ProcessedLog, Products, Same};
use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_bottom::mosaic::{Gain, GainTable, MosaicLayout, MosaicRay, gain_table};
use bathyscope_bottom::picture::{LogPicture, PingScales, stripe_factors};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Exclusions, Navigation, Relief, Side, Survey};
use std::sync::Arc;

/// Factor on the recorded range, since the calibration may make ranges longer by a few percent.
const SLACK: f64 = 1.2;

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

/// Pass over a place: consecutive pings of a log that show the place on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    /// Side of the boat on which the place is.
    pub side: Side,
    /// First and last ping.
    pub pings: [usize; 2],
    /// Ping in the middle, and the sample at which it shows the place.
    pub middle: (usize, f64),
    /// Slant range of the sample, metres.
    pub range_m: f64,
}

/// Returns the strips that show a place, in the order of the log: ping, side, ray, and the distance
/// of the place along the ray, metres.
fn strips_at(
    layout: &MosaicLayout,
    [x, y]: [f64; 2],
) -> impl Iterator<Item = (usize, Side, MosaicRay, f64)> {
    layout.strips_in([x, y, x, y]).filter_map(move |(index, side)| {
        let ray = layout.ray(index, side)?;
        let [east, north] = ray.out;
        let scale = east * east + north * north;
        let out_m = ((x - ray.at[0]) * east + (y - ray.at[1]) * north) / scale;
        let is_seen = out_m > 0.0 && out_m <= ray.reach_m(false);
        is_seen.then_some((layout.ping(index)?, side, ray, out_m))
    })
}

/// Finds the passes of a log over a place of the log's plane, by side and in the order of the log,
/// with the echoes placed as in the mosaic. The layout is not computed for a log that was far from
/// the place.
///
/// # Errors
/// When the work was cancelled.
pub fn passes_over(
    log: &ProcessedLog,
    place: [f64; 2],
    results: &Derived,
    progress: &Progress,
) -> Result<Vec<Pass>, Cancelled> {
    if !is_near(log, place) {
        return Ok(Vec::new());
    }
    let layout = results.layout(log, progress)?;
    let mut seen: Vec<(usize, Side, MosaicRay, f64)> = strips_at(&layout, place).collect();
    seen.sort_by_key(|(ping, side, ..)| (*side, *ping));
    let is_next = |a: &(usize, Side, MosaicRay, f64), b: &(usize, Side, MosaicRay, f64)| {
        a.1 == b.1 && b.0 - a.0 <= 1
    };
    let passes = seen.chunk_by(is_next).filter_map(|pass| {
        let [first, last] = [pass.first()?.0, pass.last()?.0];
        let (ping, side, ray, out_m) = pass.get(pass.len() / 2)?;
        let sample = ray.sample_of(*out_m, false);
        Some(Pass {
            side: *side,
            pings: [first, last],
            middle: (*ping, sample),
            range_m: ray.range_m(sample),
        })
    });
    Ok(passes.collect())
}

/// Returns true if the boat came as near to a place as its side-scan reaches; false for most logs
/// of a large survey.
fn is_near(log: &ProcessedLog, [x, y]: [f64; 2]) -> bool {
    let (survey, products) = (&log.survey, &log.products);
    let factor = products.correction.range_factor();
    let mut pings = products.navigation.pings.iter().enumerate();
    pings.any(|(ping, boat)| {
        let far_m = |side| survey.span(ping, side).map_or(0.0, |span| f64::from(span.far_m));
        let [port_m, starboard_m] = Side::BOTH.map(far_m);
        (boat.east_m - x).hypot(boat.north_m - y) <= SLACK * factor * port_m.max(starboard_m)
    })
}

/// Returns the place of a sample of a ping in the plane of its log; `None` if the sample is not on
/// the bottom.
pub fn place_of(layout: &MosaicLayout, ping: usize, side: Side, sample: f64) -> Option<[f64; 2]> {
    let ray = layout.ray(ping, side)?;
    let out_m = ray.across.ground_m(ray.under_m, ray.range_m(sample));
    out_m.is_finite().then(|| ray.place(out_m))
}
