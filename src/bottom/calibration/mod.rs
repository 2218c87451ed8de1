//! Converts samples to metres: measures pixels per metre at a flat spot, reads the header's scale,
//! and fits a line over the whole log.
//!
//! In: a survey with its navigation and first returns. Out: flat spots, and a calibration.
//!
//! `flat_spots` ranks the level stretches of the track, `scale` measures pixels per metre on them
//! and reads the header's, `offset` finds the constant between ranges and recorded depths and fits
//! the line over the log, `overlap` finds how far beams reach past the nadir, `sounding_lag` finds
//! the delay of soundings, and `calibrate` compares the scales and chooses one.

mod calibrate;
mod flat_spots;
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

use crate::first_return::FirstReturns;
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

/// Length below which a stretch is short, metres: it is based on a handful of soundings.
const SHORT_M: f64 = 5.0;
/// Slope along the track above which a bottom is not level, metres a metre.
const SLOPING: f64 = 0.03;
/// Relief above which the scale mixes several depths, as a share of the depth.
const UNEVEN: f64 = 0.15;
/// Share of the pings at which the recorder had lost the bottom, above which there is an objection.
const LOST: f64 = 0.1;
/// A spread counts as larger than that of the best stretch when it is this many times as large, and
/// above this share of the scale.
const WIDER: f64 = 1.5;
const WIDE: f64 = 0.01;
/// Share of the scale above which a spread is large without comparison: at 2 m of depth it is 6 cm.
const VERY_WIDE: f64 = 0.03;

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

    /// Returns the reasons why the stretch is a worse place for a calibration than `best`, or no
    /// place at all; empty where there is no objection.
    pub fn objections(&self, survey: &Survey, best: Option<&FlatSpot>) -> Vec<String> {
        if self.depth_m.is_nan() {
            return vec![
                "The log has no recorded depth over these pings, so they give no scale.".to_owned(),
            ];
        }
        let pings = self.pings.len();
        if self.lost >= pings {
            return vec![
                "The recorder had lost the bottom over all of these pings, so they give no scale."
                    .to_owned(),
            ];
        }
        let mut found = Vec::new();
        if self.lost as f64 > LOST * pings as f64 {
            found.push(format!(
                "The recorder had lost the bottom at {} of {pings} pings.",
                self.lost
            ));
        }
        found.extend(self.few_returns(survey));
        if self.length_m < SHORT_M {
            found.push(format!("The stretch is short: {:.1} m along the track.", self.length_m));
        }
        if self.slope.abs() > SLOPING {
            found.push(format!(
                "The bottom slopes by {:.1} % along the track.",
                100.0 * self.slope.abs()
            ));
        }
        if self.is_tilted() {
            found.push(format!(
                "The bottom slopes across the track: the sides differ by {:.1} %.",
                100.0 * self.tilt
            ));
        }
        if self.relief_m > UNEVEN * self.depth_m {
            found.push(format!("The recorded depth varies by {:.0} cm.", 100.0 * self.relief_m));
        }
        found.extend(self.wide_spread(best));
        found
    }

    /// Returns a sentence where more than half the pings give no usable first return on a side that
    /// was recorded.
    fn few_returns(&self, survey: &Survey) -> Option<String> {
        let recorded = survey.side_scan.get(self.pings.start)?;
        let poorer = Side::BOTH
            .into_iter()
            .zip(self.picks)
            .filter(|(side, _)| recorded.side(*side).is_some())
            .min_by_key(|(_, picks)| *picks);
        let (side, picks) = poorer.filter(|(_, picks)| 2 * picks < self.pings.len())?;
        Some(format!(
            "Only {picks} of {} pings have a usable first return to {}.",
            self.pings.len(),
            side.name(),
        ))
    }

    /// Returns a sentence where the scales of single pings scatter by much, by themselves or
    /// compared with those of the best stretch.
    fn wide_spread(&self, best: Option<&FlatSpot>) -> Option<String> {
        let spread = self.spread()?;
        let percent = 100.0 * spread;
        let best = best.filter(|best| best.pings != self.pings);
        let of_best = best.and_then(FlatSpot::spread);
        match of_best.filter(|best| spread > WIDE.max(WIDER * best)) {
            Some(best) => Some(format!(
                "Pings scatter by {percent:.1} %, by {:.1} % on the best stretch.",
                100.0 * best
            )),
            None => (spread > VERY_WIDE).then(|| format!("Pings scatter by {percent:.1} %.")),
        }
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

    /// Returns true if the soundings of a log are late, or were before their times were corrected:
    /// soundings that a recorder averages stay those of several places.
    fn are_soundings_late(&self, survey: &Survey) -> bool {
        self.sounding_lag.is_some() || survey.sounding_lag_s > 0.0
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

    /// Returns the slant range of the first return at a ping, metres; NaN without one, and where
    /// the side was not recorded.
    pub fn first_return_m(
        &self,
        survey: &Survey,
        returns: &FirstReturns,
        ping: usize,
        side: Side,
    ) -> f64 {
        let found = returns.side(side).get(ping).zip(survey.span(ping, side));
        found.map_or(f64::NAN, |(pick, span)| self.range_m(span, f64::from(pick.sample)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stretch of 100 pings on which nothing is wrong.
    pub(super) fn good() -> FlatSpot {
        FlatSpot {
            pings: 400..500,
            length_m: 10.0,
            depth_m: 2.0,
            relief_m: 0.1,
            lost: 0,
            slope: 0.004,
            scatter_m: 0.01,
            picks: [98, 99],
            tilt: 0.001,
            ppd: Some(Scale { px_per_m: 50.0, spread_px_per_m: 0.4, picks: 197 }),
            factor: Some(1.003),
        }
    }

    #[test]
    fn a_worse_stretch_says_why_and_a_good_one_says_nothing() {
        let survey = Survey::default();
        let of = |change: fn(&mut FlatSpot)| {
            let mut spot = FlatSpot { pings: 900..1000, ..good() };
            change(&mut spot);
            spot.objections(&survey, Some(&good())).join(" ")
        };
        assert_eq!(of(|_| ()), "");
        assert!(of(|spot| spot.length_m = 3.2).contains("short: 3.2 m"));
        assert!(of(|spot| spot.slope = -0.06).contains("slopes by 6.0 %"));
        assert!(of(|spot| spot.tilt = 0.02).contains("differ by 2.0 %"));
        assert!(of(|spot| spot.relief_m = 0.5).contains("varies by 50 cm"));
        assert!(of(|spot| spot.lost = 40).contains("lost the bottom at 40 of 100"));
        let lost = of(|spot| {
            spot.lost = 100;
            spot.ppd = None;
        });
        assert!(lost.contains("lost the bottom over all"), "{lost}");
        let none = of(|spot| spot.depth_m = f64::NAN);
        assert!(none.contains("no recorded depth"), "{none}");
    }

    #[test]
    fn a_larger_spread_never_takes_an_objection_back() {
        let survey = Survey::default();
        let best = good();
        let mut last = 0;
        for spread_px_per_m in [0.4, 0.7, 1.6, 4.29, 20.0] {
            let spot = FlatSpot {
                pings: 0..100,
                ppd: best.ppd.map(|ppd| Scale { spread_px_per_m, ..ppd }),
                ..good()
            };
            for best in [Some(&best), None] {
                let found = spot.objections(&survey, best).len();
                assert!(best.is_none() || found >= last, "{spread_px_per_m}");
                last = if best.is_some() { found } else { last };
                assert_eq!(found > 0, spread_px_per_m > if best.is_some() { 0.6 } else { 1.5 });
            }
        }
    }
}
