//! The command line as scripts use it: names, columns, units and exit codes of the contract.

mod cases;
mod clipped;
mod compare;
mod cut;
mod desktop;
mod detect;
mod evaluate;
mod killed;
mod products;
mod records;
mod refused;
mod report_page;
mod review;
mod soundings_only;
mod waterfall_options;

use crate::support;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn bathyscope(folder: &Path, args: &[&str]) -> Output {
    Command::new(crate::support::program())
        .args(args)
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the program starts")
}

pub(crate) fn run(folder: &Path, args: &[&str]) -> String {
    let output = bathyscope(folder, args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?} failed: {errors}");
    String::from_utf8(output.stdout).expect("text on stdout")
}

/// Returns the text that a run writes on stderr.
pub(crate) fn stderr_of(folder: &Path, args: &[&str]) -> String {
    let output = bathyscope(folder, args);
    assert!(output.status.success(), "{args:?} failed");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The one sentence that a failing run ends on.
pub(crate) fn refusal(folder: &Path, args: &[&str], code: i32) -> String {
    let output = bathyscope(folder, args);
    assert_eq!(output.status.code(), Some(code), "{args:?}");
    assert!(output.stdout.is_empty(), "{args:?} prints results although it failed");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const SCENE: &str = "duration_s = 20.0\n";

fn simulated(folder: &Path) {
    fs::write(folder.join("scene.toml"), SCENE).expect("a scene file");
    run(folder, &["simulate", "scene.toml", "-o", "pond", "--seed", "3"]);
}

fn header(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a product");
    text.lines().next().unwrap_or_default().to_owned()
}

#[test]
fn a_file_of_a_folder_that_only_has_the_name_of_a_log_is_named() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    fs::create_dir(folder.join("card")).expect("a folder");
    fs::rename(folder.join("pond.sl2"), folder.join("card/pond.sl2")).expect("a log");
    fs::write(folder.join("card/broken.SL3"), [7; 5000]).expect("a file");
    fs::write(folder.join("card/empty.xtf"), []).expect("a file");
    fs::write(folder.join("card/notes.txt"), "no log").expect("a file");
    let process = "process card -o out --products track --no-objects";
    let printed = stderr_of(folder, &process.split(' ').collect::<Vec<_>>());
    let named = |name: &str| {
        let lines = printed.lines().filter(|line| line.contains("passed over"));
        lines.filter(|line| line.ends_with(name)).count()
    };
    let counts = ["broken.SL3", "empty.xtf", "notes.txt", "pond.sl2"].map(named);
    assert_eq!(counts, [1, 1, 0, 0], "{printed}");
}

#[test]
fn simulate_info_process_and_filter_work_together() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    for product in ["pond.sl2", "pond.truth.csv", "pond.objects.csv"] {
        assert!(folder.join(product).is_file(), "{product}");
    }
    let before = fs::read(folder.join("pond.sl2")).expect("the log");

    let info: serde_json::Value =
        serde_json::from_str(&run(folder, &["info", "pond.sl2", "--json"])).expect("JSON");
    let pings = info["side_scan"]["pings"].as_u64().expect("a count");
    assert!(pings > 100, "{pings} pings");
    assert_eq!(info["side_scan"]["state"], "usable");

    run(folder, &["process", "pond.sl2", "-o", "out"]);
    let out = folder.join("out");
    assert_eq!(
        header(&out.join("points/first_returns.csv")),
        "ping,time_s,lon,lat,east_m,north_m,heading_deg,depth_m,port_sample,port_range_m,port_confidence,\
         starboard_sample,starboard_range_m,starboard_confidence,excluded"
    );
    assert_eq!(
        header(&out.join("points/cloud.csv")),
        "source,ping,lon,lat,east_m,north_m,z_m,kept,class,level,range_m,fault"
    );
    let rows = fs::read_to_string(out.join("points/first_returns.csv"))
        .expect("first returns")
        .lines()
        .count();
    assert_eq!(rows as u64, pings + 1, "one row a ping");
    for product in ["points/cloud.ply", "points/cloud.copc.laz"] {
        assert!(out.join(product).is_file(), "{product}");
    }
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join("report.json")).expect("a report"))
            .expect("JSON");
    assert_eq!(report["counts"]["pings"].as_u64(), Some(pings));
    assert_eq!(report["preset"], "recommended");
    assert_eq!(report["settings"]["first_return"]["method"], "tracker");
    assert_eq!(report["inputs"][0]["sha256"].as_str().map(str::len), Some(64));
    for key in ["n", "mean_m", "median_m", "sd_m", "rms_m", "mae_m", "p95_m"] {
        assert!(report["residuals"][key].is_number(), "residuals.{key}");
    }
    assert_eq!(
        fs::read(folder.join("pond.sl2")).expect("the log"),
        before,
        "a log is never modified"
    );

    run(
        folder,
        &[
            "filter",
            "out/points/cloud.ply",
            "-o",
            "kept.ply",
            "--radius",
            "1",
            "--min-neighbors",
            "3",
        ],
    );
    assert!(folder.join("kept.ply").is_file());
}

