//! Stretches of a log that are excluded from every result: turns, stops, and what an analyst takes
//! for bad. `edit` changes what an analyst says of them, `verdict` is how a stretch of the settings
//! says whether it counts.

mod edit;
mod verdict;

pub use edit::LogPart;

use super::{Identity, Navigation, PingNav, Sounding, Survey, turn_rates_deg_s};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Reason why a stretch is excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExclusionReason {
    /// The boat turns: far echoes sweep over the ground.
    Turn,
    /// The boat lies still or drifts.
    Stop,
    /// The recording cannot be used.
    Bad,
    /// The analyst wants it so.
    Drawn,
}

impl ExclusionReason {
    /// `turn`, `stop`, `bad` or `drawn`, as in settings and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Turn => "turn",
            Self::Stop => "stop",
            Self::Bad => "bad",
            Self::Drawn => "drawn",
        }
    }
}

/// A stretch that the settings name: by its pings, or by its time where the log has no side-scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// First and last side-scan ping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pings: Option<[usize; 2]>,
    /// First and last time, seconds of the log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<[f64; 2]>,
    /// Reason of the exclusion; `None`, written `kept`, where the stretch counts although a turn or
    /// a stop is found there.
    #[serde(with = "verdict")]
    pub reason: Option<ExclusionReason>,
    /// True where its soundings count although they were taken for those of a lost bottom or of a
    /// fault of the sounder.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub trusted: bool,
}

impl Stretch {
    /// Returns the first and last time of the stretch, seconds of the log; `None` where the log has
    /// no such ping.
    fn span_s(&self, ping_times: &[f64]) -> Option<[f64; 2]> {
        match self.pings {
            Some([first, last]) => {
                let last = last.min(ping_times.len().checked_sub(1)?);
                Some([*ping_times.get(first)?, *ping_times.get(last)?])
            }
            None => self.time_s,
        }
    }
}

/// `excluded.*` settings. Without any of them nothing is excluded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExclusionSettings {
    /// Stretches in which the boat turns faster than this are excluded, degrees a second; none are
    /// when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_turn_deg_s: Option<f64>,
    /// Stretches in which the boat is slower than this are excluded, metres a second; none are when
    /// not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_speed_mps: Option<f64>,
    /// Shorter turns and stops stay in, seconds; and the way between two of them that is shorter
    /// goes with them.
    pub min_duration_s: f64,
    /// The log that `stretches` were named for; over another they are not applied. Over any when
    /// not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<Identity>,
    /// Stretches of one log. Where they meet a turn or a stop, theirs is the reason.
    pub stretches: Vec<Stretch>,
}

impl Default for ExclusionSettings {
    fn default() -> Self {
        Self {
            max_turn_deg_s: None,
            min_speed_mps: None,
            min_duration_s: 2.0,
            log: None,
            stretches: Vec::new(),
        }
    }
}

/// More stretches than this are no work of a hand.
const MOST_STRETCHES: usize = 100_000;

