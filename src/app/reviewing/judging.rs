//! Compares the boxes with the truth, if it is known: the truth is read in a background thread,
//! compared after each change of boxes, and counted after each move of the confidence slider.

use super::{Reviewing, middle};
use crate::app::error::AppError;
use crate::app::jobs::JobKey;
use crate::app::{App, LogId, OpenLog};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Identity;
use bathyscope_objects::truth::{
    self, Mistake, RasterTruth, Standing, SurveyTruth, TruthComparison,
};
use std::path::PathBuf;
use std::sync::Arc;

/// Table of the objects in the bundled demo survey, as `bathyscope simulate` writes it for its
/// scene.
const DEMO_TRUTH: &str = include_str!("../../../assets/demo.objects.csv");

/// Order of the list of mistakes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MistakeSort {
    /// Score: the false alarms with the highest scores first, then the largest missed objects.
    #[default]
    Score,
    /// Size, the largest first.
    Size,
    /// Position along the track.
    Position,
}

bathyscope_log::named! {
    /// All sorts in the order of the menu.
    pub MistakeSort {
        Score: "score",
        Size: "size",
        Position: "position",
    }
}

/// Source of the truth.
#[derive(Clone, Debug, PartialEq)]
enum TruthSource {
    File(PathBuf),
    Demo,
}

/// The truth, and its comparison with the boxes.
#[derive(Default)]
pub struct Judging {
    truth: Option<(TruthSource, Arc<SurveyTruth>)>,
    /// Path of a truth that was requested while the log was still being opened.
    pub(in crate::app) requested: Option<PathBuf>,
    comparison: Option<TruthComparison>,
    /// True if boxes, raster or truth have changed since the last comparison began.
    pub(super) outdated: bool,
    standing: Option<Standing>,
    /// Order of the list of mistakes.
    pub(crate) sort: MistakeSort,
    /// Index of the missed object that is shown, in the truth's objects; `None` if none is.
    pub missed: Option<usize>,
}

impl Judging {
    /// Returns the name of the source of the truth; `None` while none is known.
    pub fn source(&self) -> Option<String> {
        let (source, _) = self.truth.as_ref()?;
        Some(match source {
            TruthSource::File(path) => {
                path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
            }
            TruthSource::Demo => "the demo's scene".to_owned(),
        })
    }

    /// Returns the boxes paired with the truth; the boxes may be those before the last change.
    /// `None` before the first comparison.
    pub fn comparison(&self) -> Option<&TruthComparison> {
        self.comparison.as_ref()
    }

    /// Returns the counts and mistakes of the boxes at the confidence slider; `None` before the
    /// first comparison.
    pub fn standing(&self) -> Option<&Standing> {
        self.standing.as_ref()
    }

    /// Returns the false alarms and missed objects, in the chosen order.
    pub fn mistakes(&self) -> &[Mistake] {
        self.standing().map_or(&[], |standing| &standing.mistakes)
    }

    /// Deselects the missed object.
    pub(in crate::app) fn look_away(&mut self) {
        self.missed = None;
    }

    fn forget(&mut self) {
        self.truth = None;
        self.comparison = None;
        self.standing = None;
        self.missed = None;
    }
}

impl Reviewing {
    /// Counts the mistakes again at the confidence slider, and sorts them.
    pub(super) fn count_mistakes(&mut self) {
        let Some(comparison) = &self.judging.comparison else {
            return;
        };
        let mut standing = comparison.at(self.queue.threshold);
        let place = |mistake: &Mistake| match mistake {
            Mistake::FalseAlarm { id, .. } => {
                self.review.get(*id).map(|review_box| review_box.mark.pings.start)
            }
            Mistake::Miss { object, .. } => {
                let objects = &comparison.truth().objects;
                objects.get(*object).map(|missed| missed.whole.pings.start)
            }
        };
        match self.judging.sort {
            // The comparison returns the mistakes in this order.
            MistakeSort::Score => {}
            MistakeSort::Size => {
                (standing.mistakes).sort_by(|a, b| b.size_m().total_cmp(&a.size_m()));
            }
            MistakeSort::Position => standing.mistakes.sort_by_key(place),
        }
        let is_missed = |index: usize| {
            let same =
                |miss: &Mistake| matches!(miss, Mistake::Miss { object, .. } if *object == index);
            standing.mistakes.iter().any(same)
        };
        self.judging.missed = self.judging.missed.filter(|&object| is_missed(object));
        self.judging.standing = Some(standing);
    }

    /// Sorts the list of mistakes.
    pub(in crate::app) fn sort_mistakes(&mut self, sort: MistakeSort) {
        self.judging.sort = sort;
        self.count_mistakes();
    }

    /// Returns the index of the shown mistake in the list; `None` if none is shown.
    pub fn mistake_at(&self) -> Option<usize> {
        let is_here = |mistake: &Mistake| match mistake {
            Mistake::FalseAlarm { id, .. } => self.selected == Some(*id),
            Mistake::Miss { object, .. } => self.judging.missed == Some(*object),
        };
        self.judging.mistakes().iter().position(is_here)
    }
}

impl OpenLog {
    /// Returns the source of the log's truth, and true if the analyst did not request it; `None` if
    /// there is no truth.
    fn known_truth(&mut self, is_file: bool) -> Option<(TruthSource, bool)> {
        if let Some(path) = self.reviewing.judging.requested.take() {
            return Some((TruthSource::File(path), false));
        }
        if !is_file {
            return Some((TruthSource::Demo, true));
        }
        let log = self.survey.as_ref()?.source.files.first()?;
        let sidecar = log.with_extension(truth::SIDECAR);
        sidecar.is_file().then_some((TruthSource::File(sidecar), true))
    }
}

