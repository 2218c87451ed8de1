//! Depths with a place.

use bathyscope_log::support::statistics;
use bathyscope_log::survey::{Navigation, Survey};

/// A depth at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthPoint {
    /// Metres east of the survey's origin.
    pub east_m: f64,
    /// Metres north of the survey's origin.
    pub north_m: f64,
    /// Metres below the transducer.
    pub depth_m: f64,
    /// Weight where several depths meet; 1 for a recorder's own sounding, 0 to ignore the depth.
    pub weight: f64,
    /// True if it is a depth of the recorder, under the boat or across the track, or of a
    /// reference, and no first return of the side-scan.
    pub is_sounding: bool,
}

impl DepthPoint {
    /// East and north, metres.
    pub fn place(&self) -> [f64; 2] {
        [self.east_m, self.north_m]
    }

    /// A sounding that counts in full.
    pub(crate) fn of_sounding([east_m, north_m]: [f64; 2], depth_m: f64) -> Self {
        Self { east_m, north_m, depth_m, weight: 1.0, is_sounding: true }
    }
}

/// Every sounding of the survey that has both a place and a depth, in time order.
pub fn depth_points(survey: &Survey, navigation: &Navigation) -> Vec<DepthPoint> {
    let placed = survey.soundings.iter().zip(navigation.soundings.iter());
    placed
        .filter(|(sounding, _)| sounding.is_good())
        .map(|(sounding, place)| {
            DepthPoint::of_sounding(place.place(), f64::from(sounding.depth_m))
        })
        .filter(|point| {
            point.east_m.is_finite() && point.north_m.is_finite() && point.depth_m.is_finite()
        })
        .collect()
}

/// The 2nd and 98th percentile of some depths: the ends of the colour scale. `None` without any
/// finite depth.
pub fn depth_range(depths: impl IntoIterator<Item = f32>) -> Option<[f32; 2]> {
    statistics::colour_ends(depths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colour_scale_leaves_out_the_outer_two_percent() {
        let depths = (0..=100).map(|i| i as f32).chain([f32::NAN]);
        assert_eq!(depth_range(depths), Some([2.0, 98.0]));
        assert_eq!(depth_range([f32::NAN]), None);
    }
}
