//! Converts samples to metres: measures pixels per metre at a flat spot, reads the header's scale,
//! and fits a line over the whole log.
//!
//! In: a survey with its navigation and first returns. Out: flat spots, and a calibration.
//!
//! `flat_spots` ranks the level stretches of the track, `objections` lists what is wrong with one,
//! `scale` measures pixels per metre on them and reads the header's, `offset` finds the constant
//! between ranges and recorded depths, `overlap` finds how far beams reach past the nadir,
//! `sounding_lag` finds the delay of soundings, `robust` fits the line over the log, and
//! `calibrate` compares the scales and chooses one.

mod calibrate;
mod flat_spots;
mod objections;
mod offset;
mod overlap;
mod scale;
mod sounding_lag;

pub use calibrate::calibrate;
pub use flat_spots::{flat_spots, stretch, stretch_around};
pub use offset::RangeOffset;
pub use overlap::BeamWidths;
pub use scale::{RangeAtDepth, header_scale, ranges_at_depths};
pub use sounding_lag::SoundingLag;

#[cfg(doc)]
use bathyscope_log::survey::RangeSource;
use bathyscope_log::survey::{Side, SideSpan, Survey};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::str::FromStr;

/// Scale that turns samples into metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScaleMode {
    /// Pixels per metre measured at a flat spot, `PPD = p / d`.
    FlatSpot,
    /// The range that the recorder states for each ping.
    #[default]
    Header,
}

/// Meaning of a flat spot's scale for pings of another recorded range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PpdReach {
    /// Pixels per metre, one constant for the whole log as published: wrong where the range was
    /// changed.
    Constant,
    /// A factor on the range that the log's header gives each ping. The same as the constant while
    /// the range stays, also where the header's is an estimate (Humminbird).
    #[default]
    Factor,
}

/// Treatment of a constant between first-return ranges and recorded depths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OffsetMode {
    /// Ranges stay as they are.
    None,
    /// The same as [`OffsetMode::Fit`], but ranges of a survey-grade recorder are trusted as they
    /// are ([`RangeSource`]).
    #[default]
    Auto,
    /// The constant that the log shows is subtracted, where it is one that an instrument causes
    /// ([`RangeOffset`]): the pulse's leading edge (a few centimetres early), and draft or keel
    /// offset where the recorder adds one to its depths only.
    Fit,
}

/// `calibration.*` settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CalibrationSettings {
    /// Scale that turns samples into metres.
    pub mode: ScaleMode,
    /// Side-scan pings `A..B` of the flat spot; `None` for the best-ranked one.
    pub pings: Option<PingRange>,
    /// Meaning of the flat spot's scale for pings of another recorded range.
    pub ppd: PpdReach,
    /// Treatment of a constant offset. A scale from a flat spot contains the offset already, so
    /// this setting acts on the header's scale only.
    pub offset: OffsetMode,
}

/// A range of side-scan pings, written `A..B` (B excluded).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct PingRange {
    /// First ping.
    pub start: usize,
    /// One past the last ping.
    pub end: usize,
}

impl From<PingRange> for String {
    fn from(range: PingRange) -> String {
        format!("{}..{}", range.start, range.end)
    }
}

impl FromStr for PingRange {
    /// A sentence about a text that is no range of pings.
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = text.split_once("..").and_then(|(start, end)| {
            Some(PingRange { start: start.trim().parse().ok()?, end: end.trim().parse().ok()? })
        });
        parsed.filter(|range| range.start < range.end).ok_or_else(|| {
            format!("a ping range is written A..B with A < B, for example 400..600; got `{text}`")
        })
    }
}

impl TryFrom<String> for PingRange {
    type Error = String;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

/// Stretch of the track where the recorded depth hardly changes, and what its first returns show.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatSpot {
    /// Side-scan pings of the stretch.
    pub pings: Range<usize>,
    /// Length of the stretch along the track, metres.
    pub length_m: f64,
    /// Median recorded depth, metres; NaN where none was recorded.
    pub depth_m: f64,
    /// Greatest less least recorded depth, metres; NaN where none was recorded.
    pub relief_m: f64,
    /// Number of pings with a recorded depth at which the recorder had lost the bottom.
    pub lost: usize,
    /// Slope of the recorded depth along the track, metres a metre.
    pub slope: f64,
    /// Standard deviation of the recorded depth about its line, metres.
    pub scatter_m: f64,
    /// Number of first returns that may calibrate, port and starboard: not flagged, not at the
    /// search limit.
    pub picks: [usize; 2],
    /// Difference of the ranges to both sides, as a share of the depth: above 0 where the bottom
    /// slopes across the track. NaN where a side has no such first return.
    pub tilt: f64,
    /// Pixels per metre over these first returns, `PPD = p / d`; `None` when they are too few.
    pub ppd: Option<Scale>,
    /// Recorded depth over the header's slant range, median over the same first returns: the true
    /// length of a metre of the header. `None` when they are too few.
    pub factor: Option<f64>,
}

/// Largest difference of the sides over level ground, as a share of the depth. Beams that reach
/// some degrees past the nadir differ by no more on a slope twice as steep.
const TILTED: f64 = 0.004;

impl FlatSpot {
    /// Returns the pings of the stretch as a setting.
    pub fn range(&self) -> PingRange {
        PingRange { start: self.pings.start, end: self.pings.end }
    }

