//! Holds the open logs and their order, shows one of them, and decides which is processed next.
//!
//! [`OpenLogs::shown`] is the log that waterfall, profile and panels show; the other logs keep
//! their results beside it, and maps, clouds and products are made from all visible logs.

use super::jobs::JobKey;
use super::open_log::log_colour;
use super::{App, LogId, LogPlace, OpenLog};
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::printable::quoted;
use bathyscope_log::survey::{Identity, Survey, distinct_names};
use bathyscope_products::pipeline::{ProcessedLog, Products, Settings};
use bathyscope_products::project::Store;
use std::sync::Arc;

/// Number of closed logs that undo can open again.
const CLOSED: usize = 10;

/// A log that takes part in maps and clouds, with its results.
#[derive(Clone, Debug)]
pub struct VisibleLog {
    /// Identifier of the log.
    pub id: LogId,
    /// Name of the log: [`OpenLog::name`].
    pub name: String,
    /// Colour of the log where colours distinguish logs, red, green and blue.
    pub colour: [u8; 3],
    /// The recording with its results.
    pub log: ProcessedLog,
}

/// The open logs.
#[derive(Default)]
pub struct OpenLogs {
    /// The log that waterfall, profile and panels show, and that the selection refers to.
    pub shown: OpenLog,
    /// The logs beside the shown one.
    pub(super) others: Vec<OpenLog>,
    /// All open logs, in the order of the list.
    pub(super) order: Vec<LogId>,
    /// Number of logs that were opened so far.
    last: u64,
    /// Newly opened logs, which `App::set_apart` has not checked yet.
    pub(super) arrived: Vec<LogId>,
    /// Closed logs that undo can open again, the last one at the end.
    pub(super) closed: Vec<OpenLog>,
}

