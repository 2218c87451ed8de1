//! The logs of one survey on the command line: named one by one, as folders, or by a project, and
//! opened in one frame.

use super::settings::{LogOpener, SettingsArgs};
use super::{Failure, output};
use crate::app::is_project;
use bathyscope_log::formats;
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{MountingSettings, Survey};
use bathyscope_objects::objects::{KeptReview, SurveyReview};
use bathyscope_objects::review::{Review, ReviewError};
use bathyscope_products::pipeline::settings::SourceSettings;
use bathyscope_products::pipeline::{MissionLog, Reference, Settings};
use bathyscope_products::project;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A log to open, with the settings for it.
pub(super) struct LogInput {
    /// Its file or folder.
    pub path: PathBuf,
    /// Settings and track with which it is opened and processed.
    pub logs: Arc<LogOpener>,
    /// Review of its boxes in its project.
    pub review: Option<KeptReview>,
    /// The frame that its project has it in.
    pub frame: Option<LocalFrame>,
}

/// A log that was opened.
pub(super) struct OpenedLog {
    /// The recording.
    pub survey: Arc<Survey>,
    /// The settings that it is processed with.
    pub settings: Settings,
    /// Review of its boxes.
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

/// The paths, with each folder of several logs replaced by these. A recording of several files is a
/// folder, too, and stays.
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

/// The logs that some paths name, all with the same settings, or the visible logs of a project with
/// the settings that they have there; `track` is the file of another receiver's track.
///
/// # Errors
/// When settings cannot be used, a project stands beside logs or has settings from elsewhere, or
/// one cannot be read.
pub(super) fn inputs(
    paths: &[PathBuf],
    settings: &SettingsArgs,
    track: Option<PathBuf>,
) -> Result<Vec<LogInput>, Failure> {
    match paths {
        [path] if is_project(path) => {
            if settings.are_given() || track.is_some() {
                return Err(format!(
                    "a project brings its settings; change them in it, or name its logs: {}",
                    path.display()
                )
                .into());
            }
            of_project(path)
        }
        paths => {
            if let Some(path) = paths.iter().find(|path| is_project(path)) {
                return Err(format!(
                    "a project is processed by itself; name it alone: {}",
                    path.display()
                )
                .into());
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
            let input = |path| LogInput { path, logs: logs.clone(), review: None, frame: None };
            Ok(paths.map(input).collect())
        }
    }
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
        })
    };
    inputs.into_iter().map(input).collect()
}

impl LogInput {
    /// Opens the log by itself.
    ///
    /// # Errors
    /// When it cannot be opened, or does not hold what its settings ask for.
    pub(super) fn open(&self) -> Result<OpenedLog, Failure> {
        let survey = self.logs.open(&self.path, &Progress::new())?;
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

/// Opens logs in the frame of the first that has a place, and counts those that cannot be used:
/// they are named on stderr and do not keep the others from being opened. The same bytes under
/// another name are taken once.
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

/// Opens logs as [`open_all`] does, but of a single one that cannot be used returns why.
pub(super) fn open(inputs: &[LogInput]) -> Result<(Vec<OpenedLog>, usize), Failure> {
    match inputs {
        [input] => Ok((vec![input.open()?], 0)),
        inputs => Ok(open_all(inputs)),
    }
}

/// An error where some of the logs could not be used.
///
/// # Errors
/// When there are some; it counts them.
pub(super) fn all_or(failed: usize, all: usize) -> Result<(), Failure> {
    match failed {
        0 => Ok(()),
        _ => {
            Err(format!("{failed} of {all} logs could not be processed, for the reasons above")
                .into())
        }
    }
}

fn add(opened: &mut Vec<OpenedLog>, log: OpenedLog, path: &Path) {
    if let Some(same) = opened.iter().find(|one| is_same(&one.survey, &log.survey)) {
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

/// Returns true if two logs are the same recording: byte for byte, whatever their names.
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

/// Returns true if a file has the decisions about the boxes of a log.
pub(super) fn is_of(path: &Path, log: &OpenedLog) -> bool {
    Review::open_for(path, &log.survey).is_ok()
}

/// Gives each review that is named by its file to the log that it is of, in the place of what that
/// has.
///
/// # Errors
/// Where a file cannot be used or is of none of the logs.
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
        // Of one log, its own words; of several, those about the last are those about all, but for
        // the name in them.
        if let Some(error) = refused.filter(|_| !is_taken) {
            return Err(error);
        }
    }
    Ok(())
}

/// Opens what logs are compared with: points, another log, or the logs of a folder or a project.
///
/// # Errors
/// When it cannot be opened, or its metres lie nowhere near the first log.
pub(super) fn open_reference(
    argument: &OsStr,
    first: &OpenedLog,
    progress: &Progress,
) -> Result<Reference, Failure> {
    let path = Path::new(argument);
    let inputs = match is_project(path) {
        true => of_project(path)?,
        false if is_group(argument) => {
            // What the first log's mounting puts right is put right where the mission is processed.
            let as_read = Settings {
                mounting: MountingSettings::default(),
                source: SourceSettings::default(),
                ..first.settings.clone()
            };
            let logs = Arc::new(LogOpener::new(as_read)?);
            let input = |path| LogInput { path, logs: logs.clone(), review: None, frame: None };
            logs_of(&[path.to_owned()]).into_iter().map(input).collect()
        }
        false => {
            let opened = Reference::open(argument, &first.survey, &first.settings, progress);
            return Ok(opened?);
        }
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

/// Returns true if an argument names several logs: a folder of them, or a project.
pub(super) fn is_group(argument: &OsStr) -> bool {
    let path = Path::new(argument);
    is_project(path) || logs_of(&[path.to_owned()]).len() > 1
}
