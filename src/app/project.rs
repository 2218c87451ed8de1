//! Opens and saves the survey as a project: one file that names the logs and contains all decisions
//! about them. Each undo step is written into the project's journal at once, so that a crash loses
//! no more than the last action.

use super::error::AppError;
use super::history::{keep_figure, kept_figure};
use super::jobs::JobKey;
use super::{App, LogId, OpenLog, OpenLogs, ViewOptions};
use bathyscope_log::formats::{self, OpenError};
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::ObjectNumbers;
use bathyscope_objects::review::{Queue, Sort};
use bathyscope_products::export::is_same_file;
use bathyscope_products::pipeline::Settings;
use bathyscope_products::project::{
    ENDING, LogFile, LogKey, LogLocation, NAMED, OpenedProject, Project, ProjectLog, REVIEW_VIEW,
    SavingOutcome, Store, find,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Key of the display options in the project.
const VIEW: &str = "window";
/// Key of the base map among the project's files.
const BASE_MAP: &str = "base_map";

/// State of the open project and its file.
#[derive(Default)]
pub struct ProjectSaving {
    /// The file; `None` before the first decision.
    pub(super) store: Option<Store>,
    /// True if the file is in the folder of untitled projects: the analyst gave it no name yet.
    pub(super) is_untitled: bool,
    /// Contents of the project, from which parts that this window does not show are preserved.
    pub(super) project: Project,
    /// True if saving was requested while a save was running, so that the project is saved again
    /// after it.
    saves_again: bool,
    /// True if the project cannot be written, and the analyst was notified.
    pub(super) failed: bool,
    /// True if a log cannot be described, or an untitled project cannot be created, and the analyst
    /// was notified.
    pub(super) is_refused: bool,
    /// True if a decision was made that an untitled project is to contain.
    pub(super) has_unkept: bool,
    /// True if the project of the open logs was closed, with all decisions in it, because other
    /// logs are being opened.
    pub(super) is_closed: bool,
}

/// A project that was read, with the logs of it that were found.
pub(super) struct OpenedLogs {
    pub opened: OpenedProject,
    /// True if the project is an untitled one.
    is_untitled: bool,
    logs: Vec<(Arc<ProjectLog>, Survey, Settings)>,
    /// Notices about logs that are missing or were found elsewhere.
    pub notes: Vec<String>,
}

/// Returns true if a path has the ending of a project.
pub fn is_project(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(ENDING))
}

impl OpenLogs {
    /// Returns the open logs whose files are not described yet.
    pub(super) fn to_hash(&self) -> impl Iterator<Item = (LogId, Arc<Survey>)> {
        let unknown = self.all().filter(|log| log.file.is_none() && log.is_file());
        unknown.filter_map(|log| Some((log.id, log.survey.clone()?)))
    }
}

impl ProjectSaving {
    /// Returns true if there is a project, or a decision that begins one.
    pub(super) fn has_decisions(&self) -> bool {
        self.store.is_some() || self.has_unkept
    }

    /// Returns the file of the open project; `None` if it is untitled.
    pub fn path(&self) -> Option<&Path> {
        self.store.as_ref().filter(|_| !self.is_untitled).map(Store::path)
    }

    /// Returns true if there are changes that the file which the analyst named does not contain;
    /// they are in the journal beside it, or in an untitled project.
    pub fn is_unsaved(&self) -> bool {
        let store = self.store.as_ref();
        store.is_some_and(|store| self.is_untitled || store.is_unsaved(&self.project))
    }
}

impl App {
    /// Starts to open a project, which replaces what is open.
    pub(super) fn open_project(&mut self, path: PathBuf) {
        self.jobs.stop(&JobKey::OpenLog);
        self.files.to_load.clear();
        // This window may have the project open itself.
        self.leave_project();
        self.jobs.run(
            JobKey::OpenProject,
            move |progress| read(&path, &mut None, progress),
            |app, read| match read {
                Ok(read) => {
                    app.remember(read.opened.store.path().to_owned());
                    app.take_project(read);
                }
                Err(error) => app.notices.warn(error),
            },
        );
    }

