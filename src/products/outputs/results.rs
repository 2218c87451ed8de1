//! Computes the results that the files of a run are made from: each result once, when the first
//! file needs it. Fits shapes to objects.

use super::content::{Missing, Need};
use super::order::{Order, When, log_names, log_points, survey_name};
use crate::Error;
use crate::export::tile_sets::TileSet;
use crate::export::{self, LogPoints, SideScanCoverage, TrackPiece};
use crate::pipeline::{
    Agreement, Contours, Crosslines, DepthMap, Fingerprint, Isobaths, Mosaic, MosaicPlane,
    NamedComparison, ProcessedLog, Products, comparisons, crosslines, list_objects, map_plane,
    mosaic_layout, object_shape,
};
use bathyscope_bottom::bathymetry::{DepthPoint, Grid, Surface, spot_radius_m, spot_soundings};
use bathyscope_bottom::mosaic::{MosaicLayout, TILE_CELLS, footprint, joint_grid};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_objects::objects::{LogId, LogReview, Object, ObjectList, SurveyReview};
use bathyscope_objects::review::Review;
use bathyscope_objects::targets::{FittedShape, Target};
use bathyscope_objects::{Detection, find};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Largest number of tiles of a mosaic, empty ones included: a single wrong fix makes a huge, empty
/// map.
const MOST_TILES: usize = 1_000_000;

/// Results of a survey that its files are made from. Several threads may request results at the
/// same time, each with its own progress. Tasks of rayon's threads must not request results: all
/// threads of rayon could then wait for a result that only they can compute.
pub(super) struct Results<'a> {
    pub order: &'a Order<'a>,
    pub survey: &'a Survey,
    pub products: &'a Products,
    /// Plane of the maps of the survey.
    pub map: MapPlane,
    /// Name of each log.
    pub names: Vec<String>,
    pub progress: &'a Progress,
    computed: Arc<Computed>,
}

/// Objects with the shapes of targets, by number; an object without a fitting shape has no entry.
pub(super) type ShapedObjects = (ObjectList, BTreeMap<u32, FittedShape>);

/// Results that files are made from, computed when they are requested.
#[derive(Default)]
struct Computed {
    track: OnceLock<Vec<TrackPiece>>,
    ground: Once<SideScanCoverage>,
    contours: Once<Result<Contours, Error>>,
    map_tiles: Once<TileSet>,
    spot_soundings: Once<Vec<DepthPoint>>,
    depth_map: Once<Option<Arc<DepthMap>>>,
    comparisons: Once<Vec<NamedComparison>>,
    crossings: Once<Option<Crosslines>>,
    agreement: Once<Option<Agreement>>,
    reference_inputs: Once<Vec<Fingerprint>>,
    found: Once<Vec<Vec<Detection>>>,
    found_objects: Once<ShapedObjects>,
    objects: Once<ShapedObjects>,
}

/// A result that is computed once; other threads that request it meanwhile wait.
struct Once<T> {
    made: OnceLock<T>,
    making: Mutex<()>,
}

impl<T> Default for Once<T> {
    fn default() -> Self {
        Self { made: OnceLock::new(), making: Mutex::default() }
    }
}

/// Returns the value and computes it first if necessary.
fn once<T>(once: &Once<T>, make: impl FnOnce() -> Result<T, Error>) -> Result<&T, Error> {
    if let Some(made) = once.made.get() {
        return Ok(made);
    }
    let _making = once.making.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(made) = once.made.get() {
        return Ok(made);
    }
    let made = make()?;
    Ok(once.made.get_or_init(|| made))
}

impl<'a> Results<'a> {
    /// Creates the results of an order; nothing is computed yet.
    ///
    /// # Errors
    /// When there is no log, or the coordinate system of the setting `crs` does not fit the first
    /// log.
    pub(super) fn new(order: &'a Order<'a>, progress: &'a Progress) -> Result<Self, Error> {
        let Some(ProcessedLog { survey, products }) = order.logs.first() else {
            return Err("there is no log whose files could be written".into());
        };
        Ok(Self {
            order,
            survey,
            products,
            map: map_plane(survey, &products.settings)?,
            names: log_names(order.logs),
            progress,
            computed: Arc::default(),
        })
    }

