//! A log that is followed: what each new ping costs, when the log has 10 000 pings and when it has
//! 100 000.
//!
//! One step takes in what was written, reads the tail, extends the survey and its results, as the
//! window does four times a second; 100 pings are what a recorder writes in that time at 20 times
//! real speed. Beside it stands the run over the whole log, which is repeated whenever the log grew
//! by a quarter.

use crate::large_log;
use bathyscope_log::formats::{GrowingLog, open_tail};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Survey, SurveyVersions};
use bathyscope_products::pipeline::{self, GrowingResults, Products, Settings, extend};
use bathyscope_simulation::{Scene, simulate};
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Pings of the log when it is followed.
const LENGTHS: [usize; 2] = [10_000, 100_000];
/// Samples a side: fewer than a recorder's, so that the log fits into memory as well.
const SAMPLES: u32 = 400;
/// Steps timed of each length.
const STEPS: usize = 12;
/// Side-scan pings added in a step: 0.25 s at 20 times the 20 pings a second of a recorder.
const ADDED: usize = 100;

/// Prints the work of a ping at each length and their ratio.
fn run_steps(folder: &Path) -> [f64; 2] {
    let path = folder.join("large.sl2");
    let mut scene = Scene::default();
    scene.recorder.samples_per_side = SAMPLES;
    let survey = simulate(&scene, 1, &Progress::new()).expect("nobody cancels");
    let (log, pings) = (survey.sl2_bytes(), survey.pings.len());
    let laps = (LENGTHS[1] + (STEPS + 1) * ADDED).div_ceil(pings);
    large_log::write_patches(&path, &log, 0, log.len() * laps).expect("room for the log");
    let whole = std::fs::read(&path).expect("the log");
    let whole_pings = pings * laps;
    println!("{} pings in {} MB", whole_pings, whole.len() >> 20);
    LENGTHS.map(|length| measure(folder, &whole, whole_pings, length))
}

/// The benchmark.
pub(super) fn run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [short, long] = run_steps(folder.path());
    println!(
        "ratio of the work for a ping, {} to {} pings: {:.2}",
        LENGTHS[1],
        LENGTHS[0],
        long / short
    );
}

fn measure(folder: &Path, whole: &[u8], whole_pings: usize, length: usize) -> f64 {
    let progress = Progress::new();
    let bytes_a_ping = whole.len() / whole_pings;
    let mut end = (length * bytes_a_ping).min(whole.len() - STEPS * ADDED * bytes_a_ping);
    let path = folder.join(format!("{length}.sl2"));
    std::fs::write(&path, &whole[..end]).expect("room for the log");
    let settings = Settings::default();
    let mut survey = bathyscope_log::formats::open(&path, &progress).expect("a log");
    let start = Instant::now();
    let mut products = pipeline::run(&survey, &settings, None, &progress, |_| ()).expect("results");
    let whole_ms = start.elapsed().as_secs_f64() * 1e3;
    let mut growing = GrowingLog::start(&survey, &progress).expect("a file");
    let mut results = GrowingResults::measure(&survey, &settings, &progress).expect("a scale");
    let mut versions = SurveyVersions::default();
    let settings = Arc::new(settings);
    let mut file = OpenOptions::new().append(true).open(&path).expect("the log");
    let mut step_ms = Vec::new();
    let first = survey.side_scan.len();
    for _ in 0..STEPS {
        file.write_all(&whole[end..end + ADDED * bytes_a_ping]).expect("room");
        end += ADDED * bytes_a_ping;
        let start = Instant::now();
        (survey, products) =
            step(&mut growing, &survey, &products, &settings, &mut results, &mut versions);
        step_ms.push(start.elapsed().as_secs_f64() * 1e3);
    }
    step_ms.sort_by(f64::total_cmp);
    let step_ms = step_ms[STEPS / 2];
    let ping_ms = step_ms * STEPS as f64 / (survey.side_scan.len() - first) as f64;
    println!(
        "{first:6} pings: {step_ms:6.1} ms a step of {ADDED}, {ping_ms:.3} ms a ping; all of it again takes {:.0} ms, {:.3} ms a ping when it grew by a quarter",
        whole_ms,
        whole_ms / (0.2 * first as f64),
    );
    ping_ms
}

fn step(
    growing: &mut GrowingLog,
    survey: &Survey,
    products: &Products,
    settings: &Arc<Settings>,
    results: &mut GrowingResults,
    versions: &mut SurveyVersions,
) -> (Survey, Products) {
    let progress = Progress::new();
    growing.look(&progress).expect("it grows");
    let seam = survey.seam().expect("a seam");
    let files = growing.bytes().expect("bytes");
    let tail = open_tail(survey, &seam, files, &progress).expect("a tail");
    let longer = survey.extended(tail, &seam, versions).expect("it goes on");
    let unchanged = longer.side_scan.partition_point(|ping| ping.time_s < seam.time_s);
    let made = extend(&longer, unchanged, products, settings, results, &progress);
    (longer, made.expect("results"))
}
