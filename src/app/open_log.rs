//! Holds an open log: everything that belongs to it alone. The state that all logs of the window
//! share is elsewhere.

use super::Figures;
use super::calibrating::Calibrating;
use super::exclusions::{ExclusionKey, FoundExclusions};
use super::jobs::Kept;
use super::reviewing::Reviewing;
use super::source::External;
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::survey::{Apart, Survey};
use bathyscope_objects::objects::{LogId, LogReview};
use bathyscope_products::pipeline::{
    LogSettings, ProcessedLog, Products, Settings, SourceKey, Stage,
};
use bathyscope_products::project::LogFile;
use std::path::PathBuf;
use std::sync::Arc;

/// Colours that distinguish logs: the eight of Okabe and Ito, which colour-blind people can
/// distinguish, without black.
const COLOURS: [[u8; 3]; 7] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [240, 228, 66],
    [213, 94, 0],
    [0, 114, 178],
];

/// Returns the colour of a log by its number; the colours repeat if there are more logs than
/// colours.
pub(super) fn log_colour(number: usize) -> [u8; 3] {
    COLOURS[number % COLOURS.len()]
}

/// A log with its settings, its results and its boxes. The default value is used in an empty
/// window.
#[derive(Default)]
pub struct OpenLog {
    /// Identifier of the log.
    pub id: LogId,
    pub(super) name: String,
    /// The recording with its source settings applied; `None` in an empty window.
    pub survey: Option<Arc<Survey>>,
    /// The recording as it was read, while settings correct something of its source; otherwise
    /// `None`.
    pub(super) as_read: Option<Arc<Survey>>,
    /// Source settings that are applied in [`OpenLog::survey`].
    pub(super) source: SourceKey,
    /// Colour of the log where colours distinguish logs, red, green and blue.
    pub colour: [u8; 3],
    /// True if the log takes part in maps, clouds and products.
    pub is_visible: bool,
    /// Reason that the log was hidden from the map when it was opened, until the analyst shows or
    /// hides it.
    pub apart: Option<Apart>,
    /// Shallowest and deepest sounding without a fault, metres; `None` if there is none.
    pub depth_span_m: Option<[f32; 2]>,
    /// True if the log is the bundled demo survey, which is no file.
    pub(super) is_demo: bool,
    /// The file of the recording; `None` until it is described for a project.
    pub(super) file: Option<LogFile>,
    /// File of the untitled project that was written for this log alone when it was closed.
    pub(super) kept_alone: Option<PathBuf>,
    /// Settings of this log only.
    pub own: Arc<LogSettings>,
    /// The settings in force: the shared ones, replaced by the log's own where it has any.
    pub settings: Arc<Settings>,
    /// The last results, which may be those of other settings while the engine works; `None` before
    /// the first.
    pub products: Option<Products>,
    /// The last results of the whole log, while those in [`OpenLog::products`] are provisional,
    /// because the log is followed and has grown since. Maps and files, which need the whole log,
    /// use these.
    pub whole: Option<ProcessedLog>,
    /// First returns by the settings under the slider, computed ahead of `products`.
    pub preview: Option<Arc<FirstReturns>>,
    /// Counts and residuals of `products`, or of the last products until the new ones are counted.
    pub figures: Option<Figures>,
    /// Water levels and tracks that other instruments recorded.
    pub external: External,
    /// The boxes and the decisions about them.
    pub reviewing: Reviewing,
    pub(super) found_exclusions: Kept<ExclusionKey, Arc<FoundExclusions>>,
    pub(super) calibrating: Calibrating,
}

impl OpenLog {
    /// Creates a log from a recording, without results.
    pub(super) fn new(id: LogId, survey: Arc<Survey>, settings: Arc<Settings>) -> Self {
        let name = survey.name();
        let mut log = Self { id, name, settings, is_visible: true, ..Self::default() };
        log.replace_survey(survey);
        log
    }

