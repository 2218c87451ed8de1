//! Gives the steps of the work on a survey their titles and commands, and finds the state of each.

use super::options::WorkStep;
use super::{Action, App, Command, JobKey};
use bathyscope_bottom::presentation::text::count;
use bathyscope_log::survey::SideScanState;
use bathyscope_products::pipeline::{Products, Stage};

/// State of the results of a step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum StepState {
    /// There is no result.
    Open,
    /// There is a result, and nothing about it is in doubt.
    Done,
    /// There is a result, and the analyst should look at something: a sentence, in metres.
    NeedsLook(String),
    /// The result was made with other settings.
    OutOfDate,
    /// The result is being made; the done share, 0 to 1, where it is known.
    Running(Option<f32>),
}

/// Share of first returns above the recorded depth from which they need a look.
const MANY_ABOVE: f64 = 0.05;

impl WorkStep {
    /// Returns the number of the step, which is its key with Alt: 1 to 6.
    pub(crate) fn number(self) -> usize {
        self as usize + 1
    }

    /// Returns the command that opens the step.
    pub(crate) fn action(self) -> Action {
        match self {
            WorkStep::Logs => Action::StepLogs,
            WorkStep::Bottom => Action::StepBottom,
            WorkStep::Correct => Action::StepCorrect,
            WorkStep::Map => Action::StepMap,
            WorkStep::Objects => Action::StepObjects,
            WorkStep::Export => Action::StepExport,
        }
    }

    /// Returns the title of the step.
    pub(crate) fn title(self) -> &'static str {
        let label = self.action().label();
        label.split_once(": ").map_or(label, |(_, title)| title)
    }

    /// Returns the title of the step for a narrow window.
    pub(crate) fn short_title(self) -> &'static str {
        match self {
            WorkStep::Logs => "Logs",
            WorkStep::Bottom => "Bottom",
            WorkStep::Correct => "Correct",
            WorkStep::Map => "Map",
            WorkStep::Objects => "Objects",
            WorkStep::Export => "Export",
        }
    }

    /// Returns the sentence of the tour: what the analyst does in this step.
    pub(crate) fn tour(self) -> &'static str {
        match self {
            WorkStep::Logs => {
                "Open the logs of a survey here; where they differ in height, the program says by how much."
            }
            WorkStep::Bottom => {
                "Look whether the lines follow the first echo of the bottom on both sides, and draw it where they do not."
            }
            WorkStep::Correct => {
                "Give the draft and the water level, so that depths count from the surface; a flat stretch checks the scale."
            }
            WorkStep::Map => {
                "Choose isobaths and cell size of the depth map; the pointer tells the depth at a place and its error."
            }
            WorkStep::Objects => {
                "Find objects, and accept or reject each with A and R; sizes and heights are measured from echo and shadow."
            }
            WorkStep::Export => {
                "Look how well side-scan and soundings agree, and write maps, points and the report into a folder."
            }
        }
    }

    /// Returns the step after this one; `None` after the last.
    pub(crate) fn next(self) -> Option<WorkStep> {
        WorkStep::ALL.get(self.number()).copied()
    }

    /// Returns the state of the step for the shown log.
    pub(crate) fn state(self, app: &App) -> StepState {
        match self {
            WorkStep::Logs => logs(app),
            WorkStep::Bottom => {
                of_stages(app, Stage::FirstReturn, |products| bottom(app, products))
            }
            // Draft, water level and sound speed act on the cloud.
            WorkStep::Correct => of_stages(app, Stage::Cloud, |products| correct(app, products)),
            WorkStep::Map => map(app),
            WorkStep::Objects => objects(app),
            WorkStep::Export => export(app),
        }
    }
}

impl App {
    /// Shows the tour from its first step, over the demo survey unless a survey is open.
    pub(super) fn start_tour(&mut self) {
        if self.logs.shown.survey.is_none() {
            self.apply(Command::OpenDemo);
        }
        self.view.options.panels.step = WorkStep::Logs;
        self.view.has_tour = true;
    }
}

/// State of a stage's result in relation to its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Freshness {
    /// The result is that of the settings.
    Fresh,
    /// The result was made with other settings, and no work is running to update it.
    OutOfDate,
    /// The result is made again after the stages before it.
    Waiting,
    /// The result is being made; the done share, 0 to 1.
    Running(f32),
}

impl Freshness {
    /// Returns the state of the result of a stage for the shown log.
    pub(crate) fn of(app: &App, stage: Stage) -> Self {
        match app.running_stage() {
            Some((running, share)) if running == stage => return Self::Running(share),
            Some((running, _)) if running < stage => return Self::Waiting,
            _ => {}
        }
        match app.logs.shown.stale() {
            Some(first) if first <= stage && app.is_stopped() => Self::OutOfDate,
            Some(first) if first <= stage => Self::Waiting,
            _ => Self::Fresh,
        }
    }
}

