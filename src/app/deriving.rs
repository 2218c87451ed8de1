//! Computes depth map, isobaths and mosaic of all visible logs in background threads while a layer
//! or a profile needs them, and the picture with which the waterfall of the shown log is drawn.

use super::jobs::{JobKey, Kept};
use super::{App, LogId, MapLayer, OpenLogs};
use bathyscope_bottom::bathymetry::isobaths::{IsobathSettings, NoIsobaths, evenly_apart_m};
use bathyscope_bottom::cloud::PointScales;
use bathyscope_bottom::picture::{LevelHistogram, LogPicture, Tone};
use bathyscope_bottom::presentation::units::LengthUnit;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::{
    Bottom, BottomKey, DepthMap, DepthMapKey, Derived, IsobathKey, Isobaths, Mosaic, MosaicKey,
    MosaicPlane, PictureKey, ProcessedLog, Same, colour_range_m,
};
use std::sync::Arc;

/// Layers that are drawn from the depth map.
const FROM_DEPTH_MAP: [MapLayer; 3] = [MapLayer::DepthMap, MapLayer::HillShade, MapLayer::Isobaths];

/// Greatest number of corners of the bottom in 3D: more than a screen has pixels, and some 110 MB
/// on the GPU.
const BOTTOM_CORNERS: usize = 4_000_000;

/// Isobaths as they are drawn on the map.
pub struct DrawnIsobaths {
    /// Depth map that the isobaths are drawn from.
    pub depth_map: Arc<DepthMap>,
    /// Settings with the depths of the isobaths: an interval that is chosen from the depths is
    /// round in the displayed unit.
    pub settings: IsobathSettings,
    /// Lines and depths, or the reason that there are none.
    pub isobaths: Result<Arc<Isobaths>, NoIsobaths>,
    /// Each line as it is drawn, as positions in the plane of the survey, metres.
    pub on_ground: Vec<Vec<[f64; 2]>>,
}

/// Requests for depth map, isobaths, mosaic, bottom and picture, and the last results.
#[derive(Default)]
pub struct Deriving {
    /// Results shared with the writers of files, so that nothing is computed twice.
    pub(super) results: Arc<Derived>,
    depth_map: Kept<DepthMapKey, Option<Arc<DepthMap>>>,
    isobaths: Kept<(IsobathKey, LengthUnit), Arc<DrawnIsobaths>>,
    mosaic: Kept<MosaicKey, Option<Arc<Mosaic>>>,
    bottom: Kept<BottomKey, Option<Arc<Bottom>>>,
    picture: Kept<PictureKey, (LogId, Arc<LogPicture>)>,
    histogram: Option<CountedLevels>,
}

/// A histogram and the inputs that it was counted from.
struct CountedLevels {
    of: (Same<LogPicture>, Tone),
    log: LogId,
    histogram: Arc<LevelHistogram>,
}

impl Deriving {
    /// Returns the latest isobaths; `None` before they are made.
    pub fn isobaths(&self) -> Option<&Arc<DrawnIsobaths>> {
        self.isobaths.result()
    }

    /// Returns the latest mosaic: the outer `None` before it is made, the inner `None` where
    /// nothing is shown.
    pub fn mosaic(&self) -> Option<Option<&Arc<Mosaic>>> {
        self.mosaic.result().map(Option::as_ref)
    }

    /// Returns a copy that holds only the results, for a picture.
    pub(super) fn for_picture(&self) -> Self {
        Self { results: self.results.clone(), ..Self::default() }
    }
}

impl OpenLogs {
    /// Returns the ends of the colour scale of depth over all visible logs, metres: the same scale
    /// on the map and in the cloud.
    pub fn depth_range_m(&self) -> Option<[f32; 2]> {
        colour_range_m(self.visible().filter_map(|log| log.products.as_ref()))
    }

    /// Returns the ends of the colour scales of points over all visible logs.
    pub(crate) fn point_scales(&self) -> PointScales {
        let logs = self.visible().filter_map(|log| log.products.as_ref());
        logs.fold(PointScales::default(), |all, products| all.with(products.scales))
    }
}