#[test]
fn later_settings_override_earlier_ones() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    fs::write(
        folder.join("mine.toml"),
        "[cloud]\ngeometry = \"nadir\"\n[first_return]\nthreshold = 0.2\n",
    )
    .expect("a settings file");
    run(
        folder,
        &[
            "process",
            "pond.sl2",
            "-o",
            "out",
            "--preset",
            "published",
            "--settings",
            "mine.toml",
            "--set",
            "first_return.threshold=0.35",
        ],
    );
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.join("out/report.json")).expect("a report"))
            .expect("JSON");
    let settings = &report["settings"];
    assert_eq!(settings["image"]["samples"], "words", "from the preset");
    assert_eq!(settings["cloud"]["geometry"], "nadir", "from the file");
    let threshold = settings["first_return"]["threshold"].as_f64().expect("a number");
    assert!((threshold - 0.35).abs() < 1e-6, "from the assignment: {threshold}");
    assert_eq!(report["preset"], "changed");
}

#[test]
fn what_cannot_be_used_is_refused_in_one_sentence() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::write(folder.join("letter.sl2"), "Dear surveyor, this is not a log.").expect("a file");
    fs::write(folder.join("empty.sl2"), "").expect("a file");

    let absent = refusal(folder, &["info", "absent.sl2"], 1);
    assert!(absent.contains("absent.sl2"), "{absent}");
    for name in ["letter.sl2", "empty.sl2"] {
        let sentence = refusal(folder, &["process", name, "-o", "out"], 1);
        assert!(sentence.contains(name) && sentence.lines().count() == 1, "{sentence}");
    }
    assert!(!folder.join("out").exists(), "nothing is written for a log that cannot be read");
    let unknown = refusal(
        folder,
        &["process", "letter.sl2", "-o", "out", "--set", "cloud.geometri=nadir"],
        1,
    );
    assert!(unknown.contains("geometri"), "{unknown}");
    refusal(folder, &["process"], 2);
    refusal(folder, &["info", "--jason", "x"], 2);
}

#[test]
fn without_a_display_the_demo_is_processed() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let output = run(folder, &["--demo"]);
    assert!(output.contains("bathyscope-out"), "{output}");
    assert!(folder.join("bathyscope-out/demo/report.json").is_file());
    assert!(folder.join("bathyscope-out/demo/window.png").is_file(), "lavapipe draws the window");
}

#[test]
fn the_real_river_is_processed_as_its_notes_say() {
    let Some(data) = support::real_data() else {
        return;
    };
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let river = data.join("humminbird-glen-canyon/Rec00001.DAT");
    let out = temporary.path().join("out");
    run(temporary.path(), &["process", &river.to_string_lossy(), "-o", &out.to_string_lossy()]);
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join("report.json")).expect("a report"))
            .expect("JSON");
    assert_eq!(report["counts"]["pings"], 3453);
    let residuals = &report["residuals"];
    let figure = |key: &str| residuals[key].as_f64().expect("a figure");
    // First returns of boulders, which are nearer than the water under the boat is deep, do not
    // count; `river` looks at the sand.
    assert!(figure("n") > 2000.0, "{residuals}");
    assert!(figure("median_m").abs() < 0.10, "{residuals}");
    assert!(figure("p95_m") < 0.80, "{residuals}");
}
