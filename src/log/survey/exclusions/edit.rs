//! Changes an analyst's decisions about parts of a log: to exclude a part, to include it, or to
//! remove the decision.

use super::{ExclusionReason, ExclusionSettings, Exclusions, Stretch};
use crate::survey::{Identity, NEAREST_SOUNDING_S, Navigation, PingNav, Survey, nearest_in_time};

/// A part of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LogPart {
    /// First and last side-scan ping.
    Pings([usize; 2]),
    /// First and last time, seconds of the log, for a log without side-scan.
    Time([f64; 2]),
}

impl LogPart {
    /// Returns the duration of the part, seconds; NaN where a ping is not in the log.
    pub fn duration_s(self, survey: &Survey) -> f64 {
        let [from_s, to_s] = match self {
            Self::Pings(ends) => ends.map(|ping| {
                let ping = survey.side_scan.get(ping);
                ping.map_or(f64::NAN, |ping| ping.time_s)
            }),
            Self::Time(ends_s) => ends_s,
        };
        to_s - from_s
    }

    /// Returns the places of the boat in this part: at its pings, or at its soundings where the
    /// part is given by times.
    pub fn places<'a>(self, survey: &Survey, navigation: &'a Navigation) -> &'a [PingNav] {
        let places = match self {
            Self::Pings([first, last]) => navigation.pings.get(first..=last),
            Self::Time([from_s, to_s]) => {
                let soundings = &survey.soundings;
                let first = soundings.partition_point(|sounding| sounding.time_s < from_s);
                let after = soundings.partition_point(|sounding| sounding.time_s <= to_s);
                navigation.soundings.get(first..after)
            }
        };
        places.unwrap_or_default()
    }

    /// Returns the length of the part along the track, metres. Unknown places are skipped.
    pub fn length_m(self, survey: &Survey, navigation: &Navigation) -> f64 {
        let is_placed = |place: &&PingNav| (place.east_m + place.north_m).is_finite();
        let places = self.places(survey, navigation).iter().filter(is_placed);
        let places: Vec<&PingNav> = places.collect();
        let step_m = |pair: &[&PingNav]| {
            (pair[1].east_m - pair[0].east_m).hypot(pair[1].north_m - pair[0].north_m)
        };
        places.windows(2).map(step_m).sum()
    }

    /// Returns the part of consecutive soundings with a fault, such as a lost bottom, around a
    /// time; `None` where the sounding nearest in time has no fault, or is too far away in time.
    pub fn of_false_soundings(survey: &Survey, time_s: f64) -> Option<Self> {
        let soundings = &survey.soundings;
        let at = nearest_in_time(soundings, time_s, |sounding| sounding.time_s)?;
        let is_near = (soundings[at].time_s - time_s).abs() <= NEAREST_SOUNDING_S;
        if soundings[at].is_good() || !is_near {
            return None;
        }
        let first = soundings[..at]
            .iter()
            .rposition(|sounding| sounding.is_good())
            .map_or(0, |good| good + 1);
        let after = soundings[at..].iter().position(|sounding| sounding.is_good());
        let last = after.map_or(soundings.len(), |after| at + after) - 1;
        Some(Self::Time([soundings[first].time_s, soundings[last].time_s]))
    }
}

impl ExclusionSettings {
    /// Returns the settings with a part of a log excluded; drawn stretches that touch the part are
    /// joined with it.
    pub fn excluding(&self, survey: &Survey, part: LogPart) -> Self {
        let (mut whole, mut others) = (part, Vec::new());
        for stretch in self.stretches_of(survey) {
            let joined = (stretch.reason == Some(ExclusionReason::Drawn))
                .then(|| joined(whole, stretch, survey))
                .flatten();
            match joined {
                Some(joined) => whole = joined,
                None => others.push(stretch),
            }
        }
        let rest = others.into_iter().flat_map(|stretch| without(stretch, whole, survey));
        let drawn = stretch(whole, Some(ExclusionReason::Drawn));
        self.with_stretches(survey, rest.chain([drawn]).collect())
    }