    /// Stops the hashing of logs, and waits until running writes of the project have ended; until
    /// then nothing else may use its file.
    pub(super) fn finish_writing(&mut self) {
        self.jobs.stop(&JobKey::HashLogs);
        self.files.project_saving.saves_again = false;
        self.wait_for(&JobKey::CreateProject);
        self.wait_for(&JobKey::SaveProject);
    }

    /// Starts to save the open survey as a project in a file.
    pub(super) fn save_project_as(&mut self, path: PathBuf) {
        let path = if is_project(&path) {
            path
        } else {
            PathBuf::from(format!("{}.{ENDING}", path.display()))
        };
        if self.logs.count() == 0 || !self.logs.all().all(OpenLog::is_file) {
            let text = "a project holds logs that are files, at least one; the demo survey is none";
            return self.notices.warn(text);
        }
        self.hash_logs(JobKey::HashLogs, move |app, hashed| match hashed {
            Ok(()) => app.name_project(path),
            Err(error) => app.notices.warn(error),
        });
    }

    /// Starts to describe the files of the open logs by their hashes, as far as these are not known
    /// yet, for a project that contains them.
    pub(super) fn hash_logs(
        &mut self,
        key: JobKey,
        then: impl FnOnce(&mut Self, Result<(), AppError>) + Send + 'static,
    ) {
        let logs: Vec<(LogId, Arc<Survey>)> = self.logs.to_hash().collect();
        let hash = move |progress: &Progress| -> Result<Vec<(LogId, LogFile)>, AppError> {
            let file = |(id, survey): (LogId, Arc<Survey>)| {
                let file = LogFile::of(&survey, progress)?;
                // The hash belongs to the log only if the whole log could be read.
                survey.check_files().map_err(OpenError::from)?;
                Ok((id, file))
            };
            logs.into_iter().map(file).collect()
        };
        self.jobs.run(key, hash, move |app, hashed| {
            let hashed = hashed.map(|files| {
                for (id, file) in files {
                    if let Some(log) = app.logs.get_mut(id) {
                        log.file = Some(file);
                    }
                }
            });
            then(app, hashed);
        });
    }

    /// Starts to write the project into its file.
    pub(super) fn save_project(&mut self) {
        self.keep_project("save");
        let saves = self.jobs.is_running(&JobKey::SaveProject);
        let saving = &mut self.files.project_saving;
        let Some(store) = saving.store.as_mut().filter(|_| !saving.is_untitled) else {
            return self.notices.warn("there is no project file yet; use Save project as");
        };
        if saves {
            saving.saves_again = true;
            return;
        }
        match store.begin_save(&saving.project) {
            Ok(writing) => {
                self.jobs.run(JobKey::SaveProject, move |_| writing.write(), App::take_saved);
            }
            Err(error) => self.notices.warn(error),
        }
    }

    /// Ends a save of the project, and notifies the analyst of it; starts the next save if one was
    /// requested meanwhile.
    fn take_saved(&mut self, written: SavingOutcome) {
        let saving = &mut self.files.project_saving;
        let saves_again = std::mem::take(&mut saving.saves_again);
        let Some(store) = &mut saving.store else {
            return;
        };
        match store.end_save(written) {
            Ok(()) => {
                saving.failed = false;
                let text = format!("Saved the project: {}", store.path().display());
                self.notices.notify(text);
            }
            Err(error) => self.notices.warn(error),
        }
        if saves_again {
            self.save_project();
        }
    }

    /// Returns true if the project is being written into its file.
    pub fn is_keeping(&self) -> bool {
        [JobKey::HashLogs, JobKey::HashUntitled, JobKey::CreateProject, JobKey::SaveProject]
            .iter()
            .any(|key| self.jobs.is_running(key))
    }

