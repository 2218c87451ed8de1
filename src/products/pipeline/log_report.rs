//! Part of a report on each log: counts and scales.

use bathyscope_bottom::calibration::{Calibration, PingRange, ScaleMode};
use bathyscope_bottom::cloud::ClassCounts;
use bathyscope_log::survey::{FaultCounts, Navigation, Survey, SwathPing};
use serde::Serialize;

/// Counts of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunCounts {
    /// Side-scan pings.
    pub pings: usize,
    /// Depths that the recorder gave.
    pub soundings: usize,
    /// Number of soundings that do not count, by their fault. Faulty ones that a first return
    /// confirms count.
    pub false_soundings: FaultCounts,
    /// Pings with a port first return.
    pub port_first_returns: usize,
    /// Pings with a starboard first return.
    pub starboard_first_returns: usize,
    /// First returns above the recorded depth: weed, fish or boulders.
    pub above_bottom: usize,
    /// Points of these that do not count for the depth map, neither outliers nor of too low
    /// confidence.
    pub above_bottom_left_out: usize,
    /// Points of these that count for the depth map: all, or those of long stretches.
    pub above_bottom_kept: usize,
    /// Side-scan points that are not kept because the confidence of their first return is less than
    /// `first_return.min_confidence`.
    pub low_confidence: usize,
    /// Pings at which the boat moves.
    pub moving: usize,
    /// Pings without a heading.
    pub zero_heading: usize,
    /// Side-scan pings that are excluded.
    pub excluded_pings: usize,
    /// Soundings that are excluded.
    pub excluded_soundings: usize,
    /// Points, whatever their class.
    pub points: usize,
    /// Points that count for the depth map: `kept` of `cloud.csv`, class 40 of every file.
    pub kept: usize,
    /// Points by the code of their class.
    pub classes: ClassCounts,
    /// Points that are first returns of the side-scan.
    pub side_scan_points: usize,
    /// The depths across the track; absent where the recorder measured none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swath: Option<SwathCounts>,
    /// Points that the filter removed.
    pub outliers_removed: usize,
    /// Removed share of the points of side-scan and swath, 0 to 1.
    pub outliers_removed_share: f64,
}

/// Counts of the depths that a recorder measured across the track, and of their use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SwathCounts {
    /// Pings of the swath.
    pub pings: usize,
    /// Pings of the swath without a heading, which give no points.
    pub zero_heading: usize,
    /// Depths as recorded, without the unreliable ones.
    pub depths: usize,
    /// Depths that the recorder marks as unreliable. They are not used.
    pub unreliable: usize,
    /// Points of the cloud: of the depths of a ping that lie close together one is used.
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

    /// Returns the counts in one line for people.
    pub(super) fn summary(&self) -> String {
        format!(
            "swath: {} depths of {} pings give {} points; {} pings without heading; {} depths that the recorder marks as unreliable are not used",
            self.depths, self.pings, self.points, self.zero_heading, self.unreliable
        )
    }
}

impl RunCounts {
    /// Adds those of another log.
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

/// The scales, flat, as scripts want them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibrationReport {
    /// `flat_spot` or `header`.
    pub mode: ScaleMode,
    /// Pixels (u8 samples) per metre at the flat spot.
    pub ppd_px_per_m: Option<f64>,
    /// Its robust standard deviation.
    pub ppd_spread_px_per_m: Option<f64>,
    /// Picks behind it.
    pub ppd_picks: usize,
    /// Metres that one metre of the header measures at the flat spot.
    pub ppd_factor: Option<f64>,
    /// Pings of the flat spot, `A..B`.
    pub pings: Option<PingRange>,
    /// Recorded depth at the flat spot.
    pub flat_spot_depth_m: Option<f64>,
    /// Pixels per metre that the headers imply.
    pub header_px_per_m: Option<f64>,
    /// Its spread over the log: above zero when the range changed.
    pub header_spread_px_per_m: Option<f64>,
    /// Slope of range against depth.
    pub k: Option<f64>,
    /// Offset of range against depth.
    pub b_m: Option<f64>,
    /// Taken off every slant range, metres (`calibration.offset`).
    pub offset_m: f64,
    /// The offset that the log shows, in force or not, metres.
    pub offset_measured_m: Option<f64>,
    /// Its error by its scatter, metres.
    pub offset_uncertainty_m: Option<f64>,
    /// Reason why no offset is taken off.
    pub offset_note: Option<&'static str>,
    /// Angle by which the beams look past the nadir, degrees; absent where no slope shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap_deg: Option<f64>,
    /// Robust standard deviation about that line.
    pub fit_spread_m: Option<f64>,
}

impl CalibrationReport {
    /// The scale in force first, and what is done to the ranges; `None` where nothing gives a
    /// scale.
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
