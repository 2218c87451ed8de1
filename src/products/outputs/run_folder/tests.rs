use super::*;

fn names(folder: &Path) -> Vec<String> {
    names_in(folder).unwrap()
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}

/// Writes files and a manifest that lists them.
fn write(run: &RunFolder, files: &[&str], content: &str) {
    let new = run.path();
    for file in files {
        fs::create_dir_all(new.join(file).parent().unwrap()).unwrap();
        fs::write(new.join(file), content).unwrap();
    }
    let files = run.files(&[], &Progress::new()).unwrap();
    let manifest = serde_json::json!({ "program": "bathyscope 1", "run": content, "files": files });
    fs::write(new.join("manifest.json"), manifest.to_string()).unwrap();
}

fn written(folder: &Path, files: &[&str], content: &str) -> Replaced {
    let run = RunFolder::begin(folder).unwrap();
    write(&run, files, content);
    run.commit("manifest.json").unwrap()
}

#[test]
fn a_folder_holds_the_files_of_one_run_and_those_of_its_user() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let paths =
        ["mosaic/mosaic.tif", "objects/chips/0001-rock.png", "points/cloud.csv", "track/track.gpx"];
    written(&out, &paths, "one");
    fs::write(out.join("notes.txt"), "mine").unwrap();
    fs::write(out.join("objects/chips/best.png"), "mine").unwrap();
    // The file was changed by hand since the run.
    fs::write(out.join("track/track.gpx"), "mine").unwrap();
    let gone = written(&out, &["points/cloud.csv", "depth/depth.tif"], "two");
    assert_eq!(gone.removed, ["mosaic/mosaic.tif"]);
    assert_eq!(gone.kept, ["track/track.gpx"]);
    assert_eq!(
        names(&out),
        [
            "depth/depth.tif",
            "manifest.json",
            "notes.txt",
            "objects/chips/best.png",
            "points/cloud.csv",
            "track/track.gpx"
        ]
    );
    assert!(!out.join("mosaic").exists(), "an empty folder");
    assert_eq!(text(&out.join("points/cloud.csv")), "two");
    assert_eq!(text(&out.join("track/track.gpx")), "mine");
}

#[test]
fn a_run_that_fails_leaves_all_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    drop(RunFolder::begin(&out).unwrap());
    assert!(!out.exists());
    written(&out, &["cloud.csv"], "one");
    let before = text(&out.join("manifest.json"));
    let run = RunFolder::begin(&out).unwrap();
    write(&run, &["cloud.csv", "depth.tif"], "two");
    drop(run);
    assert_eq!(names(&out), ["cloud.csv", "manifest.json"]);
    assert_eq!(text(&out.join("manifest.json")), before);
    // A folder in the way is reported before anything is moved.
    fs::create_dir(out.join("depth.tif")).unwrap();
    let run = RunFolder::begin(&out).unwrap();
    write(&run, &["cloud.csv", "depth.tif"], "two");
    let refusal = run.commit("manifest.json").unwrap_err();
    assert!(refusal.to_string().contains("depth.tif"), "{refusal}");
    assert_eq!(text(&out.join("manifest.json")), before);
    assert_eq!(text(&out.join("cloud.csv")), "one");
    // A file in the place of a subfolder is reported too.
    fs::write(out.join("objects"), "mine").unwrap();
    let run = RunFolder::begin(&out).unwrap();
    write(&run, &["objects/chips/0001-rock.png"], "two");
    let refusal = run.commit("manifest.json").unwrap_err();
    assert!(refusal.to_string().ends_with("objects"), "{refusal}");
    assert_eq!(text(&out.join("manifest.json")), before);
    assert!(!out.join(SIDE).exists());
}

