//! Finds the passes of a log over a place: consecutive pings that show the place on one side.

use super::{Derived, ProcessedLog};
use bathyscope_bottom::mosaic::{MosaicLayout, MosaicRay};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Side;

/// Factor on the recorded range, since the calibration may make ranges longer by a few percent.
const SLACK: f64 = 1.2;

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
