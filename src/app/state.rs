//! The state behind the window, to read. Commands change it in `apply`, finished workers in `work`.

use super::base_map::OpeningBaseMap;
use super::comparing::Comparing;
use super::deriving::Deriving;
use super::exporting::{Exported, Exporting};
use super::following::Following;
use super::heights::Heights;
use super::isobath_area::ReadingArea;
use super::loader::{Loading, Request};
use super::logs::Logs;
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
use super::reviewing::{Search, Step};
use super::{GivenSettings, Jobs, LoadStatus, LogId, OpenLog, ViewOptions};
use crate::formats::base_map::BaseMap;
use crate::pipeline::{Engine, EngineStatus, Settings, Stage};
use crate::project::{History, LogKey};
use crate::sonar::first_return::FirstReturns;
use crate::support::geo::LocalFrame;
use crate::survey::{Side, Survey, Track};
use std::collections::VecDeque;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// The bundled demo survey.
pub(super) const DEMO: &[u8] = include_bytes!("../../assets/demo.sl2");

/// A place in the survey, the same in all views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Side-scan ping.
    pub ping: usize,
    /// Side, when the place is off the track.
    pub side: Option<Side>,
    /// Distance outward in u8 samples.
    pub sample: Option<f32>,
    /// Point of the cloud.
    pub point: Option<usize>,
}

impl Mark {
    /// A place on the track.
    pub fn ping(ping: usize) -> Self {
        Self {
            ping,
            side: None,
            sample: None,
            point: None,
        }
    }
}

/// A request to bring a place into view; views act when the serial number changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reveal {
    /// The place.
    pub mark: Mark,
    /// Grows with each request.
    pub serial: u64,
    /// What the views enlarge; without it they only bring the place into view.
    pub close_up: Option<CloseUp>,
}

/// How large an object is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enlarged {
    /// It fills about a third of the view.
    Third,
    /// A sample of the picture is a point of the screen; what does not fit in so, with what lies around it, is smaller. For the
    /// waterfall alone: the other views only bring it into view.
    OneToOne,
    /// The scale stays; the box comes into the middle where it is not well in view. For the waterfall alone as well.
    AsItIs,
}

/// An object that the views enlarge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloseUp {
    /// How large.
    pub enlarged: Enlarged,
    /// First ping of its box, and the first one after it.
    pub pings: [usize; 2],
    /// Slant ranges of the edges of its box by the recorder's scale, port negative, metres.
    pub across_m: [f64; 2],
    /// Its place, metres east, north and up in the plane of the survey; `None` where it has none.
    pub place_m: Option<[f64; 3]>,
    /// Its longer side on the ground, metres.
    pub size_m: f64,
}

