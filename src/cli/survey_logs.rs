//! Opens the logs of one survey, named on the command line one by one, as folders, or by a project,
//! in one local coordinate frame.

use super::settings::{LogOpener, SettingsArgs};
use super::{Failure, output};
use crate::app::is_project;
use bathyscope_log::formats;
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{MountingSettings, Survey};
use bathyscope_objects::objects::{KeptReview, SurveyReview};
use bathyscope_objects::review::{Review, ReviewError};
use bathyscope_products::outputs::finish_killed_run;
use bathyscope_products::pipeline::settings::SourceSettings;
use bathyscope_products::pipeline::{MissionLog, Reference, Settings};
use bathyscope_products::project;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Log to open, with the settings for it.
pub(super) struct LogInput {
    /// File or folder of the log.
    pub path: PathBuf,
    /// Settings and track with which the log is opened and processed.
    pub logs: Arc<LogOpener>,
    /// Review of the log's boxes in its project; `None` without one.
    pub review: Option<KeptReview>,
    /// Local coordinate frame of its project; `None` without one.
    pub frame: Option<LocalFrame>,
    /// True if a project names the log.
    pub is_of_project: bool,
}

/// Log that was opened.
pub(super) struct OpenedLog {
    /// Recording of the log.
    pub survey: Arc<Survey>,
    /// Settings with which the log is processed.
    pub settings: Settings,
    /// Review of the log's boxes; `None` if there is none.
    pub review: Option<KeptReview>,
}

/// Collects the reviews of all logs.
pub(super) fn survey_review(opened: &[OpenedLog]) -> SurveyReview {
    let mut all = SurveyReview::default();
    for log in opened {
        all.add(log.review.clone());
    }
    all
}

/// Returns the paths, with each folder of several logs replaced by the paths of its logs. A
/// recording of several files is a folder, too, and is not replaced.
pub(super) fn logs_of(paths: &[PathBuf]) -> Vec<PathBuf> {
    let each = paths.iter().flat_map(|path| {
        let logs = formats::logs_in(path);
        match logs.len() {
            0 | 1 => vec![path.clone()],
            _ => logs,
        }
    });
    each.collect()
}

/// Returns the logs that some paths name, all with the same settings, or the visible logs of a
/// project with their settings there; `track` is the file of another receiver's track.
///
/// # Errors
/// When settings cannot be used, a project is named together with logs or settings, or a project or
/// track cannot be read.
pub(super) fn inputs(
    paths: &[PathBuf],
    settings: &SettingsArgs,
    track: Option<PathBuf>,
) -> Result<Vec<LogInput>, Failure> {
    if let Some(path) = paths.iter().find(|path| is_project(path)) {
        if paths.len() > 1 {
            return Err(format!(
                "a project is processed by itself; name it alone: {}",
                path.display()
            )
            .into());
        }
        if settings.are_given() || track.is_some() {
            return Err(format!(
                "a project brings its settings; change them in it, or name its logs: {}",
                path.display()
            )
            .into());
        }
        return of_project(path);
    }
    let mut settings = settings.resolve()?;
    if track.is_some() {
        settings.track.file = track;
    }
    let logs = Arc::new(LogOpener::new(settings)?);
    for path in paths.iter().flat_map(|path| formats::unusable_in(path)) {
        output::notify(format_args!(
            "warning: passed over, for it is no log that can be read: {}",
            path.display()
        ));
    }
    let paths = logs_of(paths).into_iter();
    Ok(paths.map(|path| LogInput::of_log(path, logs.clone())).collect())
}

fn of_project(path: &Path) -> Result<Vec<LogInput>, Failure> {
    let inputs = project::inputs(path, &Progress::new())?;
    let input = |input: project::ProjectInput| {
        if let Some(warning) = &input.warning {
            output::notify(format_args!("warning: {warning}"));
        }
        let has_boxes = input.log.review.boxes().len() > 0;
        Ok(LogInput {
            path: input.log.file.path.clone(),
            logs: Arc::new(LogOpener::new(input.settings)?),
            review: has_boxes.then(|| KeptReview {
                review: input.log.review.clone(),
                object_numbers: input.log.object_numbers.clone(),
                threshold: input.least_confidence,
            }),
            frame: input.frame,
            is_of_project: true,
        })
    };
    inputs.into_iter().map(input).collect()
}

impl LogInput {
    fn of_log(path: PathBuf, logs: Arc<LogOpener>) -> Self {
        Self { path, logs, review: None, frame: None, is_of_project: false }
    }

    /// Opens the log, in the local coordinate frame of its project if it is near.
    ///
    /// # Errors
    /// When the log cannot be opened, or lacks what its settings require.
    pub(super) fn open(&self) -> Result<OpenedLog, Failure> {
        let survey = self.logs.open(&self.path, &Progress::new())?;
        if !self.is_of_project {
            warn_of_decisions(&survey);
        }
        let survey = match &self.frame {
            Some(frame) => survey.in_frame_if_near(frame),
            None => survey,
        };
        Ok(OpenedLog {
            survey: Arc::new(survey),
            settings: self.logs.settings.clone(),
            review: self.review.clone(),
        })
    }
}

/// Warns if the window has decisions about a log, which is opened without them: a run uses only the
/// settings and reviews that it is given.
fn warn_of_decisions(survey: &Survey) {
    let Some(folder) = untitled_folder() else {
        return;
    };
    if let Ok(Some(found)) = project::find_untitled(&folder, survey, &[], &Progress::new()) {
        output::notify(format_args!(
            "warning: the decisions made about {} in the window are not used; they are in a project, which can be named in place of the log: {}",
            survey.name(),
            found.named().unwrap_or(&found.path).display()
        ));
    }
}

