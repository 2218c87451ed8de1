//! Part of a report on one log: counts and scales.

use bathyscope_bottom::calibration::{Calibration, PingRange, ScaleMode};
use bathyscope_bottom::cloud::ClassCounts;
use bathyscope_log::survey::{FaultCounts, Navigation, Survey, SwathPing};
use serde::Serialize;

/// Counts of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunCounts {
    /// Number of side-scan pings.
    pub pings: usize,
    /// Number of depths that the recorder measured.
    pub soundings: usize,
    /// Number of soundings that are not used, by their fault. Faulty soundings that a first return
    /// confirms are used.
    pub false_soundings: FaultCounts,
    /// Number of pings with a port first return.
    pub port_first_returns: usize,
    /// Number of pings with a starboard first return.
    pub starboard_first_returns: usize,
    /// Number of first returns above the recorded depth: weed, fish or boulders.
    pub above_bottom: usize,
    /// Number of points above the recorded depth that are left out of the depth map, though they
    /// are neither outliers nor of too low confidence.
    pub above_bottom_left_out: usize,
    /// Number of points above the recorded depth that are used for the depth map: all, or those of
    /// long stretches.
    pub above_bottom_kept: usize,
    /// Number of side-scan points that are not kept because the confidence of their first return is
    /// less than `first_return.min_confidence`.
    pub low_confidence: usize,
    /// Number of pings at which the boat moves.
    pub moving: usize,
    /// Number of pings without a heading.
    pub zero_heading: usize,
    /// Number of excluded side-scan pings.
    pub excluded_pings: usize,
    /// Number of excluded soundings.
    pub excluded_soundings: usize,
    /// Number of points of all classes.
    pub points: usize,
    /// Number of points used for the depth map: `kept` of `cloud.csv`, class 40 of every file.
    pub kept: usize,
    /// Number of points by the code of their class.
    pub classes: ClassCounts,
    /// Number of points that are first returns of the side-scan.
    pub side_scan_points: usize,
    /// Counts of the depths across the track; `None` if the recorder measured none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swath: Option<SwathCounts>,
    /// Number of points that the outlier filter removed.
    pub outliers_removed: usize,
    /// Removed share of the points of side-scan and swath, 0 to 1.
    pub outliers_removed_share: f64,
}

/// Counts of the depths that a recorder measured across the track, and of their use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SwathCounts {
    /// Number of pings of the swath.
    pub pings: usize,
    /// Number of pings of the swath without a heading, which give no points.
    pub zero_heading: usize,
    /// Number of recorded depths, without the unreliable ones.
    pub depths: usize,
    /// Number of depths that the recorder marks as unreliable, which are not used.
    pub unreliable: usize,
    /// Number of points in the cloud: of depths of a ping that are close together, one is used.
    pub points: usize,
}

impl SwathCounts {
    /// Counts the swath of a log and its results; `None` where it has no swath.
    pub(super) fn of(survey: &Survey, navigation: &Navigation, points: usize) -> Option<Self> {
        let without = navigation.swath.iter();
        let without = without.filter(|place| place.heading_rad.is_nan());
        (!survey.swath.is_empty()).then(|| Self {
            pings: survey.swath.len(),
            zero_heading: without.count(),
            depths: survey.swath.iter().map(SwathPing::len).sum(),
            unreliable: (survey.swath.iter()).map(|ping| usize::from(ping.unreliable)).sum(),
            points,
        })
    }

    /// Returns the sum of the counts of two logs.
    fn with(self, other: Self) -> Self {
        Self {
            pings: self.pings + other.pings,
            zero_heading: self.zero_heading + other.zero_heading,
            depths: self.depths + other.depths,
            unreliable: self.unreliable + other.unreliable,
            points: self.points + other.points,
        }
    }

    /// Returns the counts as one line of text.
    pub(super) fn summary(&self) -> String {
        format!(
            "swath: {} depths of {} pings give {} points; {} pings without heading; {} depths that the recorder marks as unreliable are not used",
            self.depths, self.pings, self.points, self.zero_heading, self.unreliable
        )
    }
}

impl RunCounts {
    /// Adds the counts of another log.
    pub(super) fn add(&mut self, other: &Self) {
        self.pings += other.pings;
        self.soundings += other.soundings;
        self.false_soundings.add(&other.false_soundings);
        self.port_first_returns += other.port_first_returns;
        self.starboard_first_returns += other.starboard_first_returns;
        self.above_bottom += other.above_bottom;
        self.above_bottom_left_out += other.above_bottom_left_out;
        self.above_bottom_kept += other.above_bottom_kept;
        self.low_confidence += other.low_confidence;
        self.moving += other.moving;
        self.zero_heading += other.zero_heading;
        self.excluded_pings += other.excluded_pings;
        self.excluded_soundings += other.excluded_soundings;
        self.points += other.points;
        self.kept += other.kept;
        self.classes.add(&other.classes);
        self.side_scan_points += other.side_scan_points;
        self.swath = match (self.swath, other.swath) {
            (Some(own), Some(other)) => Some(own.with(other)),
            (own, other) => own.or(other),
        };
        self.outliers_removed += other.outliers_removed;
        self.outliers_removed_share = self.classes.noise_share();
    }
}