/// What belongs to the open survey as a whole, whichever log is shown.
pub(super) struct Document {
    /// The settings that a new survey starts from: the preset, or those that the program was started with.
    pub start: Arc<Settings>,
    /// The settings that logs were last given.
    pub given: GivenSettings,
    /// The settings that all logs share.
    pub shared: Arc<Settings>,
    /// The plane that all logs lie in.
    pub plane: LocalFrame,
    /// The metres of a log became those of another system, and the plane was not settled since.
    pub is_plane_moved: bool,
    /// How recorders are mounted as a rule, by [`crate::survey::Source::recorder`].
    pub mountings: Arc<Mountings>,
    /// What undo goes back to.
    pub history: History<Step>,
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

/// The pipeline at work on the open logs.
pub(super) struct PipelineWork {
    pub engine: Engine,
    /// What the engine was asked for last.
    pub requested: Option<(LogId, Arc<Survey>, Arc<Settings>)>,
    /// Nothing is processed before the analyst asks for it: the slider is still held, or the work was stopped.
    pub is_waiting: bool,
    pub previewer: Previewer,
    /// What is made of all logs together.
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

/// Files that are being read or written.
#[derive(Default)]
pub(super) struct FileWork {
    pub loading: Option<Loading>,
    pub to_load: VecDeque<Request>,
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

/// What is searched for in the open logs, and what was found.
#[derive(Default)]
pub(super) struct Findings {
    pub heights: Heights,
    pub positions: Positions,
    pub passes: Passes,
    pub objects: Objects,
    pub search: Search,
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

/// Everything that the window shows.
pub struct App {
    /// The log that waterfall, profile and panels show: the one under the selection.
    pub log: OpenLog,
    pub(super) logs: Logs,
    pub(super) document: Document,
    pub(super) pipeline: PipelineWork,
    pub(super) files: FileWork,
    pub(super) findings: Findings,
    /// Grows when another log is shown; views drop what they cached of it when it changes.
    pub survey_serial: u64,
    /// Grows when the plane of the survey moves: with each survey opened, and with each track applied to it.
    pub plane_serial: u64,
    /// What is selected.
    pub selection: Option<Mark>,
    /// What the pointer is over.
    pub hover: Option<Mark>,
    /// The last request to show a place.
    pub reveal: Option<Reveal>,
    /// Pings in the waterfall.
    pub visible: Range<usize>,
    /// How things are shown.
    pub options: ViewOptions,
    /// Logs opened before, newest first.
    pub recent: Vec<PathBuf>,
    /// What is said on the screen.
    pub notices: Vec<Notice>,
    pub(super) said: NoticeHistory,
    /// The analyst's own picture under the map.
    pub base_map: Option<Arc<BaseMap>>,
    /// What the points are compared with.
    pub comparing: Comparing,
    /// What is drawn on the map to measure.
    pub measuring: Measuring,
    /// Lines to sail next.
    pub planning: Planning,
    pub(super) following: Following,
    /// Only a picture is drawn of it: views leave their buttons out.
    pub is_picture: bool,
    /// The folder that was written last.
    pub written_into: Option<PathBuf>,
    pub(super) jobs: Jobs,
}

impl App {
    /// An empty window.
    pub fn new(jobs: Jobs) -> Self {
        Self {
            log: OpenLog::default(),
            logs: Logs::default(),
            document: Document::default(),
            pipeline: PipelineWork::new(jobs.clone()),
            files: FileWork::default(),
            findings: Findings::default(),
            survey_serial: 0,
            plane_serial: 0,
            selection: None,
            hover: None,
            reveal: None,
            visible: 0..0,
            options: ViewOptions::default(),
            recent: Vec::new(),
            notices: Vec::new(),
            said: NoticeHistory::default(),
            base_map: None,
            comparing: Comparing::default(),
            measuring: Measuring::default(),
            planning: Planning::default(),
            following: Following::default(),
            is_picture: false,
            written_into: None,
            jobs,
        }
    }

    /// The first returns to draw: those under the slider if there are any, else those of the last result.
    pub fn returns(&self) -> Option<&Arc<FirstReturns>> {
        self.log.returns()
    }

    /// The bottom line to draw over the waterfall: what the picture is laid out by, or the first returns under the slider.
    pub fn bottom_line(&self) -> Option<&Arc<FirstReturns>> {
        self.log.bottom_line()
    }

    /// The first stage whose result is older than its settings.
    pub fn stale(&self) -> Option<Stage> {
        self.log.stale()
    }

    /// Whether results are missing or older than their settings and nothing is under way to change that.
    pub fn is_stopped(&self) -> bool {
        self.log.is_behind() && self.engine_status() == EngineStatus::Idle
    }

    /// How work in a background thread is run.
    pub fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    /// What the engine does.
    pub fn engine_status(&self) -> EngineStatus {
        self.pipeline.engine.status()
    }

    /// What is being opened.
    pub fn load_status(&self) -> Option<LoadStatus> {
        self.files.loading.as_ref().map(Loading::status)
    }

    /// Done share of the export under way, 0 to 1.
    pub fn export_fraction(&self) -> Option<f32> {
        self.files.exporting.as_ref().map(Exporting::fraction)
    }

    /// Whether nothing is being opened, computed or written.
    pub fn is_idle(&self) -> bool {
        let is_busy = self.pipeline.is_busy()
            || self.files.is_busy()
            || self.findings.is_busy()
            || self.planning.is_busy()
            || self.following.is_busy()
            || self.comparing.is_opening()
            || self.logs().any(OpenLog::is_busy);
        !is_busy
    }
}
