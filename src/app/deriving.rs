//! Depth map, isobaths and mosaic of all visible logs: asked for while a layer or a profile needs
//! them, computed in a background thread; and what the waterfall of the shown log is drawn with.

use super::{App, LogId, MapLayer};
use bathyscope_bottom::bathymetry::isobaths::{IsobathSettings, NoIsobaths, evenly_apart_m};
use bathyscope_bottom::cloud::PointScales;
use bathyscope_bottom::picture::{LevelHistogram, LogPicture, Tone};
use bathyscope_bottom::presentation::units::LengthUnit;
use bathyscope_products::pipeline::{
    Background, Bottom, BottomKey, DepthMap, DepthMapKey, Derived, IsobathKey, Isobaths, Mosaic,
    MosaicKey, MosaicPlane, PictureKey, ProcessedLog, Same, colour_range_m,
};
use std::sync::Arc;

/// Layers that are drawn from the depth map.
const FROM_DEPTH_MAP: [MapLayer; 3] = [MapLayer::DepthMap, MapLayer::HillShade, MapLayer::Isobaths];

/// Most corners of the bottom in 3D: more than a screen has pixels, and some 110 MB on the GPU.
const BOTTOM_CORNERS: usize = 4_000_000;

/// Isobaths as they are drawn.
pub struct DrawnIsobaths {
    /// Depth map that the isobaths are drawn from.
    pub depth_map: Arc<DepthMap>,
    /// Settings of the isobaths' depths: an interval that is chosen from the depths is round in the
    /// unit in use.
    pub settings: IsobathSettings,
    /// Lines and depths; why there are none.
    pub isobaths: Result<Arc<Isobaths>, NoIsobaths>,
    /// Every line as it is drawn, as places in the plane of the survey, metres.
    pub on_ground: Vec<Vec<[f64; 2]>>,
}

/// Requests for depth map, isobaths, mosaic, bottom and picture, and the last results.
#[derive(Default)]
pub(super) struct Deriving {
    /// Shared with what writes files, so that nothing is made twice.
    pub results: Arc<Derived>,
    depth_map: Background<DepthMapKey, Option<Arc<DepthMap>>>,
    isobaths: Background<(IsobathKey, LengthUnit), Arc<DrawnIsobaths>>,
    mosaic: Background<MosaicKey, Option<Arc<Mosaic>>>,
    bottom: Background<BottomKey, Option<Arc<Bottom>>>,
    picture: Background<PictureKey, (LogId, Arc<LogPicture>)>,
    histogram: Option<CountedLevels>,
}

/// A histogram with what it was counted of.
struct CountedLevels {
    of: (Same<LogPicture>, Tone),
    log: LogId,
    histogram: Arc<LevelHistogram>,
}

impl Deriving {
    pub(super) fn is_busy(&self) -> bool {
        self.depth_map.is_running()
            || self.isobaths.is_running()
            || self.mosaic.is_running()
            || self.bottom.is_running()
            || self.picture.is_running()
    }

    /// The same results for a picture.
    pub(super) fn for_picture(&self) -> Self {
        Self { results: self.results.clone(), ..Self::default() }
    }
}

impl App {
    /// Has made what is shown, and collects what is there. Costs next to nothing when nothing
    /// changed.
    pub(super) fn derive(&mut self) {
        let layers = &self.view.options.map.layers;
        let [isobaths, mosaic] =
            [MapLayer::Isobaths, MapLayer::Mosaic].map(|layer| layers.is_visible(layer));
        let depths = self.needs_depth_map();
        if !(depths || mosaic) {
            return;
        }
        // What is made of all pings would be made anew with each that a followed log gets.
        let logs: Vec<ProcessedLog> = self.settled_logs().collect();
        if mosaic {
            self.derive_mosaic(&logs);
        }
        if depths {
            self.derive_depth_map(&logs);
        }
        if isobaths {
            self.derive_isobaths(&logs);
        }
        if self.view.options.cloud.bottom {
            self.derive_bottom(&logs);
        }
    }