#[test]
fn two_runs_do_not_write_into_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let first = RunFolder::begin(folder.path()).unwrap();
    let refusal = RunFolder::begin(folder.path()).unwrap_err();
    assert!(refusal.to_string().contains("another run"), "{refusal}");
    write(&first, &["cloud.csv"], "one");
    first.commit("manifest.json").unwrap();
    RunFolder::begin(folder.path()).unwrap();
    assert_eq!(names(folder.path()), ["cloud.csv", "manifest.json"]);
}

/// Leaves the folder in the state of a killed process: no destructor runs, but the lock is gone.
fn kill(mut run: RunFolder) {
    drop(run.lock.take());
}

#[test]
fn the_next_run_clears_away_what_was_killed_before_it_was_decided() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    written(out, &["cloud.csv"], "one");
    let run = RunFolder::begin(out).unwrap();
    write(&run, &["cloud.csv", "depth.tif"], "two");
    kill(run);
    // The run was killed while it wrote the journal.
    fs::write(out.join(SIDE).join("commit.json.7.part"), "{").unwrap();
    assert_eq!(text(&out.join("cloud.csv")), "one");
    assert!(out.join(SIDE).exists());
    drop(RunFolder::begin(out).unwrap());
    assert_eq!(names(out), ["cloud.csv", "manifest.json"]);
    assert_eq!(text(&out.join("cloud.csv")), "one");
}

/// Tests a kill after each of the renames and removals: the next run or the next reader finishes
/// the work, and meanwhile a folder with a manifest is consistent.
#[test]
fn a_swap_that_was_killed_is_finished_by_the_next_run_or_reader() {
    swaps_killed_at_each_step(|out| drop(RunFolder::begin(out).unwrap()));
    swaps_killed_at_each_step(|out| finish_killed_run(out).unwrap());
    swaps_killed_at_each_step(|out| finish_killed_run(&out.join("points/cloud.csv")).unwrap());
}

