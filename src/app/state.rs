//! The state behind the window, to read. Commands change it in `apply`, finished workers in `work`.

use super::base_map::OpeningBaseMap;
use super::bottom::BottomFile;
use super::comparing::Comparing;
use super::exporting::Exporting;
use super::external::External;
use super::loader::Loading;
use super::measuring::Measuring;
use super::preview::Previewer;
use super::reviewing::{Reviewing, Step};
use super::tabulating::Tabulating;
use super::{Action, Figures, History, LoadStatus, Task, ViewOptions};
use crate::base_map::BaseMap;
use crate::first_return::FirstReturns;
use crate::pipeline::{Engine, EngineStatus, Products, Settings, Stage};
use crate::survey::{Side, Survey};
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
}

/// A sentence for the analyst.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// What happened and what to do.
    pub text: String,
    /// Something could not be done (otherwise: something was).
    pub is_error: bool,
    /// What can be done about it.
    pub offer: Option<Action>,
}

/// How work off the window's thread is run.
#[derive(Clone)]
pub enum Jobs {
    /// On worker threads, which call this when there is something to show.
    Threads(Arc<dyn Fn() + Send + Sync>),
    /// Inside the call: tests and headless pictures.
    Inline,
}

/// Everything that the window shows.
pub struct App {
    /// The open survey.
    pub survey: Option<Arc<Survey>>,
    /// Shallowest and deepest sounding of the open survey that the recorder had the bottom for, metres.
    pub depth_span_m: Option<[f32; 2]>,
    /// Soundings of the open survey after the recorder had lost the bottom.
    pub lost_soundings: usize,
    /// Grows with each survey opened; views drop what they cached when it changes.
    pub survey_serial: u64,
    /// Grows when the plane of the survey moves: with each survey opened, and with each track laid over it.
    pub plane_serial: u64,
    /// The settings that the analyst wants.
    pub settings: Settings,
    /// The last results; those of other settings while the engine works.
    pub products: Option<Products>,
    /// First returns of the settings under the slider, ahead of `products`.
    pub preview: Option<Arc<FirstReturns>>,
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
    /// What to tell.
    pub notices: Vec<Notice>,
    /// Counts and residuals of `products`; those of the last products until the new ones are counted.
    pub figures: Option<Figures>,
    /// The analyst's own picture under the map.
    pub base_map: Option<Arc<BaseMap>>,
    /// What the points are held against.
    pub comparing: Comparing,
    /// Water levels and tracks that other instruments recorded.
    pub external: External,
    /// What is drawn on the map to measure.
    pub measuring: Measuring,
    /// The boxes and what is decided about them.
    pub reviewing: Reviewing,
    /// Only a picture is drawn of it: views leave their buttons out.
    pub is_picture: bool,
    pub(super) history: History<Step>,
    pub(super) engine: Engine,
    pub(super) previewer: Previewer,
    pub(super) loading: Option<Loading>,
    pub(super) counting: Option<Task<Option<Figures>>>,
    pub(super) tabulating: Tabulating,
    pub(super) exporting: Option<Exporting>,
    pub(super) opening_base_map: Option<OpeningBaseMap>,
    pub(super) bottom_file: BottomFile,
    pub(super) jobs: Jobs,
}

impl App {
    /// An empty window.
    pub fn new(jobs: Jobs) -> Self {
        let engine = match &jobs {
            Jobs::Threads(waker) => Engine::new(waker.clone()),
            Jobs::Inline => Engine::inline(),
        };
        Self {
            survey: None,
            depth_span_m: None,
            lost_soundings: 0,
            survey_serial: 0,
            plane_serial: 0,
            settings: Settings::default(),
            products: None,
            preview: None,
            selection: None,
            hover: None,
            reveal: None,
            visible: 0..0,
            options: ViewOptions::default(),
            recent: Vec::new(),
            notices: Vec::new(),
            figures: None,
            base_map: None,
            comparing: Comparing::default(),
            external: External::default(),
            measuring: Measuring::default(),
            reviewing: Reviewing::default(),
            is_picture: false,
            history: History::default(),
            engine,
            previewer: Previewer::default(),
            loading: None,
            counting: None,
            tabulating: Tabulating::default(),
            exporting: None,
            opening_base_map: None,
            bottom_file: BottomFile::default(),
            jobs,
        }
    }

    /// The first returns to draw: those under the slider if there are any, else those of the last result.
    pub fn returns(&self) -> Option<&Arc<FirstReturns>> {
        self.preview
            .as_ref()
            .or_else(|| self.products.as_ref().map(|products| &products.returns))
    }

    /// The first stage whose result is older than its settings.
    pub fn stale(&self) -> Option<Stage> {
        let products = self.products.as_ref()?;
        Stage::first_stale(&products.settings, &self.settings)
    }

    /// Whether results are missing or older than their settings and nothing is under way to change that.
    pub fn is_stopped(&self) -> bool {
        let behind = self.products.is_none() || self.stale().is_some();
        self.survey.is_some() && behind && self.engine_status() == EngineStatus::Idle
    }

    /// Name of the change that undo would take back.
    pub fn undo_label(&self) -> Option<&'static str> {
        self.history.undo_label()
    }

    /// Name of the change that redo would do again.
    pub fn redo_label(&self) -> Option<&'static str> {
        self.history.redo_label()
    }

    /// How work off the window's thread is run.
    pub fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    /// What the engine does.
    pub fn engine_status(&self) -> EngineStatus {
        self.engine.status()
    }

    /// What is being opened.
    pub fn load_status(&self) -> Option<LoadStatus> {
        self.loading.as_ref().map(Loading::status)
    }

    /// Done share of the export under way, 0 to 1.
    pub fn export_fraction(&self) -> Option<f32> {
        self.exporting.as_ref().map(Exporting::fraction)
    }

    /// Whether nothing is being opened, computed or written.
    pub fn is_idle(&self) -> bool {
        self.loading.is_none()
            && self.engine_status() == EngineStatus::Idle
            && !self.previewer.is_busy()
            && self.counting.is_none()
            && !self.tabulating.is_busy()
            && !self.comparing.is_opening()
            && self.exporting.is_none()
            && self.opening_base_map.is_none()
            && !self.external.is_reading()
            && !self.reviewing.is_busy()
    }
}
