//! Saves decisions about logs that are in no named project, and finds them again.
//!
//! The first decision creates an untitled project in a folder of the program, with an ordinary
//! journal, so that from then on each decision is saved as it is made. When the same logs are
//! opened again, their untitled project is opened; when a log is opened in other company, the last
//! decisions about it are taken into the open survey.

use super::error::AppError;
use super::jobs::JobKey;
use super::project::{KnownLog, OpenedLogs, read};
use super::reviewing::REVIEW_SUFFIX;
use super::{Action, App, LogId, OpenLog};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::ObjectNumbers;
use bathyscope_objects::review::Review;
use bathyscope_products::pipeline::{LogSettings, Settings};
use bathyscope_products::project::{
    Project, ProjectLog, Store, UntitledProject, find_untitled, unused_path,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Name of the undo step that takes decisions from an untitled project.
const TAKEN: &str = "last decisions about the log";

/// A log with the decisions about it when it was last open.
pub(super) enum FoundDecisions {
    /// The project of the requested logs, which are opened with it.
    Project(Box<OpenedLogs>),
    /// The decisions about one log of a project.
    Log(Box<LogDecisions>, Survey),
    /// There are no decisions.
    None(Survey),
}

/// Decisions about a log in an untitled project of other logs as well.
pub(super) struct LogDecisions {
    log: Arc<ProjectLog>,
    /// Settings that the logs of that project share.
    shared: Settings,
    /// Settings of the log with the files that they name; the error if these cannot be used.
    settings: Result<Settings, AppError>,
    /// Notice about a newer review.
    note: Option<String>,
}

/// Finds the decisions about a log that was read, among the untitled projects in `folder`;
/// `others` are the logs that are opened after it, or `None` if it joins open logs.
pub(super) fn find_decisions(
    folder: &Path,
    survey: Survey,
    others: Option<&[PathBuf]>,
    progress: &Progress,
) -> Result<FoundDecisions, AppError> {
    let found = find_untitled(folder, &survey, others.unwrap_or_default(), progress)?;
    let Some(UntitledProject { path, project, log, changed_at, is_whole }) = found else {
        return Ok(FoundDecisions::None(survey));
    };
    let note = newer_review(&log, &survey, changed_at);
    if is_whole && let Some(others) = others {
        let mut paths = others.to_vec();
        paths.extend(survey.source.files.first().cloned());
        let known = KnownLog { key: log.key.clone(), survey: survey.clone(), paths };
        // A project that another window has open is read, but not opened.
        if let Ok(mut opened) = read(&path, Some(known), progress) {
            opened.notes.extend(note);
            return Ok(FoundDecisions::Project(Box::new(opened)));
        }
        progress.check()?;
    }
    let settings = project.settings_of(&log).and_then(|mut settings| {
        settings.load_files()?;
        settings.check()?;
        Ok(settings)
    });
    let settings = settings.map_err(AppError::from);
    let decisions = LogDecisions { log, shared: project.settings, settings, note };
    Ok(FoundDecisions::Log(Box::new(decisions), survey))
}

/// Returns a notice about a review beside a log that was written after the decisions in a project
/// and differs from them; `None` if there is none.
fn newer_review(log: &ProjectLog, survey: &Survey, changed_at: SystemTime) -> Option<String> {
    let path = survey.source.files.first()?.with_extension(REVIEW_SUFFIX);
    let written_at = fs::metadata(&path).and_then(|found| found.modified()).ok()?;
    let review = Review::open_for(&path, survey).ok().filter(|_| written_at > changed_at)?;
    (review.shared() != log.review.shared()).then(|| {
        format!(
            "A review next to the log is newer than the last decisions; Open review reads it: {}",
            path.display()
        )
    })
}

impl App {
    /// Saves decisions about logs that are in no named project in untitled projects in `folder`,
    /// which is created with the first of them.
    pub fn keep_untitled_in(&mut self, folder: PathBuf) {
        self.files.untitled_folder = Some(folder);
    }

    /// Saves a decision: in the journal of the project, which is created with the first decision.
    pub(super) fn keep_decision(&mut self, label: &str) {
        if self.files.project_saving.store.is_some() {
            self.keep_project(label);
        } else {
            self.files.project_saving.is_closed = false;
            self.begin_untitled();
        }
    }

    /// Starts to create an untitled project of the open logs, unless that is impossible or under
    /// way.
    fn begin_untitled(&mut self) {
        let Some(folder) = self.files.untitled_folder.clone() else {
            return;
        };
        let is_begun = [JobKey::HashUntitled, JobKey::CreateProject];
        let is_begun = is_begun.iter().any(|key| self.is_running(key));
        if is_begun || self.files.project_saving.failed || !self.logs().any(OpenLog::is_file) {
            return;
        }
        self.hash_logs(JobKey::HashUntitled, move |app, hashed| match hashed {
            Ok(()) if app.files.project_saving.store.is_some() => app.keep_project("add log"),
            Ok(()) => app.create_untitled(folder),
            Err(error) => app.say_not_kept(&error),
        });
    }

    /// Starts to describe the files of logs that joined a project, which contains them from then
    /// on.
    pub(super) fn hash_new_logs(&mut self) {
        let is_begun = self.is_running(&JobKey::HashUntitled);
        let has_store = self.files.project_saving.store.is_some();
        let can_begin = has_store && !is_begun && !self.files.project_saving.failed;
        if !can_begin || self.logs_to_hash().next().is_none() {
            return;
        }
        self.hash_logs(JobKey::HashUntitled, |app, hashed| match hashed {
            Ok(()) => app.keep_project("add log"),
            Err(error) => app.say_not_kept(&error),
        });
    }

    fn create_untitled(&mut self, folder: PathBuf) {
        let path = move |project: &Project| {
            fs::create_dir_all(&folder)
                .map_err(|source| AppError::NoFolder { source, path: folder.clone() })?;
            let first = project.logs().first();
            Ok(first.map_or_else(PathBuf::new, |log| unused_path(&folder, &log.file)))
        };
        self.create_project(path, |app, created| match created {
            Ok((store, project)) => {
                let saving = &mut app.files.project_saving;
                (saving.store, saving.project, saving.is_untitled) = (Some(store), project, true);
                let label = app.undo_label().unwrap_or(TAKEN).to_owned();
                app.keep_project(&label);
            }
            Err(error) => app.say_not_kept(&error),
        });
    }

    fn say_not_kept(&mut self, why: &AppError) {
        self.files.project_saving.failed = true;
        let save = Action::SaveProject.key();
        self.warn(format!(
            "decisions cannot be saved as they are made; save the project with {save}: {why}"
        ));
    }

    /// Returns true if closing the window now would lose decisions, because they are in no file.
    pub fn is_at_risk(&self) -> bool {
        let saving = &self.files.project_saving;
        if saving.store.is_some() {
            return saving.failed;
        }
        let is_saved = saving.is_closed || self.is_keeping();
        !is_saved && self.logs().any(|log| log.reviewing.is_unsaved())
    }

    /// Writes the changes of an untitled project into its file. A project without logs is removed:
    /// each of them was closed.
    pub(super) fn save_untitled(&mut self) {
        let saving = &mut self.files.project_saving;
        let Some(store) = saving.store.as_mut().filter(|_| saving.is_untitled) else {
            return;
        };
        if saving.project.logs().is_empty() {
            if let Some(store) = saving.store.take() {
                store.remove();
            }
        } else if store.is_unsaved(&saving.project)
            && let Err(error) = store.save(&saving.project)
        {
            // The changes are in the journal.
            self.warn(error.to_string());
        }
    }

    /// Notifies the analyst of where the decisions about a survey are that is being closed.
    pub(super) fn say_kept(&mut self) {
        let saving = &self.files.project_saving;
        let names: Vec<String> = self.logs().map(|log| quoted(&log.name())).collect();
        let first = names.first().cloned().unwrap_or_default();
        let which = match names.len() {
            0 => return,
            1 => first,
            count => format!("{first} and {} more", count - 1),
        };
        if saving.is_untitled && saving.store.is_some() {
            self.notify(format!(
                "The decisions about {which} are saved, and are there when it is opened again"
            ));
        } else if self.is_at_risk() {
            self.warn(format!("the decisions about {which} were in no file, and are gone"));
        }
    }

    /// Saves the decisions about a log that is being closed in an untitled project of its own, so
    /// that they are there when it is opened again.
    pub(super) fn keep_closed(&mut self, id: LogId) {
        let Some(folder) = self.files.untitled_folder.clone() else {
            return;
        };
        let Some(file) = self.open_log(id).and_then(|log| log.file.as_ref()) else {
            return;
        };
        let project = self.as_project(&self.files.project_saving.project);
        let Some(log) = project.log_like(file).filter(|log| has_decisions(log)) else {
            return;
        };
        let alone = project.with_only(&log.key);
        let written = fs::create_dir_all(&folder)
            .map_err(|source| AppError::NoFolder { source, path: folder.clone() });
        let path = unused_path(&folder, file);
        let written = written.and_then(|()| Ok(Store::create(&path, &alone)?));
        if let Err(error) = written {
            self.warn(error.to_string());
        }
    }

    /// Takes the decisions about a log from when it was last open, as an undo step: all settings if
    /// it is the only log, those of its own if it joins others.
    pub(super) fn take_decisions(&mut self, id: LogId, decisions: LogDecisions) {
        let LogDecisions { log, shared, settings, note } = decisions;
        let Some(name) = self.open_log(id).map(|log| quoted(&log.name())) else {
            return;
        };
        let before = self.step_now();
        let is_first = self.log_count() == 1;
        let own = settings.and_then(|loaded| {
            let own = log.settings.clone().with_files_of(&loaded);
            let base = if is_first { &shared } else { &*self.document.shared };
            let settings = own.compose(base)?;
            Ok((own, settings))
        });
        let (own, settings) = match own {
            Ok(own) => own,
            Err(error) => {
                self.warn(format!("the last settings of {name} cannot be used: {error}"));
                let usual = self.document.shared.clone();
                (LogSettings::default(), Settings::clone(&usual))
            }
        };
        if is_first {
            self.document.shared = Arc::new(shared);
            let mut numbers = ObjectNumbers::default();
            numbers.add_log(id, log.object_numbers.clone());
            self.number_objects(numbers);
        }
        let log = ProjectLog { settings: own, is_visible: true, ..ProjectLog::clone(&log) };
        self.take_project_log(id, &log, settings);
        let after = self.step_now();
        if before != after {
            self.document.history.record(&before, &after, TAKEN, false);
            self.offer(format!("{name} opened with the last decisions about it"), Action::Undo);
        }
        if let Some(note) = note {
            self.notify(note);
        }
    }
}

/// Returns true if there are decisions about a log of its own.
fn has_decisions(log: &ProjectLog) -> bool {
    log.settings != LogSettings::default() || log.review.boxes().len() > 0
}