impl ExclusionSettings {
    /// Refuses what cannot be, in one sentence.
    ///
    /// # Errors
    /// The rule that is broken.
    pub fn check(&self) -> Result<(), &'static str> {
        let is_span = |stretch: &Stretch| match (stretch.pings, stretch.time_s) {
            (Some([first, last]), None) => first <= last,
            (None, Some([from_s, to_s])) => from_s <= to_s,
            _ => false,
        };
        let rules = [
            (
                self.stretches.len() <= MOST_STRETCHES,
                "excluded.stretches may hold 100000 stretches at most",
            ),
            (
                self.stretches.iter().all(is_span),
                "excluded.stretches need either pings, the first and the last, or time_s, from and to",
            ),
        ];
        rules.iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, rule)| Err(*rule))
    }

    /// The survey with the soundings of trusted stretches taken for right, and so the depths of its
    /// pings; `None` where all of them are, or no stretch is trusted.
    pub fn trusted(&self, survey: &Survey) -> Option<Survey> {
        let spans = self.trusted_spans_s(survey);
        let inside =
            |time_s: f64| spans.iter().any(|[from_s, to_s]| (*from_s..=*to_s).contains(&time_s));
        let is_false = |one: &Sounding| !one.is_good() && inside(one.time_s);
        if spans.is_empty() || !survey.soundings.iter().any(is_false) {
            return None;
        }
        let mut trusted = survey.clone();
        for sounding in Arc::make_mut(&mut trusted.soundings) {
            sounding.fault = sounding.fault.filter(|_| !inside(sounding.time_s));
        }
        for ping in Arc::make_mut(&mut trusted.side_scan) {
            ping.depth_fault = ping.depth_fault.filter(|_| !inside(ping.time_s));
        }
        Some(trusted)
    }

    /// Returns true where a trusted stretch meets a time span of the log, seconds.
    pub fn trusts(&self, survey: &Survey, [from_s, to_s]: [f64; 2]) -> bool {
        let spans = self.trusted_spans_s(survey);
        spans.iter().any(|[first_s, last_s]| *first_s <= to_s && from_s <= *last_s)
    }

    /// Returns the first and last time of each trusted stretch, seconds of the log.
    fn trusted_spans_s(&self, survey: &Survey) -> Vec<[f64; 2]> {
        if !self.stretches.iter().any(|stretch| stretch.trusted) {
            return Vec::new();
        }
        let ping_times: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
        let spans = self.stretches_of(survey);
        let spans = spans.iter().filter(|stretch| stretch.trusted);
        spans.filter_map(|one| one.span_s(&ping_times)).collect()
    }

    /// Returns true if nothing can be excluded.
    pub fn is_empty(&self) -> bool {
        self.max_turn_deg_s.is_none() && self.min_speed_mps.is_none() && self.stretches.is_empty()
    }
}

/// A stretch that is excluded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExcludedStretch {
    /// First and last side-scan ping; `None` where it holds none.
    pub pings: Option<[usize; 2]>,
    /// First and last time, seconds of the log.
    pub time_s: [f64; 2],
    /// Why.
    pub reason: ExclusionReason,
}

impl ExcludedStretch {
    /// Returns the part of the log that the stretch covers: its pings, or its times where it holds
    /// none.
    pub fn part(&self) -> LogPart {
        self.pings.map_or(LogPart::Time(self.time_s), LogPart::Pings)
    }

    /// Its length along the track, metres.
    pub fn length_m(&self, survey: &Survey, navigation: &Navigation) -> f64 {
        self.part().length_m(survey, navigation)
    }
}

/// Exclusions of a log: the reason for every excluded side-scan ping, sounding and ping of a swath.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exclusions {
    /// One entry a side-scan ping; none at all where nothing is excluded.
    pings: Vec<Option<ExclusionReason>>,
    /// One entry a sounding; none at all where nothing is excluded.
    soundings: Vec<Option<ExclusionReason>>,
    /// One entry a ping of the swath; none at all where nothing is excluded.
    swath: Vec<Option<ExclusionReason>>,
    /// The stretches in time order.
    pub stretches: Vec<ExcludedStretch>,
    /// Settings that could not be applied, in sentences.
    pub warnings: Vec<String>,
}

