//! The state behind the window, and how commands change it.

use super::loader::Loading;
use super::{
    Action, Command, History, LoadStatus, Orientation, Origin, SideColours, ThemeChoice,
    ViewOptions,
};
use crate::calibration::PingRange;
use crate::first_return::FirstReturns;
use crate::pipeline::{Engine, EngineStatus, Preset, Products, Settings, Stage};
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
    /// Grows with each survey opened; views drop what they cached when it changes.
    pub survey_serial: u64,
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
    pub(super) history: History<Settings>,
    pub(super) engine: Engine,
    pub(super) loading: Option<Loading>,
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
            survey_serial: 0,
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
            history: History::default(),
            engine,
            loading: None,
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

    /// Whether nothing is being opened or computed.
    pub fn is_idle(&self) -> bool {
        self.loading.is_none() && self.engine_status() == EngineStatus::Idle
    }

    /// Collects what the workers finished. Call once a frame.
    pub fn poll(&mut self) {
        if let Some(outcome) = self.loading.as_ref().and_then(Loading::poll)
            && let Some(loading) = self.loading.take()
        {
            match outcome {
                Ok(survey) => self.take_survey(survey, loading.origin),
                Err(text) => self.tell(text, true),
            }
        }
        match self.engine.poll() {
            Some(Ok(products)) => {
                self.preview = None;
                self.products = Some(products);
            }
            Some(Err(text)) => self.tell(text, true),
            None => {}
        }
    }

    fn take_survey(&mut self, survey: Survey, origin: Origin) {
        if let Origin::Path(path) = origin {
            self.recent.retain(|recent| *recent != path);
            self.recent.insert(0, path);
            self.recent.truncate(10);
        }
        self.survey = Some(Arc::new(survey));
        self.survey_serial += 1;
        self.products = None;
        self.preview = None;
        self.selection = None;
        self.hover = None;
        self.visible = 0..0;
        // A flat spot belongs to the survey that it was picked in.
        self.settings.calibration.pings = None;
        self.history = History::default();
        self.process();
    }

    fn process(&mut self) {
        if let Some(survey) = &self.survey {
            self.engine
                .request(survey.clone(), self.settings.clone(), self.products.clone());
        }
    }

    fn tell(&mut self, text: String, is_error: bool) {
        self.notices.push(Notice { text, is_error });
    }

    fn start_loading(&mut self, origin: Origin) {
        self.loading = Some(Loading::start(origin, &self.jobs));
    }

    /// Carries out a command. Those that only the window can do are left to it.
    pub fn apply(&mut self, command: Command) {
        match command {
            Command::Do(action) => self.act(action),
            Command::Open(path) => self.start_loading(Origin::Path(path)),
            Command::OpenDemo => self.start_loading(Origin::Demo),
            Command::Change {
                settings,
                label,
                live,
            } => self.change(*settings, label, live),
            Command::UsePreset(preset) => self.use_preset(preset),
            Command::CalibrateAt(pings) => self.calibrate_at(pings),
            Command::Show(options) => self.options = *options,
            Command::Hover(mark) => self.hover = mark,
            Command::Select(mark) => self.selection = mark,
            Command::Reveal(mark) => self.reveal(mark),
            Command::Visible(pings) => self.visible = pings,
            Command::Dismiss(index) => {
                if index < self.notices.len() {
                    self.notices.remove(index);
                }
            }
            Command::Focus(_) | Command::Layout(_) | Command::Export(_) => {}
        }
    }

    fn change(&mut self, settings: Settings, label: &'static str, live: bool) {
        if let Err(error) = settings.check() {
            self.tell(error.to_string(), true);
            return;
        }
        self.history.record(&self.settings, &settings, label, live);
        self.set(settings);
    }

    fn set(&mut self, settings: Settings) {
        if settings != self.settings {
            self.settings = settings;
            self.process();
        }
    }

    fn use_preset(&mut self, preset: Preset) {
        let mut settings = Settings::preset(preset);
        settings.calibration.pings = self.settings.calibration.pings;
        self.change(settings, "preset", false);
    }

    fn calibrate_at(&mut self, pings: PingRange) {
        let mut settings = self.settings.clone();
        settings.calibration.pings = Some(pings);
        self.change(settings, "flat spot", false);
    }

    fn reveal(&mut self, mark: Mark) {
        let serial = self.reveal.map_or(0, |reveal| reveal.serial) + 1;
        self.selection = Some(mark);
        self.reveal = Some(Reveal { mark, serial });
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::OpenDemo => self.start_loading(Origin::Demo),
            Action::Undo => {
                if let Some(settings) = self.history.undo(&self.settings) {
                    self.set(settings);
                }
            }
            Action::Redo => {
                if let Some(settings) = self.history.redo(&self.settings) {
                    self.set(settings);
                }
            }
            Action::Cancel => {
                self.engine.cancel();
                self.loading = None;
            }
            Action::PreviousPing => self.step(-1),
            Action::NextPing => self.step(1),
            Action::Back25 => self.step(-25),
            Action::Forward25 => self.step(25),
            Action::FirstPing => self.step(isize::MIN),
            Action::LastPing => self.step(isize::MAX),
            Action::ThresholdDown => self.nudge_threshold(-0.01),
            Action::ThresholdUp => self.nudge_threshold(0.01),
            Action::FirstReturnLine => {
                let waterfall = &mut self.options.waterfall;
                waterfall.first_return = !waterfall.first_return;
            }
            Action::LevelsReset => self.options.waterfall.reset_levels(),
            Action::RangeLines => {
                let waterfall = &mut self.options.waterfall;
                waterfall.range_lines = !waterfall.range_lines;
            }
            Action::SideColours => {
                self.options.side_colours = match self.options.side_colours {
                    SideColours::Paper => SideColours::Maritime,
                    SideColours::Maritime => SideColours::Paper,
                }
            }
            Action::CalibrateHere => self.calibrate_here(),
            Action::CalibrationReset => {
                let mut settings = self.settings.clone();
                settings.calibration.pings = None;
                self.change(settings, "flat spot", false);
            }
            Action::OutlierPreview => {
                self.options.cloud.outlier_preview = !self.options.cloud.outlier_preview;
            }
            Action::Theme => {
                self.options.theme = match self.options.theme {
                    ThemeChoice::Dark => ThemeChoice::Light,
                    ThemeChoice::Light => ThemeChoice::Dark,
                }
            }
            Action::Orientation => {
                let waterfall = &mut self.options.waterfall;
                waterfall.orientation = match waterfall.orientation {
                    Orientation::Horizontal => Orientation::Vertical,
                    Orientation::Vertical => Orientation::Horizontal,
                }
            }
            Action::PresetRecommended => self.use_preset(Preset::Recommended),
            Action::PresetPublished => self.use_preset(Preset::Published),
            // Windows, dialogs, layout and cameras belong to the shell.
            _ => {}
        }
    }

    fn step(&mut self, pings: isize) {
        let Some(last) = self
            .survey
            .as_ref()
            .and_then(|survey| survey.side_scan.len().checked_sub(1))
        else {
            return;
        };
        let ping = match self.selection {
            Some(mark) => mark.ping.saturating_add_signed(pings).min(last),
            None if pings == isize::MAX => last,
            None => 0,
        };
        self.reveal(Mark::ping(ping));
    }

    fn nudge_threshold(&mut self, by: f32) {
        let mut settings = self.settings.clone();
        let threshold = settings.first_return.threshold + by;
        // Steps of a hundredth stay hundredths.
        settings.first_return.threshold = ((threshold * 100.0).round() / 100.0).clamp(0.0, 1.0);
        self.change(settings, "threshold", false);
    }

    /// The stretch of pings that a click calibrates on: 50 to either side, as far as the survey goes.
    pub fn stretch_around(&self, ping: usize) -> Option<PingRange> {
        let count = self.survey.as_ref()?.side_scan.len();
        let range = PingRange {
            start: ping.saturating_sub(50),
            end: (ping + 51).min(count),
        };
        (range.start < range.end).then_some(range)
    }

    fn calibrate_here(&mut self) {
        let pings = self
            .selection
            .and_then(|mark| self.stretch_around(mark.ping));
        match pings {
            Some(pings) => self.calibrate_at(pings),
            None => self.tell("select a ping first, then calibrate there".to_owned(), true),
        }
    }
}
