//! Holds the state of the window for reading; commands change it in `apply`, finished background
//! work in `work`.

use super::base_map::OpeningBaseMap;
use super::card_search::CardSearch;
use super::comparing::Comparing;
use super::deriving::Deriving;
use super::exporting::{Exported, Exporting};
use super::file_watch::FileWatch;
use super::following::Following;
use super::heights::Heights;
use super::isobath_area::ReadingArea;
use super::loader::{Loading, OpenRequest};
use super::logs::OpenLogs;
use super::measuring::Measuring;
use super::mounting::Mountings;
use super::notices::{Notice, NoticeHistory};
use super::objects::Objects;
use super::passes::Passes;
use super::planning::Planning;
use super::positions::Positions;
use super::preview::Previewer;
use super::project::ProjectSaving;
use super::reference_comparison::ReferenceComparison;
use super::reviewing::ObjectSearch;
use super::step::UndoStep;
use super::{GivenSettings, Jobs, LoadStatus, LogId, LogPlace, OpenLog, Reveal, ViewOptions};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::formats::base_map::BaseMap;
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::survey::{Survey, Track};
use bathyscope_products::pipeline::{Engine, EngineStatus, Settings, Stage};
use bathyscope_products::project::{History, LogKey};
use std::collections::VecDeque;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// State of the open survey as a whole, whichever log is shown.
pub(super) struct Document {
    /// The settings from which a new survey starts: the preset, or the settings that the program
    /// was started with.
    pub start: Arc<Settings>,
    /// The last settings of each log.
    pub given: GivenSettings,
    /// The settings that all logs share.
    pub shared: Arc<Settings>,
    /// The local coordinate frame of the plane that all logs share.
    pub plane: LocalFrame,
    /// True if the coordinate system of a log's metres has changed, and the plane was not chosen
    /// again since.
    pub is_plane_moved: bool,
    /// Default mounting of recorders, by [`bathyscope_log::survey::Source::recorder`].
    pub mountings: Arc<Mountings>,
    /// Steps that undo goes back to.
    pub history: History<UndoStep>,
}

impl Default for Document {
    fn default() -> Self {
        Self {
            start: Arc::default(),
            given: GivenSettings::default(),
            shared: Arc::default(),
            plane: Track::default().frame,
            is_plane_moved: false,
            mountings: Arc::default(),
            history: History::default(),
        }
    }
}

/// State of the pipeline.
pub(super) struct PipelineWork {
    pub engine: Engine,
    /// Last request to the engine.
    pub requested: Option<(LogId, Arc<Survey>, Arc<Settings>)>,
    /// True if nothing is processed until the analyst requests it: the slider is still held, or the
    /// work was stopped.
    pub is_waiting: bool,
    pub previewer: Previewer,
    /// Results that are derived from the open logs.
    pub deriving: Deriving,
}

impl PipelineWork {
    fn new(jobs: Jobs) -> Self {
        Self {
            engine: Engine::new(jobs),
            requested: None,
            is_waiting: false,
            previewer: Previewer::default(),
            deriving: Deriving::default(),
        }
    }

    fn is_busy(&self) -> bool {
        self.engine.status() != EngineStatus::Idle
            || self.previewer.is_busy()
            || self.deriving.is_busy()
    }
}

/// State of reading and writing files.
#[derive(Default)]
pub(super) struct FileWork {
    pub loading: Option<Loading>,
    pub to_load: VecDeque<OpenRequest>,
    pub opening_base_map: Option<OpeningBaseMap>,
    pub reading_area: ReadingArea,
    pub exporting: Option<Exporting>,
    pub exported: Option<Exported>,
    pub project_saving: ProjectSaving,
    /// Logs of the project that were not found.
    pub missing: Vec<LogKey>,
}

impl FileWork {
    fn is_busy(&self) -> bool {
        self.loading.is_some()
            || self.opening_base_map.is_some()
            || self.reading_area.is_busy()
            || self.exporting.is_some()
            || self.project_saving.is_busy()
    }
}

/// State and results of searches over the open logs.
#[derive(Default)]
pub(super) struct Findings {
    pub heights: Heights,
    pub positions: Positions,
    pub passes: Passes,
    pub objects: Objects,
    pub search: ObjectSearch,
    pub reference_comparison: ReferenceComparison,
}