    /// Returns the settings without any decision about a part of a log, so that only turns and
    /// stops are excluded there.
    pub fn reset(&self, survey: &Survey, part: LogPart) -> Self {
        let stretches = self.stretches_of(survey);
        let rest = stretches.iter().flat_map(|stretch| without(stretch, part, survey));
        self.with_stretches(survey, rest.collect())
    }

    /// Returns the settings with a part of a log included, even where a turn or a stop is found.
    pub fn including(&self, survey: &Survey, navigation: &Navigation, part: LogPart) -> Self {
        let mut settings = self.reset(survey, part);
        let found = Exclusions::new(survey, navigation, &settings);
        let is_out = match part {
            LogPart::Pings([first, last]) => (first..=last).any(|ping| found.ping(ping).is_some()),
            LogPart::Time([from_s, to_s]) => {
                let meets = |[first_s, last_s]: [f64; 2]| first_s <= to_s && from_s <= last_s;
                found.stretches.iter().any(|stretch| meets(stretch.time_s))
            }
        };
        if is_out {
            let mut stretches = std::mem::take(&mut settings.stretches);
            stretches.push(stretch(part, None));
            settings = settings.with_stretches(survey, stretches);
        }
        settings
    }

    /// Returns the settings with the soundings of a part of a log trusted; the part is included,
    /// even where a turn or a stop is found.
    pub fn trusting(&self, survey: &Survey, part: LogPart) -> Self {
        let mut settings = self.reset(survey, part);
        let mut stretches = std::mem::take(&mut settings.stretches);
        stretches.push(Stretch { trusted: true, ..stretch(part, None) });
        settings.with_stretches(survey, stretches)
    }

    /// Returns the stretches if they belong to this log, otherwise none.
    pub(super) fn stretches_of(&self, survey: &Survey) -> &[Stretch] {
        let own = Identity::of(survey);
        let is_own = self.log.as_ref().is_none_or(|log| own.is_same_log(log));
        if is_own { &self.stretches } else { &[] }
    }

    /// Returns the settings with these stretches of this log, in the order in which a project
    /// stores them.
    fn with_stretches(&self, survey: &Survey, mut stretches: Vec<Stretch>) -> Self {
        stretches.sort_by(|one, other| match (one.pings, other.pings) {
            (Some([one, _]), Some([other, _])) => one.cmp(&other),
            (None, None) => start_s(one).total_cmp(&start_s(other)),
            (one, other) => other.is_some().cmp(&one.is_some()),
        });
        Self {
            log: (!stretches.is_empty()).then(|| Identity::of(survey)),
            stretches,
            ..self.clone()
        }
    }
}

fn start_s(stretch: &Stretch) -> f64 {
    stretch.time_s.map_or(0.0, |[from_s, _]| from_s)
}

pub(super) fn stretch(part: LogPart, reason: Option<ExclusionReason>) -> Stretch {
    let (pings, time_s) = match part {
        LogPart::Pings(pings) => (Some(pings), None),
        LogPart::Time(time_s) => (None, Some(time_s)),
    };
    Stretch { pings, time_s, reason, trusted: false }
}

/// Returns the first and last ping of a stretch; `None` where it has none.
fn pings_of(stretch: &Stretch, survey: &Survey) -> Option<[usize; 2]> {
    let pings = &survey.side_scan;
    let [first, last] = match (stretch.pings, stretch.time_s) {
        (Some([first, last]), _) => [first, last.min(pings.len().checked_sub(1)?)],
        (None, Some([from_s, to_s])) => {
            let first = pings.partition_point(|ping| ping.time_s < from_s);
            let after = pings.partition_point(|ping| ping.time_s <= to_s);
            [first, after.checked_sub(1)?]
        }
        (None, None) => return None,
    };
    (first <= last).then_some([first, last])
}

