//! Finds the first sonar return: on each side of each ping, the place where the bottom is first
//! detected.
//!
//! In: a survey. Out: a first return for each ping and side, with or without the bottom edits.
//!
//! `normalise` reads and scales the picture, in bytes or as the published int32 picture.
//! `threshold` is the simple method, `tracker` the one that follows the bottom as a whole line.
//! `confidence` computes the confidence of a pick and whether it is above the recorded depth, and
//! lowers it beyond the depth. `false_soundings` finds the recorded depths that both sides
//! contradict. `manual_picks` holds the edits of the analyst, also those that accept first returns
//! as they were found. [`BottomLine`] chooses the bottom that the picture is laid out by: water
//! column, ground range, gain normalisation and mosaic follow it. Points, calibration and residuals
//! always use the first returns: points at the recorded depth would be no measurements, and would
//! agree with that depth exactly.

mod confidence;
mod false_soundings;
mod manual_picks;
mod normalise;
mod threshold;
mod tracker;

pub use confidence::Evidence;
pub(crate) use confidence::ground_confidence;
pub use false_soundings::FalseSoundings;
pub use manual_picks::{BottomEdit, BottomSettings, OtherLog};
pub use normalise::Normalisation;
pub use threshold::ThresholdIndex;

use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Exclusions, Side, SideSpan, Survey};
use confidence::MethodPick;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Meaning of a sample of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleMode {
    /// The recorded bytes.
    #[default]
    Bytes,
    /// Four bytes read as one little-endian int32, as the published code does: a picture of a
    /// quarter of the columns.
    Words,
}

/// `image.*` settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImageSettings {
    /// Meaning of the samples: bytes, or the published int32 words.
    pub samples: SampleMode,
}

/// Method of finding the first return.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The first sample beyond the dead zone whose normalised intensity reaches the threshold.
    Threshold,
    /// The bottom edge as a whole line, among the samples that reach the threshold.
    Tracker,
}

/// `first_return.*` settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FirstReturnSettings {
    /// Method of finding the first return.
    pub method: Method,
    /// Normalised intensity, 0 to 1, that a sample must reach to count as a return.
    pub threshold: f32,
    /// Slant range around the transducer that is ignored (ring-down), metres.
    pub dead_zone_m: f64,
    /// Difference by which a pick must be nearer than the recorded depth to be flagged as an
    /// above-bottom return, metres. Nothing is flagged where the recorder had lost the bottom.
    pub above_bottom_margin_m: f64,
    /// Least confidence at which the point of a first return is kept, 0 to 1.
    pub min_confidence: f32,
    /// Bottom line that the picture is laid out by.
    pub bottom_line: BottomLine,
}

impl Default for FirstReturnSettings {
    fn default() -> Self {
        Self {
            method: Method::Tracker,
            threshold: 0.3,
            dead_zone_m: 0.5,
            above_bottom_margin_m: 0.15,
            // On ponds, of the picks below this confidence less than one in four of the threshold
            // is right, weed counted; the tracker has hardly any such picks.
            min_confidence: 0.2,
            bottom_line: BottomLine::Search,
        }
    }
}

impl FirstReturnSettings {
    /// Returns true if both settings find the same picks: the least confidence only decides which
    /// picks are kept, and the bottom line which bottom the picture is laid out by.
    pub fn finds_the_same(&self, other: &Self) -> bool {
        Self {
            min_confidence: other.min_confidence,
            bottom_line: other.bottom_line,
            ..self.clone()
        } == *other
    }
}

/// First detection of the bottom on one side of one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Distance outward from the middle in u8 samples, fractions allowed; NaN when there is no
    /// pick.
    pub sample: f32,
    /// Probability that the pick is within 25 cm of the nearest ground, 0 to 1, as measured on
    /// simulated ponds ([`Evidence`]); 0 when there is no pick.
    pub confidence: f32,
    /// True if the pick is nearer than the recorded depth by more than the margin: an above-bottom
    /// return (weed, fish, another obstacle).
    pub above_bottom: bool,
}

impl Pick {
    /// Value where no return was found.
    pub const NONE: Pick = Pick { sample: f32::NAN, confidence: 0.0, above_bottom: false };

    /// Accepts the return as the bottom although it is above the recorded depth: its confidence
    /// becomes that of ground.
    fn accept(&mut self) {
        self.confidence = ground_confidence(self.confidence, self.above_bottom);
        self.above_bottom = false;
    }

    /// Returns true if a return was found.
    pub fn is_some(&self) -> bool {
        !self.sample.is_nan()
    }

