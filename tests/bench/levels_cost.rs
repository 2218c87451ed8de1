//! Measures the cost of depths from echo levels beside that of the surface that they correct, on a
//! survey of ten lines and 100 000 pings.

use crate::lines::ten_lines;
use crate::resources::{peak_from_here_mb, peak_mb, processor_s};
use bathyscope_bottom::bathymetry::SwathDepth;
use bathyscope_log::support::geo::{Crs, MapPlane};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::{self, ProcessedLog, Settings, joint_depth_surface};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const PINGS_A_LINE: f64 = 10_000.0;
/// Each is made so often, in turn; the least time counts.
const TIMES: usize = 3;

/// Prints time and memory of both, and the ratio.
pub(super) fn run() {
    let progress = Progress::new();
    let survey = Arc::new(ten_lines(PINGS_A_LINE));
    let mut least_s = [f64::INFINITY; 2];
    let mut most_mb = [0.0_f64; 2];
    let processed = [SwathDepth::Off, SwathDepth::Always].map(|swath| {
        let mut settings = Settings::default();
        settings.surface.swath = swath;
        let products = pipeline::run(&survey, &settings, None, &progress, |_| ());
        [ProcessedLog { survey: survey.clone(), products: products.expect("not cancelled") }]
    });
    let map = {
        let origin = survey.track.frame.origin();
        MapPlane::new(Crs::utm(origin), origin)
    };
    for _ in 0..TIMES {
        for (which, logs) in processed.iter().enumerate() {
            let (before_mb, before_s, began) = (peak_from_here_mb(), processor_s(), Instant::now());
            black_box(joint_depth_surface(logs, &map, &progress).expect("not cancelled"));
            let taken_s = processor_s() - before_s;
            least_s[which] = least_s[which].min(taken_s);
            let more_mb = peak_mb().zip(before_mb).map_or(0.0, |(peak, before)| peak - before);
            most_mb[which] = most_mb[which].max(more_mb);
            println!(
                "{} {taken_s:.2} s of processor, {:.2} s on the clock, {more_mb:.0} MB at the peak",
                ["surface", "from_levels "][which],
                began.elapsed().as_secs_f64()
            );
        }
    }
    println!(
        "{} pings: from_levels {:.2} times the surface's time, {:.1} times its memory",
        survey.side_scan.len(),
        least_s[1] / least_s[0],
        most_mb[1] / most_mb[0]
    );
}
