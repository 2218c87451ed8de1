//! The depth map and its hill-shade, made off the window's thread.

use super::relief_tiles::{DepthTiles, ShadeTiles};
use super::tiles::TileSource;
use super::transform::GroundBounds;
use crate::app::ShownLog;
use crate::bathymetry::{self, Light, SurfaceSettings, hill_shade};
use crate::cloud::PointCloud;
use crate::geo::CrsChoice;
use crate::pipeline::{DepthChart, ProcessedLog};
use crate::progress::{Cancelled, Progress};
use crate::survey::{Navigation, Sounding, Survey};
use crate::pipeline::Same;
use std::sync::Arc;

/// What a depth map is made of; equal keys give equal maps.
#[derive(Clone, PartialEq)]
pub struct ReliefKey(Vec<LogKey>);

#[derive(Clone, PartialEq)]
struct LogKey {
    survey: Same<Survey>,
    navigation: Same<Navigation>,
    cloud: Same<PointCloud>,
    kept: Same<Vec<bool>>,
    crs: CrsChoice,
    surface: SurfaceSettings,
}

impl ReliefKey {
    /// Of the last results of some logs.
    pub fn of(logs: &[ShownLog]) -> Self {
        let key = |shown: &ShownLog| {
            let ProcessedLog { survey, products } = &shown.log;
            LogKey {
                survey: Same(survey.clone()),
                navigation: Same(products.navigation.clone()),
                cloud: Same(products.cloud.clone()),
                kept: Same(products.kept.clone()),
                crs: products.settings.crs,
                surface: products.settings.surface.clone(),
            }
        };
        Self(logs.iter().map(key).collect())
    }
}

/// Ends of the colour scale of depth over all logs, metres: from the least to the greatest that one of them needs.
pub fn colour_range_m(logs: &[ShownLog]) -> Option<[f32; 2]> {
    let each = logs.iter().filter_map(|shown| range_of_log_m(&shown.log));
    each.reduce(|[shallow, deep], [s, d]| [shallow.min(s), deep.max(d)])
}

/// The 2nd and 98th percentile of the soundings that the recorder had the bottom for, as corrected. The others would stretch the
/// colours. In a log without such soundings, those of the depths that side-scan gives.
fn range_of_log_m(ProcessedLog { survey, products }: &ProcessedLog) -> Option<[f32; 2]> {
    let correction = &products.correction;
    let locked = survey.soundings.iter().filter(|sounding| sounding.locked);
    let depth_m = |sounding: &Sounding| {
        correction.depth_m(sounding.time_s, f64::from(sounding.depth_m)) as f32
    };
    bathymetry::depth_range(locked.map(depth_m)).or_else(|| {
        let depths = products.depths.iter();
        bathymetry::depth_range(depths.map(|depth| depth.depth_m))
    })
}

/// The depth map of the last results.
pub struct Relief {
    /// `None` where the depths span no surface.
    pub made: Option<Arc<Made>>,
    /// Nothing is interpolated farther than this from a depth, metres.
    pub gap_m: f64,
    /// Colours of the depths, and the hill-shade.
    tiles: Option<[Arc<dyn TileSource>; 2]>,
}

/// A depth map with its hill-shade.
pub struct Made {
    pub chart: DepthChart,
    /// Where the shade comes from.
    pub light: Light,
    /// Ends of the colour scale, metres.
    pub range_m: [f32; 2],
    /// Brightness of every cell, 0 where it is unknown.
    pub(super) shade: Vec<u8>,
    pub(super) bounds: GroundBounds,
    pub(super) gap_m: f32,
}

impl Relief {
    /// Makes it; `None` when cancelled.
    pub fn new(logs: &[ShownLog], progress: &Progress) -> Option<Self> {
        let made = Made::new(logs, progress).ok()?.map(Arc::new);
        let tiles = made.clone().map(|made| {
            let depth: Arc<dyn TileSource> = Arc::new(DepthTiles(made.clone()));
            let shade: Arc<dyn TileSource> = Arc::new(ShadeTiles(made));
            [depth, shade]
        });
        Some(Self {
            made,
            gap_m: gap_m(logs),
            tiles,
        })
    }

    /// The tiles of the depths' colours, and of the hill-shade.
    pub fn tiles(&self) -> [Option<Arc<dyn TileSource>>; 2] {
        match &self.tiles {
            Some(tiles) => tiles.clone().map(Some),
            None => [None, None],
        }
    }

    /// Depth of the cell at a place and its distance to the nearest depth; `None` where nothing is known.
    pub fn at(&self, place: [f64; 2]) -> Option<(f32, f32)> {
        self.made.as_ref()?.chart.at(place)
    }
}

impl Made {
    fn new(logs: &[ShownLog], progress: &Progress) -> Result<Option<Self>, Cancelled> {
        let processed: Vec<ProcessedLog> = logs.iter().map(|shown| shown.log.clone()).collect();
        let Some(chart) = DepthChart::of_logs(&processed, progress)? else {
            return Ok(None);
        };
        let surface = &chart.surface;
        let range_m = colour_range_m(logs)
            .or_else(|| bathymetry::depth_range(surface.depth_m.iter().copied()));
        let Some(range_m) = range_m else {
            return Ok(None);
        };
        let light = Light::suited(surface);
        Ok(Some(Self {
            shade: hill_shade(surface, &light, progress)?,
            light,
            range_m,
            bounds: bounds(&chart),
            gap_m: gap_m(logs) as f32,
            chart,
        }))
    }
}

/// Nothing is interpolated farther than this from a depth, metres: by the first log, whose settings all share.
fn gap_m(logs: &[ShownLog]) -> f64 {
    (logs.first()).map_or(0.0, |shown| shown.log.products.settings.surface.max_gap_m)
}

/// West, south, east and north of a chart in the plane of the survey.
fn bounds(chart: &DepthChart) -> GroundBounds {
    let grid = &chart.surface.grid;
    let east_m = grid.west_m + grid.columns as f64 * grid.cell_m;
    let south_m = grid.north_m - grid.rows as f64 * grid.cell_m;
    let start = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];
    // The edges of a zone are bent by centimetres in the plane of the survey: their middles count too.
    let [middle_east_m, middle_north_m] =
        [0.5 * (grid.west_m + east_m), 0.5 * (grid.north_m + south_m)];
    let places = [grid.west_m, middle_east_m, east_m]
        .into_iter()
        .flat_map(|easting_m| {
            [south_m, middle_north_m, grid.north_m].map(|northing_m| [easting_m, northing_m])
        });
    places.fold(start, |[west, south, east, north], place| {
        let [e, n] = chart.to_survey(place);
        [west.min(e), south.min(n), east.max(e), north.max(n)]
    })
}