    /// Returns the slant range by the recorder's scale at a ping, metres; NaN without a pick or a
    /// recorded side.
    fn range_m(&self, survey: &Survey, ping: usize, side: Side) -> f64 {
        let span = survey.span(ping, side).filter(|_| self.is_some());
        span.map_or(f64::NAN, |span| span.range_m(f64::from(self.sample)))
    }
}

/// First returns of every side-scan ping; copies share the lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FirstReturns {
    /// One entry per [`Survey::side_scan`] ping.
    pub port: Arc<Vec<Pick>>,
    /// One entry per [`Survey::side_scan`] ping.
    pub starboard: Arc<Vec<Pick>>,
    /// Warnings about the detection (for example words whose sign bit makes the threshold useless).
    pub warnings: Vec<String>,
    /// Stretches of manual picks: side, first and last ping.
    pub drawn: Vec<(Side, [usize; 2])>,
    /// Soundings that both sides contradict, in order.
    pub false_soundings: Arc<Vec<FalseSoundings>>,
}

impl FirstReturns {
    /// Creates the first returns of both sides, port first, that were found by a normalisation.
    fn of_sides(sides: [Vec<Pick>; 2], normalisation: &Normalisation) -> Self {
        let [port, starboard] = sides.map(Arc::new);
        let warnings = normalisation.warning().into_iter().collect();
        Self { port, starboard, warnings, ..Self::default() }
    }

    /// Returns the survey with the soundings that both sides contradict marked as a lost bottom,
    /// for the later stages; `None` where there is nothing to mark.
    pub fn judged(&self, survey: &Survey) -> Option<Survey> {
        false_soundings::judged(survey, &self.false_soundings)
    }

    /// Returns true if a bottom edit determines the pick of a ping, or determines that it has none.
    pub fn is_drawn(&self, side: Side, ping: usize) -> bool {
        let covers = |[first, last]: [usize; 2]| (first..=last).contains(&ping);
        (self.drawn.iter()).any(|&(of, pings)| of == side && covers(pings))
    }

    /// Returns the slant range of the first return at a ping by the recorder's scale, metres; NaN
    /// without one.
    pub(crate) fn range_m(&self, survey: &Survey, ping: usize, side: Side) -> f64 {
        let pick = self.side(side).get(ping);
        pick.map_or(f64::NAN, |pick| pick.range_m(survey, ping, side))
    }

    /// Returns the first returns without picks at the excluded pings.
    #[must_use]
    pub fn without(&self, exclusions: &Exclusions) -> Self {
        let mut counted = self.clone();
        for side in Side::BOTH {
            for (ping, pick) in counted.side_mut(side).iter_mut().enumerate() {
                if exclusions.ping(ping).is_some() {
                    *pick = Pick::NONE;
                }
            }
        }
        counted
    }

    /// Returns the picks of one side, to change them.
    fn side_mut(&mut self, side: Side) -> &mut Vec<Pick> {
        Arc::make_mut(match side {
            Side::Port => &mut self.port,
            Side::Starboard => &mut self.starboard,
        })
    }

    /// Returns the picks of one side.
    pub fn side(&self, side: Side) -> &[Pick] {
        match side {
            Side::Port => &self.port,
            Side::Starboard => &self.starboard,
        }
    }
}

/// Finds the first return on both sides of every ping. Without a side-scan transducer a unit
/// records noise only, and nothing is found: a value above the threshold would become a point at a
/// false depth.
///
/// # Errors
/// When the work was cancelled.
pub fn detect(
    survey: &Survey,
    image: &ImageSettings,
    settings: &FirstReturnSettings,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    if !survey.has_side_scan() {
        return Ok(none(survey));
    }
    let normalisation = Normalisation::measure(survey, image, settings.dead_zone_m, progress)?;
    detect_with(survey, image, settings, &normalisation, progress)
}

/// Detects as [`detect`] does, with a normalisation that was measured before, for example on a
/// picture of which the survey is a part.
///
/// # Errors
/// When the work was cancelled.
pub fn detect_with(
    survey: &Survey,
    image: &ImageSettings,
    settings: &FirstReturnSettings,
    normalisation: &Normalisation,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    if !survey.has_side_scan() {
        return Ok(none(survey));
    }
    let mut returns = match settings.method {
        Method::Threshold => {
            let index = ThresholdIndex::by(survey, image, normalisation.clone(), progress)?;
            index.detect(survey, settings.threshold, settings.above_bottom_margin_m)
        }
        Method::Tracker => {
            let pings = 0..survey.side_scan.len();
            track_range(survey, normalisation, settings, pings, progress)?
        }
    };
    false_soundings::judge(survey, &mut returns);
    if settings.method == Method::Tracker {
        track_again(survey, normalisation, settings, &mut returns, progress)?;
    }
    Ok(returns)
}

