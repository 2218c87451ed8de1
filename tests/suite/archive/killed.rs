//! An archive whose runs are killed at any moment: the next run makes the same bytes.

use super::{add, files, sail, scene};
use crate::cli::run;
use bathyscope_products::archive::Archive;
use bathyscope_test_support::Moments;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Kills of the test; `BATHYSCOPE_KILLS` asks for more.
const KILLS: usize = 10;
const LOGS: [&str; 3] = ["log-0.sl2", "log-1.sl2", "log-2.sl2"];

/// Runs the program and kills it after a time.
fn killed(folder: &Path, args: &[&str], after: Duration) {
    let mut child = Command::new(crate::support::program())
        .args(args)
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(after);
    child.kill().ok();
    child.wait().expect("it ends");
}

/// The files under final names.
fn final_files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut there = if folder.is_dir() { files(folder) } else { BTreeMap::new() };
    there.retain(|name, _| {
        !name.split('/').any(|part| part.starts_with('.') || part.ends_with(".part"))
    });
    there
}

#[test]
fn what_a_killed_run_leaves_is_whole_and_the_next_run_gives_the_same_bytes() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for log in 0..3 {
        sail(folder, log, &scene(log, [3.0, -4.0], 0.3 * f64::from(log)));
    }
    let began = Instant::now();
    add(folder, &LOGS);
    let process = began.elapsed();
    run(folder, &["archive", "archive"]);
    let build = began.elapsed() - process;
    let whole = final_files(&folder.join("archive"));
    let asked = std::env::var("BATHYSCOPE_KILLS").ok().and_then(|text| text.parse().ok());
    let mut moments = Moments(11);
    for kill in 0..asked.unwrap_or(KILLS) {
        std::fs::remove_dir_all(folder.join("archive")).expect("an archive");
        let to_archive =
            ["process", LOGS[0], LOGS[1], LOGS[2], "-o", "archive", "--products", "tiles"];
        let part = |all: Duration, share: f64| all.mul_f64(share);
        killed(folder, &to_archive, part(process, moments.share()));
        let check = || {
            for (name, bytes) in final_files(&folder.join("archive")) {
                assert!(whole.get(&name) == Some(&bytes), "kill {kill}: {name}");
            }
        };
        check();
        if let Ok(archive) = Archive::open(&folder.join("archive")) {
            // Whatever counts has all of its rows.
            for log in archive.logs().expect("records") {
                for file in log.tiles.iter().flat_map(|rows| &rows.files) {
                    assert!(folder.join("archive").join(&file.file).is_file(), "{}", file.file);
                }
            }
        }
        add(folder, &LOGS);
        killed(folder, &["archive", "archive"], part(build, moments.share()));
        check();
        run(folder, &["archive", "archive"]);
        assert!(final_files(&folder.join("archive")) == whole, "kill {kill}: another archive");
    }
}
