//! Changes of every kind, and tests of random sequences of them, which are undone, redone, written
//! and read.

use super::*;
use proptest::prelude::*;

/// Change that can be undone.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Change {
    /// Change of the settings of a log: settings that belong to one log change for it, all others
    /// for all logs.
    Settings {
        /// Log whose settings the analyst views; `None` for the shared settings.
        log: Option<LogKey>,
        /// Settings after the change, as composed.
        after: Box<Settings>,
    },
    /// Change of a setting to the log's own value, or back to the shared one.
    Own {
        /// Log with the setting.
        log: LogKey,
        /// Key of the setting, as in `--set`.
        key: String,
        /// True if the log gets its own value.
        own: bool,
    },
    /// Change of the bottom edits of a log.
    Bottom {
        /// Log of the edits.
        log: LogKey,
        /// All bottom edits of the log after the change.
        after: BottomSettings,
    },
    /// Decision about a box.
    Box {
        /// Log of the box.
        log: LogKey,
        /// Decision about the box.
        edit: Edit,
    },
    /// Boxes of a search, or a review that was opened.
    Review {
        /// Log of the review.
        log: LogKey,
        /// Review of all boxes of the log after the change.
        after: Arc<Review>,
    },
    /// Log that is added.
    Add(Box<ProjectLog>),
    /// Log that is removed; its file stays.
    Remove(LogKey),
    /// Move of a log in the list.
    Move {
        /// Log that is moved.
        log: LogKey,
        /// New place, from 0.
        to: usize,
    },
    /// New name of a log.
    Rename(LogKey, String),
    /// New colour of a log; `None` for one by its place in the list.
    Colour(LogKey, Option<[u8; 3]>),
    /// True if a log is shown.
    Show(LogKey, bool),
    /// Measurement by its number; `None` for a new one.
    Measure(Option<u32>, Measurement),
    /// Number of a measurement that is removed.
    Forget(u32),
    /// Another file of the survey, by its kind; `None` to remove it.
    File(String, Option<PathBuf>),
}

impl Project {
    /// Returns the project after a change; `None` if it changes nothing, or the changed object does
    /// not exist.
    pub(super) fn apply(&self, change: &Change) -> Option<Self> {
        match change {
            Change::Settings { log, after } => self.with_settings(log.as_ref(), after),
            Change::Own { log, key, own } => self.change_log(log, |log| {
                log.settings = log.settings.owning(&self.settings, key, *own)?;
                Some(())
            }),
            Change::Bottom { log, after } => self.change_log(log, |log| {
                log.settings.bottom = after.clone();
                Some(())
            }),
            Change::Box { log, edit } => self.change_log(log, |log| {
                log.review = Arc::new(log.review.apply(edit)?);
                Some(())
            }),
            Change::Review { log, after } => self.change_log(log, |log| {
                let is_of_log = after.identity().is_same_log(&log.file.identity());
                log.review = is_of_log.then(|| after.clone())?;
                Some(())
            }),
            Change::Add(log) => self.with_log(log.as_ref().clone()),
            Change::Remove(log) => self.without_log(log),
            Change::Move { log, to } => self.with_log_at(log, *to),
            Change::Rename(log, name) => self.change_log(log, |log| {
                let name = name.trim();
                log.name = (!name.is_empty()).then(|| name.chars().take(200).collect())?;
                Some(())
            }),
            Change::Colour(log, colour) => self.change_log(log, |log| {
                log.colour = *colour;
                Some(())
            }),
            Change::Show(log, is_visible) => self.change_log(log, |log| {
                log.is_visible = *is_visible;
                Some(())
            }),
            Change::Measure(number, measurement) => self.with_measurement(*number, measurement),
            Change::Forget(number) => {
                let mut after = self.clone();
                after.measurements.remove(number).map(|_| after)
            }
            Change::File(what, path) => self.with_file(what, path.as_deref()),
        }
    }

    fn change_log(
        &self,
        key: &LogKey,
        change: impl FnOnce(&mut ProjectLog) -> Option<()>,
    ) -> Option<Self> {
        let mut log = self.log(key)?.as_ref().clone();
        change(&mut log)?;
        self.with_changed(log)
    }