impl OpenLogs {
    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self {
            shown: self.shown.for_picture(),
            others: self.others.iter().map(OpenLog::for_picture).collect(),
            order: self.order.clone(),
            ..Self::default()
        }
    }

    /// Closes a log, and keeps it for undo.
    fn close(&mut self, log: OpenLog) {
        self.order.retain(|id| *id != log.id);
        self.closed.push(log.at_rest());
        let surplus = self.closed.len().saturating_sub(CLOSED);
        self.closed.drain(..surplus);
    }

    /// Returns the open logs in the order of the list.
    pub fn all(&self) -> impl Iterator<Item = &OpenLog> {
        self.order.iter().filter_map(|id| self.get(*id))
    }

    /// Returns the logs that take part in maps, clouds and products, in the order of the list.
    pub fn visible(&self) -> impl Iterator<Item = &OpenLog> {
        self.all().filter(|log| log.is_visible)
    }

    /// Returns true if a visible log has depths across the track.
    pub(crate) fn has_swath(&self) -> bool {
        let mut surveys = self.visible().filter_map(|log| log.survey.as_ref());
        surveys.any(|survey| !survey.swath.is_empty())
    }

    /// Returns the visible logs that have results, in the order of the list, from which maps and
    /// clouds are made.
    pub fn with_results(&self) -> Vec<VisibleLog> {
        let shown = |log: &OpenLog| {
            Some(VisibleLog {
                id: log.id,
                name: log.name(),
                colour: log.colour,
                log: log.with_results()?,
            })
        };
        self.visible().filter_map(shown).collect()
    }

    /// Returns the recordings and results of the visible logs, in the order of the list, with the
    /// present coordinate system of the maps, for comparisons and exports.
    pub(super) fn processed(&self) -> Vec<ProcessedLog> {
        let with_system = |mut log: ProcessedLog| {
            // No stage depends on the coordinate system: the results are valid for any.
            Arc::make_mut(&mut log.products.settings).crs = self.shown.settings.crs;
            log
        };
        self.settled().map(with_system).collect()
    }

    /// Returns the recordings and results of the visible logs as wholes ([`OpenLog::settled`]), in
    /// the order of the list.
    pub(super) fn settled(&self) -> impl Iterator<Item = ProcessedLog> {
        self.visible().filter_map(OpenLog::settled)
    }

    /// Returns the number of open logs.
    pub fn count(&self) -> usize {
        self.order.len()
    }

    /// Returns the open log with an id; `None` if there is no such log.
    pub fn get(&self, id: LogId) -> Option<&OpenLog> {
        let mut all = [&self.shown].into_iter().chain(&self.others);
        all.find(|log| log.id == id && log.survey.is_some())
    }

    /// Returns the shown log, or the log beside it, with an id.
    pub(super) fn get_mut(&mut self, id: LogId) -> Option<&mut OpenLog> {
        self.all_mut().find(|log| log.id == id)
    }

    /// Returns the shown log, followed by the logs beside it.
    pub(super) fn all_mut(&mut self) -> impl Iterator<Item = &mut OpenLog> {
        [&mut self.shown].into_iter().chain(&mut self.others)
    }

    /// Returns the ids of the shown log and of the logs beside it.
    pub(super) fn ids(&self) -> Vec<LogId> {
        let all = [&self.shown].into_iter().chain(&self.others);
        all.map(|log| log.id).collect()
    }

    /// Replaces the shown log by `log`, which takes over the order and filter of boxes, and a
    /// requested truth; returns the log that was shown before.
    fn replace_shown(&mut self, log: OpenLog) -> OpenLog {
        let mut last = std::mem::replace(&mut self.shown, log);
        self.shown.reviewing.take_tools(&mut last.reviewing);
        self.shown.reviewing.judging.requested = last.reviewing.judging.requested.take();
        last
    }

    /// Returns an open log and its recording.
    pub(super) fn log_and_survey(&self, id: LogId) -> Option<(&OpenLog, &Arc<Survey>)> {
        let log = self.get(id)?;
        Some((log, log.survey.as_ref()?))
    }

    /// Returns the recording of an open log.
    pub(super) fn survey_of(&self, id: LogId) -> Option<&Arc<Survey>> {
        self.get(id)?.survey.as_ref()
    }

    /// Gives the open logs distinct names.
    fn name_all(&mut self) {
        let read = |log: &OpenLog| Some((log.id, log.survey.clone()?));
        let logs: Vec<(LogId, Arc<Survey>)> = self.all().filter_map(read).collect();
        let names = distinct_names(logs.iter().map(|(_, survey)| &**survey));
        for ((id, _), name) in logs.into_iter().zip(names) {
            if let Some(log) = self.get_mut(id) {
                log.name = name;
            }
        }
    }

    /// Returns the name of an open log for sentences; empty if there is no such log.
    pub(super) fn name_of(&self, id: LogId) -> String {
        self.get(id).map_or_else(String::new, |log| quoted(&log.name()))
    }

    /// Restores an earlier order of the logs; logs opened since then stay at the end.
    pub(super) fn reorder(&mut self, order: impl Iterator<Item = LogId>) {
        let open = std::mem::take(&mut self.order);
        let mut order: Vec<LogId> = order.filter(|id| open.contains(id)).collect();
        let since = open.into_iter().filter(|id| !order.contains(id));
        let since: Vec<LogId> = since.collect();
        order.extend(since);
        self.order = order;
    }
}

impl App {
    /// Sets the settings from which new surveys start, apart from those that belong to one survey.
    pub fn use_settings(&mut self, settings: &Settings) {
        self.document.start = Arc::new(settings.with_survey_of(&Settings::default()));
        self.document.shared = self.document.start.clone();
        self.logs.shown.settings = self.document.shared.clone();
    }

    /// Replaces the open logs by a log that is already read, with its results if there are any.
    pub fn show_survey(&mut self, survey: Arc<Survey>, products: Option<Products>) {
        self.pipeline.is_waiting = true;
        self.replace_logs(survey);
        self.logs.shown.products = products;
    }

    /// Replaces all open logs by a log that was read.
    pub(super) fn replace_logs(&mut self, survey: Arc<Survey>) {
        self.leave_project();
        self.close_all();
        // The earlier shared settings belong to the survey that was open.
        self.document.shared = self.document.start.clone();
        self.open_first(survey);
    }

