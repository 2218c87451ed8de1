//! The outlier filter on uniform volumes and on surfaces, beside kiddo in the same process.

use bathyscope_bottom::cloud::outliers;
use bathyscope_log::support::progress::Progress;
use rayon::prelude::*;
use std::time::Instant;

const RADIUS_M: f64 = 1.0;
const MIN_NEIGHBORS: usize = 8;
/// Points within the radius of a point, on average.
const MEAN_NEIGHBORS: f64 = 12.0;

/// Prints a line a cloud. Goals: 0.3 s of CPU for the volume of 1e6 points, 3 s for that of 1e7.
pub(super) fn run() {
    println!("radius outlier removal, radius 1 m, min 8, about 12 neighbours a point");
    println!("cloud       points      kept  CPU s  wall s  kiddo CPU s  ratio");
    type Make = fn(usize) -> Vec<[f64; 3]>;
    let clouds: [(&str, Make); 3] = [("volume", volume), ("surface", surface), ("track", track)];
    for count in [100_000, 1_000_000, 10_000_000] {
        for (name, make) in clouds {
            line(name, &make(count));
        }
    }
}

fn line(name: &str, points: &[[f64; 3]]) {
    let progress = Progress::new();
    let (kept, cpu_s, wall_s) = timed(|| {
        outliers::keep(points, RADIUS_M, MIN_NEIGHBORS, &progress).expect("not cancelled")
    });
    let count = kept.iter().filter(|&&kept| kept).count();
    print!("{name:8} {:>9} {count:>9} {cpu_s:>6.2} {wall_s:>7.3}", points.len());
    // Ten million take kiddo half a minute and teach nothing new.
    if points.len() > 1_000_000 {
        return println!();
    }
    let (again, kiddo_s, _) = timed(|| with_kiddo(points));
    assert!(kept == again, "the filter and kiddo disagree on the {name}");
    println!(" {kiddo_s:>12.2} {:>6.1}", kiddo_s / cpu_s.max(0.01));
}

fn with_kiddo(points: &[[f64; 3]]) -> Vec<bool> {
    let tree = kiddo::ImmutableKdTree::<f64, 3>::new_from_slice(points).expect("a tree");
    let count = |point: &[f64; 3]| {
        let query = tree.query(point).within::<kiddo::SquaredEuclidean<f64>>(RADIUS_M * RADIUS_M);
        query.exclusive_boundaries().unsorted().execute().len()
    };
    points.par_iter().map(|point| count(point) > MIN_NEIGHBORS).collect()
}

/// Result, seconds of CPU over all threads, seconds on the clock.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64, f64) {
    let (cpu_s, start) = (cpu_seconds(), Instant::now());
    let result = work();
    (result, cpu_seconds() - cpu_s, start.elapsed().as_secs_f64())
}

/// CPU time of this process so far, to a hundredth of a second; 0 where there is no `/proc`.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Past the name in parentheses, user and system time are the twelfth and thirteenth fields.
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Uniform in a cube.
fn volume(count: usize) -> Vec<[f64; 3]> {
    let density = MEAN_NEIGHBORS / (4.0 / 3.0 * std::f64::consts::PI * RADIUS_M.powi(3));
    let edge_m = (count as f64 / density).cbrt();
    let mut random = Random(1);
    (0..count).map(|_| [0, 1, 2].map(|_| edge_m * random.next())).collect()
}

/// A bed 3 m down with waves of half a metre, and 5 % of points anywhere in 40 m of height.
fn surface(count: usize) -> Vec<[f64; 3]> {
    let edge_m = (count as f64 * std::f64::consts::PI * RADIUS_M.powi(2) / MEAN_NEIGHBORS).sqrt();
    let mut random = Random(2);
    let mut point = || {
        let [x, y] = [edge_m * random.next(), edge_m * random.next()];
        let bed_m = -3.0 + 0.5 * (x / 20.0).sin() + 0.3 * (y / 15.0).cos() + 0.05 * random.next();
        let wild = random.next() < 0.05;
        [x, y, if wild { 40.0 * (random.next() - 0.5) } else { bed_m }]
    };
    (0..count).map(|_| point()).collect()
}

/// A survey line across a square: most of its grid is empty.
fn track(count: usize) -> Vec<[f64; 3]> {
    let length_m = count as f64 * 2.0 * RADIUS_M / MEAN_NEIGHBORS;
    let mut random = Random(3);
    let point = |index: usize| {
        let along_m = length_m * index as f64 / count as f64;
        [
            0.6 * along_m + random.next(),
            0.8 * along_m + random.next(),
            -3.0 + 0.001 * along_m + 0.1 * random.next(),
        ]
    };
    (0..count).map(point).collect()
}

/// SplitMix64: the same clouds in every run.
struct Random(u64);

impl Random {
    /// Uniform in 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
