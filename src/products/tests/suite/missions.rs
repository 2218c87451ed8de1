//! Two missions over one pond, whose agreement the simulation knows.

use super::truth::{KnownSurvey, results};
use bathyscope_bottom::bathymetry::SurfaceSettings;
use bathyscope_bottom::bathymetry::compare::{Matching, match_points};
use bathyscope_bottom::cloud::Residuals;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::{Products, Settings};
use bathyscope_simulation::Scene;

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
        counted.map(|point| [point.east_m, point.north_m, point.z_m]).collect()
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
