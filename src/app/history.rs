//! Defines the state that undo restores, and the figure in it that the analyst draws to measure.
//! Records and names the changes that the analyst makes as undo steps, and goes back and forward
//! through them.

use super::planning::PlannedLines;
use super::source::Mountings;
use super::{Action, App, LogId, OpenLog};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_objects::review::Review;
use bathyscope_products::pipeline::settings::{Number, SettingKind, row};
use bathyscope_products::pipeline::{LogSettings, Settings, setting_values};
use bathyscope_products::project::{History, Measurement, PastStep, Project, ProjectLog};
use std::borrow::Cow;
use std::sync::Arc;
use toml::Value;

/// Key of the measurement that the window shows, in a project.
const MEASUREMENT: u32 = 1;

/// State that undo restores: everything that an analyst changes.
#[derive(Clone, PartialEq)]
pub struct UndoStep {
    pub(super) shared: Arc<Settings>,
    /// The logs in the order of the list.
    pub(super) logs: Vec<LogStep>,
    /// Ids of the logs that are closed and can be opened again.
    pub(super) closed: Vec<LogId>,
    pub(super) figure: Option<Arc<Figure>>,
    pub(super) planned: Option<Arc<PlannedLines>>,
    pub(super) mountings: Arc<Mountings>,
}

/// A figure that the analyst draws to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Kind of the measurement, and its corners.
    pub measurement: Measurement,
    /// True if the figure is ended, so that the next corner begins another one.
    pub done: bool,
}

/// State of one log that undo restores.
#[derive(Clone)]
pub(super) struct LogStep {
    pub id: LogId,
    pub is_visible: bool,
    pub own: Arc<LogSettings>,
    pub review: Arc<Review>,
}

impl LogStep {
    /// Returns the present state of a log, as undo would restore it.
    pub(super) fn of(log: &OpenLog) -> Self {
        Self {
            id: log.id,
            is_visible: log.is_visible,
            own: log.own.clone(),
            review: log.reviewing.review.clone(),
        }
    }
}

/// Equality of reviews means the same version in memory, which undo restores as it was.
impl PartialEq for LogStep {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
            && self.is_visible == other.is_visible
            && Arc::ptr_eq(&self.review, &other.review)
            && (Arc::ptr_eq(&self.own, &other.own) || self.own == other.own)
    }
}

impl App {
    /// Returns the present state, as undo would restore it.
    pub(crate) fn step_now(&self) -> UndoStep {
        UndoStep {
            shared: self.document.shared.clone(),
            logs: self.logs.all().map(LogStep::of).collect(),
            closed: self.logs.closed.iter().map(|log| log.id).collect(),
            figure: self.map.measuring.figure.clone(),
            planned: self.map.planning.lines.clone(),
            mountings: self.document.mountings.clone(),
        }
    }

    /// Records the change of the state since `before` as an undo step, and saves it in the project.
    /// The full name of the step states what changed, and to which value or in which log:
    /// `threshold 0.41`, `bottom of pond`.
    pub(super) fn record_step(
        &mut self,
        before: &UndoStep,
        label: impl Into<Cow<'static, str>>,
        live: bool,
    ) {
        let after = self.step_now();
        // An undo that was offered for an earlier change would now revert another one.
        self.notices.withdraw(Action::Undo);
        let label = label.into();
        let start = self.document.history.start_of(&label, before).clone();
        self.document.history.record(before, &after, label.clone(), live);
        if !live && start != after {
            let title = self.title(&label, &start, &after);
            self.document.history.name_last(title.clone());
            self.keep_decision(&title);
        }
    }

    /// Records the change of the state since `before` under a complete name as an undo step.
    pub(super) fn record_named(&mut self, before: &UndoStep, title: String) {
        let after = self.step_now();
        self.notices.withdraw(Action::Undo);
        self.document.history.record(before, &after, title.clone(), false);
        self.keep_decision(&title);
    }

    /// Reverts the last step.
    pub(super) fn undo(&mut self) {
        self.notices.withdraw(Action::Undo);
        if let Some(step) = self.document.history.undo(&self.step_now()) {
            self.take_step(step, true);
        }
    }

