//! Tests refusals of the command line: one sentence, the right exit code, nothing half written, no
//! waiting for ever.

use super::{bathyscope, refusal, run, simulated};
use bathyscope_test_support::handmade;
use std::fs;
use std::path::Path;
#[cfg(unix)]
use std::process::{Command, Stdio};

/// A refusal of input that is one line after the progress, with these words in it.
fn one_line(folder: &Path, args: &[&str], words: &[&str]) {
    let text = refusal(folder, args, 1);
    let sentence = text.lines().last().unwrap_or_default();
    assert!(sentence.starts_with("bathyscope: "), "{args:?}: {text}");
    for word in words {
        assert!(sentence.contains(word), "{args:?}: {word} in {text}");
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_misspelt_command_is_no_log() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for (word, meant) in [("proces", "process"), ("snapshto", "snapshot")] {
        let text = refusal(folder, &[word, "pond.sl2", "-o", "out"], 2);
        let expected = format!("there is no command `{word}`; did you mean `{meant}`?");
        assert!(text.contains(&expected), "{text}");
    }
    // A file of that name is a log, and a word that is like no command a log that is not there.
    fs::write(folder.join("proces"), "no log").expect("a file");
    for word in ["proces", "pond.sl2"] {
        assert_eq!(bathyscope(folder, &[word]).status.code(), Some(1), "{word}");
    }
}

#[test]
fn a_setting_and_a_reference_that_cannot_be_used_are_told_plainly() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let comma = ["process", "pond.sl2", "--set", "draft_m=1,5"];
    one_line(folder, &comma, &["it is a number", "write 1.5"]);
    fs::write(folder.join("empty.csv"), "").expect("a file");
    fs::write(folder.join("some.csv"), "lon,lat,z\n1,2,3\n").expect("a file");
    let compare = ["compare", "some.csv", "empty.csv"];
    one_line(folder, &compare, &["the file is empty", "empty.csv"]);
}

#[test]
fn a_log_is_copied_into_formats_that_are_written_and_never_over_itself() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let before = fs::read(folder.join("pond.sl2")).expect("the log");
    let to = |name: &'static str| ["convert", "pond.sl2", "-o", name];
    one_line(folder, &to("pond.doc"), &[".xtf", ".parquet", "pond.doc"]);
    one_line(folder, &to("pond.sl2"), &["never changed", "pond.sl2"]);
    let beyond = ["convert", "pond.sl2", "-o", "part.xtf", "--pings", "5..999999"];
    one_line(folder, &beyond, &["999999", "pond.sl2"]);
    assert!(!folder.join("part.xtf").exists());
    run(folder, &["convert", "pond.sl2", "-o", "part.xtf", "--pings", "5..25"]);
    assert!(run(folder, &["info", "part.xtf"]).contains("20 pings"));
    assert!(fs::read(folder.join("pond.sl2")).expect("the log") == before);
}

#[test]
fn a_recorded_log_is_not_simulated_over() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    simulated(folder);
    fs::remove_file(folder.join("pond.truth.csv")).expect("the truth");
    let before = fs::read(folder.join("pond.sl2")).expect("the log");
    one_line(folder, &["simulate", "-o", "pond"], &["pond.sl2", "another prefix"]);
    assert_eq!(fs::read(folder.join("pond.sl2")).expect("the log"), before);
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_unopened() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for name in ["pipe.sl2", "pipe.csv", "pipe.toml"] {
        let made = Command::new("mkfifo").arg(folder.join(name)).status();
        assert!(made.expect("mkfifo").success());
    }
    std::os::unix::fs::symlink("/dev/zero", folder.join("endless.csv")).expect("a link");
    let words = ["not a file"];
    one_line(folder, &["info", "pipe.sl2"], &words);
    one_line(folder, &["info", "/dev/zero"], &words);
    for scene in ["pipe.toml", "/dev/zero"] {
        one_line(folder, &["simulate", scene, "-o", "x"], &words);
    }
    let settings = ["process", "x", "-o", "out", "--settings", "pipe.toml"];
    one_line(folder, &settings, &words);
    for cloud in ["pipe.csv", "endless.csv"] {
        let filter = ["filter", cloud, "-o", "x.csv", "--radius", "1", "--min-neighbors", "1"];
        one_line(folder, &filter, &words);
    }
}