    /// Closes all logs.
    pub(super) fn close_all(&mut self) {
        for id in self.logs.ids() {
            self.jobs.stop_log(id);
        }
        let settings = self.document.shared.clone();
        self.logs.replace_shown(OpenLog { settings, ..OpenLog::default() });
        self.logs.others.clear();
        for id in std::mem::take(&mut self.logs.order) {
            self.findings.search.leave(id, &mut self.jobs);
        }
        self.forget_steps();
        self.leave_reference();
        self.jobs.stop(&JobKey::CompareHeights);
        self.findings.heights = Default::default();
        self.jobs.stop(&JobKey::ComparePositions);
        self.findings.positions = None;
        self.objects.renumber(Default::default(), &mut self.jobs);
        self.meet_log();
    }

    /// Sets the plane of the logs.
    pub(super) fn enter_plane(&mut self, plane: LocalFrame) {
        self.document.plane = plane;
        self.view.plane_serial += 1;
        // The ends of the clip box were in the earlier plane.
        self.view.options.cloud.clip = None;
        self.view.options.cloud.cut = false;
    }

    /// Opens a log in an empty window.
    fn open_first(&mut self, survey: Arc<Survey>) {
        self.enter_plane(survey.track.frame.clone());
        // Logs that were closed before, and their measurements, are in another plane.
        self.forget_steps();
        let log = self.opened(survey);
        self.logs.replace_shown(log);
        self.logs.name_all();
        self.meet_log();
    }

    /// Adds a log that was read to the open logs, in their plane; returns its id.
    pub(super) fn add_log(&mut self, survey: Survey) -> LogId {
        if self.logs.shown.survey.is_none() {
            self.open_first(Arc::new(survey));
            return self.logs.shown.id;
        }
        if !self.logs.all().any(OpenLog::is_placed) {
            // A plane around another place would distort this log's track.
            self.enter_plane(survey.track.frame.clone());
        }
        let log = self.opened(Arc::new(survey.in_frame(&self.document.plane)));
        let id = log.id;
        self.logs.others.push(log);
        self.logs.name_all();
        id
    }

    fn opened(&mut self, survey: Arc<Survey>) -> OpenLog {
        self.logs.last += 1;
        let id = LogId(self.logs.last);
        self.logs.order.push(id);
        // A closed log that is opened again by its file must not be opened a second time by undo.
        let own = Identity::of(&survey);
        let is_other = |log: &OpenLog| {
            let closed = log.survey.as_ref().map(|survey| Identity::of(survey));
            closed.is_none_or(|closed| !(closed.file == own.file && closed.is_same_log(&own)))
        };
        self.logs.closed.retain(is_other);
        let mut log = OpenLog::new(id, survey.clone(), self.document.shared.clone());
        log.colour = log_colour(self.logs.order.len() - 1);
        // Boxes of all logs are sorted and filtered alike.
        log.reviewing.queue = self.logs.shown.reviewing.queue.clone();
        log.reviewing.start(&survey);
        log
    }

    /// Shows another of the open logs in waterfall, profile and panels.
    pub(super) fn show_log(&mut self, id: LogId) {
        let Some(place) = self.logs.others.iter().position(|log| log.id == id) else {
            return;
        };
        std::mem::swap(&mut self.logs.shown, &mut self.logs.others[place]);
        let before = &mut self.logs.others[place];
        before.preview = None;
        self.logs.shown.reviewing.take_tools(&mut before.reviewing);
        self.meet_log();
    }

    /// Drops the undo steps, the closed logs and the measurement on the map.
    fn forget_steps(&mut self) {
        self.logs.closed.clear();
        self.document.history = Default::default();
        self.map.measuring = Default::default();
    }

    /// Drops the first returns that were computed ahead of the results of a log, and the
    /// measurements that are kept for the next ones.
    pub(super) fn forget_preview(&mut self, id: LogId) {
        if let Some(log) = self.logs.get_mut(id) {
            log.preview = None;
        }
        if id == self.logs.shown.id {
            self.pipeline.previewer.forget(&mut self.jobs);
        }
    }

    /// Stops the work for the log that was shown before, drops what is out of date with another
    /// shown log, and starts the work for the shown log.
    fn meet_log(&mut self) {
        self.view.survey_serial += 1;
        self.view.selection = None;
        self.view.hover = None;
        self.view.visible = 0..0;
        self.findings.reference_comparison.forget(&mut self.jobs);
        self.pipeline.previewer.forget(&mut self.jobs);
        self.schedule();
    }