    /// Returns the same results with another progress.
    pub(super) fn with_progress<'b>(&'b self, progress: &'b Progress) -> Results<'b> {
        Results {
            map: self.map.clone(),
            names: self.names.clone(),
            computed: self.computed.clone(),
            progress,
            ..*self
        }
    }

    /// Returns the reason if a need is not met; `None` if it is met.
    pub(super) fn missing(&self, need: Need) -> Result<Option<Missing>, Error> {
        let because = |why: &str| Missing(Some(why.to_owned()));
        let silent = |is_missing: bool| is_missing.then_some(Missing(None));
        let settings = &self.products.settings;
        Ok(match need {
            Need::KeptPoints => {
                let has_points = self.logs().any(|(_, made)| made.kept_points().next().is_some());
                (!has_points).then(|| because(no_cloud(self.products)))
            }
            Need::PlainLas => silent(!settings.points.las),
            Need::Track => {
                let why = if self.logs().any(|(survey, _)| survey.has_place()) {
                    "no track: the boat lay still"
                } else {
                    "no track: the log has no position"
                };
                self.track().is_empty().then(|| because(why))
            }
            Need::Footprint => self.ground()?.shapes.is_empty().then(|| {
                let why = "no footprint: no ping has side-scan, a place, a heading and an altitude";
                Missing(self.has_side_scan().then(|| why.to_owned()))
            }),
            Need::Surface => self.depth_map()?.is_none().then(|| because(NO_DEPTH_MAP)),
            Need::Hardness => {
                silent(self.depth_map()?.is_none_or(|map| map.surface.hardness_db.is_none()))
            }
            Need::Levels => self.contours()?.as_ref().err().map(|why| because(&why.to_string())),
            Need::Isobaths => {
                let has_lines = |contours: &Contours| !contours.isobaths.lines.is_empty();
                silent(!self.contours()?.as_ref().is_ok_and(has_lines))
            }
            Need::Area => silent(
                self.depth_map()?.is_some_and(|map| map.clip_area(&settings.isobaths).is_err()),
            ),
            Need::Agreement if !self.comparisons()?.is_empty() || self.crossings()?.is_some() => {
                None
            }
            // A survey without soundings or without side-scan gets no message about missing
            // residuals.
            Need::Agreement => {
                let any = |such: fn(&Survey) -> bool| self.logs().any(|(survey, _)| such(survey));
                let has_points = self.has_side_scan() || any(|survey| !survey.swath.is_empty());
                let is_expected = has_points && any(|survey| !survey.soundings.is_empty());
                Some(Missing(is_expected.then(|| NO_RESIDUALS.to_owned())))
            }
            Need::SideScan => silent(!self.has_side_scan()),
            Need::Mosaic => {
                let grid = self.mosaic_grid(self.mosaic()?.as_deref());
                grid.err().map(|why| because(&why.to_string()))
            }
            Need::Targets => silent(!self.order.review.has_targets()),
            Need::Reference => silent(self.order.reference.is_none()),
        })
    }

    /// Returns the logs of the survey, one or several, with their results.
    pub(super) fn logs(&self) -> impl Iterator<Item = (&'a Survey, &'a Products)> {
        let logs = self.order.logs.iter();
        logs.map(|log| (log.survey.as_ref(), &log.products))
    }

