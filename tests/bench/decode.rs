//! Opening logs of each format, beside a plain read of the same bytes: a 500 MB SL2, its copy as
//! XTF, and the files that BATHYSCOPE_BENCH_LOGS names (as PATH has folders).

use crate::large_log;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::export::{LogPartChoice, copy_log};
use bathyscope_products::pipeline::Settings;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs of a log.
const RUNS: usize = 5;

/// Runs the benchmark and prints ratios.
pub(super) fn run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.sl2");
    large_log::write(&path, 500 << 20).expect("a large log");
    let copy = folder.path().join("large.xtf");
    let survey = bathyscope_log::formats::open(&path, &Progress::new()).expect("a log that opens");
    let (settings, all) = (Settings::default(), LogPartChoice::default());
    let positions = settings.position_settings();
    copy_log(&copy, &survey, positions, &all, &Progress::new()).expect("a copy");
    drop(survey);
    let named = std::env::var_os("BATHYSCOPE_BENCH_LOGS").unwrap_or_default();
    let named: Vec<PathBuf> = std::env::split_paths(&named).collect();
    for path in [path, copy].iter().chain(&named) {
        compare(path);
    }
}

/// Prints medians of a log's times.
fn compare(path: &Path) {
    let rows: Vec<Times> = (0..RUNS).map(|_| once(path)).collect();
    let median = |of: fn(&Times) -> f64| {
        let mut values: Vec<f64> = rows.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let read = median(|times| times.read_s);
    let mb = rows[0].bytes as f64 / 1e6;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    println!(
        "{name}: {mb:.1} MB, {} pings, medians of {RUNS} runs in turn, file cached",
        rows[0].pings
    );
    println!("  plain read            {read:.3} s  {:.0} MB/s", mb / read);
    for (what, time) in [
        ("open", median(|times| times.open_s)),
        ("open, every sample", median(|times| times.decode_s)),
    ] {
        println!("  {what:20}  {time:.3} s  {:.2} x the read", time / read);
    }
}

/// Seconds that a log takes.
struct Times {
    /// A plain read of all of its files.
    read_s: f64,
    /// Opening it.
    open_s: f64,
    /// Opening it, with a pass over every side-scan sample.
    decode_s: f64,
    bytes: u64,
    pings: usize,
}

fn once(path: &Path) -> Times {
    let start = Instant::now();
    let survey = bathyscope_log::formats::open(path, &Progress::new()).expect("a log that opens");
    let open_s = start.elapsed().as_secs_f64();
    let sum = sum_samples(&survey);
    let decode_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let read = survey.source.files.iter().map(|file| plain_read(file));
    let (bytes, all) = read.fold((0, sum), |sum, file| (sum.0 + file.0, sum.1 + file.1));
    let read_s = start.elapsed().as_secs_f64();
    assert!(all > 0);
    Times { read_s, open_s, decode_s, bytes, pings: survey.side_scan.len() }
}

/// Bytes of a file, and their sum: touching each byte keeps the read honest.
fn plain_read(path: &Path) -> (u64, u64) {
    let mut file = File::open(path).expect("the log");
    let mut buffer = vec![0; 1 << 20];
    let (mut bytes, mut sum) = (0, 0);
    while let Ok(count @ 1..) = file.read(&mut buffer) {
        bytes += count as u64;
        sum += buffer[..count].iter().map(|byte| u64::from(*byte)).sum::<u64>();
    }
    (bytes, sum)
}

fn sum_samples(survey: &Survey) -> u64 {
    let pings = 0..survey.side_scan.len();
    let sides = pings.flat_map(|ping| Side::BOTH.map(|side| survey.samples(ping, side)));
    let levels = sides.flatten().map(|samples| match samples.stored_u8() {
        Some((bytes, _)) => bytes.iter().map(|byte| u64::from(*byte)).sum::<u64>(),
        None => (0..samples.len()).map(|index| u64::from(samples.wide(index))).sum(),
    });
    levels.sum()
}
