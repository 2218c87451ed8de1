//! Finds the depth under the boat at every ping, and its source.

use super::{CloudPoint, Correction, Geometry, PointClass, PointCloud};
use bathyscope_log::survey::{Exclusions, PingNav, Survey};
use serde::Serialize;

/// Source of the depth under the boat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthSource {
    /// The recorder's own sounding.
    Sounding,
    /// The first returns of the side-scan alone: the recorder had lost the bottom, or records no
    /// depth.
    SideScan,
    /// There is no depth.
    #[default]
    None,
}

/// Depth under the boat at a ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PingDepth {
    /// Depth, metres, corrected as the cloud is; NaN without one.
    pub depth_m: f32,
    /// Source of the depth.
    pub source: DepthSource,
    /// True where the first return of one side alone lies up a slope, and the depth is that of the
    /// same slope under the boat.
    pub by_slope: bool,
}

impl PingDepth {
    const NONE: Self = Self { depth_m: f32::NAN, source: DepthSource::None, by_slope: false };
}

/// Returns the depth under the boat at each side-scan ping, whose places are `places`: the recorded
/// depth where it has no fault, else that of the deeper of the first returns that are kept, since
/// on the other side a bank or a boulder beside the boat is detected first.
///
/// In a cloud that is placed by slopes ([`Geometry::Slope`]), a first return of one side alone that
/// lies out by `y` at the altitude `a` is square to the beam on a slope of `y / a`: the bottom lies
/// deeper by `y y / a` under the boat.
pub fn ping_depths(
    survey: &Survey,
    places: &[PingNav],
    (cloud, geometry): (&PointCloud, Geometry),
    classes: &[PointClass],
    correction: &Correction,
) -> Vec<PingDepth> {
    let recorded = survey.side_scan.iter().map(|ping| {
        let recorded_m = ping.good_depth_m();
        let depth_m = correction.depth_m(ping.time_s, f64::from(recorded_m)) as f32;
        if recorded_m > 0.0 {
            PingDepth { depth_m, source: DepthSource::Sounding, by_slope: false }
        } else {
            PingDepth::NONE
        }
    });
    let mut depths: Vec<PingDepth> = recorded.collect();
    let first_returns = || {
        let kept = cloud.kept(classes).map(|(_, point)| point);
        kept.filter(|point| point.source.is_side_scan())
    };
    let mut counts = vec![0_u8; depths.len()];
    for point in first_returns() {
        if let Some(count) = counts.get_mut(point.ping as usize) {
            *count += 1;
        }
    }
    for point in first_returns() {
        let ping = point.ping as usize;
        let Some(depth) =
            depths.get_mut(ping).filter(|depth| depth.source != DepthSource::Sounding)
        else {
            continue;
        };
        let mut point_m = -point.z_m;
        if geometry == Geometry::Slope && counts[ping] == 1 {
            let surface_m = correction.depth_m(survey.side_scan[ping].time_s, 0.0);
            let fall_m = fall_m(point, places.get(ping), point_m - surface_m);
            depth.by_slope = fall_m > 0.0;
            point_m += fall_m;
        }
        // The greater of NaN and a depth is the depth.
        depth.depth_m = depth.depth_m.max(point_m as f32);
        depth.source = DepthSource::SideScan;
    }
    depths
}

/// Returns by how much the bottom under the boat is deeper than at the first return of one side
/// alone, metres; 0 where this is not known.
fn fall_m(point: &CloudPoint, place: Option<&PingNav>, altitude_m: f64) -> f64 {
    let out_m =
        |place: &PingNav| (point.east_m - place.east_m).hypot(point.north_m - place.north_m);
    let fall_m = place.map_or(0.0, |place| out_m(place).powi(2) / altitude_m);
    if altitude_m > 0.0 && fall_m < altitude_m { fall_m } else { 0.0 }
}