    /// Closes a log, as an undo step; the decisions about it are there when it is opened again.
    pub(super) fn close_log(&mut self, id: LogId) {
        if self.logs.get(id).is_none() {
            return;
        }
        let before = self.step_now();
        let title = format!("close {}", self.logs.name_of(id));
        self.put_away(id);
        self.record_named(&before, title);
        self.schedule();
    }

    /// Removes a log from the open ones; if it was shown, a neighbour in the list is shown.
    fn put_away(&mut self, id: LogId) {
        // What is being read for the log belongs to it, even if it is closed.
        for key in [JobKey::ReadReview(id), JobKey::ReadTruth(id)] {
            self.wait_for(&key);
        }
        self.keep_closed(id);
        self.jobs.stop_log(id);
        self.findings.search.leave(id, &mut self.jobs);
        let order = &self.logs.order;
        let Some(place) = order.iter().position(|listed| *listed == id) else {
            return;
        };
        let next = order.get(place + 1).or(place.checked_sub(1).map(|i| &order[i]));
        match next.copied() {
            Some(next) if id == self.logs.shown.id => self.show_log(next),
            Some(_) => {}
            None => {
                self.document.shared = self.document.start.clone();
                let settings = self.document.shared.clone();
                let last = self.logs.replace_shown(OpenLog { settings, ..OpenLog::default() });
                self.logs.close(last);
                self.leave_reference();
                self.meet_log();
            }
        }
        if let Some(place) = self.logs.others.iter().position(|log| log.id == id) {
            let closed = self.logs.others.remove(place);
            self.logs.close(closed);
        }
        self.logs.name_all();
    }

    /// Opens and closes logs so that exactly the logs `closed` are closed.
    pub(super) fn open_and_close(&mut self, closed: &[LogId]) {
        let is_open = |log: &OpenLog| !closed.contains(&log.id);
        while let Some(place) = self.logs.closed.iter().position(is_open) {
            let mut log = self.logs.closed.remove(place);
            // The project of its own that the log got when it was closed is not needed any more.
            let alone = log.kept_alone.take().and_then(|path| Store::open(&path).ok());
            if let Some(alone) = alone {
                alone.store.remove();
            }
            self.logs.order.push(log.id);
            if self.logs.shown.survey.is_none() {
                self.logs.replace_shown(log);
                self.meet_log();
            } else {
                self.logs.others.push(log);
            }
            self.logs.name_all();
        }
        for id in closed {
            self.put_away(*id);
        }
    }

    /// Includes a log in maps, clouds and products, or excludes it, as an undo step.
    pub(super) fn set_log_visible(&mut self, id: LogId, is_visible: bool) {
        let before = self.step_now();
        if let Some(log) = self.logs.get_mut(id) {
            log.is_visible = is_visible;
            log.apart = None;
        }
        let what = if is_visible { "show" } else { "hide" };
        self.record_named(&before, format!("{what} {}", self.logs.name_of(id)));
        self.schedule();
    }

    /// Moves a log up or down the list, as an undo step.
    pub(super) fn move_log(&mut self, id: LogId, by: isize) {
        let before = self.step_now();
        let order = &mut self.logs.order;
        let Some(from) = order.iter().position(|listed| *listed == id) else {
            return;
        };
        let to = from.saturating_add_signed(by).min(order.len() - 1);
        let moved = order.remove(from);
        order.insert(to, moved);
        let way = if by < 0 { "up" } else { "down" };
        self.record_named(&before, format!("move {} {way}", self.logs.name_of(id)));
    }

    /// Shows the log `by` places after the shown one in the list, around its ends.
    pub(super) fn step_log(&mut self, by: isize) {
        let order = &self.logs.order;
        if let Some(here) = order.iter().position(|id| *id == self.logs.shown.id) {
            let next = (here as isize + by).rem_euclid(order.len() as isize);
            self.show_log(order[next as usize]);
        }
    }

    /// Shows a log, if it is not shown yet, and a place of it in all views.
    pub(super) fn reveal_in(&mut self, id: LogId, mark: LogPlace) {
        self.show_log(id);
        self.view.reveal(mark);
    }
}