    /// Replaces the recording by a later state of it.
    pub(super) fn replace_survey(&mut self, survey: Arc<Survey>) {
        let good = survey.soundings.iter().filter(|sounding| sounding.is_good());
        let depths_m = good.map(|sounding| [sounding.depth_m, sounding.depth_m]);
        self.depth_span_m = depths_m.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)]);
        self.survey = Some(survey);
    }

    /// Returns true if the log is a file.
    pub(crate) fn is_file(&self) -> bool {
        let survey = self.survey.as_ref();
        !self.is_demo && survey.is_some_and(|survey| !survey.source.files.is_empty())
    }

    /// Returns true if the log has a place: [`Survey::has_place`].
    pub(super) fn is_placed(&self) -> bool {
        self.survey.as_ref().is_some_and(|survey| survey.has_place())
    }

    /// Returns the recording with the results of the whole log: while it is followed, those of the
    /// last run over all of it. `None` without results.
    pub(crate) fn settled(&self) -> Option<ProcessedLog> {
        self.whole.clone().or_else(|| self.with_results())
    }

    /// Returns the recording and its last results; `None` without results.
    pub(crate) fn results(&self) -> Option<(&Arc<Survey>, &Products)> {
        self.survey.as_ref().zip(self.products.as_ref())
    }

    /// Returns the recording with its last results; `None` without results.
    pub(super) fn with_results(&self) -> Option<ProcessedLog> {
        let (survey, products) = self.results()?;
        Some(ProcessedLog::new(survey.clone(), products.clone()))
    }

    /// Returns the recording with its soundings as the results judge them, or as recorded without
    /// results.
    pub fn judged(&self) -> Option<&Arc<Survey>> {
        let judged = self.products.as_ref().and_then(|products| products.judged.as_ref());
        judged.or(self.survey.as_ref())
    }

    /// Returns the name to show, which no other open log has; empty in an empty window.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Returns the boxes of the log with the decisions about them and the present threshold.
    pub(super) fn review(&self) -> LogReview {
        LogReview {
            log: self.id,
            review: self.reviewing.review.clone(),
            threshold: self.reviewing.queue.threshold,
        }
    }

    /// Returns the first returns to draw: those by the settings under the slider if there are any,
    /// else those of the last results, unless the sides were exchanged since.
    pub fn returns(&self) -> Option<&Arc<FirstReturns>> {
        let swapped = self.settings.mounting.swap_sides;
        let products = self.products.as_ref();
        let products = products.filter(|made| made.settings.mounting.swap_sides == swapped);
        let found = products.map(|products| &products.returns);
        self.preview.as_ref().or(found)
    }

    /// Returns the bottom line to draw: the first returns by the settings under the slider if there
    /// are any, else the line of the last results.
    pub fn bottom_line(&self) -> Option<&Arc<FirstReturns>> {
        let is_of_result = self.preview.is_none() && self.returns().is_some();
        let products = self.products.as_ref().filter(|_| is_of_result);
        let line = products.map(|products| &products.bottom_line);
        line.or_else(|| self.returns())
    }

    /// Returns the first stage whose result is older than its settings; `None` if there is none.
    pub fn stale(&self) -> Option<Stage> {
        let products = self.products.as_ref()?;
        Stage::first_stale(&products.settings, &self.settings)
    }

    /// Returns true if results are missing or older than their settings.
    pub fn is_behind(&self) -> bool {
        let is_current = |products: &Products| products.settings == self.settings;
        self.survey.is_some() && !self.products.as_ref().is_some_and(is_current)
    }

    /// Copies the present picture settings and classes, on which no result depends, into the
    /// settings of the results. Returns true if something was copied and the results are now those
    /// of all settings.
    pub(super) fn take_settings_of_no_result(&mut self) -> bool {
        let Some(products) = &mut self.products else {
            return false;
        };
        let (made, now) = (&products.settings, &self.settings);
        if made.picture == now.picture && made.review == now.review {
            return false;
        }
        let made = Arc::make_mut(&mut products.settings);
        made.picture = now.picture.clone();
        made.review = now.review.clone();
        products.settings == self.settings
    }

    /// Returns the log without its results and running work, to be kept after closing.
    pub(super) fn at_rest(self) -> Self {
        Self {
            products: None,
            whole: None,
            preview: None,
            figures: None,
            found_exclusions: Kept::default(),
            calibrating: Calibrating::default(),
            ..self
        }
    }

    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self {
            id: self.id,
            name: self.name.clone(),
            survey: self.survey.clone(),
            colour: self.colour,
            is_visible: self.is_visible,
            apart: self.apart,
            depth_span_m: self.depth_span_m,
            own: self.own.clone(),
            settings: self.settings.clone(),
            products: self.products.clone(),
            whole: self.whole.clone(),
            preview: self.preview.clone(),
            figures: self.figures.clone(),
            external: self.external.for_picture(),
            reviewing: self.reviewing.for_picture(),
            ..Self::default()
        }
    }
}