/// Returns the union of a part and a stretch that touches it; `None` where the two are apart.
fn joined(part: LogPart, other: &Stretch, survey: &Survey) -> Option<LogPart> {
    match part {
        LogPart::Pings([first, last]) => {
            let [start, end] = pings_of(other, survey)?;
            let touches = start <= last.saturating_add(1) && first <= end.saturating_add(1);
            touches.then(|| LogPart::Pings([first.min(start), last.max(end)]))
        }
        LogPart::Time([from_s, to_s]) => {
            let [start_s, end_s] = other.time_s?;
            let touches = start_s <= to_s && from_s <= end_s;
            touches.then(|| LogPart::Time([from_s.min(start_s), to_s.max(end_s)]))
        }
    }
}

/// Returns the pieces of a stretch that are outside of a part.
fn without(other: &Stretch, part: LogPart, survey: &Survey) -> Vec<Stretch> {
    let rest = match part {
        LogPart::Pings(part) => pings_of(other, survey).and_then(|whole| {
            let before = |ping: usize| ping.checked_sub(1);
            cut(whole, part, before, |ping| ping.checked_add(1), LogPart::Pings)
        }),
        LogPart::Time(part) => other.time_s.and_then(|whole| {
            let before = |time_s: f64| Some(time_s.next_down());
            cut(whole, part, before, |time_s| Some(time_s.next_up()), LogPart::Time)
        }),
    };
    let Some(rest) = rest else {
        // The stretch is apart and stays as it was given, even if by times.
        return vec![other.clone()];
    };
    let of_rest = |part| Stretch { trusted: other.trusted, ..stretch(part, other.reason) };
    rest.into_iter().map(of_rest).collect()
}

