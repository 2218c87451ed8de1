//! The depth under the boat at every ping, and what it comes from.

use super::{Correction, PointClass, PointCloud};
use bathyscope_log::survey::{Exclusions, PingNav, Survey};
use serde::Serialize;

/// What the depth under the boat comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthSource {
    /// The recorder's own sounding.
    Sounding,
    /// The first returns of the side-scan alone: the recorder had lost the bottom, or records no
    /// depth.
    SideScan,
    /// There is none.
    #[default]
    None,
}

/// The depth under the boat at a ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PingDepth {
    /// Metres, corrected as the cloud is; NaN without one.
    pub depth_m: f32,
    /// What it comes from.
    pub source: DepthSource,
}

/// One entry a side-scan ping: the recorded depth where the recorder had the bottom, else that of
/// the deeper of the first returns that are kept. The other side detects a bank or a boulder to the
/// side of the boat first.
pub fn ping_depths(
    survey: &Survey,
    cloud: &PointCloud,
    classes: &[PointClass],
    correction: &Correction,
) -> Vec<PingDepth> {
    let recorded = survey.side_scan.iter().map(|ping| {
        let recorded_m = ping.good_depth_m();
        let depth_m = correction.depth_m(ping.time_s, f64::from(recorded_m)) as f32;
        match recorded_m > 0.0 {
            true => (depth_m, DepthSource::Sounding),
            false => (f32::NAN, DepthSource::None),
        }
    });
    let mut depths: Vec<PingDepth> =
        recorded.map(|(depth_m, source)| PingDepth { depth_m, source }).collect();
    let kept = cloud.kept(classes);
    for (_, point) in kept.filter(|(_, point)| point.source.is_side_scan()) {
        if let Some(depth) = depths.get_mut(point.ping as usize)
            && depth.source != DepthSource::Sounding
        {
            // Of NaN and a depth, this is the depth.
            depth.depth_m = depth.depth_m.max(-point.z_m as f32);
            depth.source = DepthSource::SideScan;
        }
    }
    depths
}

/// Takes the depths from the pings that are excluded; `first` is the ping of the first of them.
pub fn clear_excluded_depths(depths: &mut [PingDepth], first: usize, exclusions: &Exclusions) {
    for (ping, depth) in (first..).zip(depths) {
        if exclusions.ping(ping).is_some() {
            *depth = PingDepth { depth_m: f32::NAN, source: DepthSource::None };
        }
    }
}

/// Over how much of the track the depth comes from what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TrackShare {
    /// Pings whose depth is the recorder's own.
    pub sounding_pings: usize,
    /// Pings whose depth comes from side-scan only.
    pub side_scan_only_pings: usize,
    /// Pings without a depth.
    pub pings_without_depth: usize,
    /// Length of the track, metres.
    pub track_m: f64,
    /// Length of the track over which depth comes from side-scan only, metres.
    pub side_scan_only_m: f64,
}

/// Steps longer than this are gaps, metres.
const LONGEST_STEP_M: f64 = 50.0;

impl TrackShare {
    /// Of the depths at the pings and their places.
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

    /// Adds that of another track.
    pub fn add(&mut self, other: &Self) {
        self.sounding_pings += other.sounding_pings;
        self.side_scan_only_pings += other.side_scan_only_pings;
        self.pings_without_depth += other.pings_without_depth;
        self.track_m += other.track_m;
        self.side_scan_only_m += other.side_scan_only_m;
    }

    /// The share of the track over which depth comes from side-scan only, 0 to 1.
    pub fn side_scan_only(&self) -> f64 {
        self.side_scan_only_m / self.track_m.max(f64::MIN_POSITIVE)
    }
}
