//! Holds the state of the window, which views only read. Commands change the state in `apply`;
//! results of background work change it through `jobs`.

use super::comparing::{Comparing, ReferenceComparison};
use super::crossings::{FoundPositions, Heights};
use super::deriving::Deriving;
use super::exporting::Exported;
use super::following::Following;
use super::history::UndoStep;
use super::jobs::{JobKey, JobQueue};
use super::logs::OpenLogs;
use super::measuring::Measuring;
use super::notices::Notices;
use super::objects::Objects;
use super::opening::OpenRequest;
use super::passes::Passes;
use super::planning::Planning;
use super::processing::{Previewer, ProcessRequest};
use super::project::ProjectSaving;
use super::reviewing::ObjectSearch;
use super::source::Mountings;
use super::watching::{CardSearch, FileWatch};
use super::{Jobs, LogPlace, Reveal, ViewOptions};
use bathyscope_log::formats::base_map::BaseMap;
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_products::pipeline::{Settings, Stage};
use bathyscope_products::project::{History, LogKey};
use std::collections::VecDeque;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// State of the open survey as a whole, whichever log is shown.
#[derive(Default)]
pub struct Document {
    /// The settings from which a new survey starts: the default settings, or those that the program
    /// was started with, without the settings that belong to one survey.
    pub(super) start: Arc<Settings>,
    /// The settings that all logs share.
    pub shared: Arc<Settings>,
    /// The local coordinate frame of the plane that all logs share.
    pub(super) plane: LocalFrame,
    /// True if the plane must be chosen again: the coordinate system of a log has changed, or
    /// distant logs were hidden.
    pub(super) is_plane_moved: bool,
    /// Default mounting of recorders, by [`bathyscope_log::survey::Source::recorder`].
    pub mountings: Arc<Mountings>,
    /// Steps that undo goes back to.
    pub history: History<UndoStep>,
}

/// State of the pipeline.
#[derive(Default)]
pub struct PipelineWork {
    /// The last request to process a log; `None` once it has succeeded or failed. A request whose
    /// work was stopped stays here.
    pub(super) requested: Option<ProcessRequest>,
    /// True if nothing is processed until the analyst requests it, for example because a slider is
    /// still held, or the work was stopped or failed.
    pub(super) is_waiting: bool,
    pub(super) previewer: Previewer,
    /// Results that are derived from the open logs.
    pub deriving: Deriving,
}

/// State of reading and writing files.
#[derive(Default)]
pub struct FileWork {
    /// Name of the log that was opened last, or is being opened.
    pub(super) loading: String,
    pub(super) to_load: VecDeque<OpenRequest>,
    pub(super) exported: Option<Exported>,
    /// State of the open project and its file.
    pub project_saving: ProjectSaving,
    /// Folder in which untitled projects are saved: decisions about logs that are in no named
    /// project. The first decision creates the folder. `None` if only requested files are written.
    pub untitled_folder: Option<PathBuf>,
    /// Logs of the project that were not found.
    pub(super) missing: Vec<LogKey>,
}

/// State and results of searches over the open logs.
#[derive(Default)]
pub struct Findings {
    /// Comparison of heights.
    pub heights: Heights,
    /// Comparison of positions; `None` before the first one.
    pub positions: Option<FoundPositions>,
    pub(super) passes: Passes,
    /// Search for objects.
    pub search: ObjectSearch,
    /// Comparison with the reference.
    pub reference_comparison: ReferenceComparison,
}

/// Display state of the views.
#[derive(Default)]
pub struct ViewState {
    /// Number that grows when another log is shown; views then drop what they cached of the earlier
    /// log.
    pub survey_serial: u64,
    /// Number that grows each time the plane of the survey is set.
    pub plane_serial: u64,
    /// Selected place.
    pub selection: Option<LogPlace>,
    /// Place under the pointer.
    pub hover: Option<LogPlace>,
    /// The last request to show a place.
    pub reveal: Option<Reveal>,
    /// Pings that the waterfall shows.
    pub visible: Range<usize>,
    /// Display options.
    pub options: ViewOptions,
    /// True while the tour of the steps is shown.
    pub has_tour: bool,
    /// True if only a picture is drawn from this state: views then draw no buttons.
    pub is_picture: bool,
}

