//! Depths with a place, and what to do with the many that share one.

use crate::statistics::median;
use crate::survey::{Navigation, Survey};

/// A depth at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthPoint {
    /// Metres east of the survey's origin.
    pub east_m: f64,
    /// Metres north of the survey's origin.
    pub north_m: f64,
    /// Metres below the transducer.
    pub depth_m: f64,
}

/// Every sounding of the survey that has both a place and a depth, in time order.
pub fn depth_points(survey: &Survey, navigation: &Navigation) -> Vec<DepthPoint> {
    let placed = survey.soundings.iter().zip(&navigation.soundings);
    placed
        .filter(|(sounding, _)| sounding.locked)
        .map(|(sounding, place)| DepthPoint {
            east_m: place.east_m,
            north_m: place.north_m,
            depth_m: f64::from(sounding.depth_m),
        })
        .filter(|point| {
            point.east_m.is_finite() && point.north_m.is_finite() && point.depth_m.is_finite()
        })
        .collect()
}

/// One point for all points of a square of `cell_m`: the mean place and the median depth. A cell of 0 merges only exactly
/// repeated places. Recorders repeat a fix for most pings, and a triangulation takes one depth a place.
pub fn merge_repeated(points: &[DepthPoint], cell_m: f64) -> Vec<DepthPoint> {
    let key = |value: f64| {
        if cell_m > 0.0 {
            (value / cell_m).floor() as i64
        } else {
            // Adding zero makes the two zeros one.
            (value + 0.0).to_bits() as i64
        }
    };
    let mut keyed: Vec<([i64; 2], DepthPoint)> = points
        .iter()
        .map(|point| ([key(point.east_m), key(point.north_m)], *point))
        .collect();
    keyed.sort_by_key(|(key, _)| *key);
    let mut depths = Vec::new();
    keyed
        .chunk_by(|a, b| a.0 == b.0)
        .map(|same| merge(same, &mut depths))
        .collect()
}

fn merge(same: &[([i64; 2], DepthPoint)], depths: &mut Vec<f64>) -> DepthPoint {
    let first = same[0].1;
    depths.clear();
    let (mut east_m, mut north_m) = (0.0, 0.0);
    for (_, point) in same {
        depths.push(point.depth_m);
        east_m += point.east_m - first.east_m;
        north_m += point.north_m - first.north_m;
    }
    let count = same.len() as f64;
    DepthPoint {
        east_m: first.east_m + east_m / count,
        north_m: first.north_m + north_m / count,
        depth_m: median(depths),
    }
}

/// The 2nd and 98th percentile of some depths: the ends of the colour scale. `None` without any finite depth.
pub fn depth_range(depths: impl IntoIterator<Item = f32>) -> Option<[f32; 2]> {
    let mut depths: Vec<f32> = depths.into_iter().filter(|d| d.is_finite()).collect();
    let last = depths.len().checked_sub(1)?;
    let mut at = |share: f64| {
        let rank = (share * last as f64).round() as usize;
        *depths.select_nth_unstable_by(rank, f32::total_cmp).1
    };
    Some([at(0.02), at(0.98)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(east_m: f64, north_m: f64, depth_m: f64) -> DepthPoint {
        DepthPoint {
            east_m,
            north_m,
            depth_m,
        }
    }

    #[test]
    fn repeated_places_give_their_median() {
        let points = [
            point(1.0, 2.0, 9.0),
            point(1.0, 2.0, 3.0),
            point(1.0, 2.0, 4.0),
            point(5.0, 5.0, 1.0),
            point(5.0, 5.0, 2.0),
        ];
        let merged = merge_repeated(&points, 0.0);
        assert_eq!(merged, [point(1.0, 2.0, 4.0), point(5.0, 5.0, 1.5)]);
    }

    #[test]
    fn a_cell_merges_its_neighbours_at_their_mean_place() {
        let points = [
            point(0.1, 0.1, 1.0),
            point(0.3, 0.3, 3.0),
            point(1.1, 0.1, 7.0),
        ];
        let merged = merge_repeated(&points, 1.0);
        assert_eq!(merged.len(), 2);
        assert!((merged[0].east_m - 0.2).abs() < 1e-12);
        assert_eq!(merged[0].depth_m, 2.0);
    }

    #[test]
    fn the_colour_scale_leaves_out_the_outer_two_percent() {
        let depths = (0..=100).map(|i| i as f32).chain([f32::NAN]);
        assert_eq!(depth_range(depths), Some([2.0, 98.0]));
        assert_eq!(depth_range([f32::NAN]), None);
    }
}