impl Findings {
    fn is_busy(&self) -> bool {
        self.heights.is_busy()
            || self.positions.is_busy()
            || self.passes.is_busy()
            || self.objects.is_busy()
            || self.search.is_busy()
            || self.search.is_busy_with_tail()
            || self.reference_comparison.is_busy()
    }
}

/// Display state of the views.
#[derive(Default)]
pub struct ViewState {
    /// Number that grows when another log is shown; views then drop what they cached of the earlier
    /// log.
    pub survey_serial: u64,
    /// Number that grows when the plane of the survey moves: with each survey opened, and with each
    /// track applied to it.
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
    /// True if only a picture is drawn from this state: views then draw no buttons.
    pub is_picture: bool,
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
    /// The log that waterfall, profile and panels show, and that the selection refers to.
    pub log: OpenLog,
    pub(super) logs: OpenLogs,
    pub(super) document: Document,
    pub(super) pipeline: PipelineWork,
    pub(super) files: FileWork,
    pub(super) findings: Findings,
    /// Display state of the views.
    pub view: ViewState,
    /// Base map, reference, measurement and planned lines that the analyst adds to the map.
    pub map: MapWork,
    /// Logs that were opened before, the newest first.
    pub recent: Vec<PathBuf>,
    /// Notices on the screen.
    pub notices: Vec<Notice>,
    pub(super) said: NoticeHistory,
    pub(super) following: Following,
    pub(super) file_watch: FileWatch,
    pub(super) card_search: CardSearch,
    /// The folder that was written last; `None` if none was.
    pub written_into: Option<PathBuf>,
    pub(super) jobs: Jobs,
}

impl App {
    /// Creates the state of an empty window.
    pub fn new(jobs: Jobs) -> Self {
        Self {
            log: OpenLog::default(),
            logs: OpenLogs::default(),
            document: Document::default(),
            pipeline: PipelineWork::new(jobs.clone()),
            files: FileWork::default(),
            findings: Findings::default(),
            view: ViewState::default(),
            map: MapWork::default(),
            recent: Vec::new(),
            notices: Vec::new(),
            said: NoticeHistory::default(),
            following: Following::default(),
            file_watch: FileWatch::default(),
            card_search: CardSearch::default(),
            written_into: None,
            jobs,
        }
    }

    /// Returns the first returns to draw: those by the settings under the slider if there are any,
    /// else those of the last results.
    pub fn returns(&self) -> Option<&Arc<FirstReturns>> {
        self.log.returns()
    }

    /// Returns the bottom line to draw over the waterfall: the line by which the picture is laid
    /// out, or the first returns by the settings under the slider.
    pub fn bottom_line(&self) -> Option<&Arc<FirstReturns>> {
        self.log.bottom_line()
    }

    /// Returns the first stage whose result is older than its settings; `None` if there is none.
    pub fn stale(&self) -> Option<Stage> {
        self.log.stale()
    }

    /// Returns true if results are missing or older than their settings, and no work is running to
    /// update them.
    pub(crate) fn is_stopped(&self) -> bool {
        self.log.is_behind() && self.engine_status() == EngineStatus::Idle
    }

    /// Returns the runner of work in background threads.
    pub fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    /// Returns the state of the engine.
    pub(crate) fn engine_status(&self) -> EngineStatus {
        self.pipeline.engine.status()
    }

    /// Returns the name and progress of the log that is being opened; `None` if none is.
    pub(crate) fn load_status(&self) -> Option<LoadStatus> {
        self.files.loading.as_ref().map(Loading::status)
    }

    /// Returns the done share of the running export, 0 to 1; `None` if none is running.
    pub(crate) fn export_fraction(&self) -> Option<f32> {
        self.files.exporting.as_ref().map(Exporting::fraction)
    }

    /// Returns true if nothing is being opened, computed or written.
    pub fn is_idle(&self) -> bool {
        let is_busy = self.pipeline.is_busy()
            || self.files.is_busy()
            || self.findings.is_busy()
            || self.map.planning.is_busy()
            || self.following.is_busy()
            || self.map.comparing.is_opening()
            || self.logs().any(OpenLog::is_busy);
        !is_busy
    }
}