/// Scales of a log, in one flat table for scripts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibrationReport {
    /// Mode of the scale in force, `flat_spot` or `header`.
    pub mode: ScaleMode,
    /// Pixels (u8 samples) per metre at the flat spot; `None` without one.
    pub ppd_px_per_m: Option<f64>,
    /// Robust standard deviation of the pixels per metre at the flat spot.
    pub ppd_spread_px_per_m: Option<f64>,
    /// Number of picks from which the pixels per metre were computed.
    pub ppd_picks: usize,
    /// Metres on the flat spot that correspond to one metre by the header.
    pub ppd_factor: Option<f64>,
    /// Pings of the flat spot, `A..B`.
    pub pings: Option<PingRange>,
    /// Recorded depth at the flat spot, metres.
    pub flat_spot_depth_m: Option<f64>,
    /// Pixels per metre that the headers imply.
    pub header_px_per_m: Option<f64>,
    /// Spread of the header's pixels per metre over the log: above zero if the range changed.
    pub header_spread_px_per_m: Option<f64>,
    /// Slope of range against depth.
    pub k: Option<f64>,
    /// Offset of range against depth, metres.
    pub b_m: Option<f64>,
    /// Offset subtracted from every slant range, metres (`calibration.offset`).
    pub offset_m: f64,
    /// Offset measured in the log, in force or not, metres.
    pub offset_measured_m: Option<f64>,
    /// Uncertainty of the measured offset by its scatter, metres.
    pub offset_uncertainty_m: Option<f64>,
    /// Reason why no offset is subtracted; `None` if one is.
    pub offset_note: Option<&'static str>,
    /// Angle by which the beams reach past the nadir, degrees; `None` if no slope shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap_deg: Option<f64>,
    /// Robust standard deviation about the line of range against depth, metres.
    pub fit_spread_m: Option<f64>,
}

impl CalibrationReport {
    /// Returns the scale in force and the other one, and the offset of the ranges, as text; `None`
    /// if there is no scale.
    pub(super) fn summary(&self) -> Option<String> {
        let header = (self.header_px_per_m).map(|px| format!("as recorded {px:.2} px/m"));
        let flat_spot = (self.ppd_px_per_m.zip(self.ppd_spread_px_per_m))
            .map(|(ppd, spread)| format!("flat spot {ppd:.2} +- {spread:.2} px/m"));
        let [first, second] = match self.mode {
            ScaleMode::Header => [header, flat_spot],
            ScaleMode::FlatSpot => [flat_spot, header],
        };
        let first = first?;
        let second = second.map_or(String::new(), |second| format!("; not in force: {second}"));
        let offset = match self.offset_m {
            0.0 => String::new(),
            offset_m => format!(", range offset {:+.2} m", -offset_m),
        };
        let overlap = self.overlap_deg.map_or(String::new(), |overlap_deg| {
            format!(", beams look {overlap_deg:.1} degrees past the nadir")
        });
        Some(format!("scale: {first}{offset}{overlap}{second}"))
    }

    pub(super) fn new(calibration: &Calibration) -> Self {
        let Calibration {
            mode,
            flat_spot,
            header,
            fit,
            offset_m,
            measured_offset,
            offset_note,
            beams,
            ..
        } = calibration;
        let ppd = calibration.ppd();
        Self {
            mode: *mode,
            ppd_px_per_m: ppd.map(|scale| scale.px_per_m),
            ppd_spread_px_per_m: ppd.map(|scale| scale.spread_px_per_m),
            ppd_picks: ppd.map_or(0, |scale| scale.picks),
            ppd_factor: calibration.factor(),
            pings: flat_spot
                .as_ref()
                .map(|spot| PingRange { start: spot.pings.start, end: spot.pings.end }),
            flat_spot_depth_m: flat_spot.as_ref().map(|spot| spot.depth_m),
            header_px_per_m: header.map(|scale| scale.px_per_m),
            header_spread_px_per_m: header.map(|scale| scale.spread_px_per_m),
            offset_m: *offset_m,
            offset_measured_m: measured_offset.map(|measured| measured.offset_m),
            offset_uncertainty_m: measured_offset.map(|measured| measured.uncertainty_m),
            offset_note: *offset_note,
            overlap_deg: (beams.overlap_rad > 0.0).then(|| beams.overlap_rad.to_degrees()),
            k: fit.map(|fit| fit.k),
            b_m: fit.map(|fit| fit.b_m),
            fit_spread_m: fit.map(|fit| fit.spread_m),
        }
    }
}