/// Removes the depths of excluded pings; `first` is the ping of the first depth.
pub fn clear_excluded_depths(depths: &mut [PingDepth], first: usize, exclusions: &Exclusions) {
    for (ping, depth) in (first..).zip(depths) {
        if exclusions.ping(ping).is_some() {
            *depth = PingDepth::NONE;
        }
    }
}

/// Shares of the track by the source of the depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TrackShare {
    /// Number of pings whose depth is the recorder's own.
    pub sounding_pings: usize,
    /// Number of pings whose depth comes from side-scan only.
    pub side_scan_only_pings: usize,
    /// Number of pings without a depth.
    pub pings_without_depth: usize,
    /// Length of the track, metres.
    pub track_m: f64,
    /// Length of the track over which depth comes from side-scan only, metres.
    pub side_scan_only_m: f64,
}

/// Shortest step that is a gap, metres.
const LONGEST_STEP_M: f64 = 50.0;

impl TrackShare {
    /// Sums up pings and track length by the source of the depth at each ping.
    pub fn of(depths: &[PingDepth], places: &[PingNav]) -> Self {
        let mut share = Self::default();
        for (index, depth) in depths.iter().enumerate() {
            let pair =
                index.checked_sub(1).and_then(|last| places.get(last).zip(places.get(index)));
            let step_m =
                pair.map_or(0.0, |(a, b)| (b.east_m - a.east_m).hypot(b.north_m - a.north_m));
            // Steps from or to a ping without a place are NaN.
            let step_m = if step_m < LONGEST_STEP_M { step_m } else { 0.0 };
            share.track_m += step_m;
            match depth.source {
                DepthSource::Sounding => share.sounding_pings += 1,
                DepthSource::SideScan => {
                    share.side_scan_only_pings += 1;
                    share.side_scan_only_m += step_m;
                }
                DepthSource::None => share.pings_without_depth += 1,
            }
        }
        share
    }

    /// Adds the shares of another track.
    pub fn add(&mut self, other: &Self) {
        self.sounding_pings += other.sounding_pings;
        self.side_scan_only_pings += other.side_scan_only_pings;
        self.pings_without_depth += other.pings_without_depth;
        self.track_m += other.track_m;
        self.side_scan_only_m += other.side_scan_only_m;
    }

    /// Returns the share of the track over which depth comes from side-scan only, 0 to 1.
    pub fn side_scan_only(&self) -> f64 {
        self.side_scan_only_m / self.track_m.max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::PointSource;
    use bathyscope_log::survey::SidePing;

    fn point(source: PointSource, out_m: f64, z_m: f64) -> CloudPoint {
        CloudPoint { confidence: 1.0, sample: 1.0, ..CloudPoint::new(source, 0, [out_m, 0.0, z_m]) }
    }

    #[test]
    fn a_slope_that_one_side_sees_goes_on_under_the_boat() {
        let survey = Survey::of_pings([SidePing::with_depth(0.0, f32::NAN)]);
        let place = PingNav::northbound([0.0; 2], 1.0);
        let depth = |points: &[CloudPoint], geometry| {
            let cloud = PointCloud { points: points.iter().copied().collect(), zero_heading: 0 };
            let classes = vec![PointClass::Bottom; points.len()];
            let correction = Correction::default();
            ping_depths(&survey, &[place], (&cloud, geometry), &classes, &correction)[0]
        };
        let port = point(PointSource::Port, -2.0, -4.0);
        let alone = depth(&[port], Geometry::Slope);
        assert_eq!((alone.depth_m, alone.by_slope), (5.0, true));
        let placed_by_an_angle = depth(&[port], Geometry::Published);
        assert_eq!((placed_by_an_angle.depth_m, placed_by_an_angle.by_slope), (4.0, false));
        let starboard = point(PointSource::Starboard, -0.3, -4.9);
        let both = depth(&[port, starboard], Geometry::Slope);
        assert_eq!((both.depth_m, both.by_slope), (4.9, false));
    }
}