    /// Has made what the waterfall of the shown log is drawn with, and counts its levels anew where
    /// they changed.
    pub(super) fn derive_picture(&mut self) {
        let (Some(survey), Some(products)) = (&self.log.survey, &self.log.products) else {
            return;
        };
        if survey.side_scan.is_empty() {
            return;
        }
        let log = ProcessedLog::new(survey.clone(), products.clone());
        let (results, id) = (self.pipeline.deriving.results.clone(), self.log.id);
        let ask = &mut self.pipeline.deriving.picture;
        let whole = self.log.whole.clone();
        ask.ask(PictureKey::of(&log), &self.jobs, move |progress| {
            let picture = match &whole {
                // The gain is that of the log as a whole.
                Some(whole) => results.growing_picture(&log, whole, progress),
                None => results.picture(&log, progress),
            };
            Some((id, picture.ok()?))
        });
        let Some(picture) = self.picture().cloned() else {
            return;
        };
        let of = (Same(picture), self.log.settings.picture.tone());
        let counted = self.pipeline.deriving.histogram.as_ref();
        // Levels that changed with every ping would make the picture flicker.
        let holds = self.log.whole.is_some()
            && counted.is_some_and(|counted| counted.of.1 == of.1 && counted.log == self.log.id);
        if !holds && counted.is_none_or(|counted| counted.of != of) {
            let histogram = Arc::new(LevelHistogram::of(&of.0.0, &of.1));
            let log = self.log.id;
            self.pipeline.deriving.histogram = Some(CountedLevels { of, log, histogram });
        }
    }

    /// Returns the picture that the waterfall of the shown log is drawn with, as it was made last;
    /// `None` before its first results.
    pub fn picture(&self) -> Option<&Arc<LogPicture>> {
        let made = self.pipeline.deriving.picture.result();
        let of_shown = made.filter(|(log, _)| *log == self.log.id);
        of_shown.map(|(_, picture)| picture)
    }

    /// The levels of the shown log's picture, with the gain that is set.
    pub fn histogram(&self) -> Option<&Arc<LevelHistogram>> {
        let picture = self.picture()?;
        let counted = self.pipeline.deriving.histogram.as_ref();
        let of_shown = counted.filter(|counted| {
            let is_held = self.log.whole.is_some() && counted.log == self.log.id;
            is_held || Arc::ptr_eq(&counted.of.0.0, picture)
        });
        of_shown.map(|counted| &counted.histogram)
    }

    fn derive_depth_map(&mut self, logs: &[ProcessedLog]) {
        let (results, of) = (self.pipeline.deriving.results.clone(), logs.to_vec());
        let key = DepthMapKey::of(logs);
        self.pipeline.deriving.depth_map.ask(key, &self.jobs, move |progress| {
            let made = results.depth_map(&of, progress).ok()?;
            if let Some(made) = &made {
                // Tiles are painted from it.
                made.shade(progress).ok()?;
            }
            Some(made)
        });
    }

    fn derive_isobaths(&mut self, logs: &[ProcessedLog]) {
        let depth_map = self.pipeline.deriving.depth_map.result().cloned().flatten();
        let Some((depth_map, first)) = depth_map.zip(logs.first()) else {
            self.pipeline.deriving.isobaths = Background::default();
            return;
        };
        let settings = first.products.settings.isobaths.clone();
        let results = self.pipeline.deriving.results.clone();
        let unit = self.view.options.units.length;
        let key = (IsobathKey::of(&depth_map, &settings), unit);
        self.pipeline.deriving.isobaths.ask(key, &self.jobs, move |progress| {
            let settings = match unit {
                // As in the files, which have them already then.
                LengthUnit::Metres => settings,
                _ => settings.round_in(unit.metres(), depth_map.extent()),
            };
            let isobaths = results.isobaths(&depth_map, &settings, progress).ok()?;
            let on_ground = match &isobaths {
                Ok(isobaths) => isobaths.on_ground(&depth_map),
                Err(_) => Vec::new(),
            };
            Some(Arc::new(DrawnIsobaths { depth_map, settings, isobaths, on_ground }))
        });
    }

    fn derive_bottom(&mut self, logs: &[ProcessedLog]) {
        let Some(depth_map) = self.pipeline.deriving.depth_map.result().cloned().flatten() else {
            self.pipeline.deriving.bottom = Background::default();
            return;
        };
        let colour = self.view.options.cloud.bottom_colour;
        let key = BottomKey::of(&depth_map, logs, colour, BOTTOM_CORNERS);
        let (results, of) = (self.pipeline.deriving.results.clone(), logs.to_vec());
        self.pipeline.deriving.bottom.ask(key, &self.jobs, move |progress| {
            results.bottom(&of, colour, BOTTOM_CORNERS, progress).ok()
        });
    }

