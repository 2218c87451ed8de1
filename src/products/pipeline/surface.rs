//! Transforms the points of a cloud into the metres of a map, in the coordinate system that `crs`
//! names, and computes the surface of the depths of a survey there. Computes the shape of the
//! bottom across the track, too, from the depths that the log itself measured.

use super::{ProcessedLog, Products};
use bathyscope_bottom::bathymetry::{
    DepthPoint, Surface, SurfaceMethod, SurfaceSettings, SwathDepth, surface, surface_of_depths,
};
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud};
use bathyscope_bottom::swath::{LogEchoes, PingPlace, SideEchoes, correct};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{median_of, quantile, sorted};
use bathyscope_log::survey::{Navigation, PingNav, Relief, Side, Survey};

/// Side of the cells of the surface from which the shape across the track is read, as a share of
/// the median depth, and its least value, metres: smaller shapes are noise as seen from the
/// transducer.
const CELL_SHARE: f64 = 0.25;
const LEAST_CELL_M: f64 = 1.0;
/// Share of all sides that do not exceed the slant range up to which the shape is computed.
const RANGE_SHARE: f64 = 0.98;
/// Most cells along a side of the surface from which the shape is read.
const MOST_CELLS: usize = 2048;

/// Transformation of the cloud of a log into the plane of a map.
pub(super) struct CloudPlane<'a> {
    pub map: &'a MapPlane,
    pub log: &'a ProcessedLog,
}

impl<'a> CloudPlane<'a> {
    /// Returns the kept points for which `chosen` is true, each with its easting, northing and
    /// elevation, metres.
    pub(super) fn points(
        &self,
        chosen: impl Fn(&CloudPoint) -> bool,
    ) -> impl Iterator<Item = ([f64; 3], &'a CloudPoint)> {
        let chosen = self.log.products.kept_points().filter(move |point| chosen(point));
        let placed = chosen.map(|point| (self.place(point), point));
        placed.filter(|(place, _)| is_finite(place))
    }

    /// Returns the kept points that count for the surface, as weighted depths.
    fn depth_points(&self) -> Vec<DepthPoint> {
        let Products { cloud, classes, settings, .. } = &self.log.products;
        depth_points(cloud, classes, &settings.surface, |point| self.place(point))
    }

    /// Returns the depths under the boat that follow from the slope of a first return of one side
    /// alone, weighted as first returns.
    fn slope_points(&self) -> Vec<DepthPoint> {
        let Products { depths, navigation, settings, .. } = &self.log.products;
        let weight = settings.surface.side_scan_weight;
        let depths = depths.iter().zip(navigation.pings.iter());
        let by_slope = depths.filter(|(depth, _)| depth.by_slope && weight > 0.0);
        let placed = by_slope.map(|(depth, at)| {
            let [east_m, north_m] = self.plane_place(at.place());
            [east_m, north_m, -f64::from(depth.depth_m)]
        });
        placed.filter(is_finite).map(|place| first_return(place, weight)).collect()
    }

    /// Returns the first returns that one side alone sees above the recorded depth for long, and
    /// that do not count: weed, a bank or a scarp. Their weight is 0.
    fn doubtful_points(&self) -> Vec<DepthPoint> {
        let Products { cloud, classes, .. } = &self.log.products;
        let doubtful = cloud.points.iter().zip(classes.iter()).filter(|(point, class)| {
            **class == PointClass::AboveBottom && point.above_bottom_m > 0.0
        });
        let placed = doubtful.map(|(point, _)| self.place(point)).filter(is_finite);
        placed.map(|place| first_return(place, 0.0)).collect()
    }

    fn echoes(&self) -> LogEchoes<'a> {
        log_echoes(&self.log.survey, &self.log.products, |place| self.plane_place(place))
    }

    fn place(&self, point: &CloudPoint) -> [f64; 3] {
        let [east_m, north_m] = self.plane_place([point.east_m, point.north_m]);
        [east_m, north_m, point.z_m]
    }

    /// Returns east and north in the map's plane of a place in the log's plane.
    fn plane_place(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        let ProcessedLog { survey, products } = self.log;
        self.map.place(products.navigation.to_lon_lat(&survey.track, east_m, north_m))
    }
}

/// Returns a depth from a first return.
fn first_return([east_m, north_m, z_m]: [f64; 3], weight: f64) -> DepthPoint {
    DepthPoint { east_m, north_m, depth_m: -z_m, weight, is_sounding: false, slope_end: f32::NAN }
}

/// Returns the kept points of a cloud that count for a surface, as weighted depths; `place` returns
/// east, north and elevation of a point in the surface's plane.
pub fn depth_points(
    cloud: &PointCloud,
    classes: &[PointClass],
    settings: &SurfaceSettings,
    place: impl Fn(&CloudPoint) -> [f64; 3],
) -> Vec<DepthPoint> {
    let weighted = || {
        let weighted = cloud.kept(classes).map(|(_, point)| (point, settings.weight(point)));
        weighted.filter(|(_, weight)| *weight > 0.0)
    };
    // Counted first: a vector of a million points that grows takes three times their memory for a
    // moment.
    let mut points = Vec::with_capacity(weighted().count());
    let placed = weighted().map(|(point, weight)| (place(point), weight, point));
    points.extend(placed.filter(|(place, ..)| is_finite(place)).map(
        |([east_m, north_m, z_m], weight, point)| DepthPoint {
            east_m,
            north_m,
            depth_m: -z_m,
            weight,
            is_sounding: !point.source.is_side_scan(),
            slope_end: point.slope_end.share(),
        },
    ));
    points
}

