//! Determines the stretches of a log that are excluded from every result: turns, stops, and
//! stretches that an analyst names. `edit` changes the decisions of the analyst.

mod edit;

pub use edit::LogPart;

use super::{Identity, Navigation, PingNav, Sounding, Survey, run_ranges, turn_rates_deg_s};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Reason why a stretch is excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExclusionReason {
    /// The boat turns, so that far echoes sweep over the ground.
    Turn,
    /// The boat is at rest or drifts.
    Stop,
    /// The recording cannot be used.
    Bad,
    /// The analyst drew the stretch as excluded.
    Drawn,
}

impl ExclusionReason {
    /// Returns the name in settings and tables: `turn`, `stop`, `bad` or `drawn`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Turn => "turn",
            Self::Stop => "stop",
            Self::Bad => "bad",
            Self::Drawn => "drawn",
        }
    }
}

/// Reads and writes the reason of a stretch as text: the reason of its exclusion, or `kept` where
/// it counts.
mod verdict {
    use super::ExclusionReason;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// The reason of a stretch that counts.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Included {
        Kept,
    }

    #[derive(Serialize, Deserialize)]
    #[serde(untagged, expecting = "a reason is `turn`, `stop`, `bad`, `drawn` or `kept`")]
    enum Verdict {
        Excluded(ExclusionReason),
        Included(Included),
    }

    pub(super) fn serialize<S: Serializer>(
        reason: &Option<ExclusionReason>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        let verdict = reason.map_or(Verdict::Included(Included::Kept), Verdict::Excluded);
        verdict.serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<ExclusionReason>, D::Error> {
        Ok(match Verdict::deserialize(from)? {
            Verdict::Excluded(reason) => Some(reason),
            Verdict::Included(Included::Kept) => None,
        })
    }
}

/// A stretch in the settings, given by its pings, or by its times where the log has no side-scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// First and last side-scan ping; `None` for a stretch given by times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pings: Option<[usize; 2]>,
    /// First and last time, seconds of the log; `None` for a stretch given by pings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<[f64; 2]>,
    /// Reason of the exclusion. `None`, written as `kept`, means that the stretch counts although a
    /// turn or a stop is found there.
    #[serde(with = "verdict")]
    pub reason: Option<ExclusionReason>,
    /// True if the soundings of the stretch count although they were marked as those of a lost
    /// bottom or of another fault.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub trusted: bool,
}

impl Stretch {
    /// Returns the first and last time of the stretch, seconds of the log; `None` where its first
    /// ping is not in the log.
    fn span_s(&self, survey: &Survey) -> Option<[f64; 2]> {
        let pings = &survey.side_scan;
        match self.pings {
            Some([first, last]) => {
                let last = last.min(pings.len().checked_sub(1)?);
                Some([pings.get(first)?.time_s, pings.get(last)?.time_s])
            }
            None => self.time_s,
        }
    }
}

/// The `excluded.*` settings. By default nothing is excluded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExclusionSettings {
    /// Turn rate above which stretches are excluded, degrees a second; `None` excludes no turns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_turn_deg_s: Option<f64>,
    /// Speed below which stretches are excluded, metres a second; `None` excludes no stops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_speed_mps: Option<f64>,
    /// Shortest turn or stop that is excluded, seconds. Turns, or stops, with no more time than
    /// this between them are joined.
    pub min_duration_s: f64,
    /// The log that `stretches` belong to; they are not applied to another log. With `None` they
    /// are applied to any log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<Identity>,
    /// Stretches of one log. Where they overlap a turn or a stop, the reason is that of the
    /// stretch.
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

/// Largest number of stretches, more than anyone draws by hand.
const MOST_STRETCHES: usize = 100_000;

impl ExclusionSettings {
    /// Checks the stretches.
    ///
    /// # Errors
    /// The broken rule as a sentence, when there are too many stretches, or a stretch has neither
    /// or both of pings and times, or ends before it begins.
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

