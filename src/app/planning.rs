//! Plans the next survey lines in a background thread, changes them by hand, and writes them for
//! plotters and autopilots.

use super::App;
use super::error::AppError;
use super::jobs::JobKey;
use bathyscope_bottom::planning::{Leg, Plan, PlanError, PlanSettings, plan};
use bathyscope_log::support::geo::{LocalFrame, LonLat};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::export::{PlanFormat, PlannedWay};
use bathyscope_products::pipeline::{list_objects, survey_coverage};
use std::path::PathBuf;
use std::sync::Arc;

/// Notice when there are no lines to act on.
const NO_LINES: &str = "no lines are planned yet; use Plan lines first";
const NO_LINE: &str = "no planned line is selected; click one on the map first";

/// Planned lines, and the local coordinate frame of their coordinates.
#[derive(Clone, Debug)]
pub struct PlannedLines {
    /// The plan.
    pub plan: Plan,
    /// The local coordinate frame of the plan.
    pub frame: LocalFrame,
    /// First position of the first log, where the boat starts.
    home: LonLat,
    /// Name of the lines.
    name: String,
}

/// Equality compares the lines and the origin of their local coordinate frame, which determine
/// everything else.
impl PartialEq for PlannedLines {
    fn eq(&self, other: &Self) -> bool {
        self.plan.lines == other.plan.lines && self.frame.origin() == other.frame.origin()
    }
}

/// A request about the planned lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanRequest {
    /// Set the settings of the next plan.
    Ask(PlanSettings),
    /// Select a line by its number, or deselect it.
    Select(Option<usize>),
    /// Move an end of a line to a place on the map.
    Move {
        /// Number of the line.
        line: usize,
        /// 0 for the start of the line, 1 for its end.
        end: usize,
        /// New place of the end.
        to: LonLat,
    },
}

/// State of the planned lines.
#[derive(Default)]
pub struct Planning {
    /// Settings of the next plan.
    pub asked: PlanSettings,
    /// The planned lines; `None` if there are none.
    pub lines: Option<Arc<PlannedLines>>,
    /// Number of the line that commands act on; `None` if none is selected.
    pub selected: Option<usize>,
}

impl Planning {
    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self { lines: self.lines.clone(), ..Self::default() }
    }
}

impl App {
    /// Starts to plan lines for all visible logs.
    pub(super) fn plan_lines(&mut self) {
        let shown = self.logs.with_results();
        let Some(first) = shown.first() else {
            let text = "there is no survey to plan from; open a log, and wait for its results";
            return self.notices.warn(text);
        };
        let survey = &first.log.survey;
        let frame = survey.track.frame.clone();
        let home = survey.track.fixes.first().map(|fix| fix.position);
        let home = home.unwrap_or(frame.origin());
        let name = format!("{} lines", survey.name());
        let review = self.survey_review();
        let logs: Vec<_> = shown.into_iter().map(|shown| shown.log).collect();
        let asked = self.map.planning.asked;
        let work = move |progress: &Progress| -> Result<PlannedLines, PlanError> {
            let objects = list_objects(&logs, &review, progress)?;
            let known = survey_coverage(&logs, &objects, progress)?.ok_or(PlanError::NoLog)?;
            let plan = plan(&known, None, &asked, progress)?;
            Ok(PlannedLines { plan, frame, home, name })
        };
        self.jobs.run(JobKey::PlanLines, work, |app, planned| match planned {
            Ok(lines) => app.set_lines(Some(lines), "planned lines"),
            Err(error) => app.notices.warn(error),
        });
    }

    /// Carries out a request about the lines.
    pub(super) fn change_plan(&mut self, request: PlanRequest) {
        match request {
            PlanRequest::Ask(asked) => self.map.planning.asked = asked,
            PlanRequest::Select(line) => self.map.planning.selected = line,
            PlanRequest::Move { line, end, to } => {
                let Some(planned) = self.map.planning.lines.clone() else {
                    return;
                };
                let mut lines = planned.plan.lines.clone();
                let place = planned.frame.to_enu(to);
                match (lines.get_mut(line), end) {
                    (Some(leg), 0) => leg.from = place,
                    (Some(leg), _) => leg.to = place,
                    (None, _) => return,
                }
                self.map.planning.selected = Some(line);
                self.replace_lines(&planned, lines, "end of a planned line");
            }
        }
    }

    /// Removes the selected line.
    pub(super) fn remove_line(&mut self) {
        let Some(planned) = self.map.planning.lines.clone() else {
            return self.notices.warn(NO_LINES);
        };
        let mut lines = planned.plan.lines.clone();
        let selected = self.map.planning.selected.filter(|line| *line < lines.len());
        let Some(line) = selected else {
            return self.notices.warn(NO_LINE);
        };
        lines.remove(line);
        self.replace_lines(&planned, lines, "removed planned line");
    }

    /// Replaces the planned lines; without lines, the plan is removed.
    fn replace_lines(&mut self, planned: &PlannedLines, lines: Vec<Leg>, label: &'static str) {
        let changed = (!lines.is_empty())
            .then(|| PlannedLines { plan: planned.plan.with_lines(lines), ..planned.clone() });
        self.set_lines(changed, label);
    }

    /// Sets the planned lines, as an undo step.
    pub(super) fn set_lines(&mut self, lines: Option<PlannedLines>, label: &'static str) {
        let before = self.step_now();
        self.map.planning.lines = lines.map(Arc::new);
        let count = |lines: &Arc<PlannedLines>| lines.plan.lines.len();
        let count = self.map.planning.lines.as_ref().map_or(0, count);
        self.map.planning.selected = self.map.planning.selected.filter(|line| *line < count);
        self.record_step(&before, label, false);
    }

    /// Writes the planned lines into a file, in the format of the file name's ending.
    pub(super) fn save_plan(&mut self, path: PathBuf) {
        let Some(planned) = self.map.planning.lines.clone() else {
            return self.notices.warn(NO_LINES);
        };
        if self.refuses_log(self.logs.shown.id, &path) {
            return;
        }
        let way = PlannedWay {
            name: &planned.name,
            plan: &planned.plan,
            frame: &planned.frame,
            home: planned.home,
        };
        let format = PlanFormat::of(&path).map_err(AppError::from);
        let written = format.and_then(|format| Ok(way.write(&path, format)?));
        let path = quoted(&path.display().to_string());
        self.notices.tell(written.map(|()| format!("Wrote the planned lines to {path}")));
    }
}