#[cfg(unix)]
#[test]
fn a_name_that_is_not_unicode_is_a_name() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let name = OsStr::from_bytes(b"p\xFFnd.sl2");
    fs::copy(folder.join("pond.sl2"), folder.join(name)).expect("a copy");
    let info = Command::new(crate::support::program())
        .args([OsStr::new("info"), name, OsStr::new("--json")])
        .current_dir(folder)
        .output()
        .expect("the program starts");
    assert!(info.status.success(), "{info:?}");
    serde_json::from_slice::<serde_json::Value>(&info.stdout).expect("JSON");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_or_closed_stdout_is_no_panic() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let info = |stdout: Stdio| {
        let mut command = Command::new(crate::support::program());
        let command = command.args(["info", "pond.sl2"]).current_dir(folder);
        command.stdout(stdout).stderr(Stdio::piped()).spawn().expect("the program starts")
    };
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
    let output = info(full.into()).wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(1));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("stdout") && errors.lines().count() == 1, "{errors}");

    let mut reader_gone = info(Stdio::piped());
    drop(reader_gone.stdout.take());
    assert!(reader_gone.wait().expect("an end").success());
}

#[test]
fn surveys_of_one_name_get_a_folder_each() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    for side in ["a", "b"] {
        fs::create_dir(folder.join(side)).expect("a folder");
        fs::copy(folder.join("pond.sl2"), folder.join(side).join("Rec1.sl2")).expect("a copy");
    }
    run(folder, &["process", "--each", "a/Rec1.sl2", "b/Rec1.sl2", "-o", "out"]);
    assert_eq!(names(&folder.join("out")), ["Rec1", "Rec1-2"]);
    let report = fs::read_to_string(folder.join("out/Rec1-2/report.json")).expect("a report");
    assert!(report.contains("b/Rec1.sl2"), "{report}");

    // One that cannot be read costs the others nothing, and shows in the exit code.
    let output = bathyscope(folder, &["process", "no.sl2", "pond.sl2", "-o", "more"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(folder.join("more/report.json").is_file());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("no.sl2") && errors.contains("1 of 2 logs"), "{errors}");
}

#[test]
fn impossible_settings_are_refused_with_their_reason() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let cases: [(&str, &[&str]); 6] = [
        ("calibration.pings=9..1", &["A < B", "`9..1`"]),
        ("calibration.pings=5000..6000", &["5000..6000", "the log has", "pond.sl2"]),
        ("calibration.pings=10..99999", &["the log has"]),
        ("cloud.geometry=flat", &["flat", "nadir"]),
        ("outliers.min_neighbors=-1", &["-1"]),
        ("first_return.threshold=nan", &["between 0 and 1"]),
    ];
    for (setting, words) in cases {
        one_line(folder, &["process", "pond.sl2", "-o", "out", "--set", setting], words);
    }
    let files: [(&str, &[&str]); 3] = [
        ("[cloud\nalpha2_deg = 3\n", &["line 1"]),
        ("[cloud]\nalpha = 3\n", &["alpha", "`cloud`"]),
        ("[cloud]\nalpha2_deg = \"x\"\n", &["cloud.alpha2_deg"]),
    ];
    for (text, words) in files {
        fs::write(folder.join("mine.toml"), text).expect("settings");
        let args = ["process", "pond.sl2", "-o", "out", "--settings", "mine.toml"];
        let text = refusal(folder, &args, 1);
        assert_eq!(text.lines().count(), 1, "{text}");
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
    assert!(!folder.join("out").exists(), "nothing is written");
    let beyond = "calibration.pings=5000..6000";
    let snapshot = ["snapshot", "pond.sl2", "-o", "x.png", "--set", beyond];
    one_line(folder, &snapshot, &["5000..6000"]);
}

#[test]
fn outputs_that_cannot_be_are_refused_before_the_work() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let log = fs::read(folder.join("pond.sl2")).expect("the log");
    let before = names(folder);
    one_line(folder, &["process", "pond.sl2", "-o", "pond.sl2"], &["pond.sl2"]);
    one_line(folder, &["snapshot", "pond.sl2", "-o", "pond.sl2"], &[".png"]);
    one_line(folder, &["simulate", "-o", "no/pond"], &["make it first"]);
    one_line(folder, &["simulate", "-o", "."], &["folder"]);
    let filter =
        ["filter", "pond.truth.csv", "-o", "pond", "--radius", "1", "--min-neighbors", "1"];
    one_line(folder, &filter, &[".laz"]);
    assert_eq!(names(folder), before);
    assert_eq!(fs::read(folder.join("pond.sl2")).expect("the log"), log);
    for wrong in ["0", "-1", "nan", "inf"] {
        let radius = format!("--radius={wrong}");
        let args = ["filter", "x.csv", "-o", "y.csv", &radius, "--min-neighbors", "1"];
        refusal(folder, &args, 2);
    }
    refusal(
        folder,
        &["filter", "x.csv", "-o", "y.csv", "--radius", "1", "--min-neighbors", "0"],
        2,
    );
}

