//! The registry of outputs against what runs really write.

use crate::cli::run;
use crate::truth::KnownSurvey;
use bathyscope::app::{App, Command, FileToWrite, Jobs};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::{
    self, EarlierRun, OUTPUT_FILES, Order, OutputFile, Product, RunFolder, When, row_of,
};
use bathyscope_products::pipeline::{self, Derived, ProcessedLog, Settings};
use bathyscope_simulation::Scene;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// Names of all files of a folder and of the folders in it.
fn names(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            let inner = self::names(&entry.path());
            names.extend(inner.iter().map(|file| format!("{name}/{file}")));
        } else {
            names.push(name)
        }
    }
    names.sort();
    names
}

#[test]
fn a_run_with_everything_writes_a_file_for_every_row_and_no_other() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::write(folder.join("scene.toml"), "duration_s = 20.0\n").expect("a scene");
    run(folder, &["simulate", "scene.toml", "-o", "pond", "--seed", "3"]);
    let before = ["process", "pond.sl2", "--no-objects", "--products", "track"];
    run(folder, &[&before[..], &["-o", "before"]].concat());
    let compared = ["--reference", "before/points/cloud.csv:lon,lat,z_m"];
    // So that there are boxes to write pictures of.
    let search = [
        "--set",
        "detector.score=0.01",
        "--set",
        "points.las=true",
        "--set",
        "surface.swath=always",
        "-o",
        "out",
    ];
    run(folder, &[&["process", "pond.sl2"], &compared[..], &search[..]].concat());
    let names = names(&folder.join("out"));
    for name in &names {
        let rows = OUTPUT_FILES.iter().filter(|row| row.owns(name)).count();
        assert_eq!(rows, 1, "rows for {name}");
    }
    // Targets are those of a review, which this run has not.
    let is_of_run = |row: &&OutputFile| row.when != When::Chosen(Product::Targets);
    for row in OUTPUT_FILES.iter().filter(is_of_run) {
        let mut missing: Vec<String> =
            row.companions.iter().map(|companion| (*companion).into()).collect();
        if row.file_name().contains('.') {
            missing.push(row.name.to_owned());
        }
        missing.retain(|name| !names.contains(name));
        assert!(missing.is_empty(), "{missing:?} of {}", row.name);
        assert!(names.iter().any(|name| row.owns(name)), "{}", row.name);
    }
    // No table of a run is a log: `OWN` in `sounding_table/layout.rs` recognises those with places.
    for name in names.iter().filter(|name| name.ends_with(".csv")) {
        let opened = formats::open(&folder.join("out").join(name), &Progress::new());
        assert!(opened.is_err(), "{name} is opened as a log");
    }
    // The page lists what lies beside it and says what each is.
    let page = fs::read_to_string(folder.join("out/report.html")).expect("a page");
    let rows = OUTPUT_FILES.iter().filter(is_of_run);
    for row in rows.filter(|row| row.name != "report.html") {
        let listed = format!(">{}</td><td class=\"text\">{}<", row.name, row.brief);
        assert!(!row.brief.is_empty() && page.contains(&listed), "{listed}");
    }

    for name in &self::names(&folder.join("before")) {
        let row = row_of(name).expect("a row");
        let asked = row.when == When::Always || row.when == When::Chosen(Product::Track);
        assert!(asked, "{name}");
    }
}

#[test]
fn each_described_file_is_named_by_a_reader_of_another_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers");
    let paths = fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path());
    let scripts = paths.filter(|path| path.extension().is_some_and(|ending| ending == "py"));
    let readers: String = scripts.map(|path| fs::read_to_string(path).expect("a script")).collect();
    for row in OUTPUT_FILES.iter().filter(|row| row.described.is_some()) {
        let stem = row.file_name().split('.').next().expect("a name");
        assert!(readers.contains(stem), "tests/readers does not open {}", row.name);
    }
}

#[test]
fn no_input_is_written_over_whatever_file_of_a_run_it_is_named_after() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let survey = Survey::default();
    let files = OUTPUT_FILES.iter().filter(|row| row.file_name().contains('.'));
    // A file on top may be that of a version without subfolders, which a run takes away.
    for name in files.flat_map(|row| [row.name, row.file_name()]) {
        let path = temporary.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, "somebody's own").expect("a file");
        let mut survey = survey.clone();
        survey.source.files = vec![path.clone()];
        let refused = outputs::begin(temporary.path(), [&survey], None).expect_err(name);
        assert!(refused.to_string().contains(name), "{refused}");
        fs::remove_file(path).expect("a file");
    }
    fs::write(temporary.path().join("manifest.json"), "{}").expect("a file");
    let refused = outputs::begin(temporary.path(), [&survey], None).expect_err("another's");
    assert!(refused.to_string().contains("something else"), "{refused}");
}

#[test]
fn help_and_panel_name_the_files_of_the_registry() {
    let files = |product: Product| product.files();
    assert_eq!(
        files(Product::Track),
        "track/track.gpx, .geojson, .kmz, .shp; track/footprint.geojson, .kmz"
    );
    assert_eq!(files(Product::Cloud), "points/cloud.copc.laz, .las, .ply, .xyz");
    assert_eq!(
        files(Product::Depth),
        "depth/depth.tif, .qml; depth/uncertainty.tif, .qml; depth/shoalest.tif, .qml; depth/distance.tif, .qml; depth/source.tif, .qml; depth/hardness.tif, .qml (colours for QGIS)"
    );
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let help = run(temporary.path(), &["process", "--help"]);
    for product in Product::ALL {
        let line = format!("- {}:", product.name());
        let said = help.lines().find(|text| text.contains(&line));
        assert!(said.is_some_and(|said| said.contains(&files(product))), "{help}");
    }
}