impl ViewState {
    /// Selects a place, and requests that the views show it.
    pub(super) fn reveal(&mut self, mark: LogPlace) {
        let serial = self.reveal.map_or(0, |reveal| reveal.serial) + 1;
        self.selection = Some(mark);
        self.reveal = Some(Reveal { mark, serial, close_up: None });
    }
}

/// Base map, reference, measurement and planned lines that the analyst adds to the map.
#[derive(Default)]
pub struct MapWork {
    /// The analyst's own picture under the map.
    pub base_map: Option<Arc<BaseMap>>,
    /// Reference that the points are compared with.
    pub comparing: Comparing,
    /// Figure that is drawn on the map to measure, and its tool.
    pub measuring: Measuring,
    /// State of the planned survey lines.
    pub planning: Planning,
}

/// State of the whole window.
pub struct App {
    /// The open logs.
    pub logs: OpenLogs,
    /// State of the open survey as a whole.
    pub document: Document,
    /// State of the pipeline.
    pub pipeline: PipelineWork,
    /// State of reading and writing files.
    pub files: FileWork,
    /// Results of searches over the open logs.
    pub findings: Findings,
    /// The objects of the visible logs.
    pub objects: Objects,
    /// Display state of the views.
    pub view: ViewState,
    /// Base map, reference, measurement and planned lines that the analyst adds to the map.
    pub map: MapWork,
    /// Paths of logs and projects that were opened or saved before, the last one first.
    pub recent: Vec<PathBuf>,
    /// Notices to the analyst.
    pub notices: Notices,
    /// The followed log.
    pub following: Following,
    pub(super) file_watch: FileWatch,
    /// Search of cards and drives for logs.
    pub card_search: CardSearch,
    /// Folder that the last export wrote into; `None` if nothing was exported, or if something else
    /// than a folder of products was written since.
    pub written_into: Option<PathBuf>,
    /// Work in the background.
    pub(crate) jobs: JobQueue,
}

impl App {
    /// Creates the state of an empty window.
    pub fn new(workers: Jobs) -> Self {
        Self {
            logs: OpenLogs::default(),
            document: Document::default(),
            pipeline: PipelineWork::default(),
            files: FileWork::default(),
            findings: Findings::default(),
            objects: Objects::default(),
            view: ViewState::default(),
            map: MapWork::default(),
            recent: Vec::new(),
            notices: Notices::default(),
            following: Following::default(),
            file_watch: FileWatch::default(),
            card_search: CardSearch::default(),
            written_into: None,
            jobs: JobQueue::new(workers),
        }
    }

    /// Returns true if results of the shown log are missing or older than its settings, and no log
    /// is being processed.
    pub(crate) fn is_stopped(&self) -> bool {
        self.logs.shown.is_behind() && !self.jobs.is_running(&JobKey::Process)
    }

    /// Returns the running stage of the pipeline and its progress, 0 to 1; `None` if no log is
    /// being processed.
    pub(crate) fn running_stage(&self) -> Option<(Stage, f32)> {
        let fraction = self.jobs.fraction(&JobKey::Process)?;
        Some((self.pipeline.requested.as_ref()?.stage(), fraction))
    }

    /// Returns the description of the work that the analyst waits for, and its progress, 0 to 1;
    /// `None` if there is no such work.
    pub fn awaited(&self) -> Option<(String, f32)> {
        if let Some(fraction) = self.jobs.fraction(&JobKey::OpenLog) {
            return Some((format!("opening {}", self.files.loading), fraction));
        }
        if let Some((stage, fraction)) = self.running_stage() {
            return Some((stage.name().to_owned(), fraction));
        }
        let (key, fraction) = self.jobs.requested()?;
        let search = self.search_status().filter(|_| *key == JobKey::SearchObjects);
        Some((key.name().to_owned(), search.map_or(fraction, |search| search.share)))
    }

    /// Returns true if nothing is being opened, computed or written.
    pub fn is_idle(&self) -> bool {
        let is_waiting = self.findings.search.is_busy() || self.following.is_ending();
        !self.jobs.is_busy() && !is_waiting
    }
}