/// Returns the pieces of a span before and after another span; `None` where the two are apart.
fn cut<T: Copy + PartialOrd>(
    [first, last]: [T; 2],
    [from, to]: [T; 2],
    before: impl Fn(T) -> Option<T>,
    after: impl Fn(T) -> Option<T>,
    part: fn([T; 2]) -> LogPart,
) -> Option<Vec<LogPart>> {
    if last < from || to < first {
        return None;
    }
    let head = before(from).map(|end| [first, end]);
    let tail = after(to).map(|start| [start, last]);
    let pieces = [head, tail].into_iter().flatten();
    Some(pieces.filter(|[start, end]| start <= end).map(part).collect())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{sailed, turns_and_stops};
    use super::*;
    use crate::survey::SoundingFault;

    fn named(settings: &ExclusionSettings) -> Vec<([usize; 2], Option<ExclusionReason>)> {
        let stretches = settings.stretches.iter();
        stretches.filter_map(|stretch| Some((stretch.pings?, stretch.reason))).collect()
    }

    #[test]
    fn strokes_join_cut_and_are_taken_back() {
        use ExclusionReason::{Bad, Drawn};
        let (survey, navigation) = sailed(true);
        let pings = |first, last| LogPart::Pings([first, last]);
        let mut given = ExclusionSettings::default();
        given.stretches.push(stretch(LogPart::Time([1.0, 9.95]), Some(Bad)));
        let one = given.excluding(&survey, pings(120, 139));
        let two = one.excluding(&survey, pings(140, 159));
        assert_eq!(named(&two), [([120, 159], Some(Drawn))], "they touch");
        assert_eq!(two.stretches[1], given.stretches[0], "it stays as given");
        assert!(two.log.is_some());
        let three = two.excluding(&survey, pings(90, 125));
        assert_eq!(named(&three), [([10, 89], Some(Bad)), ([90, 159], Some(Drawn))]);
        let four = three.including(&survey, &navigation, pings(100, 110));
        let drawn = [([90, 99], Some(Drawn)), ([111, 159], Some(Drawn))];
        assert_eq!(named(&four)[1..], drawn, "no turn is found there");
        let none = four.reset(&survey, pings(0, 599));
        assert_eq!(none, ExclusionSettings::default());
        assert_eq!(none.check(), Ok(()));
    }

    #[test]
    fn soundings_of_a_lost_bottom_are_trusted_and_distrusted_again() {
        let (mut survey, _) = sailed(true);
        assert_eq!(LogPart::of_false_soundings(&survey, 10.0), None);
        let soundings = std::sync::Arc::make_mut(&mut survey.soundings);
        let ends_s = [soundings[20].time_s, soundings[29].time_s];
        soundings[20..30]
            .iter_mut()
            .for_each(|sounding| sounding.fault = Some(SoundingFault::LostBottom));
        let pings = std::sync::Arc::make_mut(&mut survey.side_scan);
        for ping in pings.iter_mut() {
            let is_lost = (ends_s[0]..=ends_s[1]).contains(&ping.time_s);
            ping.depth_fault = is_lost.then_some(SoundingFault::LostBottom);
            ping.depth_m = 3.0;
        }
        let part = LogPart::of_false_soundings(&survey, 0.5 * (ends_s[0] + ends_s[1]));
        assert_eq!(part, Some(LogPart::Time(ends_s)));
        let none = ExclusionSettings::default();
        assert!(none.trusted(&survey).is_none());
        let settings = none.trusting(&survey, part.unwrap());
        let text = toml::to_string(&settings).expect("settings are text");
        assert_eq!(toml::from_str::<ExclusionSettings>(&text), Ok(settings.clone()));
        let trusted = settings.trusted(&survey).expect("a change");
        assert!(trusted.soundings.iter().all(|sounding| sounding.is_good()));
        assert!(trusted.side_scan.iter().all(|ping| ping.depth_fault.is_none()));
        assert_eq!(settings.reset(&survey, part.unwrap()), none);
    }

    #[test]
    fn a_turn_that_is_found_is_taken_back_in_and_found_again() {
        for with_pings in [true, false] {
            let (survey, navigation) = sailed(with_pings);
            let settings = turns_and_stops();
            let of = |settings: &ExclusionSettings| Exclusions::new(&survey, &navigation, settings);
            let turn = of(&settings).stretches[0];
            let kept = settings.including(&survey, &navigation, turn.part());
            assert_eq!(kept.check(), Ok(()));
            assert_eq!(kept.stretches[0].reason, None);
            let left = of(&kept).stretches;
            assert_eq!(left.len(), 1, "the stop: {left:?}");
            // Excluding the turn again replaces the decision to include it.
            let out = kept.excluding(&survey, turn.part());
            assert_eq!(of(&out).stretches[0].reason, ExclusionReason::Drawn);
            assert_eq!(of(&out).stretches[0].time_s, turn.time_s);
            let found = kept.reset(&survey, turn.part());
            assert_eq!(found, settings);
            let text = toml::to_string(&kept).expect("settings are text");
            assert!(text.contains("\"kept\""), "{text}");
            assert_eq!(toml::from_str::<ExclusionSettings>(&text), Ok(kept));
            assert!(toml::from_str::<ExclusionSettings>(&text.replace("kept", "gone")).is_err());
        }
    }

    #[test]
    fn a_part_has_a_length_and_a_duration() {
        for with_pings in [true, false] {
            let (survey, navigation) = sailed(with_pings);
            let settings = turns_and_stops();
            let turn = Exclusions::new(&survey, &navigation, &settings).stretches[0];
            let part = turn.part();
            let lasts_s = turn.time_s[1] - turn.time_s[0];
            assert!((part.duration_s(&survey) - lasts_s).abs() < 1e-9);
            // The boat goes two metres a second.
            let length_m = part.length_m(&survey, &navigation);
            assert!((length_m - 2.0 * lasts_s).abs() < 0.5, "{length_m}");
        }
    }
}