    fn with_settings(&self, key: Option<&LogKey>, after: &Settings) -> Option<Self> {
        let mut changed = self.clone();
        match key {
            None => {
                changed.settings = after.clone();
                changed.settings.bottom = BottomSettings::default();
            }
            Some(key) => {
                let mut log = self.log(key)?.as_ref().clone();
                let (shared, own) = log.settings.change(&self.settings, after).ok()?;
                changed.settings = shared;
                log.settings = own;
                changed = changed.with_changed(log).unwrap_or(changed);
            }
        }
        (changed != *self).then_some(changed)
    }

    fn with_measurement(&self, number: Option<u32>, measurement: &Measurement) -> Option<Self> {
        let last = self.measurements.keys().next_back();
        let next = || last.map_or(Some(1), |last| last.checked_add(1));
        let number = number.map_or_else(next, Some)?;
        let mut after = self.clone();
        let replaced = after.measurements.insert(number, measurement.clone());
        (replaced.as_ref() != Some(measurement)).then_some(after)
    }

    fn with_file(&self, what: &str, path: Option<&Path>) -> Option<Self> {
        let mut after = self.clone();
        match path {
            Some(path) => after.files.insert(what.to_owned(), path.to_owned()),
            None => after.files.remove(what),
        };
        (after.files != self.files).then_some(after)
    }
}

/// Makes any change from random numbers; changes that do not fit the project change nothing.
fn any_change() -> impl Strategy<Value = (u8, usize, usize)> {
    (0_u8..14, 0_usize..500, 0_usize..500)
}

fn change_from((kind, a, b): (u8, usize, usize), project: &Project) -> Option<Change> {
    let logs = project.logs();
    let key = || Some(logs.get(a % logs.len().max(1))?.key.clone());
    Some(match kind {
        0 => Change::Add(Box::new(log(&format!("log {}", a % 6)))),
        1 if b % 4 == 0 => Change::Remove(key()?),
        2 => Change::Move { log: key()?, to: b % 6 },
        3 => Change::Rename(key()?, format!("name {b}")),
        4 => Change::Colour(key()?, (b % 3 > 0).then_some([b as u8, 1, 2])),
        5 => Change::Show(key()?, b % 2 == 0),
        6 => setting_change(project, key()?, b)?,
        7 => Change::Own {
            log: key()?,
            key: ["draft_m", "outliers.min_neighbors", "track.offset_s"][b % 3].to_owned(),
            own: a % 2 == 0,
        },
        8 | 9 => bottom_change(project.log(&key()?)?, kind == 8, a, b),
        10 => {
            let log = project.log(&key()?)?.clone();
            Change::Review { after: with_boxes(&log, b % 20), log: log.key.clone() }
        }
        11 | 12 => Change::Box { log: key()?, edit: box_edit(a, b) },
        _ => change_of_survey(a, b),
    })
}

/// Returns a change of one of three settings.
fn setting_change(project: &Project, log: LogKey, b: usize) -> Option<Change> {
    let settings = project.settings_of(project.log(&log)?).ok()?;
    let text = ["draft_m=", "outliers.min_neighbors=", "water_level_m="][b % 3];
    let after = settings.with_assignment(&format!("{text}{}", 1 + b % 7)).ok()?;
    Some(Change::Settings { log: Some(log), after: Box::new(after) })
}

/// Returns a change that draws, accepts or removes a stretch of the bottom line.
fn bottom_change(log: &ProjectLog, is_drawn: bool, a: usize, b: usize) -> Change {
    let side = Side::BOTH[b % 2];
    let of_log =
        if log.settings.bottom.is_empty() { bottom(&[]) } else { log.settings.bottom.clone() };
    let pings = [a.min(b), a.max(b)];
    let after = match is_drawn {
        true if a.is_multiple_of(3) => of_log.accepting(side, pings),
        true => of_log.with(line(side, pings)),
        false => of_log.without(side, pings),
    };
    Change::Bottom { log: log.key.clone(), after }
}

/// Returns an edit of a box that may exist, or a new box.
fn box_edit(a: usize, b: usize) -> Edit {
    let id = BoxId(1 + (b % 20) as u32);
    match a % 13 {
        0 => Edit::Accept(id),
        1 => Edit::Reject(id),
        2 => Edit::Undecide(id),
        4 => Edit::Reshape(id, mark(b % 480)),
        5 => Edit::SwapSide(id),
        6 => Edit::Add { mark: mark(b % 480), class: 0 },
        7 => Edit::SetEdges { id, mark: mark(b % 480), border_m: b as f64 / 100.0 },
        8 => Edit::FindEdges(id),
        9 => Edit::AddPoint {
            side: Side::BOTH[b % 2],
            ping: b % 480,
            range_m: 1.0 + b as f64 / 50.0,
            class: 0,
        },
        3 | 10 => Edit::Classify(id, format!("class {}", b % 4)),
        11 if b.is_multiple_of(2) => Edit::Rename(id, format!("name {b}")),
        11 => Edit::Rate(id, (!b.is_multiple_of(3)).then_some(Certainty::ALL[b % 3])),
        _ if b.is_multiple_of(2) => Edit::Remove(id),
        _ => Edit::Note(id, format!("note\n{b} \"x\" \u{2028}")),
    }
}