/// Returns true if all coordinates of a place are finite.
fn is_finite(place: &[f64; 3]) -> bool {
    place.iter().all(|value| value.is_finite())
}

/// Computes the surface of the kept points of all logs of a survey in the plane of a map, by the
/// `surface.*` settings of the first log. The points of each log have the weights of its own
/// settings; a cell with points of several logs has their weighted median, so that a log with many
/// points there counts more. Where one side alone sees a slope, the depth under the boat that
/// follows from it counts as well. If `surface.swath` is set, depths between the lines come from
/// the echo levels of all logs. `None` if the depths span no surface.
///
/// # Errors
/// When the work was cancelled.
pub fn joint_depth_surface(
    logs: &[ProcessedLog],
    map: &MapPlane,
    progress: &Progress,
) -> Result<Option<Surface>, Cancelled> {
    let Some(first) = logs.first() else {
        return Ok(None);
    };
    let settings = &first.products.settings.surface;
    let mut points = joint_depth_points(logs, map, progress)?;
    let planes: Vec<CloudPlane<'_>> = logs.iter().map(|log| CloudPlane { map, log }).collect();
    points.extend(planes.iter().flat_map(CloudPlane::slope_points));
    let mut made = match settings.swath {
        SwathDepth::Off => surface(points, settings, progress)?,
        _ => {
            let mut made = surface(points.clone(), settings, progress)?;
            if let Some(made) = &mut made {
                let echoes = planes.iter().map(CloudPlane::echoes).collect();
                correct(made, echoes, &points, progress, settings.swath)?;
            }
            made
        }
    };
    if let Some(made) = &mut made {
        for plane in &planes {
            made.doubt(&plane.doubtful_points());
        }
    }
    Ok(made)
}

/// Returns the kept points of all logs of a survey that count for its surface, in the plane of a
/// map.
///
/// # Errors
/// When the work was cancelled.
pub fn joint_depth_points(
    logs: &[ProcessedLog],
    map: &MapPlane,
    progress: &Progress,
) -> Result<Vec<DepthPoint>, Cancelled> {
    let mut points = Vec::new();
    for log in logs {
        progress.check()?;
        points.append(&mut CloudPlane { map, log }.depth_points());
    }
    Ok(points)
}

/// Returns the echoes and places of the pings of a log, for depths from echo levels. `place`
/// transforms east and north in the plane of the survey into those of another plane, metres.
/// Excluded pings have no place. A log without usable side-scan has no pings.
pub fn log_echoes<'a>(
    survey: &'a Survey,
    products: &Products,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> LogEchoes<'a> {
    let count = if survey.has_side_scan() { survey.side_scan.len() } else { 0 };
    let of_ping = |ping: usize| {
        let time_s = survey.side_scan.get(ping).map_or(f64::NAN, |ping| ping.time_s);
        let navigation = products.navigation.pings.get(ping);
        let counts = products.exclusions.ping(ping).is_none();
        let (place_m, starboard) = navigation
            .filter(|_| counts)
            .and_then(|navigation| placed(navigation, &place))
            .unwrap_or(([f64::NAN; 2], [f64::NAN; 2]));
        PingPlace {
            time_s,
            place_m,
            starboard,
            transducer_m: -products.correction.z_m(time_s, 0.0),
            sides: Side::BOTH.map(|side| side_echoes(survey, products, ping, side)),
        }
    };
    LogEchoes { levels: survey, pings: (0..count).map(of_ping).collect() }
}

/// Returns the place of a ping in the plane to which `place` transforms, and the direction of
/// starboard there: the north directions of two planes may differ. `None` if the direction is
/// unknown.
fn placed(
    navigation: &PingNav,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> Option<([f64; 2], [f64; 2])> {
    let starboard = navigation.starboard()?;
    let from = navigation.place();
    let here = place(from);
    let beside = place([from[0] + starboard[0], from[1] + starboard[1]]);
    let across = [beside[0] - here[0], beside[1] - here[1]];
    let length_m = across[0].hypot(across[1]);
    (length_m > 0.0).then(|| (here, across.map(|part| part / length_m)))
}

fn side_echoes(survey: &Survey, products: &Products, ping: usize, side: Side) -> SideEchoes {
    let reduction = products.reduction();
    let range_m = |sample: f64| {
        let span = survey.span(ping, side);
        span.map_or(f64::NAN, |span| reduction.range_m(span, sample))
    };
    let pick = products.returns.side(side).get(ping);
    let near_m = range_m(0.0);
    SideEchoes {
        near_m,
        step_m: range_m(1.0) - near_m,
        first_return: pick.map_or(f64::NAN, |pick| f64::from(pick.sample)),
        above_bottom: pick.is_some_and(|pick| pick.above_bottom),
    }
}

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
