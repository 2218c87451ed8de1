use super::*;

fn names(folder: &Path) -> Vec<String> {
    names_in(folder).unwrap()
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}

/// Writes files and a manifest that names them.
fn write(run: &RunFolder, files: &[&str], content: &str) {
    let new = run.path();
    for file in files {
        if let Some((inner, _)) = file.split_once('/') {
            fs::create_dir_all(new.join(inner)).unwrap();
        }
        fs::write(new.join(file), content).unwrap();
    }
    let files = run.files(&Progress::new()).unwrap();
    let manifest = serde_json::json!({ "program": "bathyscope 1", "run": content, "files": files });
    fs::write(new.join("report.json"), manifest.to_string()).unwrap();
}

fn written(folder: &Path, files: &[&str], content: &str) -> Vec<String> {
    let run = RunFolder::begin(folder).unwrap();
    write(&run, files, content);
    run.commit("report.json").unwrap()
}

#[test]
fn a_folder_holds_the_files_of_one_run_and_those_of_its_user() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    written(
        &out,
        &[
            "cloud.csv",
            "mosaic.tif",
            "chips/0001-rock.png",
            "track.gpx",
        ],
        "one",
    );
    fs::write(out.join("notes.txt"), "mine").unwrap();
    fs::write(out.join("chips/best.png"), "mine").unwrap();
    // Changed by hand: it is no longer what the run wrote.
    fs::write(out.join("track.gpx"), "mine").unwrap();
    let gone = written(&out, &["cloud.csv", "depth.tif"], "two");
    assert_eq!(gone, ["mosaic.tif"]);
    assert_eq!(
        names(&out),
        [
            "chips/best.png",
            "cloud.csv",
            "depth.tif",
            "notes.txt",
            "report.json",
            "track.gpx"
        ]
    );
    assert_eq!(text(&out.join("cloud.csv")), "two");
    assert_eq!(text(&out.join("track.gpx")), "mine");
}

#[test]
fn a_run_that_fails_leaves_all_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    drop(RunFolder::begin(&out).unwrap());
    assert!(!out.exists());
    written(&out, &["cloud.csv"], "one");
    let before = text(&out.join("report.json"));
    let run = RunFolder::begin(&out).unwrap();
    write(&run, &["cloud.csv", "depth.tif"], "two");
    drop(run);
    assert_eq!(names(&out), ["cloud.csv", "report.json"]);
    assert_eq!(text(&out.join("report.json")), before);
    // A folder in the way is reported before anything is moved.
    fs::create_dir(out.join("depth.tif")).unwrap();
    let run = RunFolder::begin(&out).unwrap();
    write(&run, &["cloud.csv", "depth.tif"], "two");
    let refusal = run.commit("report.json").unwrap_err();
    assert!(refusal.to_string().contains("depth.tif"), "{refusal}");
    assert_eq!(text(&out.join("report.json")), before);
    assert_eq!(text(&out.join("cloud.csv")), "one");
    assert!(!out.join(SIDE).exists());
}

#[test]
fn two_runs_do_not_write_into_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let first = RunFolder::begin(folder.path()).unwrap();
    let refusal = RunFolder::begin(folder.path()).unwrap_err();
    assert!(refusal.to_string().contains("another run"), "{refusal}");
    write(&first, &["cloud.csv"], "one");
    first.commit("report.json").unwrap();
    RunFolder::begin(folder.path()).unwrap();
    assert_eq!(names(folder.path()), ["cloud.csv", "report.json"]);
}

/// What a process leaves that is killed: no destructor runs, but the lock is gone.
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
    // It was about to be decided.
    fs::write(out.join(SIDE).join("commit.json.7.part"), "{").unwrap();
    assert_eq!(text(&out.join("cloud.csv")), "one");
    assert!(out.join(SIDE).exists());
    drop(RunFolder::begin(out).unwrap());
    assert_eq!(names(out), ["cloud.csv", "report.json"]);
    assert_eq!(text(&out.join("cloud.csv")), "one");
}