/// Returns the state of a step whose last stage is `last`: with a sentence from `doubt` if
/// something about the result needs a look.
fn of_stages(app: &App, last: Stage, doubt: impl FnOnce(&Products) -> Option<String>) -> StepState {
    match (Freshness::of(app, last), &app.logs.shown.products) {
        (Freshness::Running(share), _) => StepState::Running(Some(share)),
        (Freshness::Waiting, _) => StepState::Running(None),
        (_, None) => StepState::Open,
        (Freshness::OutOfDate, Some(_)) => StepState::OutOfDate,
        (Freshness::Fresh, Some(products)) => {
            doubt(products).map_or(StepState::Done, StepState::NeedsLook)
        }
    }
}

fn logs(app: &App) -> StepState {
    if let Some(share) = app.jobs.fraction(&JobKey::OpenLog) {
        return StepState::Running(Some(share));
    }
    let Some(survey) = &app.logs.shown.survey else {
        return StepState::Open;
    };
    let of_heights = app.unlevelled();
    let apart = || app.logs.all().any(|log| log.apart.is_some());
    let apart = || apart().then(|| "A log is not on the map.".to_owned());
    let warned = || match survey.warnings.len() {
        0 => None,
        1 => Some("The log has a warning.".to_owned()),
        several => Some(format!("The log has {} warnings.", count(several))),
    };
    of_heights.or_else(apart).or_else(warned).map_or(StepState::Done, StepState::NeedsLook)
}

fn bottom(app: &App, products: &Products) -> Option<String> {
    let survey = app.logs.shown.survey.as_ref()?;
    if survey.side_scan_state != SideScanState::Usable {
        return Some("The log has no side-scan.".to_owned());
    }
    if let Some(warning) = products.bottom_line.warnings.first() {
        return Some(warning.clone());
    }
    let figures = app.logs.shown.figures.as_ref()?;
    let (above, all) = (figures.above_bottom.count, figures.port_picks + figures.starboard_picks);
    (above as f64 > MANY_ABOVE * all as f64).then(|| {
        format!("{} of {} first returns are above the recorded depth.", count(above), count(all))
    })
}

fn correct(app: &App, products: &Products) -> Option<String> {
    let correction = &products.correction;
    let lack = match [correction.knows_draft(), correction.knows_level()] {
        [true, true] => None,
        [false, false] => Some("Draft and water level are not given."),
        [false, true] => Some("The draft is not given."),
        [true, false] => Some("The water level is not given."),
    };
    let scale = || products.calibration.warnings.first().cloned();
    let exclusions =
        || app.logs.shown.exclusions().and_then(|found| found.exclusions.warnings.first().cloned());
    correction.gap_warning().or_else(scale).or_else(exclusions).or(lack.map(str::to_owned))
}

fn map(app: &App) -> StepState {
    if app.jobs.is_running(&JobKey::DepthMap) {
        return StepState::Running(app.jobs.fraction(&JobKey::DepthMap));
    }
    of_stages(app, Stage::Relief, |_| {
        // A map that nothing shows is not made.
        matches!(app.depth_map(), Some(None)).then(|| "The depths span no surface.".to_owned())
    })
}

fn objects(app: &App) -> StepState {
    if let Some(status) = app.search_status() {
        return StepState::Running(Some(status.share));
    }
    if !app.logs.has_boxes() {
        return StepState::Open;
    }
    let undecided = app.logs.review_counts().boxes.proposed;
    match (undecided, app.search_note()) {
        (0, None) => StepState::Done,
        (0, Some(note)) => StepState::NeedsLook(note),
        (1, _) => StepState::NeedsLook("A box is undecided.".to_owned()),
        (several, _) => StepState::NeedsLook(format!("{} boxes are undecided.", count(several))),
    }
}

fn export(app: &App) -> StepState {
    if let Some(share) = app.jobs.fraction(&JobKey::Export) {
        return StepState::Running(Some(share));
    }
    match (&app.files.exported, app.out_of_date()) {
        (None, _) => StepState::Open,
        (Some(_), Some(_)) => StepState::OutOfDate,
        (Some(_), None) => StepState::Done,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_has_its_number_in_its_command_and_key() {
        for step in WorkStep::ALL {
            let (action, number) = (step.action(), step.number());
            assert_eq!(action.label(), format!("Step {number}: {}", step.title()));
            assert_eq!(action.key(), format!("Alt+{number}"));
        }
    }
}