    /// Returns the points of each log, from which tables and clouds are written.
    pub(super) fn log_points(&self) -> Vec<LogPoints<'_>> {
        log_points(self.order.logs, &self.names)
    }

    fn has_side_scan(&self) -> bool {
        self.logs().any(|(survey, _)| survey.has_side_scan())
    }

    /// Returns the name of the survey: the names of its logs, or the first and the last of more
    /// than three.
    pub(super) fn name(&self) -> String {
        survey_name(&self.names)
    }

    /// Returns the track of the boat, log by log. If the time of every log is known, all times are
    /// seconds after the time zero of the first log.
    pub(super) fn track(&self) -> &[TrackPiece] {
        self.computed.track.get_or_init(|| {
            let pieces = self.logs().flat_map(|(survey, products)| {
                let later_s = survey.start_unix_s.zip(self.start_unix_s());
                let later_s = later_s.map_or(0.0, |(own_s, first_s)| own_s - first_s);
                let mut pieces = export::track(survey, &products.navigation);
                for point in pieces.iter_mut().flat_map(|piece| &mut piece.points) {
                    point.time_s += later_s;
                }
                pieces
            });
            pieces.collect()
        })
    }

    /// Returns the Unix seconds of the time zero of the first log; `None` where the time of a log
    /// is not known.
    pub(super) fn start_unix_s(&self) -> Option<f64> {
        let all_know = self.logs().all(|(survey, _)| survey.start_unix_s.is_some());
        self.survey.start_unix_s.filter(|_| all_know)
    }

    /// Returns the ground that the side-scan insonified.
    pub(super) fn ground(&self) -> Result<&SideScanCoverage, Error> {
        once(&self.computed.ground, || {
            let map = &self.map;
            let layouts: Vec<MosaicLayout> = self
                .logs()
                .map(|(survey, products)| mosaic_layout(survey, products, map))
                .collect();
            let shapes = footprint(&layouts, self.progress)?;
            Ok(SideScanCoverage::new(shapes, map))
        })
    }

    /// Returns the surface of the depth map, if it was computed already.
    pub(super) fn made_surface(&self) -> Option<&Surface> {
        let map = self.computed.depth_map.made.get()?.as_ref()?;
        Some(&map.surface)
    }

    /// Returns the depth map; `None` where the depths span no surface.
    pub(super) fn depth_map(&self) -> Result<Option<&Arc<DepthMap>>, Error> {
        let made = once(&self.computed.depth_map, || {
            Ok(self.order.derived.depth_map(self.order.logs, self.progress)?)
        });
        made.map(Option::as_ref)
    }

    /// Returns the depth map for a file that needs one.
    ///
    /// # Errors
    /// When there is no map or it cannot be computed.
    pub(super) fn needed_depth_map(&self) -> Result<&Arc<DepthMap>, Error> {
        Ok(self.depth_map()?.ok_or(NO_SURFACE)?)
    }

    /// Returns the surface of the depth map for a file that needs one.
    ///
    /// # Errors
    /// As [`Results::needed_depth_map`].
    pub(super) fn surface(&self) -> Result<&Surface, Error> {
        Ok(&self.needed_depth_map()?.surface)
    }

    /// Describes the corrections, applied or not, and the interpolation of the cells of a surface.
    pub(super) fn applied(&self, surface: &Surface) -> String {
        format!(
            "{} By {} in cells of {} m, none farther than {} m from a depth.",
            self.products.correction.statement(),
            surface.method_in_words(),
            surface.grid.cell_m,
            self.products.settings.surface.max_gap_m
        )
    }

    /// Returns the isobaths, or the reason why there are none.
    pub(super) fn isobaths(&self) -> Result<Result<Arc<Isobaths>, Error>, Error> {
        let Some(depth_map) = self.depth_map()? else {
            return Ok(Err(NO_SURFACE.into()));
        };
        let settings = &self.products.settings.isobaths;
        let made = (self.order.derived).isobaths(depth_map, settings, self.progress);
        Ok(made?.map_err(Error::from))
    }

    /// Returns the isobaths, the areas between them and the storage below each level, or the reason
    /// why there are none.
    pub(super) fn contours(&self) -> Result<&Result<Contours, Error>, Error> {
        once(&self.computed.contours, || {
            let isobaths = match self.isobaths()? {
                Ok(isobaths) => isobaths,
                Err(why) => return Ok(Err(why)),
            };
            let depth_map = self.needed_depth_map()?;
            Ok(Ok(Contours::new(depth_map, isobaths, self.progress)?))
        })
    }

    /// Returns the tiles of the depth map, which `draw` draws at the first call.
    pub(super) fn map_tiles(
        &self,
        draw: impl FnOnce() -> Result<TileSet, Error>,
    ) -> Result<&TileSet, Error> {
        once(&self.computed.map_tiles, draw)
    }

    /// Returns the depths that a chart prints, in the plane of the map; none without a depth map.
    pub(super) fn spot_soundings(&self) -> Result<&[DepthPoint], Error> {
        let made = once(&self.computed.spot_soundings, || {
            let Some(depth_map) = self.depth_map()? else {
                return Ok(Vec::new());
            };
            let settings = &self.products.settings.isobaths;
            let area = depth_map.clip_area(settings)?;
            let mut points = depth_map.depth_points(self.progress)?;
            if let Some(area) = area {
                points.retain(|point| area.holds([point.east_m, point.north_m]));
            }
            let radius_m = spot_radius_m(settings, &points);
            Ok(radius_m.map_or_else(Vec::new, |radius_m| spot_soundings(&points, radius_m)))
        });
        made.map(Vec::as_slice)
    }

    /// Compares side-scan with the soundings, over all logs.
    pub(super) fn comparisons(&self) -> Result<&[NamedComparison], Error> {
        let made = once(&self.computed.comparisons, || {
            Ok(comparisons(self.order.logs, &self.map, self.progress)?)
        });
        made.map(Vec::as_slice)
    }

    /// Returns the crossings of tracks with themselves and with each other.
    pub(super) fn crossings(&self) -> Result<Option<&Crosslines>, Error> {
        let made = once(&self.computed.crossings, || {
            Ok(crosslines(self.order.logs, &self.names, self.progress)?)
        });
        made.map(Option::as_ref)
    }

    /// Returns the mosaic in the plane of the map; `None` where no log has echoes with a place.
    pub(super) fn mosaic(&self) -> Result<Option<Arc<Mosaic>>, Error> {
        let plane = MosaicPlane::Map(self.map.clone());
        Ok(self.order.derived.mosaic(self.order.logs, plane, self.progress)?)
    }

    /// Returns the grid of the file with the mosaic.
    ///
    /// # Errors
    /// When no echo has a place, or the mosaic would have too many cells.
    pub(super) fn mosaic_grid(&self, mosaic: Option<&Mosaic>) -> Result<Grid, Error> {
        let cell_m = self.products.settings.mosaic.cell_m;
        let grid = mosaic.and_then(|mosaic| joint_grid(&mosaic.logs, cell_m));
        let grid =
            grid.ok_or("no mosaic: no ping has side-scan, a place, a heading and an altitude")?;
        let [down, across] = [grid.rows, grid.columns].map(|cells| cells.div_ceil(TILE_CELLS));
        if down.saturating_mul(across) > MOST_TILES {
            return Err(format!(
                "no mosaic: it would have {} by {} cells; choose a larger mosaic.cell_m, or look for positions that are far off",
                grid.columns, grid.rows
            )
            .into());
        }
        Ok(grid)
    }

    /// Returns the agreement of the survey with the reference; `None` without a reference.
    pub(super) fn agreement(&self) -> Result<Option<&Agreement>, Error> {
        let made = once(&self.computed.agreement, || {
            let Some((reference, matching)) = self.order.reference else {
                return Ok(None);
            };
            let (logs, progress) = (self.order.logs, self.progress);
            Ok(Some(Agreement::with_reference(logs, reference, matching, progress)?))
        });
        made.map(Option::as_ref)
    }

    /// Returns the files that the reference was read from; none without a reference.
    pub(super) fn reference_inputs(&self) -> Result<&[Fingerprint], Error> {
        let made = once(&self.computed.reference_inputs, || match self.order.reference {
            Some((reference, _)) => reference.inputs(self.progress),
            None => Ok(Vec::new()),
        });
        made.map(Vec::as_slice)
    }

    /// Returns the boxes that the model finds in each log outside of excluded stretches.
    ///
    /// # Errors
    /// When there is no model, or the boxes cannot be computed.
    pub(super) fn found(&self) -> Result<&[Vec<Detection>], Error> {
        let model = self.order.search.ok_or(NOT_SEARCHED)?;
        let of_log = |(survey, products): (&Survey, &Products)| {
            if !survey.has_side_scan() {
                return Ok(Vec::new());
            }
            let (navigation, settings) = (&products.navigation, &products.settings.detector);
            let mut found = find(survey, navigation, model, settings, self.progress, |_| ())?;
            found
                .retain(|detection| !products.exclusions.is_middle_excluded(&detection.mark.pings));
            Ok(found)
        };
        let made = once(&self.computed.found, || self.logs().map(of_log).collect());
        made.map(Vec::as_slice)
    }

    /// Returns the review with proposals from the search added for the logs that satisfy
    /// `is_asked`, none of them decided; numbers of boxes continue from log to log.
    fn found_review(&self, is_asked: impl Fn(usize) -> bool) -> Result<SurveyReview, Error> {
        let mut review = self.order.review.clone();
        review.logs.resize(self.order.logs.len(), None);
        let Some(model) = self.order.search else {
            return Ok(review);
        };
        let mut first = 1;
        for (index, found) in self.found()?.iter().enumerate() {
            if is_asked(index) {
                let identity = Identity::of(&self.order.logs[index].survey);
                let proposals = Review::of_found(identity, model.names(), first, found);
                review.logs[index] = Some(LogReview {
                    log: LogId(index as u64),
                    review: Arc::new(proposals),
                    threshold: 0.0,
                });
            }
            first += found.len() as u32;
        }
        Ok(review)
    }

    /// Returns the objects that a search found in all logs, with their shapes.
    ///
    /// # Errors
    /// When there was no search, or the objects cannot be computed.
    pub(super) fn shaped_found(&self) -> Result<&ShapedObjects, Error> {
        self.found()?;
        once(&self.computed.found_objects, || {
            let review = self.found_review(|_| true)?;
            Ok(list_with_shapes(self.order.logs, &review, self.progress)?)
        })
    }

    /// Returns the objects of the survey with their shapes: for each log those of its review, or
    /// else those that a search found. There are some if the order asks for [`When::Listed`].
    ///
    /// # Errors
    /// When there was neither a search nor a review, or the objects cannot be computed.
    pub(super) fn shaped_objects(&self) -> Result<&ShapedObjects, Error> {
        if !self.order.review.has_boxes() {
            return self.shaped_found();
        }
        let is_searched = self.order.asks_for(When::Searched);
        once(&self.computed.objects, || {
            let review =
                self.found_review(|log| is_searched && self.order.review.log(log).is_none())?;
            Ok(list_with_shapes(self.order.logs, &review, self.progress)?)
        })
    }
}

