//! Transforms the points of a cloud into the metres of a map.

use crate::pipeline::{Products, map_plane};
use bathyscope_bottom::bathymetry::{DepthPoint, SurfaceSettings};
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud};
use bathyscope_log::support::geo::{Crs, MapPlane};
use bathyscope_log::survey::{Navigation, Survey, Track};

/// Transformation of a log's cloud into the plane of its maps.
#[derive(Clone)]
pub(crate) struct CloudPlane<'a> {
    /// Plane of the maps.
    pub map: MapPlane,
    track: &'a Track,
    navigation: &'a Navigation,
}

impl<'a> CloudPlane<'a> {
    /// Creates the transformation into the plane of the coordinate system that `crs` names, or of
    /// the UTM zone if that system cannot be used.
    pub(crate) fn or_utm(survey: &'a Survey, products: &'a Products) -> Self {
        let origin = survey.track.frame.origin();
        let utm = |_| MapPlane::new(Crs::utm(origin), origin);
        let map = map_plane(survey, &products.settings).unwrap_or_else(utm);
        Self::new(survey, products, map)
    }

    /// Creates the transformation of one of several logs into the plane that all of them share.
    pub(crate) fn new(survey: &'a Survey, products: &'a Products, map: MapPlane) -> Self {
        Self { map, track: &survey.track, navigation: &products.navigation }
    }

    /// Returns the kept points for which `chosen` is true, each with its easting, northing and
    /// elevation, metres.
    pub(super) fn points<'p>(
        &self,
        products: &'p Products,
        chosen: impl Fn(&CloudPoint) -> bool,
    ) -> impl Iterator<Item = ([f64; 3], &'p CloudPoint)> {
        let chosen = products.kept_points().filter(move |point| chosen(point));
        let placed = chosen.map(|point| (self.place(point), point));
        placed.filter(|(place, _)| is_finite(place))
    }

    /// Returns the kept points that count for the surface, as weighted depths.
    pub(crate) fn depth_points(&self, products: &Products) -> Vec<DepthPoint> {
        let (cloud, classes) = (&products.cloud, &products.classes);
        depth_points(cloud, classes, &products.settings.surface, |p| self.place(p))
    }

    /// Returns the depths under the boat that follow from the slope of a first return of one side
    /// alone, weighted as first returns.
    pub(super) fn slope_points(&self, products: &Products) -> Vec<DepthPoint> {
        let weight = products.settings.surface.side_scan_weight;
        let depths = products.depths.iter().zip(products.navigation.pings.iter());
        let by_slope = depths.filter(|(depth, _)| depth.by_slope && weight > 0.0);
        let placed = by_slope.map(|(depth, at)| {
            let [east_m, north_m] = self.plane_place(at.place());
            [east_m, north_m, -f64::from(depth.depth_m)]
        });
        placed.filter(is_finite).map(|place| first_return(place, weight)).collect()
    }

    /// Returns the first returns that one side alone sees above the recorded depth for long, and
    /// that do not count: weed, a bank or a scarp. Their weight is 0.
    pub(super) fn doubtful_points(&self, products: &Products) -> Vec<DepthPoint> {
        let classed = products.cloud.points.iter().zip(products.classes.iter());
        let doubtful = classed.filter(|(point, class)| {
            **class == PointClass::AboveBottom && point.above_bottom_m > 0.0
        });
        let placed = doubtful.map(|(point, _)| self.place(point)).filter(is_finite);
        placed.map(|place| first_return(place, 0.0)).collect()
    }

    fn place(&self, point: &CloudPoint) -> [f64; 3] {
        let [east_m, north_m] = self.plane_place([point.east_m, point.north_m]);
        [east_m, north_m, point.z_m]
    }

    /// Returns east and north in the map's plane of a place in the log's plane.
    fn plane_place(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        self.map.place(self.navigation.to_lon_lat(self.track, east_m, north_m))
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