impl Exclusions {
    /// Finds what the settings exclude.
    pub fn new(survey: &Survey, navigation: &Navigation, settings: &ExclusionSettings) -> Self {
        if settings.is_empty() {
            return Self::default();
        }
        let ping_times: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
        let sounding_times: Vec<f64> = survey.soundings.iter().map(|one| one.time_s).collect();
        // Turns and stops are the boat's, whichever record tells them.
        let (times_s, places) = if !ping_times.is_empty() {
            (&ping_times, &navigation.pings)
        } else {
            (&sounding_times, &navigation.soundings)
        };
        let mut spans = automatic(times_s, places, settings);
        let mut made = Self::default();
        match named(survey, settings, &ping_times) {
            // The later in the list win.
            Ok(named) => spans.extend(named),
            Err(other) => made.warnings.push(other.to_string()),
        }
        made.pings = flags(&ping_times, &spans);
        made.soundings = flags(&sounding_times, &spans);
        let swath_times: Vec<f64> = survey.swath.iter().map(|ping| ping.time_s).collect();
        made.swath = flags(&swath_times, &spans);
        made.stretches = if !ping_times.is_empty() {
            stretches(&ping_times, &made.pings, true)
        } else {
            stretches(&sounding_times, &made.soundings, false)
        };
        made
    }

    /// Returns true if the middle of some side-scan pings, those of a box, is excluded.
    pub fn is_middle_excluded(&self, pings: &Range<usize>) -> bool {
        self.ping(usize::midpoint(pings.start, pings.end)).is_some()
    }

    /// Returns the reason why a side-scan ping is excluded; `None` where it counts.
    pub fn ping(&self, ping: usize) -> Option<ExclusionReason> {
        self.pings.get(ping).copied().flatten()
    }

    /// Returns the reason why a sounding is excluded; `None` where it counts.
    pub fn sounding(&self, sounding: usize) -> Option<ExclusionReason> {
        self.soundings.get(sounding).copied().flatten()
    }

    /// Returns the reason why a ping of the swath is excluded; `None` where it counts.
    pub fn swath(&self, ping: usize) -> Option<ExclusionReason> {
        self.swath.get(ping).copied().flatten()
    }

    /// Side-scan pings that are excluded.
    pub fn ping_count(&self) -> usize {
        self.pings.iter().flatten().count()
    }

    /// The stretch that a side-scan ping lies in, by its place in [`Exclusions::stretches`]; `None`
    /// where the ping counts.
    pub fn stretch_at(&self, ping: usize) -> Option<usize> {
        self.ping(ping)?;
        let begun =
            |stretch: &ExcludedStretch| stretch.pings.is_some_and(|[first, _]| first <= ping);
        self.stretches.partition_point(begun).checked_sub(1)
    }

    /// Soundings that are excluded.
    pub fn sounding_count(&self) -> usize {
        self.soundings.iter().flatten().count()
    }

    /// Returns true if nothing is excluded.
    pub fn is_empty(&self) -> bool {
        self.stretches.is_empty()
    }
}

/// First and last time of a span, seconds, and the reason of its exclusion; `None` where it counts.
type TimeSpan = ([f64; 2], Option<ExclusionReason>);

/// Turns and stops.
fn automatic(times_s: &[f64], places: &[PingNav], settings: &ExclusionSettings) -> Vec<TimeSpan> {
    let min_s = settings.min_duration_s;
    let mut spans = Vec::new();
    if let Some(max_deg_s) = settings.max_turn_deg_s {
        let turns = turn_rates_deg_s(times_s, places);
        let is_out =
            |index: usize| turns.get(index).is_some_and(|turn| f64::from(*turn) > max_deg_s);
        spans.extend(runs(times_s, is_out, ExclusionReason::Turn, min_s));
    }
    if let Some(min_mps) = settings.min_speed_mps {
        // A speed that is not known is no stop.
        let is_out = |index: usize| places.get(index).is_some_and(|at| at.speed_mps < min_mps);
        spans.extend(runs(times_s, is_out, ExclusionReason::Stop, min_s));
    }
    spans
}

/// Runs of records that are out; those that are nearer to each other than `min_s` are one, and
/// shorter ones stay in.
fn runs(
    times_s: &[f64],
    is_out: impl Fn(usize) -> bool,
    reason: ExclusionReason,
    min_s: f64,
) -> Vec<TimeSpan> {
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for (index, &time_s) in times_s.iter().enumerate() {
        if !is_out(index) {
            continue;
        }
        match joined.last_mut() {
            Some([_, to_s]) if time_s - *to_s <= min_s => *to_s = time_s,
            _ => joined.push([time_s, time_s]),
        }
    }
    let long = joined.into_iter().filter(|[from_s, to_s]| to_s - from_s >= min_s);
    long.map(|span| (span, Some(reason))).collect()
}