/// Returns the folder where the window keeps untitled projects; `None` on a system without one.
#[cfg(feature = "gui")]
fn untitled_folder() -> Option<PathBuf> {
    crate::ui::untitled_folder()
}

/// Returns no folder: a program without the window keeps no projects.
#[cfg(not(feature = "gui"))]
fn untitled_folder() -> Option<PathBuf> {
    None
}

/// Opens logs in the local coordinate frame of the first that has a position, and counts those that
/// cannot be used: they are named on stderr and do not prevent the others from being opened. A log
/// with the same bytes as an earlier one is left out.
fn open_all(inputs: &[LogInput]) -> (Vec<OpenedLog>, usize) {
    let mut opened: Vec<OpenedLog> = Vec::new();
    let mut failed = 0;
    for input in inputs {
        match input.open() {
            Ok(log) => add(&mut opened, log, &input.path),
            Err(Failure { sentence }) => {
                failed += 1;
                output::notify(format_args!("bathyscope: {sentence}"));
            }
        }
    }
    (opened, failed)
}

/// Opens logs as [`open_all`] does; a single log that cannot be used is returned as the error.
pub(super) fn open(inputs: &[LogInput]) -> Result<(Vec<OpenedLog>, usize), Failure> {
    match inputs {
        [input] => Ok((vec![input.open()?], 0)),
        inputs => Ok(open_all(inputs)),
    }
}

/// Returns an error if some of the logs could not be used.
///
/// # Errors
/// When `failed` is above 0; the error has both numbers.
pub(super) fn all_or(failed: usize, all: usize) -> Result<(), Failure> {
    if failed == 0 {
        return Ok(());
    }
    Err(format!("{failed} of {all} logs could not be processed, for the reasons above").into())
}

fn add(opened: &mut Vec<OpenedLog>, log: OpenedLog, path: &Path) {
    if let Some(same) = opened.iter().find(|known| is_same(&known.survey, &log.survey)) {
        return output::notify(format_args!(
            "warning: the log holds the same bytes as {} and is taken once: {}",
            same.survey.name(),
            path.display()
        ));
    }
    let placed = opened.iter().find(|log| log.survey.has_place());
    let frame = placed.map(|log| log.survey.track.frame.clone());
    let survey = match frame {
        Some(frame) => Arc::new(Arc::unwrap_or_clone(log.survey).in_frame(&frame)),
        None => log.survey,
    };
    opened.push(OpenedLog { survey, ..log });
}

/// Returns true if two logs are the same recording: equal byte for byte, under any name.
fn is_same(one: &Survey, other: &Survey) -> bool {
    let own = |survey: &Survey| {
        let track = usize::from(survey.track.external.is_some());
        survey.bytes.len().saturating_sub(track)
    };
    let (count, others) = (own(one), own(other));
    count == others
        && one.source.byte_count == other.source.byte_count
        && one.bytes.iter().zip(&other.bytes).take(count).all(|(one, other)| one[..] == other[..])
}

/// Sets each review that is named by its file as the review of the log that it belongs to, in place
/// of the log's earlier review.
///
/// # Errors
/// When a file cannot be read or belongs to none of the logs.
pub(super) fn take_reviews(logs: &mut [OpenedLog], files: &[PathBuf]) -> Result<(), ReviewError> {
    for path in files {
        let mut refused = None;
        let is_taken = logs.iter_mut().any(|log| match Review::open_for(path, &log.survey) {
            Ok(review) => {
                log.review = Some(review.into());
                true
            }
            Err(error) => {
                refused = Some(error);
                false
            }
        });
        // With several logs, the error for the last one is returned: the others differ only in the
        // name of the log.
        if let Some(error) = refused.filter(|_| !is_taken) {
            return Err(error);
        }
    }
    Ok(())
}

/// Opens the reference that logs are compared with: points, another log, or the logs of a folder or
/// a project.
///
/// # Errors
/// When the reference cannot be opened, or its points in metres are nowhere near the first log.
pub(super) fn open_reference(
    argument: &OsStr,
    first: &OpenedLog,
    progress: &Progress,
) -> Result<Reference, Failure> {
    let path = Path::new(argument);
    let inputs = if is_project(path) {
        of_project(path)?
    } else {
        let paths = logs_of(&[path.to_owned()]);
        if paths.len() <= 1 {
            finish_killed_run(path)?;
            let opened = Reference::open(argument, &first.survey, &first.settings, progress);
            return Ok(opened?);
        }
        // The mounting and source settings of the first log are applied when the mission is
        // processed.
        let as_read = Settings {
            mounting: MountingSettings::default(),
            source: SourceSettings::default(),
            ..first.settings.clone()
        };
        let logs = Arc::new(LogOpener::new(as_read)?);
        paths.into_iter().map(|path| LogInput::of_log(path, logs.clone())).collect()
    };
    let (opened, failed) = open_all(&inputs);
    all_or(failed, inputs.len())?;
    let log = |log: OpenedLog| MissionLog {
        survey: log.survey,
        settings: Some(log.settings).filter(|_| is_project(path)),
    };
    let logs = opened.into_iter().map(log).collect();
    Ok(Reference::of_logs(path, logs))
}
