//! Saves decisions about logs that are in no named project, and finds them again.
//!
//! The first decision creates an untitled project in a folder of the program, with an ordinary
//! journal, so that from then on each decision is saved as it is made. When the same logs are
//! opened again, their untitled project is opened; when a log is opened alone or with other logs,
//! the last decisions about it are taken into the open survey. An untitled project whose survey was
//! saved under a name points to the named one.

use super::error::AppError;
use super::jobs::JobKey;
use super::project::{KnownLog, OpenedLogs, ProjectSaving, read};
use super::reviewing::REVIEW_SUFFIX;
use super::{Action, App, LogId, Notices, OpenLog};
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::ObjectNumbers;
use bathyscope_objects::review::Review;
use bathyscope_products::Error;
use bathyscope_products::pipeline::{LogSettings, Settings, SettingsError};
use bathyscope_products::project::{
    NAMED, Project, ProjectLog, Store, UntitledProject, find_untitled, unused_path,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Name of the undo step that takes decisions from an untitled project.
const TAKEN: &str = "last decisions about the log";

/// Contents of a path that was opened.
pub(super) enum OpenedPath {
    /// A log, with the decisions about it when it was last open.
    Log(Box<Survey>, ReadDecisions),
    /// The untitled project of exactly the requested logs, which are opened with it.
    Project(Box<OpenedLogs>),
    /// A folder of several logs.
    Folder(Vec<PathBuf>),
    /// The name of a recording that is already open.
    Known(String),
}

/// Decisions about a log from when it was last open.
pub(super) enum ReadDecisions {
    /// Decisions in an untitled project that is not opened itself.
    Untitled(Box<LogDecisions>),
    /// Path of the named project that has the decisions.
    Named(PathBuf),
    /// Bottom edits in the sidecar file of an earlier version.
    Sidecar(ReadBottom),
    /// No decisions.
    None,
}

/// The bottom edits of a sidecar file, or the error if they cannot be used.
pub(super) type ReadBottom = Result<BottomSettings, Error>;

/// Decisions about a log in an untitled project that is not opened itself.
pub(super) struct LogDecisions {
    log: Arc<ProjectLog>,
    /// Settings that the logs of that project share.
    shared: Settings,
    /// Settings of the log, with the contents of the files that they name; the error if the
    /// settings cannot be used.
    settings: Result<Settings, AppError>,
    /// Notices about files that cannot be read, and about a newer review.
    notes: Vec<String>,
}

/// Finds the decisions about a log that was read, among the untitled projects in `folder`;
/// `others` are the logs that are opened after it, or `None` if it joins open logs.
pub(super) fn find_decisions(
    folder: &Path,
    mut survey: Survey,
    others: Option<&[PathBuf]>,
    progress: &Progress,
) -> Result<OpenedPath, AppError> {
    let found = find_untitled(folder, &survey, others.unwrap_or_default(), progress)?;
    let Some(found) = found else {
        return Ok(OpenedPath::Log(Box::new(survey), ReadDecisions::None));
    };
    if let Some(named) = found.named() {
        return Ok(OpenedPath::Log(Box::new(survey), ReadDecisions::Named(named.clone())));
    }
    let UntitledProject { path, mut project, log, changed_at, is_whole } = found;
    let note = newer_review(&log, &survey, changed_at);
    if is_whole && let Some(others) = others {
        let mut paths = others.to_vec();
        paths.extend(survey.source.files.first().cloned());
        let mut known = Some(KnownLog { key: log.key.clone(), survey, paths });
        // A project that another window has open, or one of whose logs is another recording now, is
        // read, but not opened.
        if let Ok(mut opened) = read(&path, &mut known, progress) {
            opened.notes.extend(note);
            // The named project does not exist any more.
            opened.opened.project.files.remove(NAMED);
            return Ok(OpenedPath::Project(Box::new(opened)));
        }
        progress.check()?;
        survey = known.ok_or(AppError::OtherLog)?.survey;
    }
    let mut notes: Vec<String> = note.into_iter().collect();
    let mut note = |error: SettingsError| {
        let text = error.to_string();
        if !notes.contains(&text) {
            notes.push(text);
        }
    };
    project.settings.load_files().unwrap_or_else(&mut note);
    let settings = project.settings_of(&log).map(|mut settings| {
        settings.load_files().unwrap_or_else(&mut note);
        settings
    });
    let settings = settings.map_err(AppError::from);
    let decisions = LogDecisions { log, shared: project.settings, settings, notes };
    Ok(OpenedPath::Log(Box::new(survey), ReadDecisions::Untitled(Box::new(decisions))))
}

/// Returns a notice about the review file beside a log, if the file is newer than the decisions in
/// the project and differs from them; `None` otherwise.
fn newer_review(log: &ProjectLog, survey: &Survey, changed_at: SystemTime) -> Option<String> {
    let path = survey.source.files.first()?.with_extension(REVIEW_SUFFIX);
    let written_at = fs::metadata(&path).and_then(|found| found.modified()).ok()?;
    let review = Review::open_for(&path, survey).ok().filter(|_| written_at > changed_at)?;
    let review = review.with_sides(log.review.identity().swapped_sides);
    (review.shared() != log.review.shared()).then(|| {
        format!(
            "A review next to the log is newer than the last decisions; Open review reads it: {}",
            path.display()
        )
    })
}

impl ProjectSaving {
    /// Writes the changes of an untitled project into its file, or removes it if all its logs were
    /// closed.
    pub(super) fn save_untitled(&mut self, notices: &mut Notices) {
        let Some(store) = self.store.as_mut().filter(|_| self.is_untitled) else {
            return;
        };
        if self.project.logs().is_empty() {
            if let Some(store) = self.store.take() {
                store.remove();
            }
        } else if store.is_unsaved(&self.project)
            && let Err(error) = store.save(&self.project)
        {
            // The changes are in the journal.
            notices.warn(error);
        }
    }
}

impl App {
    /// Saves a decision in the journal of the project. If there is no project, the first decision
    /// creates an untitled one, if possible, as soon as the logs are hashed. A project that is
    /// already being created will contain the decision too.
    pub(super) fn keep_decision(&mut self, label: &str) {
        let saving = &mut self.files.project_saving;
        if saving.store.is_some() {
            return self.keep_project(label);
        }
        saving.is_closed = false;
        let is_begun = self.jobs.is_running(&JobKey::CreateProject);
        if is_begun || saving.is_refused || !self.logs.all().any(OpenLog::is_file) {
            return;
        }
        saving.has_unkept = true;
        if self.logs.to_hash().next().is_some() {
            self.hash_new_logs();
        } else {
            self.create_untitled();
        }
    }

    /// Starts to describe the files of logs that are not hashed yet, so that a project can contain
    /// them as soon as there is a decision.
    pub(super) fn hash_new_logs(&mut self) {
        let saving = &self.files.project_saving;
        let can_begin = saving.store.is_some() || self.files.untitled_folder.is_some();
        let is_begun = self.jobs.is_running(&JobKey::HashUntitled);
        if !can_begin || is_begun || saving.is_refused || self.logs.to_hash().next().is_none() {
            return;
        }
        self.hash_logs(JobKey::HashUntitled, |app, hashed| match hashed {
            Ok(()) if app.files.project_saving.store.is_some() => app.keep_project("add log"),
            Ok(()) if app.files.project_saving.has_unkept => app.create_untitled(),
            Err(error) if app.files.project_saving.has_decisions() => app.say_not_kept(&error),
            // Logs that were opened meanwhile.
            Ok(()) => app.hash_new_logs(),
            // The first decision tries again, and reports an error.
            Err(_) => {}
        });
    }

    /// Waits until the logs are hashed if there are decisions to save; otherwise stops the hashing.
    pub(super) fn finish_hashing(&mut self) {
        if self.files.project_saving.has_decisions() {
            self.wait_for(&JobKey::HashUntitled);
        } else {
            self.jobs.stop(&JobKey::HashUntitled);
        }
    }

    fn create_untitled(&mut self) {
        // The survey may be given a name meanwhile, or its last log may be closed.
        self.wait_for(&JobKey::CreateProject);
        if self.files.project_saving.store.is_some() {
            return self.keep_project("add log");
        }
        let Some(folder) = self.files.untitled_folder.clone() else {
            return;
        };
        if !self.logs.all().any(|log| log.file.is_some()) {
            return;
        }
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
                let label = app.document.history.undo_label().unwrap_or(TAKEN).to_owned();
                app.keep_project(&label);
            }
            Err(error) => app.say_not_kept(&error),
        });
    }

    fn say_not_kept(&mut self, why: &AppError) {
        self.files.project_saving.is_refused = true;
        let save = Action::SaveProject.key();
        self.notices.warn(format!(
            "decisions cannot be saved as they are made; save the project with {save}: {why}"
        ));
    }

    /// Returns true if closing the window now would lose decisions, because they are in no file.
    pub fn is_at_risk(&self) -> bool {
        let saving = &self.files.project_saving;
        let is_refused = saving.failed || saving.is_refused;
        let is_saved = saving.store.is_some() || saving.is_closed || self.is_keeping();
        let mut logs = self.logs.all().filter(|log| !is_saved || !log.is_file());
        let is_box_at_risk = logs.any(|log| log.reviewing.is_unsaved());
        is_box_at_risk || is_refused && self.document.history.steps().next().is_some()
    }

    /// Notifies the analyst that the decisions about the survey that is being closed are saved in
    /// an untitled project, or that they are gone.
    pub(super) fn say_kept(&mut self) {
        let saving = &self.files.project_saving;
        let names: Vec<String> = self.logs.all().map(|log| quoted(&log.name())).collect();
        let first = names.first().cloned().unwrap_or_default();
        let which = match names.len() {
            0 => return,
            1 => first,
            count => format!("{first} and {} more", count - 1),
        };
        if self.is_at_risk() {
            self.notices.warn(format!("decisions about {which} were in no file, and are gone"));
        } else if saving.is_untitled && saving.store.is_some() {
            self.notices.notify(format!(
                "The decisions about {which} are saved, and are there when it is opened again"
            ));
        }
    }

    /// Makes a change that the analyst did not decide, as an undo step. It is saved at once if a
    /// project is open, otherwise with the next decision. Returns true if anything changed.
    pub(super) fn take_unkept(
        &mut self,
        label: &'static str,
        change: impl FnOnce(&mut Self),
    ) -> bool {
        let before = self.step_now();
        change(self);
        let after = self.step_now();
        if before == after {
            return false;
        }
        self.notices.withdraw(Action::Undo);
        self.document.history.record(&before, &after, label, false);
        self.keep_project(label);
        true
    }

    /// Saves the decisions about a log that is being closed. They get an untitled project of their
    /// own, so that they are there when the log is opened again.
    pub(super) fn keep_closed(&mut self, id: LogId) {
        let Some(folder) = self.files.untitled_folder.clone() else {
            return;
        };
        // The log is described by the project that is being created.
        self.finish_hashing();
        self.wait_for(&JobKey::CreateProject);
        let Some(file) = self.logs.get(id).and_then(|log| log.file.as_ref()) else {
            return;
        };
        let project = self.as_project(&self.files.project_saving.project);
        let Some(log) = project.log_like(file) else {
            return;
        };
        let alone = project.with_only(&log.key);
        let is_decided = log.settings != LogSettings::default()
            || log.review.boxes().len() > 0
            || alone.settings != *self.document.start
            || !alone.measurements.is_empty();
        if !is_decided {
            return;
        }
        let written = fs::create_dir_all(&folder)
            .map_err(|source| AppError::NoFolder { source, path: folder.clone() });
        let path = unused_path(&folder, file);
        let written = written.and_then(|()| Ok(Store::create(&path, &alone, Vec::new())?));
        match (written, self.logs.get_mut(id)) {
            (Ok(_), Some(log)) => log.kept_alone = Some(path),
            (Ok(_), None) => {}
            (Err(error), _) => self.notices.warn(error),
        }
    }

    /// Takes the decisions about a log from when it was last open, as an undo step: all settings if
    /// it is the only log, those of its own if it joins others.
    pub(super) fn take_decisions(&mut self, id: LogId, decisions: LogDecisions) {
        let LogDecisions { log, shared, settings, notes } = decisions;
        let Some(name) = self.logs.get(id).map(|log| quoted(&log.name())) else {
            return;
        };
        let is_first = self.logs.count() == 1;
        let own = settings.and_then(|loaded| {
            let own = log.settings.clone().with_files_of(&loaded);
            let base = if is_first { &shared } else { &*self.document.shared };
            let settings = own.compose(base)?;
            Ok((own, settings))
        });
        let (own, settings, shared) = match own {
            Ok((own, settings)) => (own, settings, is_first.then_some(shared)),
            Err(error) => {
                self.notices.warn(format!("the last settings of {name} cannot be used: {error}"));
                let usual = self.document.shared.clone();
                (LogSettings::default(), Settings::clone(&usual), None)
            }
        };
        let log = ProjectLog { settings: own, is_visible: true, ..ProjectLog::clone(&log) };
        let is_change = self.take_unkept(TAKEN, |app| {
            if let Some(shared) = shared {
                app.document.shared = Arc::new(shared);
            }
            if is_first {
                let mut numbers = ObjectNumbers::default();
                numbers.add_log(id, log.object_numbers.clone());
                app.objects.renumber(numbers, &mut app.jobs);
            }
            app.take_project_log(id, &log, settings);
        });
        if is_change {
            self.notices
                .offer(format!("{name} opened with the last decisions about it"), Action::Undo);
        }
        for note in notes {
            self.notices.warn(note);
        }
    }
}