impl App {
    /// Starts reading the truth of the shown log from a file; if a log is being opened, the file is
    /// read for that log once it is open.
    pub(in crate::app) fn open_truth(&mut self, path: PathBuf) {
        let id = self.logs.shown.id;
        if self.jobs.is_running(&JobKey::OpenLog) {
            self.logs.shown.reviewing.judging.requested = Some(path);
        } else if self.logs.shown.survey.is_some() {
            self.read_truth(id, TruthSource::File(path), false);
        } else {
            self.notices.warn("open the log first, then its known objects");
        }
    }

    /// Starts reading the truth that was requested while a log was being opened, or else its
    /// sidecar file.
    pub(in crate::app) fn look_for_truth(&mut self, id: LogId, is_file: bool) {
        let known = self.logs.get_mut(id).and_then(|log| log.known_truth(is_file));
        if let Some((source, is_found)) = known {
            self.read_truth(id, source, is_found);
        }
    }

    /// Starts reading the truth of a log; `is_found` if the analyst did not open its file.
    fn read_truth(&mut self, id: LogId, source: TruthSource, is_found: bool) {
        let Some(survey) = self.logs.survey_of(id) else {
            return;
        };
        let (identity, from) = (Identity::of(survey), source.clone());
        let read = move |_: &Progress| -> Result<SurveyTruth, AppError> {
            match &from {
                TruthSource::Demo => Ok(SurveyTruth::parse(DEMO_TRUTH, &identity)?),
                TruthSource::File(path) => Ok(SurveyTruth::read(path, &identity)?),
            }
        };
        self.jobs.run(JobKey::ReadTruth(id), read, move |app, read| {
            let truth = match read {
                Ok(truth) => truth,
                Err(error) => return app.notices.warn(error),
            };
            let objects = truth.objects.len();
            app.jobs.stop(&JobKey::CompareTruth(id));
            let Some(log) = app.logs.get_mut(id) else {
                return;
            };
            let judging = &mut log.reviewing.judging;
            judging.forget();
            judging.truth = Some((source.clone(), Arc::new(truth)));
            judging.outdated = true;
            // The name of a sidecar file is shown where its objects are used.
            if let TruthSource::File(path) = source
                && !is_found
            {
                let path = path.display();
                app.notices.notify(format!("Opened {objects} known objects: {path}"));
            }
        });
    }

    /// Removes the truth of the shown log.
    pub(in crate::app) fn forget_truth(&mut self) {
        self.jobs.stop(&JobKey::CompareTruth(self.logs.shown.id));
        self.logs.shown.reviewing.judging.forget();
    }

    /// Starts comparing the boxes of a log with its truth if they have changed.
    pub(in crate::app) fn compare_with_truth(&mut self, id: LogId) {
        if self.jobs.is_running(&JobKey::CompareTruth(id)) {
            return;
        }
        let Some(log) = self.logs.get_mut(id).filter(|log| log.reviewing.judging.outdated) else {
            return;
        };
        let (review, raster) = (log.reviewing.review.clone(), log.reviewing.raster().cloned());
        let judging = &mut log.reviewing.judging;
        let Some(((_, truth), raster)) = judging.truth.as_ref().zip(raster) else {
            return;
        };
        let truth = truth.clone();
        judging.outdated = false;
        self.jobs.run(
            JobKey::CompareTruth(id),
            move |_| TruthComparison::new(&review, RasterTruth::new(&raster, truth), &raster),
            move |app, comparison| {
                if let Some(log) = app.logs.get_mut(id) {
                    log.reviewing.judging.comparison = Some(comparison);
                    log.reviewing.count_mistakes();
                }
            },
        );
    }

    /// Shows a mistake in all views: selects the box of a false alarm, or marks a missed object.
    pub(in crate::app) fn show_mistake(&mut self, mistake: &Mistake) {
        match *mistake {
            Mistake::FalseAlarm { id, .. } => self.select_box(Some(id)),
            Mistake::Miss { object, .. } => {
                self.select_box(None);
                let known = (self.logs.shown.reviewing.judging.comparison())
                    .and_then(|comparison| comparison.truth().objects.get(object));
                if let Some((survey, known)) = self.logs.shown.survey.as_ref().zip(known) {
                    let mark = middle(survey, &known.whole);
                    self.logs.shown.reviewing.judging.missed = Some(object);
                    self.view.reveal(mark);
                }
            }
        }
    }

    /// Shows the mistake `by` places after the shown one in the list, around its ends.
    pub(in crate::app) fn step_mistake(&mut self, by: isize) {
        let judging = &self.logs.shown.reviewing.judging;
        let mistakes = judging.mistakes();
        let count = mistakes.len() as isize;
        if count == 0 || !self.logs.shown.reviewing.has_boxes() {
            let text = match judging.standing() {
                Some(_) if count == 0 => "there are no mistakes from this score on",
                Some(_) => {
                    "there are no boxes yet to compare with known objects; find objects first"
                }
                None => "mistakes need known objects: open them in the Review menu",
            };
            return self.notices.notify(text);
        }
        let next = match self.logs.shown.reviewing.mistake_at() {
            Some(here) => (here as isize + by).rem_euclid(count),
            None if by < 0 => count - 1,
            None => 0,
        };
        let next = mistakes[next as usize];
        self.show_mistake(&next);
    }
}