    /// Writes the changes into the journal of the project, if it has a file already.
    pub(super) fn keep_project(&mut self, label: &str) {
        if self.files.project_saving.store.is_none() {
            return;
        }
        self.hash_new_logs();
        self.files.project_saving.project = self.as_project(&self.files.project_saving.project);
        let Some(store) = &mut self.files.project_saving.store else {
            return;
        };
        match store.record(&self.files.project_saving.project, label) {
            Ok(()) => self.files.project_saving.failed = false,
            Err(error) => {
                if !std::mem::replace(&mut self.files.project_saving.failed, true) {
                    self.notices.warn(error);
                }
            }
        }
    }

    /// Saves everything that is not saved yet, because the window closes.
    pub fn keep_all(&mut self) {
        // A project that is created must exist before the last changes are written into it.
        if self.files.project_saving.has_decisions() {
            self.hash_new_logs();
        }
        self.finish_hashing();
        self.wait_for(&JobKey::CreateProject);
        self.keep_project("close");
        self.finish_writing();
        self.files.project_saving.save_untitled(&mut self.notices);
    }

    /// Closes the project, before logs that do not belong to it are opened.
    pub(super) fn leave_project(&mut self) {
        self.keep_all();
        self.say_kept();
        let saving = &self.files.project_saving;
        let is_closed = saving.is_closed || saving.store.is_some();
        self.files.project_saving = ProjectSaving { is_closed, ..ProjectSaving::default() };
        self.files.missing.clear();
    }

    /// Returns the open survey as a project; parts that the window does not show stay as they are
    /// in `before`.
    pub(super) fn as_project(&self, before: &Project) -> Project {
        let mut project = before.clone();
        project.settings = Settings::clone(&self.document.shared);
        let is_placed = self.logs.all().any(OpenLog::is_placed);
        project.origin = is_placed.then(|| self.document.plane.origin());
        let open = self.logs.all().filter_map(|log| Some((log, log.file.as_ref()?)));
        let open: Vec<(&OpenLog, &LogFile)> = open.collect();
        let is_open = |log: &ProjectLog| {
            open.iter().any(|(_, file)| file.sha256 == log.file.sha256)
                || self.files.missing.contains(&log.key)
        };
        let gone: Vec<_> = (project.logs().iter())
            .filter(|log| !is_open(log))
            .map(|log| log.key.clone())
            .collect();
        for key in gone {
            project = project.without_log(&key).unwrap_or(project);
        }
        for (place, (log, file)) in open.into_iter().enumerate() {
            let known = project.log_like(file).cloned();
            let is_new = known.is_none();
            let mut entry = known
                .map_or_else(|| ProjectLog::new(file.clone()), |known| ProjectLog::clone(&known));
            entry.file.path.clone_from(&file.path);
            // A followed log has more pings than when it was read.
            entry.file.pings = file.pings;
            entry.is_visible = log.is_visible;
            entry.settings = log.own.as_ref().clone();
            entry.review = log.reviewing.review.clone();
            entry.object_numbers = self.objects.numbers().of_log(log.id);
            let key = entry.key.clone();
            let after = if is_new { project.with_log(entry) } else { project.with_changed(entry) };
            project = after.unwrap_or(project);
            project = project.with_log_at(&key, place).unwrap_or(project);
        }
        keep_figure(&mut project, self.map.measuring.figure.as_ref());
        project.files.remove(BASE_MAP);
        let base_map = self.map.base_map.as_ref();
        project.files.extend(base_map.map(|map| (BASE_MAP.to_owned(), map.path.clone())));
        project.set_view(VIEW, &self.view.options);
        let Queue { sort, threshold, .. } = self.logs.shown.reviewing.queue;
        project.set_view(REVIEW_VIEW, &KeptQueue { sort, threshold });
        project
    }

