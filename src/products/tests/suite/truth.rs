//! Results of simulated surveys compared with what these hide, and of two missions over one pond,
//! whose agreement the simulation knows; and results of real logs.

use bathyscope_bottom::bathymetry::compare::{Matching, match_points};
use bathyscope_bottom::bathymetry::{DepthPoint, Surface, SurfaceSettings, SwathDepth, surface};
use bathyscope_bottom::cloud::{ClassRules, CloudPoint, PointSource, Residuals, classify};
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

/// One mission and what the program made of it.
pub(super) struct Mission {
    pub known: KnownSurvey,
    pub products: Products,
}

impl Mission {
    pub(super) fn new(scene: &Scene, seed: u64) -> Self {
        let known = KnownSurvey::new(scene, seed);
        let products = results(&known.survey, &Settings::default());
        Self { known, products }
    }

    /// East, north and elevation of the points that a depth map is made of, in this mission's own
    /// plane.
    fn points(&self) -> Vec<[f64; 3]> {
        let settings = SurfaceSettings::default();
        let counted = self.products.kept_points().filter(|point| settings.weight(point) > 0.0);
        counted.map(CloudPoint::place).collect()
    }
}

/// Mean and standard deviation, metres.
pub(super) type Spread = [f64; 2];

/// Computes the difference that Bathyscope reports of the second mission from the surface of the
/// first, and the difference that follows from the error of each mission against the bottom, taken
/// one by one: the difference of the means, and the root of the sum of the squares of the standard
/// deviations.
pub(super) fn repeatability(first: &Mission, second: &Mission) -> (Spread, Spread) {
    let frames = [&first.known.survey.track.frame, &second.known.survey.track.frame];
    let measured = second.points().into_iter().map(|[east_m, north_m, z_m]| {
        let [east_m, north_m] = frames[0].to_enu(frames[1].to_lon_lat(east_m, north_m));
        [east_m, north_m, z_m]
    });
    let measured: Vec<[f64; 3]> = measured.collect();
    let matching = Matching::Surface { max_gap_m: 20.0 };
    let matches = match_points(&measured, &first.points(), matching, &Progress::new());
    let matches = matches.expect("not cancelled");
    let bed_z_m = |index: usize| {
        let [east_m, north_m, _] = measured[index];
        -first.known.truth.bed_depth_m(east_m, north_m)
    };
    let [found, of_first, of_second] = [
        matches.iter().map(|matched| matched.difference_m).collect(),
        matches.iter().map(|matched| matched.reference_z_m - bed_z_m(matched.measured)).collect(),
        matches
            .iter()
            .map(|matched| measured[matched.measured][2] - bed_z_m(matched.measured))
            .collect(),
    ]
    .map(|mut errors: Vec<f64>| Residuals::of(&mut errors).expect("points over the surface"));
    let expected = [of_second.mean_m - of_first.mean_m, of_second.sd_m.hypot(of_first.sd_m)];
    ([found.mean_m, found.sd_m], expected)
}
