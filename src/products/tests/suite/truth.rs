//! Results of simulated surveys compared with what these hide, and results of real logs.

use bathyscope_bottom::bathymetry::{DepthPoint, Surface, SurfaceSettings, SwathDepth, surface};
use bathyscope_bottom::cloud::{ClassRules, CloudPoint, PointSource, classify};
use bathyscope_bottom::swath::{LogEchoes, correct};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::{self, Products, Settings, log_echoes};
use bathyscope_simulation::{Scene, Simulated, simulate};
use std::path::Path;

/// Fault of a cell of a map.
#[derive(Clone, Copy)]
pub(super) struct MapError {
    /// Depth of the map minus that of the bed, metres.
    pub error_m: f64,
    /// Uncertainty that the map states there ([`Surface::spread_m`]), metres.
    pub spread_m: f64,
    /// Distance to the nearest sounding, metres.
    pub away_m: f64,
}

/// A simulated survey, opened as any log would be, and its truth.
pub(super) struct KnownSurvey {
    pub survey: Survey,
    pub truth: Simulated,
}

impl KnownSurvey {
    pub(super) fn new(scene: &Scene, seed: u64) -> Self {
        let progress = Progress::new();
        let truth = simulate(scene, seed, &progress).expect("a simulated survey");
        let survey = formats::open_bytes("simulated.sl2", truth.sl2_bytes(), &progress)
            .expect("a log that opens");
        Self { survey, truth }
    }

    /// Claimed depth minus true depth of the bed at the claimed place, for every kept side-scan
    /// point. Weed is left out: there the first return is no bottom.
    pub(super) fn depth_errors_m(&self, products: &Products) -> Vec<f64> {
        products
            .kept_points()
            .filter_map(|point| {
                let side = match point.source {
                    PointSource::Port => Side::Port,
                    PointSource::Starboard => Side::Starboard,
                    PointSource::DownScan | PointSource::Swath => return None,
                };
                let ground = !self.truth.pings.get(point.ping as usize)?.side(side).weed;
                ground.then(|| -point.z_m - self.truth.bed_depth_m(point.east_m, point.north_m))
            })
            .collect()
    }

    /// The depth map in the survey's plane.
    pub(super) fn map(&self, products: &Products, settings: &SurfaceSettings) -> Surface {
        map(&self.survey, products, settings, |_| true).expect("a surface")
    }

    /// The errors of a map at the middle of each cell that `soundings` fills too.
    pub(super) fn map_errors(&self, map: &Surface, soundings: &Surface) -> Vec<MapError> {
        let cells = (0..map.grid.len()).filter_map(|cell| {
            let [east_m, north_m] = map.grid.centre_of(cell);
            let (depth_m, _) = map.at(east_m, north_m)?;
            let (_, away_m) = soundings.at(east_m, north_m)?;
            Some(MapError {
                error_m: f64::from(depth_m) - self.truth.bed_depth_m(east_m, north_m),
                spread_m: f64::from(map.spread_m[cell]),
                away_m: f64::from(away_m),
            })
        });
        cells.collect()
    }
}

/// The depth map of a survey in its plane, of those of the points that the settings count as bottom
/// and `counts` lets through; `None` where they make none.
pub(super) fn map(
    survey: &Survey,
    products: &Products,
    settings: &SurfaceSettings,
    counts: impl Fn(&CloudPoint) -> bool,
) -> Option<Surface> {
    let echoes = log_echoes(survey, products, |place| place);
    map_with(echoes, products, settings, counts)
}

/// The same, with depths from the levels of some echoes where the settings ask for it.
pub(super) fn map_with(
    echoes: LogEchoes<'_>,
    products: &Products,
    settings: &SurfaceSettings,
    counts: impl Fn(&CloudPoint) -> bool,
) -> Option<Surface> {
    let progress = Progress::new();
    let rules = ClassRules {
        above_bottom: settings.above_bottom,
        longest_above_bottom_m: settings.longest_above_bottom_m,
        ..products.settings.class_rules()
    };
    let classes = classify(&products.cloud, &rules, &progress).expect("not cancelled");
    let kept = products.cloud.kept(&classes);
    let points: Vec<DepthPoint> = kept
        .filter(|(_, point)| counts(point))
        .map(|(_, point)| DepthPoint {
            east_m: point.east_m,
            north_m: point.north_m,
            depth_m: -point.z_m,
            weight: settings.weight(point),
            is_sounding: point.source == PointSource::DownScan,
            slope_end: point.slope_end.share(),
        })
        .filter(|point| point.weight > 0.0)
        .collect();
    let mut made = surface(points.clone(), settings, &progress).expect("not cancelled")?;
    if settings.swath != SwathDepth::Off {
        correct(&mut made, vec![echoes], &points, &progress, settings.swath)
            .expect("not cancelled");
    }
    Some(made)
}

/// A log with what the default settings make of it.
pub(crate) fn processed(path: &Path) -> (Survey, Products) {
    let survey = formats::open(path, &Progress::new()).expect("a log that opens");
    let products = results(&survey, &Settings::default());
    (survey, products)
}

/// Results of a survey.
pub(super) fn results(survey: &Survey, settings: &Settings) -> Products {
    pipeline::run(survey, settings, None, &Progress::new(), |_| ()).expect("not cancelled")
}