    fn derive_mosaic(&mut self, logs: &[ProcessedLog]) {
        let (results, of) = (self.pipeline.deriving.results.clone(), logs.to_vec());
        let key = MosaicKey::of(logs, MosaicPlane::Survey);
        self.pipeline.deriving.mosaic.ask(key, &self.jobs, move |progress| {
            results.mosaic(&of, MosaicPlane::Survey, progress).ok()
        });
    }

    /// The depth map of all visible logs as it was made last; outer `None` before that, inner where
    /// the depths span no surface, and no other map is being made.
    pub fn depth_map(&self) -> Option<Option<&Arc<DepthMap>>> {
        let made = &self.pipeline.deriving.depth_map;
        let last = made.result().map(Option::as_ref);
        last.filter(|map| map.is_some() || !made.is_running())
    }

    /// Ends of the one colour scale of depth over all visible logs, metres: the same on the map and
    /// in the cloud.
    pub fn depth_range_m(&self) -> Option<[f32; 2]> {
        colour_range_m(self.visible_logs().filter_map(|log| log.products.as_ref()))
    }

    /// Ends of the colour scales of points over all visible logs.
    pub(crate) fn point_scales(&self) -> PointScales {
        let logs = self.visible_logs().filter_map(|log| log.products.as_ref());
        logs.fold(PointScales::default(), |all, one| all.with(one.scales))
    }

    /// Returns true if something on the map is drawn or measured from the depth map; otherwise it
    /// may be older than its settings.
    pub(crate) fn needs_depth_map(&self) -> bool {
        let layers = &self.view.options.map.layers;
        let shows = |layer: &MapLayer| layers.is_visible(*layer);
        FROM_DEPTH_MAP.iter().any(shows)
            || self.map.measuring.shows_profile()
            || self.view.options.cloud.bottom
    }

    /// The isobaths as they were made last.
    pub fn isobaths(&self) -> Option<&Arc<DrawnIsobaths>> {
        self.pipeline.deriving.isobaths.result()
    }

    /// The mosaic as it was made last; inner `None` where nothing is shown.
    pub fn mosaic(&self) -> Option<Option<&Arc<Mosaic>>> {
        self.pipeline.deriving.mosaic.result().map(Option::as_ref)
    }

    /// The bottom as a body, as it was made last; `None` where there is none, or it is not shown.
    pub fn bottom(&self) -> Option<&Arc<Bottom>> {
        let is_shown = self.view.options.cloud.bottom;
        self.pipeline.deriving.bottom.result().filter(|_| is_shown)?.as_ref()
    }

    /// Metres from one isobath on the bottom in 3D to the next, and the depth of one of them;
    /// `None` where none are shown, and where the settings name depths that are not equally far
    /// apart.
    pub fn bottom_isobaths_m(&self) -> Option<[f32; 2]> {
        let bottom = self.bottom().filter(|_| self.view.options.cloud.isobaths)?;
        let settings = &self.log.settings.isobaths;
        let extent = bottom.depth_map.extent();
        let settings = settings.round_in(self.view.options.units.length.metres(), extent);
        let levels_m = settings.levels_m(extent).ok()?;
        evenly_apart_m(&levels_m).map(|metres| metres.map(|metres| metres as f32))
    }

    /// Returns a phrase for each derived result that is being made.
    pub(crate) fn deriving(&self) -> impl Iterator<Item = &'static str> {
        let jobs = [
            (self.pipeline.deriving.depth_map.is_running(), "making the depth map"),
            (self.pipeline.deriving.isobaths.is_running(), "drawing isobaths"),
            (self.pipeline.deriving.mosaic.is_running(), "normalising the mosaic's gain"),
            (self.pipeline.deriving.bottom.is_running(), "making the bottom in 3D"),
            (
                // While a log is followed, that is done with every few pings.
                self.pipeline.deriving.picture.is_running() && self.log.whole.is_none(),
                "normalising the waterfall's gain",
            ),
        ];
        let running = jobs.into_iter().filter(|(is_running, _)| *is_running);
        running.map(|(_, what)| what)
    }
}
