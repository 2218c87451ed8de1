//! Computes the shape of the bottom across the track from the depths that the log itself measured.

use super::surface::depth_points;
use bathyscope_bottom::bathymetry::{Surface, SurfaceMethod, SurfaceSettings, surface_of_depths};
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{median_of, quantile, sorted};
use bathyscope_log::survey::{Navigation, Relief, Side, Survey};

/// Side of the cells of the surface from which the shape is read, as a share of the median depth,
/// and its least value, metres: smaller shapes are noise as seen from the transducer.
const CELL_SHARE: f64 = 0.25;
const LEAST_CELL_M: f64 = 1.0;
/// Share of all sides that do not exceed the slant range up to which the shape is computed.
const RANGE_SHARE: f64 = 0.98;
/// Most cells along a side of the surface.
const MOST_CELLS: usize = 2048;

/// Computes the bottom across the track of every ping; level where no depth is known, and
/// everywhere if `surface.relief` is off.
///
/// The surface is always made of linear triangles, whatever method the depth map uses: a decimetre
/// of difference between lines moves an echo ten metres away by a few centimetres only.
///
/// # Errors
/// When the work was cancelled.
pub(super) fn relief(
    survey: &Survey,
    navigation: &Navigation,
    cloud: &PointCloud,
    classes: &[PointClass],
    settings: &SurfaceSettings,
    progress: &Progress,
) -> Result<Relief, Cancelled> {
    if !settings.relief || !survey.has_side_scan() {
        return Ok(Relief::default());
    }
    let points = depth_points(cloud, classes, settings, CloudPoint::place);
    let depth_m = median_of(points.iter().map(|point| point.depth_m));
    let cell_m = (CELL_SHARE * depth_m).max(LEAST_CELL_M);
    let settings = SurfaceSettings {
        method: SurfaceMethod::Linear,
        cell_m: Some(cell_m),
        max_side: MOST_CELLS,
        ..settings.clone()
    };
    let Some(bottom) = surface_of_depths(points, &settings, progress)? else {
        return Ok(Relief::default());
    };
    let pings = survey.side_scan.len().min(navigation.pings.len());
    let deeper_m = |side: Side, ping: usize, ground_m: f64| {
        deeper_m(&bottom, navigation, side, ping, ground_m)
    };
    Ok(Relief::new(pings, farthest_m(survey), deeper_m))
}

/// Returns the depth of the bottom at a distance across the track minus the depth under the boat,
/// metres; `None` if one of them is unknown.
fn deeper_m(
    bottom: &Surface,
    navigation: &Navigation,
    side: Side,
    ping: usize,
    ground_m: f64,
) -> Option<f64> {
    let boat = navigation.pings.get(ping)?;
    let beside = boat.abeam(side, ground_m)?;
    // A cell at the edge of the surface, where the outermost lines are, has no neighbour for the
    // bilinear interpolation.
    let depth_m = |[east_m, north_m]: [f64; 2]| {
        let of_cell = || bottom.at(east_m, north_m).map(|(depth_m, _)| depth_m);
        bottom.depth_at([east_m, north_m]).or_else(of_cell)
    };
    let under_m = depth_m(boat.place())?;
    let there_m = depth_m(beside)?;
    Some(f64::from(there_m - under_m))
}

/// Returns the slant range that nearly no side of a ping exceeds, metres: a damaged header may
/// contain any range.
pub(super) fn farthest_m(survey: &Survey) -> f64 {
    let pings = survey.side_scan.iter();
    let spans = pings.flat_map(|ping| [ping.port, ping.starboard]).flatten();
    let ranges = spans.map(|span| f64::from(span.far_m));
    let ranges = sorted(ranges.filter(|far_m| far_m.is_finite()));
    // The quantile of no ranges is NaN, and the greater of NaN and 1 is 1.
    quantile(&ranges, RANGE_SHARE).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{SidePing, SideSpan};

    #[test]
    fn a_damaged_header_does_not_say_how_far_the_bottom_is_read() {
        let ping = |index: usize| SidePing {
            starboard: Some(SideSpan::of_bytes(100, [0.0, if index == 7 { 3e9 } else { 20.0 }])),
            ..SidePing::with_depth(index as f64, 3.0)
        };
        let survey = Survey::of_pings((0..200).map(ping));
        assert_eq!(farthest_m(&survey), 20.0);
        assert_eq!(farthest_m(&Survey::default()), 1.0);
    }
}