/// Stretches of another log.
#[derive(Debug, thiserror::Error)]
#[error(
    "excluded.stretches are not applied: they belong to {}, a log of {} bytes and {} pings",
    .0.file, .0.byte_count, .0.pings
)]
struct StretchesOfOtherLog<'a>(&'a Identity);

/// The stretches that the settings name, as spans of time.
///
/// # Errors
/// Where they belong to another log.
fn named<'a>(
    survey: &Survey,
    settings: &'a ExclusionSettings,
    ping_times: &[f64],
) -> Result<Vec<TimeSpan>, StretchesOfOtherLog<'a>> {
    let own = Identity::of(survey);
    if let Some(log) = settings.log.as_ref().filter(|log| !own.is_same_log(log)) {
        return Err(StretchesOfOtherLog(log));
    }
    let span = |stretch: &Stretch| Some((stretch.span_s(ping_times)?, stretch.reason));
    Ok(settings.stretches.iter().filter_map(span).collect())
}

/// The reason at every time; empty where there is none at all.
fn flags(times_s: &[f64], spans: &[TimeSpan]) -> Vec<Option<ExclusionReason>> {
    let mut flags = vec![None; times_s.len()];
    for ([from_s, to_s], reason) in spans {
        let first = times_s.partition_point(|time_s| time_s < from_s);
        let after = times_s.partition_point(|time_s| time_s <= to_s);
        if let Some(inside) = flags.get_mut(first..after) {
            inside.fill(*reason);
        }
    }
    if flags.iter().any(Option::is_some) { flags } else { Vec::new() }
}

