//! Logs that are cut, overwritten or removed while `bathyscope process` reads them: it ends by itself, with all products or none.

use super::simulated;
use crate::suite::support::Moments;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Times that each thing is done.
const ROUNDS: usize = 4;

/// A run during which something is done to the log at some moment.
fn process(folder: &Path, moment: Duration, act: impl FnOnce(&Path)) -> Output {
    let child = Command::new(crate::suite::support::program())
        .args(["process", "pond.sl2", "--no-objects", "-o", "out"])
        .args(["--products", "depth,mosaic,track"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(moment);
    act(&folder.join("pond.sl2"));
    child.wait_with_output().expect("an end")
}

/// That a run ended as one of a whole log does, or said what became of the log and left nothing. Which?
fn ended_well(folder: &Path, output: &Output, words: &[&str]) -> bool {
    let said = String::from_utf8_lossy(&output.stderr);
    let out = folder.join("out");
    match output.status.code() {
        Some(0) => assert!(out.join("manifest.json").is_file(), "{said}"),
        Some(1) => {
            let last = said.lines().last().unwrap_or_default();
            assert!(words.iter().any(|words| last.contains(words)), "{said}");
            assert!(last.contains("pond.sl2"), "{said}");
            assert!(!out.exists(), "{said}");
        }
        _ => panic!("it was ended: {}: {said}", output.status),
    }
    output.status.success()
}

#[test]
fn a_log_that_is_cut_overwritten_or_removed_ends_no_run_badly() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let log = folder.join("pond.sl2");
    let bytes = fs::read(&log).expect("the log");
    let again = || {
        fs::write(&log, &bytes).expect("the log");
        fs::remove_dir_all(folder.join("out")).ok();
    };
    let began = Instant::now();
    assert!(process(folder, Duration::ZERO, |_| ()).status.success());
    let whole = began.elapsed();

    let mut moments = Moments(15);
    let mut moment = || whole.mul_f64(moments.share());
    let shorter = ["became shorter", "cannot be read any more", "is empty"];
    let mut refused = 0;
    for round in 0..ROUNDS {
        for to in [0, 2048, 4096, bytes.len() as u64 / 2] {
            again();
            let output = process(folder, moment(), |log| {
                let file = File::options().write(true).open(log).expect("the log");
                file.set_len(to).expect("a cut");
            });
            // A log that was cut before it was opened is a shorter one; cut to next to nothing it is none.
            let words = [&shorter[..], &["damaged", "not a sonar log"]].concat();
            refused += usize::from(!ended_well(folder, &output, &words));
        }
        again();
        let output = process(folder, moment(), |log| {
            let mut file = File::options().write(true).open(log).expect("the log");
            file.write_all(&vec![round as u8; bytes.len()])
                .expect("other bytes");
        });
        ended_well(folder, &output, &["was changed", "not a sonar log"]);
        again();
        let output = process(folder, moment(), |log| {
            fs::remove_file(log).expect("no log")
        });
        ended_well(folder, &output, &["no such file"]);
    }
    eprintln!(
        "{refused} of {} runs of a log that was cut were refused",
        4 * ROUNDS
    );
    assert!(refused > 0, "the log was never cut while it was read");
}