    /// Returns the flatness of the stretch and the scale by its first returns, in three lines.
    pub fn summary(&self) -> String {
        let [port, starboard] = self.picks;
        let scale = match self.ppd.zip(self.factor) {
            Some((ppd, factor)) => format!(
                "recorded range ×{factor:.3}, {:.2} ±{:.2} pixels/m",
                ppd.px_per_m, ppd.spread_px_per_m
            ),
            None => "no scale".to_owned(),
        };
        format!(
            "pings {}..{}, {:.1} m long, {:.2} m deep, relief {:.0} cm, slope {:.1} %\n{scale}\n{port} first returns to port, {starboard} to starboard",
            self.pings.start,
            self.pings.end,
            self.length_m,
            self.depth_m,
            100.0 * self.relief_m,
            100.0 * self.slope.abs(),
        )
    }

    /// Returns true if the bottom slopes across the track, so that the first returns of both sides
    /// are nearer than the depth.
    pub(crate) fn is_tilted(&self) -> bool {
        self.tilt > TILTED
    }

    /// Returns the standard deviation of the scale of single pings as a share of the scale; `None`
    /// without a scale.
    pub fn spread(&self) -> Option<f64> {
        let ppd = self.ppd?;
        Some(ppd.spread_px_per_m / ppd.px_per_m)
    }
}

/// A scale with its spread, in u8 samples a metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Median over the pings used.
    pub px_per_m: f64,
    /// Robust standard deviation (1.4826 MAD) over the pings used.
    pub spread_px_per_m: f64,
    /// Number of picks used, both sides.
    pub picks: usize,
}

/// Robust straight line `r = k d + b` of first-return range against recorded depth over the whole
/// log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthFit {
    /// Slope; about 1 when the fan covers nadir, above 1 when the inner edge of the beam is tilted.
    pub k: f64,
    /// Offset, metres: draft, pulse lead, keel offset.
    pub b_m: f64,
    /// Robust standard deviation about the line, metres.
    pub spread_m: f64,
    /// Number of picks used.
    pub picks: usize,
}

/// Conversion of picks to slant ranges. The default leaves ranges as the recorder wrote them,
/// without measurements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    /// Scale in force.
    pub mode: ScaleMode,
    /// Meaning of the flat spot's scale for pings of another range.
    pub reach: PpdReach,
    /// Stretch on which pixels per metre were measured, if any.
    pub flat_spot: Option<FlatSpot>,
    /// Scale that the log's headers imply (median over the log), if any.
    pub header: Option<Scale>,
    /// Line of range against depth over the whole log, if any.
    pub fit: Option<DepthFit>,
    /// Offset subtracted from every slant range, metres: [`Calibration::measured_offset`] where it
    /// is in force, else 0.
    pub offset_m: f64,
    /// Constant between ranges and depths that the log shows, in force or not.
    pub measured_offset: Option<RangeOffset>,
    /// Reason why no offset is taken off, in a few words for a panel.
    pub offset_note: Option<&'static str>,
    /// Widths of the beams, found on slopes across the track.
    pub beams: BeamWidths,
    /// Delay of the soundings, found on slopes along the track; `None` where these show no lag.
    pub sounding_lag: Option<SoundingLag>,
    /// Disagreements, in sentences.
    pub warnings: Vec<String>,
}

impl Calibration {
    /// Returns the pixels per metre at the flat spot, if measured.
    pub fn ppd(&self) -> Option<Scale> {
        self.flat_spot.as_ref()?.ppd
    }

    /// Returns the true length of a metre of the header at the flat spot ([`FlatSpot::factor`]).
    pub fn factor(&self) -> Option<f64> {
        self.flat_spot.as_ref()?.factor
    }

    /// Returns the excess of first-return ranges over recorded depths by the scale in force, at the
    /// median depth, and two standard errors of it, metres; `None` where the log does not show it.
    pub fn remaining_offset_m(&self) -> Option<[f64; 2]> {
        let found = self.measured_offset?;
        let left_m = match (self.mode, self.factor()) {
            (ScaleMode::FlatSpot, Some(factor)) => {
                factor * (found.depth_m + found.offset_m) - found.depth_m
            }
            _ => found.offset_m - self.offset_m,
        };
        Some([left_m, found.uncertainty_m])
    }

    /// Returns the change of the recorded ranges in words, for the edge of a picture; `None` where
    /// the ranges stay as they are.
    pub fn range_change(&self) -> Option<String> {
        match (self.mode, self.reach, self.ppd(), self.factor()) {
            (ScaleMode::FlatSpot, PpdReach::Constant, Some(ppd), _) => {
                Some(format!("scale {:.2} pixels/m", ppd.px_per_m))
            }
            (ScaleMode::FlatSpot, PpdReach::Factor, _, Some(factor)) => {
                Some(format!("scale ×{factor:.3}"))
            }
            _ if self.offset_m.abs() < 0.005 => None,
            _ => Some(format!("range offset {:+.2} m", -self.offset_m)),
        }
    }

    /// Returns the slant range, metres, at a distance of `sample` samples outward from the nearest
    /// edge of a recorded side.
    pub fn range_m(&self, span: &SideSpan, sample: f64) -> f64 {
        let header_m = span.range_m(sample);
        match (self.mode, self.reach, self.ppd(), self.factor()) {
            (ScaleMode::FlatSpot, PpdReach::Constant, Some(ppd), _) => sample / ppd.px_per_m,
            (ScaleMode::FlatSpot, PpdReach::Factor, _, Some(factor)) => factor * header_m,
            _ => header_m - self.offset_m,
        }
    }

    /// Returns the slant range of a pick at a sample, metres; NaN without a pick, and where the
    /// side was not recorded.
    pub fn pick_range_m(&self, survey: &Survey, ping: usize, side: Side, sample: f32) -> f64 {
        let span = survey.span(ping, side);
        span.map_or(f64::NAN, |span| self.range_m(span, f64::from(sample)))
    }
}