/// Runs of the same reason.
fn stretches(
    times_s: &[f64],
    flags: &[Option<ExclusionReason>],
    are_pings: bool,
) -> Vec<ExcludedStretch> {
    let mut start = 0;
    let mut found = Vec::new();
    for same in flags.chunk_by(|a, b| a == b) {
        let last = start + same.len() - 1;
        if let Some(reason) = same[0] {
            found.push(ExcludedStretch {
                pings: are_pings.then_some([start, last]),
                time_s: [times_s[start], times_s[last]],
                reason,
            });
        }
        start = last + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{SidePing, Sounding};
    use std::sync::Arc;

    /// A minute at ten pings a second: 20 s north at 2 m/s, a turn of 12 degrees a second for 15 s,
    /// 15 s straight, 10 s at rest.
    pub(super) fn sailed(with_pings: bool) -> (Survey, Navigation) {
        let times_s: Vec<f64> = (0..600).map(|index| 0.1 * f64::from(index)).collect();
        let (mut at, mut heading_rad) = ([0.0, 0.0], 0.0_f64);
        let mut places = Vec::new();
        for &time_s in &times_s {
            if (20.0..35.0).contains(&time_s) {
                heading_rad += 12_f64.to_radians() * 0.1;
            }
            let speed_mps = if time_s >= 50.0 { 0.0 } else { 2.0 };
            at = [
                at[0] + 0.1 * speed_mps * heading_rad.sin(),
                at[1] + 0.1 * speed_mps * heading_rad.cos(),
            ];
            places.push(PingNav { east_m: at[0], north_m: at[1], heading_rad, speed_mps });
        }
        let ping = |&time_s: &f64| SidePing::with_depth(time_s, 3.0);
        let sounding = |&time_s: &f64| Sounding::new(time_s, 3.0);
        let pings: Vec<SidePing> =
            if with_pings { times_s.iter().map(ping).collect() } else { Vec::new() };
        let survey = Survey {
            soundings: Arc::new(times_s.iter().step_by(2).map(sounding).collect()),
            ..Survey::of_pings(pings)
        };
        let of_soundings = places.clone().into_iter().step_by(2).collect();
        let navigation = Navigation {
            soundings: Arc::new(of_soundings),
            ..Navigation::of_pings(places.into_iter().filter(|_| with_pings))
        };
        (survey, navigation)
    }

    pub(super) fn turns_and_stops() -> ExclusionSettings {
        ExclusionSettings {
            max_turn_deg_s: Some(6.0),
            min_speed_mps: Some(0.5),
            ..ExclusionSettings::default()
        }
    }

    #[test]
    fn turns_and_stops_are_found_with_and_without_side_scan() {
        for with_pings in [true, false] {
            let (survey, navigation) = sailed(with_pings);
            let out = Exclusions::new(&survey, &navigation, &turns_and_stops());
            let [turn, stop] = out.stretches[..] else { panic!("{:?}", out.stretches) };
            assert_eq!(turn.reason, ExclusionReason::Turn);
            assert_eq!(stop.reason, ExclusionReason::Stop);
            // The rate is a mean over two seconds to both sides.
            for (found_s, true_s) in turn.time_s.iter().zip([20.0, 35.0]) {
                assert!((found_s - true_s).abs() < 1.5, "{turn:?}");
            }
            assert!((stop.time_s[0] - 50.0).abs() < 0.3 && stop.time_s[1] > 59.0);
            assert_eq!(turn.pings.is_some(), with_pings);
            assert_eq!(out.sounding(137), Some(ExclusionReason::Turn));
            assert_eq!(out.sounding(20), None);
            assert_eq!(out.ping(275), with_pings.then_some(ExclusionReason::Turn));
        }
    }

    #[test]
    fn what_an_analyst_names_stands_over_what_is_found_and_belongs_to_its_log() {
        let (survey, navigation) = sailed(true);
        let mut settings = turns_and_stops();
        settings.stretches = vec![
            Stretch {
                pings: Some([250, 299]),
                time_s: None,
                reason: Some(ExclusionReason::Bad),
                trusted: false,
            },
            Stretch {
                pings: None,
                time_s: Some([5.0, 5.95]),
                reason: Some(ExclusionReason::Drawn),
                trusted: false,
            },
        ];
        assert_eq!(settings.check(), Ok(()));
        let out = Exclusions::new(&survey, &navigation, &settings);
        let reasons: Vec<ExclusionReason> = out.stretches.iter().map(|one| one.reason).collect();
        use ExclusionReason::{Bad, Drawn, Stop, Turn};
        assert_eq!(reasons, [Drawn, Turn, Bad, Turn, Stop]);
        assert_eq!(out.stretches[0].pings, Some([50, 59]));
        assert_eq!(out.stretches[2].pings, Some([250, 299]));
        let counted = out.stretches.iter().filter_map(|one| one.pings);
        let counted: usize = counted.map(|[first, last]| last + 1 - first).sum();
        assert_eq!(out.ping_count(), counted);
        settings.log = Some(Identity {
            swapped_sides: false,
            file: "other.sl2".to_owned(),
            byte_count: 7,
            pings: 9,
        });
        let other = Exclusions::new(&survey, &navigation, &settings);
        assert_eq!(other.stretches.len(), 2);
        assert!(other.warnings[0].contains("other.sl2"), "{:?}", other.warnings);
        settings.stretches[0].time_s = Some([1.0, 2.0]);
        assert!(settings.check().is_err());
    }

    #[test]
    fn nothing_is_excluded_unasked() {
        let (survey, navigation) = sailed(true);
        let out = Exclusions::new(&survey, &navigation, &ExclusionSettings::default());
        assert_eq!(out, Exclusions::default());
        // A turn that is shorter than the shortest stays.
        let mut settings = turns_and_stops();
        settings.min_duration_s = 20.0;
        assert!(Exclusions::new(&survey, &navigation, &settings).is_empty());
    }
}