/// A log of a pond over whose bed every product exists.
fn survey() -> Arc<Survey> {
    let mut scene = Scene::gentle();
    scene.track.lines = 3;
    scene.track.cross_lines = 1;
    scene.track.length_m = 40.0;
    Arc::new(KnownSurvey::new(&scene, 5).survey)
}

/// All files of a run that searches for nothing, with their bytes.
fn written(survey: &Arc<Survey>, settings: &Settings, folder: &Path) -> Vec<(String, Vec<u8>)> {
    let progress = Progress::new();
    let products = pipeline::run(survey, settings, None, &progress, |_| ()).expect("products");
    let survey = survey.clone();
    let log = ProcessedLog { survey, products };
    let order = Order {
        logs: std::slice::from_ref(&log),
        derived: &Derived::default(),
        requested: &Product::ALL,
        reference: None,
        search: None,
        review: &SurveyReview::default(),
        corrections: &[],
    };
    let run = RunFolder::begin(folder).expect("a folder");
    outputs::write(&order, run, &progress, |_| ()).expect("a whole set of files");
    let files = names(folder).into_iter();
    let bytes = |name: String| {
        let bytes = fs::read(folder.join(&name)).expect("a file");
        (name, bytes)
    };
    files.map(bytes).collect()
}

/// A file that repeats every setting, without them: its figures depend on none of those that its
/// row leaves out.
fn figures(bytes: &[u8]) -> Option<serde_json::Value> {
    let mut record: serde_json::Value = serde_json::from_slice(bytes).ok()?;
    record.as_object_mut()?.remove("settings")?;
    Some(record)
}

/// A change of a setting for each first word that a row may leave out.
const CHANGES: [&str; 15] = [
    "calibration.offset=none",
    "cloud.geometry=published",
    "crs=wgs84",
    "draft_m=0.3",
    "first_return.threshold=0.6",
    "height_offset_m=0.2",
    "image.samples=words",
    "isobaths.interval_m=0.3",
    "mosaic.cell_m=0.5",
    "outliers.radius_m=0.2",
    "review.classes=[\"wreck\"]",
    "sound_speed.m_s=1400",
    "surface.cell_m=0.7",
    "water_level_m=0.4",
    "detector.score=0.9",
];

#[test]
fn a_file_is_the_same_whatever_the_settings_are_that_its_row_leaves_out() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path().join("out");
    let survey = survey();
    let before = written(&survey, &Settings::default(), &folder);
    let record_of_run = EarlierRun::read(&folder).expect("a run");
    assert!(record_of_run.out_of_date(&Settings::default()).is_empty());
    let left_out: BTreeSet<&str> =
        (OUTPUT_FILES.iter()).flat_map(|row| row.regardless_of.iter().copied()).collect();
    let mut tried = BTreeSet::new();
    for change in CHANGES {
        let word = change.split(['.', '=']).next().expect("a word");
        tried.insert(word);
        let settings = Settings::default().with_assignment(change).expect(change);
        let after = written(&survey, &settings, &folder);
        let mut changed = Vec::new();
        for (name, bytes) in &before {
            let row = row_of(name).expect("a row");
            // It repeats the settings and hashes of all.
            let is_record = *name == outputs::MANIFEST;
            let is_same = |now: &Vec<u8>| {
                now == bytes || figures(now).is_some_and(|now| Some(now) == figures(bytes))
            };
            let same = (after.iter()).any(|(other, now)| other == name && is_same(now));
            if !same && !is_record {
                assert!(!row.regardless_of.contains(&word), "{change} alters {name}");
                changed.push(row.name);
            }
        }
        // Not vacuous: the page lists what was changed.
        assert!(changed.contains(&"report.html"), "{change}: {changed:?}");
        let stale: Vec<&str> =
            (record_of_run.out_of_date(&settings).iter()).map(|row| row.name).collect();
        for name in changed {
            assert!(stale.contains(&name), "{change}: {name} not in {stale:?}");
        }
    }
    // Readings of the water level need a file of their own; they act as `water_level_m` does.
    assert_eq!(left_out.difference(&tried).collect::<Vec<_>>(), [&"water_level"]);
}

fn wait(app: &mut App) {
    app.poll();
    while !app.is_idle() {
        app.poll();
    }
}

#[test]
fn the_window_says_which_files_are_older_than_the_settings() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::OpenDemo);
    wait(&mut app);
    let out = temporary.path().join("out");
    app.apply(Command::Write(FileToWrite::Products(out.clone())));
    wait(&mut app);
    assert!(app.out_of_date().is_none());
    let mut settings = Settings::clone(&app.logs.shown.settings);
    settings.isobaths.interval_m = Some(0.35);
    let change = Command::Change { settings: Box::new(settings), label: "isobaths", live: false };
    app.apply(change);
    wait(&mut app);
    let (folder, files) = app.out_of_date().expect("older files");
    assert_eq!(folder, out);
    let names: Vec<&str> = files.iter().map(|row: &&OutputFile| row.name).collect();
    assert_eq!(
        names,
        [
            "isobaths/isobaths.geojson",
            "isobaths/isobaths.kmz",
            "isobaths/isobaths.shp",
            "isobaths/depth_areas.geojson",
            "isobaths/spot_soundings.geojson",
            "isobaths/storage.csv",
            "map_tiles/depth.mbtiles",
            "map_tiles/depth.pmtiles",
            "map_tiles/depth_values.pmtiles",
            "map_tiles/index.html",
            "survey.gpkg",
            "report.html",
            "report.json",
            "manifest.json"
        ]
    );
    // Written anew, none is.
    app.apply(Command::Write(FileToWrite::Products(out)));
    wait(&mut app);
    assert!(app.out_of_date().is_none());
}