/// Searches again around false soundings: they moved the line to themselves, or lowered the
/// confidence of right picks. The expected depths then limit the line. Afterwards all first returns
/// are compared with the expected depths, on the scale of the log. Over a held depth, first returns
/// above the depth are accepted as the bottom.
fn track_again(
    survey: &Survey,
    normalisation: &Normalisation,
    settings: &FirstReturnSettings,
    returns: &mut FirstReturns,
    progress: &Progress,
) -> Result<(), Cancelled> {
    if returns.false_soundings.is_empty() {
        confidence::doubt_by_own_scale(survey, returns);
        return Ok(());
    }
    let (explained, pings) = false_soundings::explained(survey, &returns.false_soundings);
    for pings in false_soundings::ranges_around(survey, &pings) {
        let found = track_range(&explained, normalisation, settings, pings.clone(), progress)?;
        for side in Side::BOTH {
            returns.side_mut(side)[pings.clone()].copy_from_slice(found.side(side));
        }
    }
    confidence::doubt_by_own_scale(&explained, returns);
    for ping in false_soundings::held_pings(survey, &returns.false_soundings) {
        for side in Side::BOTH {
            returns.side_mut(side)[ping].accept();
        }
    }
    Ok(())
}

fn none(survey: &Survey) -> FirstReturns {
    let none = Arc::new(vec![Pick::NONE; survey.side_scan.len()]);
    FirstReturns { port: none.clone(), starboard: none, ..FirstReturns::default() }
}

/// Returns the evidence for the picks that [`detect`] finds, port and starboard; the laws of
/// confidence are fitted to it.
pub fn evidence(
    survey: &Survey,
    image: &ImageSettings,
    settings: &FirstReturnSettings,
    progress: &Progress,
) -> Result<[Vec<Evidence>; 2], Cancelled> {
    let normalisation = Normalisation::measure(survey, image, settings.dead_zone_m, progress)?;
    let settled = match settings.method {
        Method::Threshold => {
            let index = ThresholdIndex::by(survey, image, normalisation, progress)?;
            index.found(settings.threshold)
        }
        Method::Tracker => {
            let pings = 0..survey.side_scan.len();
            tracked(survey, &normalisation, settings, pings, progress)?
        }
    };
    let gathering = confidence::Gathering {
        survey,
        first: 0,
        settled: &settled,
        margin_m: settings.above_bottom_margin_m,
        dead_zone_m: settings.dead_zone_m,
        method: settings.method,
    };
    Ok(gathering.evidence())
}

/// First returns that a method found, port and starboard, with the recorded depth of each ping in
/// metres, NaN where there is none to believe.
struct Settled {
    found: [Vec<MethodPick>; 2],
    depths_m: Vec<f32>,
}

fn tracked(
    survey: &Survey,
    normalisation: &Normalisation,
    settings: &FirstReturnSettings,
    pings: Range<usize>,
    progress: &Progress,
) -> Result<Settled, Cancelled> {
    let found = tracker::track(survey, normalisation, settings, pings.clone(), progress)?;
    let depths_m = pings.into_par_iter().map(|ping| survey.good_depth_m(ping));
    Ok(Settled { found, depths_m: depths_m.collect() })
}

/// Runs the tracker over some pings only; the picks are the same as over the whole survey.
///
/// This is for the preview while the threshold is dragged: `normalisation` is that of the whole
/// picture, kept by the caller ([`ThresholdIndex::normalisation`] has it). The result has one entry
/// for each of `pings`.
///
/// # Errors
/// When the work was cancelled.
pub fn track_range(
    survey: &Survey,
    normalisation: &Normalisation,
    settings: &FirstReturnSettings,
    pings: Range<usize>,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    // The confidence of a pick depends on the pings around it.
    let around = pings.start.saturating_sub(confidence::REACH)
        ..survey.side_scan.len().min(pings.end + confidence::REACH);
    let settled = tracked(survey, normalisation, settings, around.clone(), progress)?;
    let mut sides = confidence::Gathering {
        survey,
        first: around.start,
        settled: &settled,
        margin_m: settings.above_bottom_margin_m,
        dead_zone_m: settings.dead_zone_m,
        method: Method::Tracker,
    }
    .picks();
    for picks in &mut sides {
        picks.truncate(pings.end - around.start);
        picks.drain(..pings.start - around.start);
    }
    Ok(FirstReturns::of_sides(sides, normalisation))
}