impl App {
    /// Starts computing the shown results again if their inputs have changed.
    pub(super) fn derive(&mut self) {
        let layers = &self.view.options.map.layers;
        let [isobaths, mosaic] =
            [MapLayer::Isobaths, MapLayer::Mosaic].map(|layer| layers.is_visible(layer));
        let depths = self.needs_depth_map();
        if !(depths || mosaic) {
            return;
        }
        // Results of all pings would be computed again with each ping of a followed log.
        let logs: Vec<ProcessedLog> = self.logs.settled().collect();
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

    /// Starts computing the picture for the waterfall of the shown log, and counts its levels again
    /// if they changed.
    pub(super) fn derive_picture(&mut self) {
        let log = self.logs.shown.with_results();
        let Some(log) = log.filter(|log| !log.survey.side_scan.is_empty()) else {
            return;
        };
        let (results, id) = (self.pipeline.deriving.results.clone(), self.logs.shown.id);
        let (key, whole) = (PictureKey::of(&log), self.logs.shown.whole.clone());
        let work = move |progress: &Progress| {
            let picture = match &whole {
                // The gain is that of the whole log.
                Some(whole) => results.growing_picture(&log, whole, progress),
                None => results.picture(&log, progress),
            };
            Some((id, picture.ok()?))
        };
        self.keep(JobKey::Picture, key, work, |app| Some(&mut app.pipeline.deriving.picture));
        let Some(picture) = self.picture().cloned() else {
            return;
        };
        let of = (Same(picture), self.logs.shown.settings.picture.tone());
        let counted = self.pipeline.deriving.histogram.as_ref();
        // Levels that changed with every ping would make the picture flicker.
        let holds = self.logs.shown.whole.is_some()
            && counted
                .is_some_and(|counted| counted.of.1 == of.1 && counted.log == self.logs.shown.id);
        if !holds && counted.is_none_or(|counted| counted.of != of) {
            let histogram = Arc::new(LevelHistogram::of(&of.0.0, &of.1));
            let log = self.logs.shown.id;
            self.pipeline.deriving.histogram = Some(CountedLevels { of, log, histogram });
        }
    }

    /// Returns the latest picture for the waterfall of the shown log; `None` before its first
    /// results.
    pub fn picture(&self) -> Option<&Arc<LogPicture>> {
        let made = self.pipeline.deriving.picture.result();
        let of_shown = made.filter(|(log, _)| *log == self.logs.shown.id);
        of_shown.map(|(_, picture)| picture)
    }

    /// Returns the histogram of the levels of the shown log's picture, with the gain that is set;
    /// `None` until it is counted.
    pub fn histogram(&self) -> Option<&Arc<LevelHistogram>> {
        let picture = self.picture()?;
        let counted = self.pipeline.deriving.histogram.as_ref();
        let of_shown = counted.filter(|counted| {
            let is_held = self.logs.shown.whole.is_some() && counted.log == self.logs.shown.id;
            is_held || Arc::ptr_eq(&counted.of.0.0, picture)
        });
        of_shown.map(|counted| &counted.histogram)
    }

    fn derive_depth_map(&mut self, logs: &[ProcessedLog]) {
        let (results, of) = (self.pipeline.deriving.results.clone(), logs.to_vec());
        let key = DepthMapKey::of(logs);
        let work = move |progress: &Progress| {
            let made = results.depth_map(&of, progress).ok()?;
            if let Some(made) = &made {
                // Tiles are painted from the shading.
                made.shade(progress).ok()?;
            }
            Some(made)
        };
        self.keep(JobKey::DepthMap, key, work, |app| Some(&mut app.pipeline.deriving.depth_map));
    }

    fn derive_isobaths(&mut self, logs: &[ProcessedLog]) {
        let depth_map = self.pipeline.deriving.depth_map.result().cloned().flatten();
        let Some((depth_map, first)) = depth_map.zip(logs.first()) else {
            let isobaths = &mut self.pipeline.deriving.isobaths;
            return isobaths.drop_all(&mut self.jobs, &JobKey::Isobaths);
        };
        let settings = first.products.settings.isobaths.clone();
        let results = self.pipeline.deriving.results.clone();
        let unit = self.view.options.units.length;
        let key = (IsobathKey::of(&depth_map, &settings), unit);
        let work = move |progress: &Progress| {
            let settings = match unit {
                // These settings are those of the files, which then share the result.
                LengthUnit::Metres => settings,
                _ => settings.round_in(unit.metres(), depth_map.extent()),
            };
            let isobaths = results.isobaths(&depth_map, &settings, progress).ok()?;
            let on_ground = match &isobaths {
                Ok(isobaths) => isobaths.on_ground(&depth_map),
                Err(_) => Vec::new(),
            };
            Some(Arc::new(DrawnIsobaths { depth_map, settings, isobaths, on_ground }))
        };
        self.keep(JobKey::Isobaths, key, work, |app| Some(&mut app.pipeline.deriving.isobaths));
    }

    fn derive_bottom(&mut self, logs: &[ProcessedLog]) {
        let Some(depth_map) = self.pipeline.deriving.depth_map.result().cloned().flatten() else {
            let bottom = &mut self.pipeline.deriving.bottom;
            return bottom.drop_all(&mut self.jobs, &JobKey::Bottom);
        };
        let colour = self.view.options.cloud.bottom_colour;
        let key = BottomKey::of(&depth_map, logs, colour, BOTTOM_CORNERS);
        let (results, of) = (self.pipeline.deriving.results.clone(), logs.to_vec());
        let work =
            move |progress: &Progress| results.bottom(&of, colour, BOTTOM_CORNERS, progress).ok();
        self.keep(JobKey::Bottom, key, work, |app| Some(&mut app.pipeline.deriving.bottom));
    }

    fn derive_mosaic(&mut self, logs: &[ProcessedLog]) {
        let (results, of) = (self.pipeline.deriving.results.clone(), logs.to_vec());
        let key = MosaicKey::of(logs, MosaicPlane::Survey);
        let work =
            move |progress: &Progress| results.mosaic(&of, MosaicPlane::Survey, progress).ok();
        self.keep(JobKey::Mosaic, key, work, |app| Some(&mut app.pipeline.deriving.mosaic));
    }

    /// Returns the latest depth map of all visible logs: the outer `None` before it is made, the
    /// inner `None` if the depths span no surface and no other map is being made.
    pub fn depth_map(&self) -> Option<Option<&Arc<DepthMap>>> {
        let made = &self.pipeline.deriving.depth_map;
        let last = made.result().map(Option::as_ref);
        last.filter(|map| map.is_some() || !self.jobs.is_running(&JobKey::DepthMap))
    }

    /// Returns true if something on the map is drawn or measured from the depth map; otherwise the
    /// depth map may be older than its settings.
    pub(crate) fn needs_depth_map(&self) -> bool {
        let layers = &self.view.options.map.layers;
        let shows = |layer: &MapLayer| layers.is_visible(*layer);
        FROM_DEPTH_MAP.iter().any(shows)
            || self.map.measuring.shows_profile()
            || self.view.options.cloud.bottom
    }

    /// Returns the latest bottom as a body; `None` if there is none, or if it is not shown.
    pub fn bottom(&self) -> Option<&Arc<Bottom>> {
        let is_shown = self.view.options.cloud.bottom;
        self.pipeline.deriving.bottom.result().filter(|_| is_shown)?.as_ref()
    }

    /// Returns the distance from one isobath on the bottom in 3D to the next, and the depth of one
    /// of them, metres; `None` if none are shown, or if the depths in the settings are not equally
    /// spaced.
    pub fn bottom_isobaths_m(&self) -> Option<[f32; 2]> {
        let bottom = self.bottom().filter(|_| self.view.options.cloud.isobaths)?;
        let settings = &self.logs.shown.settings.isobaths;
        let extent = bottom.depth_map.extent();
        let settings = settings.round_in(self.view.options.units.length.metres(), extent);
        let levels_m = settings.levels_m(extent).ok()?;
        evenly_apart_m(&levels_m).map(|metres| metres.map(|metres| metres as f32))
    }

    /// Returns a phrase for each derived result that is being made.
    pub(crate) fn deriving(&self) -> impl Iterator<Item = &'static str> {
        // While a log is followed, the gain of its picture is normalised with every few pings.
        let picture = self.logs.shown.whole.is_none().then_some(JobKey::Picture);
        let made = [JobKey::DepthMap, JobKey::Isobaths, JobKey::Mosaic, JobKey::Bottom];
        let running = made.into_iter().chain(picture).filter(|key| self.jobs.is_running(key));
        running.map(|key| key.name())
    }
}