#[test]
fn columns_are_found_named_or_asked_for() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("points");
    let filter = |cloud: &'static str| {
        ["filter", cloud, "-o", "kept.csv", "--radius", "1", "--min-neighbors", "1"]
    };
    write("twice.csv", "x,x,y,z\n1,2,3,4\n");
    one_line(folder, &filter("twice.csv:x,y,z"), &["`x` is named twice"]);
    one_line(folder, &filter("twice.csv:y,y,z"), &["`y` is named twice"]);
    one_line(folder, &filter("twice.csv:a,b,c"), &["`a`", "x, x, y, z"]);
    write("empty.csv", "");
    run(folder, &filter("empty.csv"));
    write("strange.csv", "id;lon;lat\n1;2;3\n1;2;3\n");
    let output = bathyscope(folder, &filter("strange.csv"));
    assert!(output.status.success());
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("warning") && text.contains("`id`"), "{text}");
    // A row that is no place has no neighbours; it does not stop the others.
    write("holes.csv", "\u{feff}x,y,z\r\n1,2,3\r\nnan,2,3\r\n# rest\r\n1,2,3\r\ninf,0,0\r\n");
    let text = run(folder, &filter("holes.csv"));
    assert!(text.starts_with("kept 2 of 4"), "{text}");
}

#[test]
fn a_folder_of_logs_is_listed_and_each_log_processed() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let trip = folder.join("trip");
    fs::create_dir(&trip).expect("a folder");
    let logs = [
        ("a.sl2", handmade::sl2(&handmade::survey_frames(30))),
        ("b.sl3", handmade::sl3(&handmade::survey_frames(30), 168)),
        ("line.xtf", handmade::xtf(20, 1, 3, (-73.6, 42.7), 3.0)),
        ("notes.txt", b"a fine day".to_vec()),
    ];
    for (name, bytes) in &logs {
        fs::write(trip.join(name), bytes).expect("a file");
    }
    let text = run(folder, &["info", "trip"]);
    for words in [
        "3 logs in this folder",
        "a.sl2: Lowrance SL2",
        "b.sl3: Lowrance SL3",
        "line.xtf: XTF, start 2020-06-01",
        "process trip -o OUT",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let list: serde_json::Value =
        serde_json::from_str(&run(folder, &["info", "trip", "--json"])).expect("JSON");
    assert_eq!(list.as_array().map(Vec::len), Some(3));
    assert_eq!(list[2]["side_scan"]["pings"], 20);
    let process = ["process", "trip", "--each", "--no-objects", "--products", "track", "-o", "out"];
    run(folder, &process);
    for name in ["a", "b", "line"] {
        assert!(folder.join("out").join(name).join("report.json").is_file(), "{name}");
    }
    // They are one picture.
    let snapshot = ["snapshot", "trip", "-o", "x.png", "--view", "map"];
    run(folder, &snapshot);
    assert!(folder.join("x.png").is_file());
    fs::create_dir(folder.join("empty")).expect("a folder");
    one_line(folder, &["info", "empty"], &["a folder without a log", "SL2", "empty"]);
    // A folder with one log is that log.
    for name in ["b.sl3", "line.xtf"] {
        fs::remove_file(trip.join(name)).expect("the file");
    }
    assert!(run(folder, &["info", "trip"]).contains("Lowrance SL2"));
}

#[test]
fn what_the_system_says_is_put_plainly() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    fs::write(folder.join("two.csv"), "1 2\n3 4\n").expect("a file");
    fs::write(folder.join("short.csv"), "x,y,z\n1,2,3\n4,5\n").expect("a file");
    let filter = |name: &'static str| {
        ["filter", name, "-o", "k.csv", "--radius", "1", "--min-neighbors", "1"]
    };
    let cases: [(&[&str], &[&str]); 9] = [
        (&["info", "absent.sl2"], &["no such file or folder", "check the path", "absent.sl2"]),
        (&["process", "absent.sl2", "-o", "out"], &["no such file or folder"]),
        (&["process", "pond.sl2", "-o", "pond.sl2/out"], &["part of the path is a file"]),
        (&["process", "pond.sl2", "-o", "out", "--settings", "no.toml"], &["no such file"]),
        (&["process", "pond.sl2", "-o", "out", "--settings", "."], &["it is a folder"]),
        (&["compare", "pond.sl2", "no.csv"], &["no such file or folder"]),
        (&filter("."), &["."]),
        (&filter("two.csv"), &["line 1", "2 fields", "x, y and z", "name the columns"]),
        (&filter("short.csv"), &["line 3", "column `z`", "mend the line"]),
    ];
    for (args, words) in cases {
        one_line(folder, args, words);
        let sentence = refusal(folder, args, 1);
        assert!(!sentence.contains("os error"), "{sentence}");
    }
}

#[test]
fn a_snapshot_says_what_drew_it_and_no_more() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let output = std::process::Command::new(crate::support::program())
        .args(["snapshot", "-o", "demo.png", "--size", "320x240", "--view", "profile"])
        .current_dir(temporary.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("NODEVICE_SELECT")
        .output()
        .expect("the program starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    assert!(text.starts_with("drawn by ") && text.lines().count() == 1, "{text}");
    assert!(temporary.path().join("demo.png").is_file());
}