    /// Writes the project for the first time, or saves it if it has this path already. Until it is
    /// written, changes are saved where they were before: in the earlier project, or in an untitled
    /// one.
    fn name_project(&mut self, path: PathBuf) {
        if self.files.project_saving.path().is_some_and(|kept| is_same_file(kept, &path)) {
            return self.save_project();
        }
        self.create_project(
            move |_| Ok(path),
            |app, created| match created {
                Ok((store, project)) => app.take_named(store, project),
                Err(error) => app.notices.warn(error),
            },
        );
    }

    /// Starts to write the open survey, with the changes that led to it, as a new project at the
    /// path that `path` returns.
    pub(super) fn create_project(
        &mut self,
        path: impl FnOnce(&Project) -> Result<PathBuf, AppError> + Send + 'static,
        then: impl FnOnce(&mut Self, Result<(Store, Project), AppError>) + Send + 'static,
    ) {
        // The file of an untitled project that is being written would stay behind.
        self.wait_for(&JobKey::CreateProject);
        let project = self.as_project(&self.files.project_saving.project);
        let past = self.past_of(&project);
        self.jobs.run(
            JobKey::CreateProject,
            move |_| {
                let store = Store::create(&path(&project)?, &project, past)?;
                Ok((store, project))
            },
            then,
        );
    }

    /// Sets the project that was written under a name as the open one.
    fn take_named(&mut self, store: Store, project: Project) {
        let text = format!("Saved the project: {}", store.path().display());
        self.remember(store.path().to_owned());
        self.finish_writing();
        let saving = ProjectSaving { store: Some(store), project, ..ProjectSaving::default() };
        let mut before = std::mem::replace(&mut self.files.project_saving, saving);
        if let Some(mut untitled) = before.store.filter(|_| before.is_untitled)
            && let Some(named) = self.files.project_saving.path()
        {
            // The untitled project points to the named one from now on. Without the pointer, the
            // decisions of this moment would be found.
            before.project.files.insert(NAMED.to_owned(), named.to_owned());
            untitled.save(&before.project).ok();
        }
        self.notices.notify(text);
        self.keep_project("save under another name");
    }

    /// Replaces the open logs by those of a project that was read.
    pub(super) fn take_project(&mut self, read: OpenedLogs) {
        let OpenedLogs { opened, is_untitled, logs, notes } = read;
        let OpenedProject { store, project, notes: project_notes, past } = opened;
        self.leave_project();
        self.files.missing = (project.logs().iter())
            .filter(|log| logs.iter().all(|(found, ..)| found.key != log.key))
            .map(|log| log.key.clone())
            .collect();
        self.close_all();
        self.document.shared = Arc::new(project.settings.clone());
        // The display of a survey without a name is that of the window.
        let options = project.view::<ViewOptions>(VIEW).filter(|_| !is_untitled);
        self.view.options = options.unwrap_or_else(|| self.view.options.for_new_survey());
        let queue = project.view::<KeptQueue>(REVIEW_VIEW);
        let frame = project.origin.map(LocalFrame::new);
        let mut numbers = ObjectNumbers::default();
        for (log, survey, settings) in logs {
            // The plane stays, whichever log is first now.
            let survey = match &frame {
                Some(frame) => survey.in_frame_if_near(frame),
                None => survey,
            };
            let id = self.add_log(survey);
            numbers.add_log(id, log.object_numbers.clone());
            self.take_project_log(id, &log, settings);
        }
        self.objects.renumber(numbers, &mut self.jobs);
        if let Some(KeptQueue { sort, threshold }) = queue
            && (0.0..=1.0).contains(&threshold)
        {
            self.logs.set_queue(&Queue { sort, threshold, ..Queue::default() });
        }
        self.map.measuring.figure = kept_figure(&project, None);
        let saving = ProjectSaving { store: Some(store), project, ..ProjectSaving::default() };
        self.files.project_saving = ProjectSaving { is_untitled, ..saving };
        self.take_past(past);
        self.pipeline.is_waiting = false;
        if let Some(path) = self.files.project_saving.project.files.get(BASE_MAP).cloned() {
            self.reopen_base_map(path);
        }
        for text in project_notes.into_iter().chain(notes) {
            self.notices.warn(text);
        }
        self.schedule();
    }

