//! `bathyscope process` killed at any moment: the folder holds the files of one run, and the next
//! run leaves nothing over.

use super::{run, simulated};
use bathyscope_products::outputs::{MANIFEST, RunFolder};
use bathyscope_test_support::Moments;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Kills of the test; `BATHYSCOPE_KILLS` asks for more.
const KILLS: usize = 15;
/// Folder in which a run keeps its files until all are there.
const SIDE: &str = ".bathyscope-run";
/// A file of the user's in the same folder.
const NOTES: &str = "notes.txt";

fn kills() -> usize {
    let asked = std::env::var("BATHYSCOPE_KILLS");
    asked.ok().and_then(|text| text.parse().ok()).unwrap_or(KILLS)
}

/// A run with a setting that the manifest and the report state.
fn start(folder: &Path, draft_m: f64, products: &str) -> Child {
    let draft = format!("draft_m={draft_m}");
    Command::new(crate::support::program())
        .args(["process", "pond.sl2", "--no-objects", "-o", "out"])
        .args(["--products", products, "--set", &draft])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts")
}

fn names(folder: &Path) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() && name != SIDE {
            let inner = self::names(&entry.path());
            names.extend(inner.iter().map(|file| format!("{name}/{file}")));
        } else {
            _ = names.insert(name);
        }
    }
    names
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a file")).expect("JSON")
}

/// Checks that all files are of the run that the manifest names, and no other is there. Returns the
/// draft.
fn draft_of_whole_run(out: &Path) -> f64 {
    let manifest = json(&out.join(MANIFEST));
    let mut expected: BTreeSet<String> = [MANIFEST, NOTES].map(str::to_owned).into();
    let draft_m = manifest["settings"]["draft_m"].as_f64().expect("a draft");
    for file in manifest["files"].as_array().expect("files") {
        let name = file["file"].as_str().expect("a name");
        let bytes = fs::read(out.join(name)).expect("a file that the report names");
        let hash: String =
            Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(file["sha256"], hash.as_str(), "{name}");
        assert_eq!(file["bytes"].as_u64(), Some(bytes.len() as u64), "{name}");
        expected.insert(name.to_owned());
    }
    let report = json(&out.join("report.json"));
    assert_eq!(report["run"], manifest["run"]);
    assert_eq!(report["settings"], manifest["settings"]);
    let mut there = names(out);
    there.remove(SIDE);
    assert_eq!(there, expected);
    draft_m
}

#[test]
fn a_killed_run_leaves_the_files_of_one_run() {
    const SOME: &str = "cloud,track,depth,report";
    const OTHERS: &str = "cloud,xyz,isobaths,residuals";
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let out = folder.join("out");
    let began = Instant::now();
    assert!(start(folder, 0.0, SOME).wait().expect("a run").success());
    let whole = began.elapsed();
    fs::write(out.join(NOTES), "mine").expect("a file");
    assert_eq!(draft_of_whole_run(&out), 0.0);
    // What a version left that wrote its files one by one.
    fs::write(out.join("cloud.csv.4294967294.part"), "half").expect("a file");

    let mut moments = Moments(14);
    let (mut before_m, mut at_work, mut at_swap) = (0.0, 0, 0);
    for kill in 1..=kills() {
        let draft_m = 0.01 * kill as f64;
        let products = if kill % 2 == 0 { SOME } else { OTHERS };
        let mut child = start(folder, draft_m, products);
        std::thread::sleep(Duration::from_secs_f64(1.1 * whole.as_secs_f64() * moments.share()));
        child.kill().expect("a run, or what is left of it");
        child.wait().expect("a run that was killed");
        let journal = out.join(SIDE).join("commit.json").exists();
        at_work += usize::from(out.join(SIDE).exists());
        if !out.join(MANIFEST).exists() {
            assert!(journal, "without a manifest a swap is under way");
        }
        if journal {
            at_swap += 1;
            // The next run of any kind finishes it before it does anything else.
            drop(RunFolder::begin(&out).expect("a folder that can be written into"));
        }
        let found_m = draft_of_whole_run(&out);
        assert!(
            found_m == before_m || (found_m - draft_m).abs() < 1e-9,
            "kill {kill}: {found_m}, neither {before_m} nor {draft_m}"
        );
        before_m = found_m;
    }
    eprintln!("{} kills: {at_work} left a side folder, {at_swap} of them in the swap", kills());
    assert!(start(folder, 9.0, SOME).wait().expect("a run").success());
    assert_eq!(draft_of_whole_run(&out), 9.0);
    assert!(!out.join(SIDE).exists());
    assert_eq!(fs::read(out.join(NOTES)).expect("a file"), b"mine");
}