    /// Returns the survey without faults of the soundings, and of the depths of pings, in trusted
    /// stretches; `None` where that changes no sounding.
    pub fn trusted(&self, survey: &Survey) -> Option<Survey> {
        let spans = self.trusted_spans_s(survey);
        let inside =
            |time_s: f64| spans.iter().any(|[from_s, to_s]| (*from_s..=*to_s).contains(&time_s));
        let is_false = |sounding: &Sounding| !sounding.is_good() && inside(sounding.time_s);
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

    /// Returns true if a trusted stretch overlaps a time span of the log, seconds.
    pub fn trusts(&self, survey: &Survey, [from_s, to_s]: [f64; 2]) -> bool {
        let spans = self.trusted_spans_s(survey);
        spans.iter().any(|[first_s, last_s]| *first_s <= to_s && from_s <= *last_s)
    }

    /// Returns the first and last time of each trusted stretch, seconds of the log.
    fn trusted_spans_s(&self, survey: &Survey) -> Vec<[f64; 2]> {
        let trusted = self.stretches_of(survey).iter().filter(|stretch| stretch.trusted);
        trusted.filter_map(|stretch| stretch.span_s(survey)).collect()
    }

    /// Returns true if nothing can be excluded.
    pub fn is_empty(&self) -> bool {
        self.max_turn_deg_s.is_none() && self.min_speed_mps.is_none() && self.stretches.is_empty()
    }
}

/// An excluded stretch of a log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExcludedStretch {
    /// First and last side-scan ping; `None` where the log has no side-scan.
    pub pings: Option<[usize; 2]>,
    /// First and last time, seconds of the log.
    pub time_s: [f64; 2],
    /// Reason of the exclusion.
    pub reason: ExclusionReason,
}

impl ExcludedStretch {
    /// Returns the part of the log that the stretch covers: its pings, or its times where it has no
    /// pings.
    pub fn part(&self) -> LogPart {
        self.pings.map_or(LogPart::Time(self.time_s), LogPart::Pings)
    }
}

/// Exclusions of a log: the reason for each excluded side-scan ping, sounding and ping of a swath.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exclusions {
    /// One entry per side-scan ping; empty where no ping is excluded.
    pings: Vec<Option<ExclusionReason>>,
    /// One entry per sounding; empty where no sounding is excluded.
    soundings: Vec<Option<ExclusionReason>>,
    /// One entry per ping of the swath; empty where none is excluded.
    swath: Vec<Option<ExclusionReason>>,
    /// Excluded stretches in time order.
    pub stretches: Vec<ExcludedStretch>,
    /// Sentences about settings that could not be applied.
    pub warnings: Vec<String>,
}

impl Exclusions {
    /// Determines the exclusions of a log by the settings.
    pub fn new(survey: &Survey, navigation: &Navigation, settings: &ExclusionSettings) -> Self {
        if settings.is_empty() {
            return Self::default();
        }
        // Turns and stops are found at the pings, or at the soundings where the log has no pings.
        let times_s = survey.record_times_s();
        let has_pings = !survey.side_scan.is_empty();
        let places = if has_pings { &navigation.pings } else { &navigation.soundings };
        let mut spans = automatic(&times_s, places, settings);
        let mut made = Self::default();
        let own = Identity::of(survey);
        match settings.log.as_ref().filter(|log| !own.is_same_log(log)) {
            Some(other) => made.warnings.push(format!(
                "excluded.stretches are not applied: they belong to {}, a log of {} bytes and {} pings",
                other.file, other.byte_count, other.pings
            )),
            // Later spans replace earlier ones, so that named stretches replace turns and stops.
            None => spans.extend(settings.stretches.iter().filter_map(|stretch| {
                Some((stretch.span_s(survey)?, stretch.reason))
            })),
        }
        made.pings = flags(&survey.side_scan, |ping| ping.time_s, &spans);
        made.soundings = flags(&survey.soundings, |sounding| sounding.time_s, &spans);
        made.swath = flags(&survey.swath, |ping| ping.time_s, &spans);
        let flags = if has_pings { &made.pings } else { &made.soundings };
        made.stretches = stretches(&times_s, flags, has_pings);
        made
    }

