//! Identifies the recording to which a sidecar file belongs, gives the logs of one survey distinct
//! names, and finds logs that do not belong to the survey of the others because they are too far
//! away, or too short to show anything.

use super::Survey;
use crate::support::geo::{LonLat, distance_m};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Distance beyond which logs belong to different waters, metres.
const FAR_M: f64 = 50_000.0;
/// Fewest pings, soundings or pings of a swath of a log; in a shorter one the recorder was only
/// switched on and off again.
const FEWEST: usize = 20;

/// Identity of a log in its sidecar files (decisions about boxes, bottom edits). It depends on the
/// log's own bytes only, not on settings that are applied to the log. A log that was renamed or
/// moved is still the same log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// File name of the log, without its folder.
    pub file: String,
    /// Number of bytes of all files of the log.
    pub byte_count: u64,
    /// Number of side-scan pings.
    pub pings: usize,
    /// True if port and starboard were exchanged against the recording: the sides in the sidecar
    /// file are then the exchanged ones.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub swapped_sides: bool,
}

impl Identity {
    /// Returns the identity of an open survey.
    pub fn of(survey: &Survey) -> Self {
        let file = survey.source.files.first();
        Self {
            file: file.and_then(|file| file_name(file)).unwrap_or_default(),
            byte_count: survey.source.byte_count,
            pings: survey.side_scan.len(),
            swapped_sides: survey.swapped_sides,
        }
    }

    /// Returns true if both identities are of the same recording, by the numbers of bytes and
    /// pings.
    pub fn is_same_log(&self, other: &Self) -> bool {
        self.byte_count == other.byte_count && self.pings == other.pings
    }
}

/// Reason why a log does not belong to the survey of the other logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Apart {
    /// The log is far from the others.
    Far {
        /// Distance to the nearest of the other logs, metres.
        distance_m: f64,
    },
    /// The log is too short.
    Short {
        /// Number of its side-scan pings.
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

/// Returns a name for each log: the stem of its file. Where other logs have the same name, it
/// becomes the file name, then the file name with the folder, then that with a number. Names often
/// collide, as recorders begin each card with `Rec00001`.
pub fn distinct_names<'a>(logs: impl Iterator<Item = &'a Survey>) -> Vec<String> {
    let logs: Vec<&Survey> = logs.collect();
    let mut names: Vec<String> = logs.iter().map(|log| log.name()).collect();
    for longer in [file_name, with_folder] {
        let shared = shared(&names);
        for ((name, log), shared) in names.iter_mut().zip(&logs).zip(shared) {
            if let Some(longer) = log.source.files.first().and_then(|file| longer(file))
                && shared
            {
                *name = longer;
            }
        }
    }
    // Backward, so that the names before are as they were.
    for log in (1..names.len()).rev() {
        let before = names[..log].iter().filter(|name| **name == names[log]).count();
        if before > 0 {
            names[log] = format!("{} ({})", names[log], before + 1);
        }
    }
    names
}

/// Returns for each name true if it occurs more than once.
fn shared(names: &[String]) -> Vec<bool> {
    let count = |name: &String| names.iter().filter(|other| *other == name).count();
    names.iter().map(|name| count(name) > 1).collect()
}

/// Returns the name of a file: `Rec00001.DAT`.
fn file_name(file: &Path) -> Option<String> {
    Some(file.file_name()?.to_string_lossy().into_owned())
}

/// Returns the name of a file with its folder: `Rec00001.DAT (card 2)`.
fn with_folder(file: &Path) -> Option<String> {
    let folder = file.parent()?.file_name()?;
    Some(format!("{} ({})", file_name(file)?, folder.to_string_lossy()))
}

/// Returns for each log the reason why it does not belong to the survey; `None` where it does. The
/// survey is the group of neighbouring logs with a log that is `known` to belong to it, otherwise
/// the group with most pings. A single log is a survey, and so are logs that are all too short.
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

/// Returns the position of the fix in the middle of a log; `None` without fixes.
fn place(log: &Survey) -> Option<LonLat> {
    let fixes = &log.track.fixes;
    fixes.get(fixes.len() / 2).map(|fix| fix.position)
}

/// Groups logs, so that each log of a group is near another log of the group.
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

    fn names(files: &[&str]) -> Vec<String> {
        let log = |file: &&str| {
            let mut log = Survey::default();
            log.source.files = vec![file.into()];
            log
        };
        let logs: Vec<Survey> = files.iter().map(log).collect();
        distinct_names(logs.iter())
    }

    #[test]
    fn a_name_is_as_long_as_it_must_be() {
        assert_eq!(names(&["a/pond.sl2", "a/lake.sl2"]), ["pond", "lake"]);
        assert_eq!(
            names(&["a/pond.sl2", "a/pond.sl3", "a/lake.sl2"]),
            ["pond.sl2", "pond.sl3", "lake"]
        );
        assert_eq!(
            names(&["a/pond.sl2", "b/pond.sl2", "b/pond.sl3"]),
            ["pond.sl2 (a)", "pond.sl2 (b)", "pond.sl3"]
        );
        assert_eq!(names(&["1/a/pond.sl2", "2/a/pond.sl2"]), ["pond.sl2 (a)", "pond.sl2 (a) (2)"]);
    }

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
