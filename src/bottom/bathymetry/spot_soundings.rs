//! Chooses the depths that a chart prints as figures: few enough to be read, the shoalest of their
//! surroundings.

use super::DepthPoint;
use super::isobaths::IsobathSettings;
use crate::presentation::ticks;
use bathyscope_log::support::outline::bounds;
use std::collections::HashMap;

/// Approximate number of figures along the diagonal of a map, where the settings give no distance.
const ALONG_DIAGONAL: f64 = 40.0;

/// Chooses depths that are at least `radius_m` apart, shoal first: the shallowest of all, then the
/// shallowest that is far enough from it, and so on. Every other depth has a chosen one within this
/// distance that is no deeper. The chosen depths are in order from shallow to deep.
pub fn spot_soundings(points: &[DepthPoint], radius_m: f64) -> Vec<DepthPoint> {
    let mut order: Vec<&DepthPoint> = points.iter().collect();
    order.sort_unstable_by(|a, b| {
        (a.depth_m.total_cmp(&b.depth_m))
            .then(a.north_m.total_cmp(&b.north_m))
            .then(a.east_m.total_cmp(&b.east_m))
    });
    let mut chosen: Vec<DepthPoint> = Vec::new();
    let mut in_square: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    for point in order {
        let place = point.place();
        let [column, row] = place.map(|metres| (metres / radius_m).floor() as i64);
        let around = (-1..=1).flat_map(|right| (-1..=1).map(move |up| [column + right, row + up]));
        let mut near = around.filter_map(|square| in_square.get(&square)).flatten();
        let is_near = |other: &usize| {
            let other = &chosen[*other];
            (other.east_m - place[0]).hypot(other.north_m - place[1]) < radius_m
        };
        if !near.any(is_near) {
            in_square.entry([column, row]).or_default().push(chosen.len());
            chosen.push(*point);
        }
    }
    chosen
}

/// Returns the distance between spot soundings, metres: that of the settings or, without one, a
/// round distance by the extent of the depths; `None` without both.
pub fn spot_radius_m(settings: &IsobathSettings, points: &[DepthPoint]) -> Option<f64> {
    let [west, south, east, north] = bounds(points.iter().map(DepthPoint::place));
    let by_extent = || {
        let diagonal_m = (east - west).hypot(north - south);
        (east > west || north > south).then(|| ticks::round_up(diagonal_m / ALONG_DIAGONAL))
    };
    settings.spot_radius_m.or_else(by_extent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::testing::point;

    fn depth(east_m: f64, depth_m: f64) -> DepthPoint {
        point(east_m, 0.3 * east_m, depth_m)
    }

    #[test]
    fn the_shoalest_are_kept_and_none_lies_near_another() {
        let points: Vec<DepthPoint> = (0..400)
            .map(|index| depth(f64::from(index), 3.0 + f64::from(index * 37 % 101) / 50.0))
            .collect();
        let chosen = spot_soundings(&points, 20.0);
        assert_eq!(chosen[0].depth_m, 3.0);
        assert!(chosen.is_sorted_by_key(|point| point.depth_m));
        let apart_m =
            |a: &DepthPoint, b: &DepthPoint| (a.east_m - b.east_m).hypot(a.north_m - b.north_m);
        for (index, point) in chosen.iter().enumerate() {
            assert!(chosen[..index].iter().all(|other| apart_m(point, other) >= 20.0));
        }
        // Each that was left out has a shallower one, or one as shallow, nearby.
        for point in &points {
            let covers = |sounding: &&DepthPoint| {
                apart_m(sounding, point) < 20.0 && sounding.depth_m <= point.depth_m
            };
            assert!(chosen.iter().any(|sounding| covers(&sounding)), "{point:?}");
        }
        assert!((10..22).contains(&chosen.len()), "{}", chosen.len());
    }

    #[test]
    fn the_distance_follows_the_extent_where_nobody_gives_it() {
        let points = [depth(0.0, 1.0), depth(400.0, 1.0)];
        let mut settings = IsobathSettings::default();
        assert_eq!(spot_radius_m(&settings, &points), Some(20.0));
        assert_eq!(spot_radius_m(&settings, &points[..1]), None);
        assert_eq!(spot_radius_m(&settings, &[]), None);
        settings.spot_radius_m = Some(7.0);
        assert_eq!(spot_radius_m(&settings, &points[..1]), Some(7.0));
        assert!(spot_soundings(&[], 7.0).is_empty());
    }
}
