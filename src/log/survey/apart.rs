//! Finds logs that do not belong to the survey of the other logs: they lie too far away, or are too
//! short to show anything.

use super::Survey;
use crate::support::geo::{LonLat, distance_m};

/// Logs farther apart than this are of different waters, metres.
const FAR_M: f64 = 50_000.0;
/// A log of fewer pings, soundings and pings of a swath was switched on and off again.
const FEWEST: usize = 20;

/// Reason why a log does not belong to the survey of the other logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Apart {
    /// It lies far from the others.
    Far {
        /// Distance to the nearest of them, metres.
        distance_m: f64,
    },
    /// It is too short.
    Short {
        /// Its side-scan pings.
        pings: usize,
    },
}

impl std::fmt::Display for Apart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Apart::Far { distance_m } => {
                write!(f, "{:.0} km from the other logs", distance_m / 1000.0)
            }
            Apart::Short { pings: 1 } => f.write_str("too short: 1 ping"),
            Apart::Short { pings } => write!(f, "too short: {pings} pings"),
        }
    }
}

/// Returns for each log the reason why it does not belong to the survey; `None` where it does. The
/// survey is the logs near those of `known`, or, where none of these has a place, the near ones
/// with most pings. One log is a survey, and so are logs that are all too short.
pub fn apart(logs: &[&Survey], known: &[bool]) -> Vec<Option<Apart>> {
    let is_short = |log: &&Survey| {
        let counts = [log.side_scan.len(), log.soundings.len(), log.swath.len()];
        counts.iter().all(|count| *count < FEWEST)
    };
    let pings = |log: usize| logs[log].side_scan.len();
    let long: Vec<usize> = (0..logs.len()).filter(|&log| !is_short(&logs[log])).collect();
    let mut why = vec![None; logs.len()];
    if long.is_empty() {
        return why;
    }
    for log in (0..logs.len()).filter(|log| !long.contains(log)) {
        why[log] = Some(Apart::Short { pings: pings(log) });
    }
    let placed = long.iter().filter_map(|&log| Some((log, place(logs[log])?)));
    let groups = groups(placed.collect());
    let weight = |group: &Vec<(usize, LonLat)>| {
        let is_known = group.iter().any(|(log, _)| known.get(*log) == Some(&true));
        let count: usize = group.iter().map(|(log, _)| pings(*log)).sum();
        (is_known, count)
    };
    let Some(survey) = groups.iter().max_by_key(|group| weight(group)) else {
        return why;
    };
    for (log, at) in groups.iter().filter(|group| *group != survey).flatten() {
        let distances_m = survey.iter().map(|(_, there)| distance_m(*at, *there));
        let distance_m = distances_m.fold(f64::INFINITY, f64::min);
        why[*log] = Some(Apart::Far { distance_m });
    }
    why
}

/// The place in the middle of a log.
fn place(log: &Survey) -> Option<LonLat> {
    let fixes = &log.track.fixes;
    fixes.get(fixes.len() / 2).map(|fix| fix.position)
}

/// Logs in groups: each log of a group lies near another one of it.
fn groups(mut placed: Vec<(usize, LonLat)>) -> Vec<Vec<(usize, LonLat)>> {
    let mut groups = Vec::new();
    while let Some(first) = placed.pop() {
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&(_, here)) = group.get(next) {
            let near = |(_, there): &mut (usize, LonLat)| distance_m(here, *there) <= FAR_M;
            group.extend(placed.extract_if(.., near));
            next += 1;
        }
        groups.push(group);
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{Fix, SidePing};

    fn log(pings: usize, lon_deg: f64) -> Survey {
        let ping = SidePing::with_depth(0.0, f32::NAN);
        let position = LonLat::new(lon_deg, 50.0);
        let fix = Fix::at(0.0, position);
        let mut survey = Survey::of_pings(vec![ping; pings]);
        survey.track.fixes = vec![fix].into();
        survey
    }

    fn of(logs: &[Survey], known: &[bool]) -> Vec<Option<Apart>> {
        apart(&logs.iter().collect::<Vec<_>>(), known)
    }

    #[test]
    fn the_survey_is_where_most_pings_are() {
        let logs = [log(100, 0.0), log(300, 20.0), log(300, 20.5), log(3, 20.0)];
        let why = of(&logs, &[false; 4]);
        let far = |why| matches!(why, Some(Apart::Far { distance_m }) if (1.3e6..1.5e6).contains(&distance_m));
        assert!(far(why[0]), "{:?}", why[0]);
        assert_eq!(why[1..3], [None, None]);
        assert_eq!(why[3], Some(Apart::Short { pings: 3 }));
    }

    #[test]
    fn what_was_open_before_stays() {
        let logs = [log(100, 0.0), log(300, 20.0)];
        let why = of(&logs, &[true, false]);
        assert!(why[0].is_none() && why[1].is_some());
    }

    #[test]
    fn a_long_river_is_one_survey_and_one_log_always_is() {
        let river: Vec<Survey> = (0..20).map(|part| log(50, 0.5 * f64::from(part))).collect();
        assert!(of(&river, &[false; 20]).iter().all(Option::is_none));
        assert_eq!(of(&[log(3, 0.0)], &[false]), [None]);
        assert_eq!(of(&[], &[]), []);
    }
}