/// Killed after each of the renames and removals: the next run finishes the job, and a folder with a manifest is whole meanwhile.
#[test]
fn a_swap_that_was_killed_is_finished_by_the_next_run() {
    let old = ["chips/0001-rock.png", "cloud.csv", "depth.tif"];
    let new = ["chips/0001-boat.png", "cloud.csv", "track.gpx"];
    for step in 0.. {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        written(out, &old, "one");
        let run = RunFolder::begin(out).unwrap();
        write(&run, &new, "two");
        let staged = run.path();
        let journal = Journal {
            files: new.iter().map(|&name| name.to_owned()).collect(),
            remove: vec!["chips/0001-rock.png".to_owned(), "depth.tif".to_owned()],
            manifest: Some("report.json".to_owned()),
        };
        journal.write(&out.join(SIDE).join(JOURNAL)).unwrap();
        // The order in which it is done, as far as the kill lets it.
        let moves = |name: &str| fs::rename(staged.join(name), out.join(name)).unwrap();
        let removes = |name: &str| fs::remove_file(out.join(name)).unwrap();
        let steps: [&dyn Fn(); 7] = [
            &|| removes("report.json"),
            &|| moves("chips/0001-boat.png"),
            &|| moves("cloud.csv"),
            &|| moves("track.gpx"),
            &|| removes("chips/0001-rock.png"),
            &|| removes("depth.tif"),
            &|| moves("report.json"),
        ];
        for one in &steps[..step] {
            one();
        }
        if (1..steps.len()).contains(&step) {
            assert!(!out.join("report.json").exists());
        }
        kill(run);
        drop(RunFolder::begin(out).unwrap());
        let mut expected = new.to_vec();
        expected.insert(2, "report.json");
        assert_eq!(names(out), expected, "killed at {step}");
        assert!(text(&out.join("report.json")).contains(r#""run":"two""#));
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
    for name in [
        "../thesis.txt",
        &folder.path().join("thesis.txt").to_string_lossy(),
    ] {
        file.file = name.to_owned();
        let manifest = serde_json::json!({ "program": "bathyscope 1", "files": [&file] });
        fs::write(out.join("report.json"), manifest.to_string()).unwrap();
        written(&out, &["cloud.csv"], "one");
        assert_eq!(text(&folder.path().join("thesis.txt")), "years");
    }
    // Nor does a journal.
    fs::create_dir(out.join(SIDE)).unwrap();
    let journal = r#"{"files":[],"remove":["../thesis.txt"],"manifest":null}"#;
    fs::write(out.join(SIDE).join(JOURNAL), journal).unwrap();
    drop(RunFolder::begin(&out).unwrap());
    assert_eq!(text(&folder.path().join("thesis.txt")), "years");
    assert!(!out.join(SIDE).exists());
}

#[test]
fn a_group_of_files_leaves_the_run_and_takes_the_place_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    written(
        out,
        &["cloud.csv", "detections.csv", "detections.csv.json"],
        "one",
    );
    let run = RunFolder::begin(out).unwrap();
    fs::write(run.path().join("detections.csv"), "two").unwrap();
    run.commit_group(|name| name.starts_with("detections."))
        .unwrap();
    assert_eq!(names(out), ["cloud.csv", "detections.csv", "report.json"]);
    let manifest: serde_json::Value =
        serde_json::from_str(&text(&out.join("report.json"))).unwrap();
    let files = manifest["files"].as_array().unwrap();
    assert_eq!(files.len(), 1);
    assert_eq!(files[0]["file"], "cloud.csv");
    assert_eq!(text(&out.join("detections.csv")), "two");
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
        // Somebody else's record, by its name.
        ("photo.jpg.json", r#"{ "product": "photo.jpg" }"#),
    ] {
        fs::write(out.join(name), content).unwrap();
    }
    let gone = written(out, &["depth.tif"], "new");
    assert_eq!(
        gone,
        ["mosaic.tif", "report.html", "track.dbf", "track.shp"]
    );
    let mut expected = vec![
        "depth.tif",
        "film.mkv.4294967294.part",
        "photo.jpg",
        "photo.jpg.json",
        "report.json",
    ];
    if !cfg!(target_os = "linux") {
        expected.insert(0, "cloud.csv.4294967294.part");
    }
    assert_eq!(names(out), expected);
}
