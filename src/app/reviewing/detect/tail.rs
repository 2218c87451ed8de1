//! Searches the pings that a followed log has got since its last search.
//!
//! The boxes that are found are no undo step, because undo reverts what the analyst did. An undo
//! step that restores an older version of the boxes leaves pings unsearched, and these are searched
//! again.

use super::{LABEL, LEAST_SCORE};
use crate::app::error::AppError;
use crate::app::jobs::JobKey;
use crate::app::{App, LogId};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Navigation;
use bathyscope_objects::{Detection, DetectorSettings, find};
use std::ops::Range;
use std::sync::Arc;

/// Number of new pings that start a search: about half of a tile of the picture at a walking pace.
const ENOUGH: usize = 150;
/// Number of earlier pings that are searched again, because an object may have been cut off at the
/// end.
const AGAIN: usize = 300;

/// The search of the end of a log, which begins once objects were requested.
#[derive(Default)]
pub(super) struct TailSearch {
    is_wanted: bool,
}

impl TailSearch {
    /// Enables the search, because objects were requested.
    pub(super) fn wants(&mut self) {
        self.is_wanted = true;
    }
}

impl App {
    /// Stops and disables the search.
    pub(super) fn stop_tail(&mut self) {
        self.jobs.stop(&JobKey::SearchTail);
        self.findings.search.tail = TailSearch::default();
    }

    /// Starts searching the pings that a followed log has got since its last search, if objects
    /// were requested.
    pub(in crate::app) fn search_tail(&mut self, id: LogId) {
        let search = &self.findings.search;
        let is_searched = search.is_busy() || self.jobs.is_running(&JobKey::SearchTail);
        if search.tail.is_wanted && !is_searched {
            self.begin_tail(id);
        }
    }

    fn begin_tail(&mut self, id: LogId) {
        let Some(detector) = self.findings.search.detector.clone() else {
            return;
        };
        let Some(log) = self.logs.get(id) else {
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
        let work = move |progress: &Progress| -> Result<Vec<Detection>, AppError> {
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
            for detection in &mut found {
                detection.mark.pings =
                    detection.mark.pings.start + from..detection.mark.pings.end + from;
            }
            Ok(found)
        };
        let name = JobKey::SearchTail.name();
        self.jobs.run_or(
            JobKey::SearchTail,
            work,
            move |app, found| match found {
                Ok(found) => app.adopt_tail(id, &found, from..to),
                Err(error) => app.fail_tail(&error),
            },
            move |app| app.fail_tail(&AppError::Failed(name)),
        );
    }

    /// Stops the search and reports its error: the same model would fail again.
    fn fail_tail(&mut self, error: &AppError) {
        self.stop_tail();
        self.notices.warn(error.to_string());
    }

    /// Adds the boxes that were found in some pings, even if the log is not followed any more.
    fn adopt_tail(&mut self, log: LogId, found: &[Detection], pings: Range<usize>) {
        // A box at the edge of the picture is no object, and objects that begin before it are
        // listed already.
        let from = pings.start;
        let inside =
            found.iter().filter(|detection| detection.mark.pings.start > from || from == 0);
        let inside: Vec<Detection> = inside.cloned().collect();
        let adopted = self.adopted(log, &inside, pings);
        if let Some((log, review)) = self.logs.get_mut(log).zip(adopted) {
            log.reviewing.set(review);
            self.keep_project(LABEL);
        }
    }
}
