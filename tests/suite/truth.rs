//! Results held against what a simulated survey hides.

use bathyscope::cloud::PointSource;
use bathyscope::formats;
use bathyscope::pipeline::Products;
use bathyscope::progress::Progress;
use bathyscope::simulation::{Scene, Simulated, simulate};
use bathyscope::survey::{Side, Survey};

/// A simulated survey, opened as any log would be, and its truth.
pub struct KnownSurvey {
    pub survey: Survey,
    pub truth: Simulated,
}

impl KnownSurvey {
    pub fn new(scene: &Scene, seed: u64) -> Self {
        let progress = Progress::new();
        let truth = simulate(scene, seed, &progress).expect("a simulated survey");
        let survey = formats::open_bytes("simulated.sl2", truth.sl2_bytes(), &progress)
            .expect("a log that opens");
        Self { survey, truth }
    }

    /// Claimed depth minus true depth of the bed at the claimed place, for every kept side-scan point. Weed is left out:
    /// there the first return is no bottom.
    pub fn depth_errors_m(&self, products: &Products) -> Vec<f64> {
        let points = products.cloud.points.iter().zip(products.kept.iter());
        let kept = points.filter(|(_, kept)| **kept).map(|(point, _)| point);
        kept.filter_map(|point| {
            let side = match point.source {
                PointSource::Port => Side::Port,
                PointSource::Starboard => Side::Starboard,
                PointSource::DownScan => return None,
            };
            let ground = !self.truth.pings.get(point.ping as usize)?.side(side).weed;
            ground.then(|| -point.z_m - self.truth.bed_depth_m(point.east_m, point.north_m))
        })
        .collect()
    }
}