fn swaps_killed_at_each_step(finish: impl Fn(&Path)) {
    let old = ["depth.tif", "objects/chips/0001-rock.png", "points/cloud.csv"];
    let new = ["objects/chips/0001-boat.png", "points/cloud.csv", "report.json"];
    for step in 0.. {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        written(out, &old, "one");
        // A version without subfolders gave its manifest the name of a present file.
        fs::rename(out.join("manifest.json"), out.join("report.json")).unwrap();
        let run = RunFolder::begin(out).unwrap();
        write(&run, &new, "two");
        let staged = run.path();
        let journal = Journal {
            first: vec!["report.json".to_owned()],
            files: new.iter().map(|&name| name.to_owned()).collect(),
            remove: vec!["depth.tif".to_owned(), "objects/chips/0001-rock.png".to_owned()],
            manifest: Some("manifest.json".to_owned()),
        };
        journal.write(&out.join(SIDE).join(JOURNAL)).unwrap();
        // The renames and removals in their order, up to the kill.
        let moves = |name: &str| fs::rename(staged.join(name), out.join(name)).unwrap();
        let removes = |name: &str| fs::remove_file(out.join(name)).unwrap();
        let steps: [&dyn Fn(); 7] = [
            &|| removes("report.json"),
            &|| moves("objects/chips/0001-boat.png"),
            &|| moves("points/cloud.csv"),
            &|| moves("report.json"),
            &|| removes("depth.tif"),
            &|| removes("objects/chips/0001-rock.png"),
            &|| moves("manifest.json"),
        ];
        for take_step in &steps[..step] {
            take_step();
        }
        if step < steps.len() {
            assert!(!out.join("manifest.json").exists());
        }
        kill(run);
        finish(out);
        let mut expected = new.to_vec();
        expected.insert(0, "manifest.json");
        assert_eq!(names(out), expected, "killed at {step}");
        assert!(text(&out.join("manifest.json")).contains(r#""run":"two""#));
        for name in new {
            assert_eq!(text(&out.join(name)), "two", "{name}, killed at {step}");
        }
        if step == steps.len() {
            break;
        }
    }
}

#[test]
fn a_manifest_from_elsewhere_removes_nothing_outside_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(folder.path().join("thesis.txt"), "years").unwrap();
    let mut file = Fingerprint::of(folder.path(), "thesis.txt", &Progress::new()).unwrap();
    for name in ["../thesis.txt", &folder.path().join("thesis.txt").to_string_lossy()] {
        file.file = name.to_owned();
        let manifest = serde_json::json!({ "program": "bathyscope 1", "files": [&file] });
        fs::write(out.join("manifest.json"), manifest.to_string()).unwrap();
        written(&out, &["cloud.csv"], "one");
        assert_eq!(text(&folder.path().join("thesis.txt")), "years");
    }
    // A journal does not lead out of the folder either.
    fs::create_dir(out.join(SIDE)).unwrap();
    let journal = r#"{"files":[],"remove":["../thesis.txt"],"manifest":null}"#;
    fs::write(out.join(SIDE).join(JOURNAL), journal).unwrap();
    drop(RunFolder::begin(&out).unwrap());
    assert_eq!(text(&folder.path().join("thesis.txt")), "years");
    assert!(!out.join(SIDE).exists());
}

#[test]
fn a_group_of_files_leaves_the_run_and_takes_the_place_of_its_own() {
    let paths =
        ["objects/detections.csv", "objects/detections.gpx", "points/cloud.csv", "report.json"];
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    written(out, &paths, "one");
    let run = RunFolder::begin(out).unwrap();
    fs::create_dir(run.path().join("objects")).unwrap();
    fs::write(run.path().join("objects/detections.csv"), "two").unwrap();
    let gone = run.commit_group(|name| name.starts_with("objects/"));
    assert_eq!(gone.unwrap().removed, ["objects/detections.gpx"]);
    let expected = ["manifest.json", "objects/detections.csv", "points/cloud.csv", "report.json"];
    assert_eq!(names(out), expected);
    let manifest: serde_json::Value =
        serde_json::from_str(&text(&out.join("manifest.json"))).unwrap();
    let files = manifest["files"].as_array().unwrap().iter();
    let files: Vec<&str> = files.map(|file| file["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["points/cloud.csv", "report.json"]);
    assert_eq!(text(&out.join("objects/detections.csv")), "two");
}

#[test]
fn what_a_version_without_a_list_wrote_goes_by_its_records() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let record = |product: &str| {
        let record = serde_json::json!({ "program": "bathyscope 0.1.0", "product": product });
        fs::write(out.join(format!("{product}.json")), record.to_string()).unwrap();
    };
    for product in ["mosaic.tif", "track.shp"] {
        fs::write(out.join(product), "old").unwrap();
        record(product);
    }
    let report = r#"{ "program": "bathyscope 0.1.0" }"#;
    for (name, content) in [
        ("track.dbf", "old"),
        ("report.json", report),
        ("report.html", "<p>Made with bathyscope 0.1.0.</p>"),
        ("cloud.csv.4294967294.part", "half"),
        ("film.mkv.4294967294.part", "mine"),
        ("photo.jpg", "mine"),
        // A record of another program, by its name.
        ("photo.jpg.json", r#"{ "product": "photo.jpg" }"#),
    ] {
        fs::write(out.join(name), content).unwrap();
    }
    let gone = written(out, &["depth/depth.tif", "report.json"], "new");
    assert_eq!(gone.kept, [""; 0]);
    assert_eq!(gone.removed, ["mosaic.tif", "report.html", "track.dbf", "track.shp"]);
    let mut expected = vec![
        "depth/depth.tif",
        "film.mkv.4294967294.part",
        "manifest.json",
        "photo.jpg",
        "photo.jpg.json",
        "report.json",
    ];
    if !cfg!(target_os = "linux") {
        expected.insert(0, "cloud.csv.4294967294.part");
    }
    assert_eq!(names(out), expected);
}