    /// Applies the settings and decisions that a project holds for a log.
    pub(super) fn take_project_log(&mut self, id: LogId, log: &ProjectLog, settings: Settings) {
        if let Err(error) = self.follow_source(id, &settings) {
            self.notices.warn(error);
        }
        let shared = self.document.shared.clone();
        if let Some(open) = self.logs.get_mut(id) {
            open.file = Some(log.file.clone());
            open.is_visible = log.is_visible;
            open.own = Arc::new(log.settings.clone().with_files_of(&settings));
            open.settings = Arc::new(settings);
            open.reviewing.set(log.review.clone());
            // The log may have grown since.
            open.carry_own(&shared);
        }
        self.carry_decisions(id);
    }
}

/// Part of the queue of boxes that a project stores: without the filter, which is temporary.
#[derive(Serialize, Deserialize)]
struct KeptQueue {
    sort: Sort,
    threshold: f32,
}

/// A log of an untitled project that is read already.
pub(super) struct KnownLog {
    pub key: LogKey,
    pub survey: Survey,
    /// Present paths of the logs that were requested.
    pub paths: Vec<PathBuf>,
}

/// Reads a project and opens its logs. The project is an untitled one if a log of it is `known`,
/// which is taken unless there is an error.
pub(super) fn read(
    path: &Path,
    known: &mut Option<KnownLog>,
    progress: &Progress,
) -> Result<OpenedLogs, AppError> {
    let is_untitled = known.is_some();
    let mut opened = Store::open(path)?;
    let folder = opened.store.folder();
    let mut to_find = opened.project.clone();
    if let Some(known) = known {
        opened.project = opened.project.with_logs_at(&known.paths);
        to_find = opened.project.without_log(&known.key).unwrap_or(to_find);
    }
    let places: BTreeMap<LogKey, LogLocation> =
        find(&to_find, &folder, progress)?.into_iter().collect();
    if is_untitled && places.values().any(|place| *place != LogLocation::Here) {
        return Err(AppError::OtherLog);
    }
    for log in opened.project.logs() {
        opened.project.settings_of(log)?;
    }
    let (mut logs, mut notes) = (Vec::new(), Vec::new());
    // The files of the shared settings are read once for all logs.
    if let Err(error) = opened.project.settings.load_files() {
        notes.push(error.to_string());
    }
    for log in opened.project.logs() {
        let log = match places.get(&log.key) {
            None | Some(LogLocation::Here) => log.clone(),
            Some(LogLocation::Changed) => {
                notes.push(log.is_changed());
                log.clone()
            }
            Some(LogLocation::Moved(path)) => {
                notes.push(format!("Found {} at {}", quoted(&log.name), path.display()));
                Arc::new(log.at(path))
            }
            Some(LogLocation::Missing | LogLocation::Replaced) => {
                notes.push(format!(
                    "the log {} is missing; put it back, or below the folder of the project, and open the project again: {}",
                    quoted(&log.name),
                    log.file.path.display()
                ));
                continue;
            }
        };
        let mut settings = opened.project.settings_of(&log)?;
        if let Err(error) = settings.load_files() {
            let text = error.to_string();
            // A notice about shared settings must not be repeated for each log.
            if !notes.contains(&text) {
                notes.push(text);
            }
        }
        let survey = match known.take_if(|known| known.key == log.key) {
            Some(known) => Ok(known.survey),
            None => formats::open(&log.file.path, progress),
        };
        match survey {
            Ok(survey) => logs.push((log, survey, settings)),
            Err(error) => notes.push(error.to_string()),
        }
    }
    Ok(OpenedLogs { opened, is_untitled, logs, notes })
}