    /// Applies the step again that was undone last.
    pub(super) fn redo(&mut self) {
        self.notices.withdraw(Action::Undo);
        if let Some(step) = self.document.history.redo(&self.step_now()) {
            self.take_step(step, false);
        }
    }

    /// Goes to the state after the first `count` steps.
    pub(super) fn go_to_step(&mut self, count: usize) {
        let is_back = count < self.document.history.steps().filter(|step| !step.is_undone).count();
        self.notices.withdraw(Action::Undo);
        if let Some(step) = self.document.history.go_to(count, &self.step_now()) {
            self.take_step(step, is_back);
        }
    }

    /// Sets the undo steps from the past of a project, as far back as its logs are the open ones.
    pub(super) fn take_past(&mut self, past: Vec<PastStep>) {
        let mut after = self.step_now();
        let mut steps = Vec::new();
        for PastStep { label, before } in past.into_iter().rev() {
            let Some(step) = self.step_of(&before, &after) else {
                break;
            };
            if step != after {
                steps.push((step.clone(), Cow::Owned(label)));
                after = step;
            }
        }
        steps.reverse();
        self.document.history = History::of_past(steps);
    }

    /// Returns the changes that led to a project that is saved for the first time, as far back as
    /// its logs are the open ones.
    pub(super) fn past_of(&self, project: &Project) -> Vec<PastStep> {
        let versions = self.document.history.past().rev().map_while(|(step, label)| {
            Some(PastStep { label: label.to_owned(), before: self.project_of(step, project)? })
        });
        let mut steps: Vec<PastStep> = versions.collect();
        steps.reverse();
        steps
    }

    /// Returns the version of a project at a step, the reverse of [`App::step_of`]; `None` if other
    /// logs were open.
    fn project_of(&self, step: &UndoStep, project: &Project) -> Option<Project> {
        if step.logs.len() != project.logs().len() {
            return None;
        }
        let mut version = project.clone();
        version.settings = Settings::clone(&step.shared);
        for (place, log) in step.logs.iter().enumerate() {
            let file = self.logs.get(log.id)?.file.as_ref()?;
            let mut entry = ProjectLog::clone(version.log_like(file)?);
            entry.is_visible = log.is_visible;
            entry.settings = log.own.as_ref().clone();
            entry.review = log.review.clone();
            let key = entry.key.clone();
            version = version.with_changed(entry).unwrap_or(version);
            version = version.with_log_at(&key, place).unwrap_or(version);
        }
        keep_figure(&mut version, step.figure.as_ref());
        Some(version)
    }

    /// Returns the step of a version of the open project; parts that it has in common with the step
    /// `after` it share memory. `None` if the version has other logs.
    fn step_of(&self, project: &Project, after: &UndoStep) -> Option<UndoStep> {
        let mut step = after.clone();
        if project.settings != *after.shared {
            let mut shared = project.settings.clone();
            shared.load_files().ok()?;
            step.shared = Arc::new(shared);
        }
        for log in &mut step.logs {
            let open = self.logs.get(log.id)?;
            let was = project.log_like(open.file.as_ref()?)?;
            log.is_visible = was.is_visible;
            if was.settings != *log.own {
                let mut settings = was.settings.compose(&step.shared).ok()?;
                settings.load_files().ok()?;
                log.own = Arc::new(was.settings.clone().with_files_of(&settings));
            }
            if was.review != log.review {
                log.review = was.review.clone();
            }
        }
        if project.logs().len() != step.logs.len() {
            return None;
        }
        let place = |id: LogId| {
            let file = self.logs.get(id).and_then(|log| log.file.as_ref());
            let was = file.and_then(|file| project.log_like(file));
            project.logs().iter().position(|log| was.is_some_and(|was| Arc::ptr_eq(log, was)))
        };
        step.logs.sort_by_key(|log| place(log.id));
        step.figure = kept_figure(project, after.figure.as_ref());
        Some(step)
    }

