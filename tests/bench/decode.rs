//! Opening a 500 MB SL2, beside a plain read of the same bytes; and the memory that a 2 GB log takes while open.

use crate::bench::large_log;
use crate::support::progress::Progress;
use crate::survey::{Side, Survey};
use std::fs::File;
use std::io::Read as _;
use std::path::Path;
use std::time::Instant;

/// Runs the benchmark and prints ratios.
pub(super) fn run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.sl2");
    let bytes = large_log::write(&path, 500 << 20).expect("a large log");
    let mut rows: Vec<[f64; 3]> = (0..5).map(|_| once(&path)).collect();
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let median = |column: usize| {
        let mut values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (read, open, decode) = (median(0), median(1), median(2));
    let mb = bytes as f64 / 1e6;
    println!(
        "{mb:.0} MB of SL2, medians of {} runs in turn, file cached",
        rows.len()
    );
    println!("  plain read            {read:.3} s  {:.0} MB/s", mb / read);
    println!(
        "  open                  {open:.3} s  {:.2} x the read",
        open / read
    );
    println!(
        "  open, every sample    {decode:.3} s  {:.2} x the read",
        decode / read
    );
}

/// Seconds of a plain read, of opening, and of opening with a pass over every side-scan sample.
fn once(path: &Path) -> [f64; 3] {
    let start = Instant::now();
    let mut file = File::open(path).expect("the log");
    let mut buffer = vec![0; 1 << 20];
    let mut sum = 0_u64;
    while let Ok(count @ 1..) = file.read(&mut buffer) {
        // Touching each byte keeps the read honest.
        sum += buffer[..count]
            .iter()
            .map(|byte| u64::from(*byte))
            .sum::<u64>();
    }
    let read = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let survey = crate::formats::open(path, &Progress::new()).expect("a log that opens");
    let open = start.elapsed().as_secs_f64();
    sum += sum_samples(&survey);
    let decode = start.elapsed().as_secs_f64();
    assert!(sum > 0);
    [read, open, decode]
}

fn sum_samples(survey: &Survey) -> u64 {
    let pings = 0..survey.side_scan.len();
    let sides = pings.flat_map(|ping| Side::BOTH.map(|side| survey.samples(ping, side)));
    let stored = sides.flatten().filter_map(|samples| samples.stored_u8());
    stored
        .map(|(bytes, _)| bytes.iter().map(|byte| u64::from(*byte)).sum::<u64>())
        .sum()
}