/// Lists the objects of a review, and fits shapes to its targets.
pub(super) fn list_with_shapes(
    logs: &[ProcessedLog],
    review: &SurveyReview,
    progress: &Progress,
) -> Result<ShapedObjects, Cancelled> {
    let list = list_objects(logs, review, progress)?;
    let shape = |object: &&Object| {
        progress.check()?;
        let boxes: Vec<(&ProcessedLog, &Target)> = (list.members(object))
            .filter_map(|object_box| Some((logs.get(object_box.log)?, object_box.target.as_ref()?)))
            .collect();
        let shape = object_shape(&boxes).ok();
        Ok(shape.map(|shape| (object.number, shape)))
    };
    let targets: Vec<&Object> = list.targets().collect();
    let shapes: Result<BTreeMap<u32, FittedShape>, Cancelled> =
        targets.par_iter().filter_map(|object| shape(object).transpose()).collect();
    Ok((list, shapes?))
}

/// Error that is not expected: the registry requires a surface before it writes one.
pub(super) const NO_SURFACE: &str = "there is no depth map";
pub(super) const NOT_SEARCHED: &str = "nothing searched for objects";
const NO_DEPTH_MAP: &str = "no depth map: the depths span no surface (a single straight line, or none near another within surface.max_gap_m)";
const NO_RESIDUALS: &str = "no residuals: there are no side-scan points near a sounding, and no track crosses itself or another";

/// Returns the reason why there is no point to write.
fn no_cloud(products: &Products) -> &'static str {
    if products.cloud.points.is_empty() {
        "no cloud: there is no point, since no first return and no recorded depth has a place and a heading"
    } else {
        "no cloud: no point counts as bottom (column class of points/cloud.csv); see outliers.radius_m and outliers.min_neighbors"
    }
}