    fn title(&self, label: &str, before: &UndoStep, after: &UndoStep) -> String {
        let mut title = label.to_owned();
        if let Some(value) = value_of_change(before, after, self.view.options.units) {
            title += &format!(" {value}");
        }
        let changed: Vec<LogId> = changed_logs(before, after).map(|(_, log)| log.id).collect();
        match changed[..] {
            [] => {}
            [id] if self.logs.count() > 1 => title += &format!(" of {}", self.logs.name_of(id)),
            [_] => {}
            _ => title += &format!(" of {} logs", changed.len()),
        }
        title
    }
}

/// Stores the measurement on the map in a project if it is finished; otherwise removes the
/// measurement of the project.
pub(super) fn keep_figure(project: &mut Project, figure: Option<&Arc<Figure>>) {
    project.measurements.remove(&MEASUREMENT);
    let figure = figure.filter(|figure| figure.done);
    let measurement = figure.map(|figure| (MEASUREMENT, figure.measurement.clone()));
    project.measurements.extend(measurement);
}

/// Returns the measurement of a project as a figure; shares memory with `before` if both are equal.
pub(super) fn kept_figure(project: &Project, before: Option<&Arc<Figure>>) -> Option<Arc<Figure>> {
    let measurement = project.measurements.get(&MEASUREMENT)?;
    let same = before.filter(|figure| figure.done && figure.measurement == *measurement);
    Some(
        same.cloned()
            .unwrap_or_else(|| Arc::new(Figure { measurement: measurement.clone(), done: true })),
    )
}

fn changed_logs<'a>(
    before: &'a UndoStep,
    after: &'a UndoStep,
) -> impl Iterator<Item = (&'a LogStep, &'a LogStep)> {
    let pairs = after.logs.iter().filter_map(|log| {
        let was = before.logs.iter().find(|was| was.id == log.id)?;
        Some((was, log))
    });
    pairs.filter(|(was, log)| was != log)
}

/// Returns a value in metres, whatever the unit that it was typed in: the list of the history
/// writes it in the unit of the day on which it is read. One more decimal keeps a round number of
/// feet round.
fn in_metres(number: &Number, value: f64, units: Units) -> String {
    let metric = number.shown_in(Units::default());
    if number.shown_in(units).suffix == metric.suffix {
        metric.said(value)
    } else {
        format!("{value:.*}{}", metric.decimals + 1, metric.suffix)
    }
}

/// Returns the new value of the only setting that differs, as its control writes it, or the name of
/// the preset that the settings now match and did not match before; `None` if no setting or several
/// differ.
fn value_of_change(before: &UndoStep, after: &UndoStep, units: Units) -> Option<String> {
    let (was, is) = if !Arc::ptr_eq(&before.shared, &after.shared) {
        if let Some(preset) = after.shared.matching_preset() {
            let is_new = before.shared.matching_preset() != Some(preset);
            return is_new.then(|| preset.name().to_owned());
        }
        (setting_values(&before.shared), setting_values(&after.shared))
    } else {
        let mut changed = changed_logs(before, after);
        let (was, log) = changed.next().filter(|_| changed.next().is_none())?;
        (was.own.own().clone(), log.own.own().clone())
    };
    let keys = was.keys().chain(is.keys());
    let mut keys = keys.filter(|key| was.get(*key) != is.get(*key));
    let key = keys.next()?;
    // A key of both lists occurs twice in the chain.
    if keys.any(|other| other != key) {
        return None;
    }
    match (&row(key)?.kind, is.get(key)) {
        (SettingKind::Number(number), Some(value)) => {
            let value = value.as_float().or(value.as_integer().map(|whole| whole as f64))?;
            Some(in_metres(number, value, units))
        }
        (SettingKind::Number(number), None) => number.none_word().map(str::to_owned),
        (SettingKind::Choice(choice), Some(Value::String(chosen))) => {
            let named = choice.names.iter().find(|name| name.value == chosen);
            Some(named.map_or(chosen.as_str(), |name| name.label).to_owned())
        }
        _ => None,
    }
}