/// Returns a change of data that belong to no log: measurements and files.
fn change_of_survey(a: usize, b: usize) -> Change {
    let at = |step: f64| LonLat { lon_deg: a as f64 / 10.0 + step, lat_deg: b as f64 / 10.0 };
    let empty = Measurement::new([MeasurementKind::Area, MeasurementKind::Profile][a % 2]);
    let corners = [0.0, 0.5, 0.25].into_iter().map(at);
    let measurement = corners.fold(empty, |line, corner| line.with(corner, None));
    match b % 4 {
        0 => Change::Forget(1 + (a % 4) as u32),
        1 => Change::File(
            "base_map".to_owned(),
            a.is_multiple_of(2).then(|| format!("/m/{a}.tif").into()),
        ),
        2 => Change::Measure(Some(1 + (a % 4) as u32), measurement),
        _ => Change::Measure(None, measurement),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Tests that every change can be undone to the state before, and redone to the state after,
    /// step by step.
    #[test]
    fn all_that_is_done_is_undone_and_done_again(requested in prop::collection::vec(any_change(), 1..60)) {
        let mut history = History::default();
        let mut states = vec![Project::default()];
        let mut labels = Vec::new();
        for request in requested {
            let now = &states[states.len() - 1];
            let Some(change) = change_from(request, now) else { continue };
            let Some(after) = now.apply(&change) else { continue };
            let label = format!("change {}", labels.len());
            labels.push(label.clone());
            history.record(now, &after, label, false);
            states.push(after);
        }
        let steps: Vec<String> = history.steps().map(|step| step.label.to_owned()).collect();
        prop_assert_eq!(&steps, &labels);
        let mut now = states[states.len() - 1].clone();
        for expected in states.iter().rev().skip(1) {
            now = history.undo(&now).expect("a step");
            prop_assert_eq!(&now, expected);
            prop_assert_eq!(now.to_text(folder()), expected.to_text(folder()));
        }
        prop_assert!(history.undo(&now).is_none());
        for expected in &states[1..] {
            now = history.redo(&now).expect("a step");
            prop_assert_eq!(&now, expected);
        }
        prop_assert!(history.redo(&now).is_none());
    }

    /// Tests that the journal entry of a change turns the lines before it into the lines after it,
    /// from any state to any other.
    #[test]
    fn the_lines_of_a_change_are_all_of_it(requested in prop::collection::vec(any_change(), 1..40), from in any::<prop::sample::Index>()) {
        let mut states = vec![full()];
        for request in requested {
            let now = &states[states.len() - 1];
            let after = change_from(request, now).and_then(|change| now.apply(&change));
            states.extend(after);
        }
        let (before, after) = (from.get(&states), &states[states.len() - 1]);
        let mut lines = rows::of(before, folder());
        let (set, gone) = rows::changes(before, after, folder());
        journal::Entry::done("change", &set, &gone).replay(&mut lines);
        prop_assert_eq!(text::write(&lines), after.to_text(folder()));
        let read_back = rows::read(lines, folder()).expect("a project");
        prop_assert_eq!(read_back.to_text(folder()), after.to_text(folder()));
    }

    /// Tests that any damaged text is either read or refused.
    #[test]
    fn spoilt_text_is_read_or_refused(at in any::<prop::sample::Index>(), length in 0_usize..40, with in ".{0,12}") {
        let text = full().to_text(folder());
        let letters: Vec<char> = text.chars().collect();
        let from = at.index(letters.len());
        let to = (from + length).min(letters.len());
        let spoilt: String = letters[..from].iter().copied().chain(with.chars()).chain(letters[to..].iter().copied()).collect();
        if let Ok(project) = read(&spoilt) {
            let written = project.to_text(folder());
            prop_assert_eq!(read(&written).expect("what was written").to_text(folder()), written);
        }
    }
}
