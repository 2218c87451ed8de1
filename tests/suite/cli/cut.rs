//! Logs that are cut, overwritten or removed while `bathyscope process` reads them: it ends by
//! itself, with all products or none.

use super::simulated;
use bathyscope_test_support::Moments;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Times that each thing is done.
const ROUNDS: usize = 4;

/// A run during which something is done to the log at some moment.
fn process(folder: &Path, moment: Duration, act: impl FnOnce(&Path)) -> Output {
    let child = Command::new(crate::support::program())
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

fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Checks that a run ended with all products of one of two states of the log, or with a sentence
/// and none. Returns the sentence.
fn refused(folder: &Path, output: &Output, states: [&[u8]; 2]) -> Option<String> {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let out = folder.join("out");
    match output.status.code() {
        Some(0) => {
            let manifest = fs::read(out.join("manifest.json")).expect("a manifest");
            let manifest: Value = serde_json::from_slice(&manifest).expect("JSON");
            let read = manifest["inputs"][0]["sha256"].as_str().expect("a hash");
            assert!(states.map(sha256).iter().any(|state| state == read), "{said}");
            None
        }
        Some(1) => {
            let last = said.lines().last().unwrap_or_default().to_owned();
            assert!(last.starts_with("bathyscope: "), "{said}");
            assert!(!last.contains("a fault in Bathyscope"), "{said}");
            assert!(!out.exists(), "{said}");
            Some(last)
        }
        _ => panic!("it was ended: {}: {said}", output.status),
    }
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
    let (mut cut, mut overwritten) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        for to in [0, 2048, 4096, bytes.len() / 2] {
            again();
            let output = process(folder, moment(), |log| {
                let file = File::options().write(true).open(log).expect("the log");
                file.set_len(to as u64).expect("a cut");
            });
            cut.extend(refused(folder, &output, [&bytes, &bytes[..to]]));
        }
        again();
        let other: Vec<u8> = bytes.iter().map(|byte| byte ^ 0x5A).collect();
        let output = process(folder, moment(), |log| {
            let mut file = File::options().write(true).open(log).expect("the log");
            file.write_all(&other).expect("other bytes");
        });
        overwritten.extend(refused(folder, &output, [&bytes, &other]));
        again();
        let output = process(folder, moment(), |log| fs::remove_file(log).expect("no log"));
        let refused = refused(folder, &output, [&bytes, &bytes]);
        assert!(refused.is_none_or(|text| text.contains("no such file")));
    }
    eprintln!("{cut:#?}\n{overwritten:#?}");
    let is_said = |said: &[String], what: &str| said.iter().any(|text| text.contains(what));
    assert!(is_said(&cut, "became shorter"), "never cut while it was read");
    assert!(is_said(&overwritten, "changed"), "never overwritten");
}