#[test]
fn detect_takes_its_files_out_of_the_run_that_lies_there() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    run(folder, &["process", "pond.sl2", "-o", "out", "--products", "depth"]);
    let out = folder.join("out");
    let listed = || {
        let manifest = json(&out.join(MANIFEST));
        let files = manifest["files"].as_array().expect("files").iter();
        let names = files.map(|file| file["file"].as_str().expect("a name").to_owned());
        names.collect::<BTreeSet<String>>()
    };
    assert!(listed().contains("objects/detections.csv"));
    run(folder, &["detect", "pond.sl2", "-o", "out", "--score", "0.9"]);
    assert!(out.join("objects/detections.csv").exists() && out.join("depth/depth.tif").exists());
    assert!(listed().contains("depth/depth.tif"));
    assert!(!listed().iter().any(|name| name.starts_with("objects/")));
    assert!(!out.join(SIDE).exists());

    // A run without objects has none of an earlier one beside it, and says so.
    run(folder, &["process", "pond.sl2", "-o", "out", "--products", "depth"]);
    let bare = ["process", "pond.sl2", "-o", "out", "--no-objects", "--products", "depth"];
    let text = run(folder, &bare);
    assert!(text.contains("removed of an earlier run: objects/detections.csv"), "{text}");
    assert!(!out.join("objects").exists());
}

/// A folder of the version before this one, with all files of the run on top and a record beside
/// each.
fn write_flat_run(out: &Path) {
    fs::create_dir(out).expect("a folder");
    let mut files = Vec::new();
    for name in
        ["depth.tif", "depth.tif.json", "depth.qml", "track.gpx", "track.gpx.json", "cloud.csv"]
    {
        fs::write(out.join(name), name).expect("a file");
        let sha256: String =
            (Sha256::digest(name).iter()).map(|byte| format!("{byte:02x}")).collect();
        files.push(serde_json::json!({ "file": name, "bytes": name.len(), "sha256": sha256 }));
    }
    let report =
        serde_json::json!({ "program": "bathyscope 0.1.0", "settings": {}, "files": files });
    fs::write(out.join("report.json"), report.to_string()).expect("a report");
}

#[test]
fn files_of_a_version_without_subfolders_are_removed_or_named() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let out = folder.join("out");
    write_flat_run(&out);
    // Changed since, and one that no manifest names.
    fs::write(out.join("track.gpx"), "mine").expect("a file");
    fs::write(out.join("detections.csv"), "mine").expect("a file");
    fs::write(out.join(NOTES), "mine").expect("a file");
    // A search takes the place of its own files only, and says which of a version without
    // subfolders stay.
    let args = "detect pond.sl2 -o out --score 0.9";
    let text = run(folder, &args.split(' ').collect::<Vec<_>>());
    let said = "; left from before, not of this run: detections.csv\n";
    assert!(text.ends_with(said), "{text}");
    assert!(out.join("objects/detections.csv").is_file() && out.join("depth.tif").is_file());
    fs::remove_dir_all(out.join("objects")).expect("the files of the search");

    let args = "process pond.sl2 -o out --no-objects --products depth";
    let text = run(folder, &args.split(' ').collect::<Vec<_>>());
    let said = "removed of an earlier run: cloud.csv, depth.qml, depth.tif; \
                left from before, not of this run: detections.csv, track.gpx";
    assert!(text.contains(said), "{text}");
    let mut there = names(&out);
    for name in ["track.gpx", "detections.csv", NOTES] {
        assert!(there.remove(name), "{name}");
    }
    let manifest = json(&out.join(MANIFEST));
    let listed = manifest["files"].as_array().expect("files").iter();
    let mut expected: BTreeSet<String> =
        listed.map(|file| file["file"].as_str().expect("a name").to_owned()).collect();
    expected.insert(MANIFEST.to_owned());
    assert_eq!(there, expected);
}
