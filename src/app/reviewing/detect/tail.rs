//! Searches the pings that a followed log has got since its last search.
//!
//! The boxes that are found are no undo step, because undo reverts what the analyst did. An undo
//! step that restores an older version of the boxes leaves pings unsearched, and these are searched
//! again.

use super::{LABEL, LEAST_SCORE};
use crate::app::error::AppError;
use crate::app::{App, LogId, Task, TaskOutcome};
use bathyscope_log::survey::Navigation;
use bathyscope_objects::{Detection, DetectorSettings, find};
use std::sync::Arc;

/// Number of new pings that start a search: about half of a tile of the picture at a walking pace.
const ENOUGH: usize = 150;
/// Number of earlier pings that are searched again, because an object may have been cut off at the
/// end.
const AGAIN: usize = 300;

/// The search of the end of a log.
#[derive(Default)]
pub(super) struct TailSearch {
    is_wanted: bool,
    running: Option<Running>,
}

struct Running {
    log: LogId,
    /// First ping of the search, and the first ping after it.
    from: usize,
    to: usize,
    task: Task<Result<Vec<Detection>, AppError>>,
}

impl TailSearch {
    /// Enables the search, because objects were requested.
    pub(super) fn wants(&mut self) {
        self.is_wanted = true;
    }

    /// Stops and disables the search.
    pub(super) fn stop(&mut self) {
        *self = Self::default();
    }
}

impl super::ObjectSearch {
    /// Returns true if the end of a followed log is being searched.
    pub(crate) fn is_busy_with_tail(&self) -> bool {
        self.tail.running.is_some()
    }
}

impl App {
    /// Starts searching the pings that a followed log has got since its last search, if objects
    /// were requested.
    pub(in crate::app) fn search_tail(&mut self, id: LogId) {
        let tail = &self.findings.search.tail;
        if tail.is_wanted && tail.running.is_none() && !self.findings.search.is_busy() {
            self.begin_tail(id);
        }
    }

    fn begin_tail(&mut self, id: LogId) {
        let Some(detector) = self.findings.search.detector.clone() else {
            return;
        };
        let Some(log) = self.open_log(id) else {
            return;
        };
        let (Some(survey), Some(products)) = (&log.survey, &log.products) else {
            return;
        };
        let searched = log.reviewing.review.searched().last();
        let end = searched.map_or(0, |searched| searched.pings.end);
        let to = survey.side_scan.len().min(products.navigation.pings.len());
        if to < end + ENOUGH {
            return;
        }
        let from = end.saturating_sub(AGAIN);
        let (survey, all) = (survey.clone(), products.navigation.clone());
        let task = Task::start(&self.jobs, move |progress| {
            let (stretch, _) = survey.stretch_from(from);
            let navigation = Navigation {
                pings: Arc::new(all.pings[from..to].to_vec()),
                soundings: Arc::default(),
                swath: Arc::default(),
                antenna: Arc::default(),
                zero_heading: 0,
                moving: 0,
                ..(*all).clone()
            };
            let settings = DetectorSettings {
                score: Some(LEAST_SCORE.min(detector.model.score())),
                ..DetectorSettings::default()
            };
            let model = &detector.model;
            let found = find(&stretch, &navigation, model, &settings, progress, |_| ());
            let mut found = found?;
            for one in &mut found {
                one.mark.pings = one.mark.pings.start + from..one.mark.pings.end + from;
            }
            Ok(found)
        });
        self.findings.search.tail.running = Some(Running { log: id, from, to, task });
    }

    /// Collects the boxes that were found, even if the log is not followed any more.
    pub(in crate::app) fn collect_tail(&mut self) {
        let found =
            match self.findings.search.tail.running.as_ref().map(|running| running.task.poll()) {
                Some(TaskOutcome::Done(found)) => found,
                Some(TaskOutcome::Failed) => Err(AppError::Failed("the search for objects")),
                Some(TaskOutcome::Pending) | None => return,
            };
        let Some(running) = self.findings.search.tail.running.take() else {
            return;
        };
        match found {
            Ok(found) => self.adopt_tail(&running, &found),
            Err(error) => {
                // The same model would fail again.
                self.findings.search.tail.stop();
                self.warn(error.to_string());
            }
        }
    }

    fn adopt_tail(&mut self, running: &Running, found: &[Detection]) {
        let &Running { log, from, to, .. } = running;
        // A box at the edge of the picture is no object, and objects that begin before it are
        // listed already.
        let inside = found.iter().filter(|one| one.mark.pings.start > from || from == 0);
        let inside: Vec<Detection> = inside.cloned().collect();
        let adopted = self.adopted(log, &inside, from..to);
        if let Some((log, review)) = self.log_mut(log).zip(adopted) {
            log.reviewing.set(review);
            self.keep_project(LABEL);
        }
    }
}
