//! Computes how side-scan is shown.
//!
//! For one log: the places of its echoes and the passes over a place, which the mosaic on the
//! screen and the search for passes use; its gain normalisation, which the mosaic and the waterfall
//! use; and the scales, gain and stripe filter of its picture. For a survey: the mosaic, in which
//! the echoes of every log are placed on the bottom, normalised in gain and matched to the levels
//! of the other logs.

use super::Derived;
use crate::pipeline::{ProcessedLog, Products, Same};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_bottom::mosaic::{
    Bounds, Gain, GainTable, MosaicLayout, MosaicLog, MosaicRay, MosaicSettings, gain_table,
    joint_bounds, joint_window, match_levels,
};
use bathyscope_bottom::picture::{LogPicture, PingScales, stripe_factors};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Exclusions, Navigation, Relief, Side, Survey};
use std::sync::{Arc, OnceLock};

/// Factor on the recorded range, since the calibration may make ranges longer by a few percent.
const SLACK: f64 = 1.2;
/// Finest level of detail: its cells are 2 to this power metres, about the length of a recorder's
/// sample.
pub const FINEST: i8 = -6;
/// Number of levels of detail, each twice as coarse as the one before: the coarsest shows a
/// continent.
const LEVELS: usize = 32;
/// Share of a cell: a level leaves out pings where neither the boat nor the ends of its swath move
/// farther than this.
const THINNED: f64 = 0.7;

/// Inputs of the layout of a log's side-scan on the bottom: equal keys give equal layouts.
#[derive(Clone, PartialEq)]
struct SideScanKey {
    survey: Same<Survey>,
    navigation: Same<Navigation>,
    bottom_line: Same<FirstReturns>,
    calibration: Same<Calibration>,
    exclusions: Same<Exclusions>,
    range_factor: f64,
}

impl SideScanKey {
    /// Creates the key from the results of a log.
    fn of(ProcessedLog { survey, products }: &ProcessedLog) -> Self {
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

/// Plane of a mosaic.
#[derive(Clone, PartialEq)]
pub enum MosaicPlane {
    /// Plane of the survey, for the map on the screen.
    Survey,
    /// Plane of a map.
    Map(MapPlane),
}

/// Inputs of a mosaic: equal keys give equal mosaics.
#[derive(Clone, PartialEq)]
pub struct MosaicKey {
    plane: MosaicPlane,
    logs: Vec<MosaicLogKey>,
}

#[derive(Clone, PartialEq)]
struct MosaicLogKey {
    side_scan: SideScanKey,
    relief: Same<Relief>,
    settings: MosaicSettings,
}

impl MosaicKey {
    /// Creates the key from the results of some logs. The size of the cells and the colours are not
    /// in the key: they are chosen when the mosaic is drawn.
    pub fn of(logs: &[ProcessedLog], plane: MosaicPlane) -> Self {
        let MosaicSettings { cell_m, colours, .. } = MosaicSettings::default();
        let key = |log: &ProcessedLog| MosaicLogKey {
            side_scan: SideScanKey::of(log),
            relief: Same(log.products.relief.clone()),
            settings: MosaicSettings { cell_m, colours, ..log.products.settings.mosaic.clone() },
        };
        Self { plane, logs: logs.iter().map(key).collect() }
    }
}

/// Mosaic of a survey, ready to be drawn at any scale.
pub struct Mosaic {
    /// Logs that have side-scan, in the order of their recording.
    pub logs: Vec<MosaicLog>,
    /// Settings with which the mosaic is drawn.
    pub settings: MosaicSettings,
    /// West, south, east and north of the mosaic, metres.
    pub bounds: Bounds,
    /// Layouts of each log with the pings that each level shows, computed when the level is first
    /// drawn.
    thinned: Vec<[OnceLock<MosaicLayout>; LEVELS]>,
}

impl Mosaic {
    /// Creates the mosaic of the logs that have side-scan: their echoes are placed in a plane in
    /// the order of the recording, normalised by the gain of each log and matched to the levels of
    /// the other logs. Where logs overlap, `mosaic.overlap` selects what is shown: with `later` the
    /// later log. `None` if the mosaic would be empty.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        logs: &[ProcessedLog],
        plane: &MosaicPlane,
        results: &Derived,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(first) = logs.first() else {
            return Ok(None);
        };
        let settings = first.products.settings.mosaic.clone();
        let mut in_time: Vec<&ProcessedLog> = logs.iter().collect();
        in_time.retain(|log| log.survey.has_side_scan());
        // Logs without a start time are the first, in their given order.
        let start_s = |log: &ProcessedLog| log.survey.start_unix_s.unwrap_or(f64::NEG_INFINITY);
        in_time.sort_by(|a, b| start_s(a).total_cmp(&start_s(b)));
        let mut made = Vec::with_capacity(in_time.len());
        for log in in_time {
            let ProcessedLog { survey, products } = log;
            let layout = match plane {
                MosaicPlane::Survey => results.layout(log, progress)?,
                MosaicPlane::Map(map) => Arc::new(mosaic_layout(survey, products, map)),
            };
            // A log without side-scan known to be on the bottom is not shown.
            if let Some(gain) = results.gain(log, progress)? {
                made.push(MosaicLog {
                    survey: survey.clone(),
                    layout,
                    gain: GainTable::clone(&gain),
                });
            }
        }
        let logs = match_levels(made, &settings, progress)?;
        let bounds = joint_bounds(&logs);
        Ok(bounds.map(|bounds| Self {
            thinned: logs.iter().map(|_| [const { OnceLock::new() }; LEVELS]).collect(),
            logs,
            settings,
            bounds,
        }))
    }

    /// Returns the levels of all cells of a grid, row by row: 0 without an echo, else 1 to 255. A
    /// coarse grid needs less work: pings that make no difference in its cells are left out.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn levels(&self, grid: &Grid, progress: &Progress) -> Result<Vec<u8>, Cancelled> {
        let logs = self.logs.iter().zip(&self.thinned);
        let logs = logs.map(|(log, thinned)| {
            let layout = thinned_layout(log, thinned, grid.cell_m);
            (&*log.survey, layout, &log.gain)
        });
        joint_window(logs, grid, &self.settings, progress)
    }
}

/// Returns the layout with the fewest pings that cells of this size need.
fn thinned_layout<'a>(
    log: &'a MosaicLog,
    thinned: &'a [OnceLock<MosaicLayout>; LEVELS],
    cell_m: f64,
) -> &'a MosaicLayout {
    let level = cell_m.log2().floor() - f64::from(FINEST);
    // Also if the size of the cell is 0 or NaN.
    if level.is_nan() || level < 0.0 {
        return &log.layout;
    }
    let slot = (level as usize).min(LEVELS - 1);
    let of_level_m = 2f64.powi(i32::from(FINEST) + slot as i32);
    thinned[slot].get_or_init(|| log.layout.thinned(THINNED * of_level_m))
}