    /// Returns true if the ping in the middle of a range of side-scan pings, such as a box, is
    /// excluded.
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

    /// Returns the number of excluded side-scan pings.
    pub fn ping_count(&self) -> usize {
        self.pings.iter().flatten().count()
    }

    /// Returns the index in [`Exclusions::stretches`] of the stretch with a side-scan ping; `None`
    /// where the ping counts.
    pub fn stretch_at(&self, ping: usize) -> Option<usize> {
        self.ping(ping)?;
        let begun =
            |stretch: &ExcludedStretch| stretch.pings.is_some_and(|[first, _]| first <= ping);
        self.stretches.partition_point(begun).checked_sub(1)
    }

    /// Returns the number of excluded soundings.
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

/// Finds the turns and stops that the settings exclude.
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
        // An unknown speed, NaN, is not a stop.
        let is_out = |index: usize| places.get(index).is_some_and(|at| at.speed_mps < min_mps);
        spans.extend(runs(times_s, is_out, ExclusionReason::Stop, min_s));
    }
    spans
}

/// Returns the time spans of runs of records for which `is_out` is true. Runs at most `min_s` apart
/// are joined; runs shorter than `min_s` are left out.
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

/// Returns the reason of the exclusion of each record; empty where no record is excluded.
fn flags<T>(
    records: &[T],
    time_s: impl Fn(&T) -> f64,
    spans: &[TimeSpan],
) -> Vec<Option<ExclusionReason>> {
    let mut flags = vec![None; records.len()];
    for ([from_s, to_s], reason) in spans {
        let first = records.partition_point(|record| time_s(record) < *from_s);
        let after = records.partition_point(|record| time_s(record) <= *to_s);
        if let Some(inside) = flags.get_mut(first..after) {
            inside.fill(*reason);
        }
    }
    if flags.iter().any(Option::is_some) { flags } else { Vec::new() }
}

/// Returns the stretches: runs of records that are excluded for the same reason.
fn stretches(
    times_s: &[f64],
    flags: &[Option<ExclusionReason>],
    are_pings: bool,
) -> Vec<ExcludedStretch> {
    let of_run = |run: Range<usize>| {
        let ends = [run.start, run.end - 1];
        Some(ExcludedStretch {
            pings: are_pings.then_some(ends),
            time_s: ends.map(|end| times_s[end]),
            reason: flags[run.start]?,
        })
    };
    run_ranges(flags, |a, b| a == b).filter_map(of_run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::SidePing;

    /// Creates a log of a minute at ten pings a second: 20 s north at 2 m/s, a turn of 12 degrees a
    /// second for 15 s, 15 s straight, 10 s at rest.
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
            // The turn rate is a mean over two seconds before and after.
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
            edit::stretch(LogPart::Pings([250, 299]), Some(ExclusionReason::Bad)),
            edit::stretch(LogPart::Time([5.0, 5.95]), Some(ExclusionReason::Drawn)),
        ];
        assert_eq!(settings.check(), Ok(()));
        let out = Exclusions::new(&survey, &navigation, &settings);
        let reasons: Vec<ExclusionReason> =
            out.stretches.iter().map(|stretch| stretch.reason).collect();
        use ExclusionReason::{Bad, Drawn, Stop, Turn};
        assert_eq!(reasons, [Drawn, Turn, Bad, Turn, Stop]);
        assert_eq!(out.stretches[0].pings, Some([50, 59]));
        assert_eq!(out.stretches[2].pings, Some([250, 299]));
        let counted = out.stretches.iter().filter_map(|stretch| stretch.pings);
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
        // A turn that is shorter than `min_duration_s` is not excluded.
        let mut settings = turns_and_stops();
        settings.min_duration_s = 20.0;
        assert!(Exclusions::new(&survey, &navigation, &settings).is_empty());
    }
}