/// Joins rising indices to stretches. An index goes on with the stretch before it where `goes_on`
/// returns true for the end of this stretch and the index.
fn joined(
    indices: impl Iterator<Item = usize>,
    goes_on: impl Fn(usize, usize) -> bool,
) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for index in indices {
        match stretches.last_mut() {
            Some(last) if goes_on(last.end, index) => last.end = index + 1,
            _ => stretches.push(index..index + 1),
        }
    }
    stretches
}

/// Source of the bottom line. Bottom edits replace either source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BottomLine {
    /// The first return of each side.
    #[default]
    Search,
    /// The depth of the recorder's own sounding, the same on both sides; the first return where the
    /// recorder had lost the bottom.
    Recorded,
}

/// Returns the bottom line at the recorded depths. Manual picks stay; the first returns stay where
/// there is no depth to believe or the depth is beyond the recorded range. `sample_at` converts a
/// depth into a sample of a recorded side, with the calibration in use. A warning counts the places
/// without a recorded depth.
pub fn at_recorded_depth(
    survey: &Survey,
    returns: &FirstReturns,
    sample_at: impl Fn(&SideSpan, f64) -> f64,
) -> FirstReturns {
    let mut line = returns.clone();
    let (mut found, mut places) = (0, 0);
    for side in Side::BOTH {
        let drawn = drawn(returns, side);
        let recorded = line.side_mut(side).iter_mut().zip(drawn).enumerate();
        for (ping, (pick, is_drawn)) in recorded {
            let Some(span) = survey.span(ping, side).filter(|_| !is_drawn) else {
                continue;
            };
            places += 1;
            let depth_m = f64::from(survey.good_depth_m(ping));
            let sample = sample_at(span, depth_m);
            if (0.0..=f64::from(span.count)).contains(&sample) {
                *pick = Pick { sample: sample as f32, confidence: 1.0, above_bottom: false };
            } else {
                found += 1;
            }
        }
    }
    if found > 0 {
        line.warnings.push(format!(
            "the bottom line is the first return at {found} of {places} places, both sides counted: the recorder has no depth there"
        ));
    }
    line
}

/// Returns for each ping true if its pick on a side is a manual one.
fn drawn(returns: &FirstReturns, side: Side) -> Vec<bool> {
    let mut drawn = vec![false; returns.side(side).len()];
    for (_, [first, last]) in returns.drawn.iter().filter(|(of, _)| *of == side) {
        let end = drawn.len().min(last.saturating_add(1));
        if let Some(pings) = drawn.get_mut(*first..end) {
            pings.fill(true);
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{SidePing, SoundingFault};

    #[test]
    fn edits_stay_and_what_was_not_recorded_is_searched_and_said() {
        let span = SideSpan::of_bytes(1000, [0.0, 20.0]);
        let ping = |depth_m: f32, depth_fault| SidePing {
            time_s: 0.0,
            depth_m,
            depth_fault,
            port: Some(span),
            starboard: None,
        };
        // A depth; one that was drawn over; one with a fault; none; one beyond the range.
        let side_scan = vec![
            ping(4.0, None),
            ping(4.0, None),
            ping(4.0, Some(SoundingFault::LostBottom)),
            ping(f32::NAN, None),
            ping(30.0, None),
        ];
        let survey = Survey::of_pings(side_scan);
        let pick = |sample| Pick { sample, confidence: 0.5, above_bottom: true };
        let returns = FirstReturns {
            port: Arc::new((0..5).map(|ping| pick(100.0 + ping as f32)).collect()),
            starboard: vec![Pick::NONE; 5].into(),
            drawn: vec![(Side::Port, [1, 1])],
            ..FirstReturns::default()
        };
        // Echoes lie 0.1 m farther out than by the recorder's scale.
        let line =
            at_recorded_depth(&survey, &returns, |span, depth_m| span.sample_at(depth_m + 0.1));
        let samples: Vec<f32> = line.port.iter().map(|pick| pick.sample).collect();
        assert_eq!(samples, [205.0, 101.0, 102.0, 103.0, 104.0]);
        assert!(!line.port[0].above_bottom && line.port[2].above_bottom);
        assert_eq!(line.drawn, returns.drawn);
        assert!(line.starboard.iter().all(|pick| !pick.is_some()));
        assert!(line.warnings[0].contains("at 3 of 4 places"), "{:?}", line.warnings);
    }
}
