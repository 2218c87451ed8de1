//! `bathyscope detect` as scripts use it, with a model of another maker.

use super::{bathyscope, header, refusal, run, simulated};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn model() -> String {
    format!("{}/yolov8.onnx", bathyscope_test_support::detector_models().display())
}

fn rows(path: &Path) -> Vec<Vec<String>> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    let rows = table.records().map(|row| row.expect("a row"));
    rows.map(|row| row.iter().map(str::to_owned).collect()).collect()
}

#[test]
fn objects_of_a_log_become_a_table_and_chips() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let model = model();
    let args = ["detect", "pond.sl2", "-o", "out", "--model", &model, "--score", "0.5"];
    let output = bathyscope(folder, &args);
    assert!(output.status.success());
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("model: YOLOv8 to v12 with 3 classes, 64 x 64"), "{text}");

    let table = folder.join("out/objects/detections.csv");
    assert_eq!(
        header(&table),
        "id,file,class,score,state,side,ping_from,ping_to,sample_from,sample_to,lon,lat,east_m,north_m,length_m,width_m,\
         height_m,depth_m,sigma_m,height_sigma_m,object,note,name,confidence,shape,shape_length_m,shape_width_m,shape_height_m,\
         shape_heading_deg,shape_explained"
    );
    let rows = rows(&table);
    assert!(!rows.is_empty(), "a net of random weights fires");
    let text = fs::read(folder.join("out/objects/detections.geojson")).expect("a map");
    let map: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    let text = String::from_utf8_lossy(&output.stdout);
    // An object that several lines saw has as many boxes.
    let objects: BTreeSet<&str> = rows.iter().map(|row| row[20].as_str()).collect();
    let objects = objects.iter().filter(|number| !number.is_empty()).count();
    assert!(objects > 0 && text.contains(&format!("found {} box", rows.len())));
    assert_eq!(map["features"].as_array().map(Vec::len), Some(objects));
    assert_eq!(self::rows(&folder.join("out/objects/objects.csv")).len(), objects);
    assert!(text.contains(&format!(") on {objects} object")), "{text}");
    for (index, row) in rows.iter().enumerate() {
        assert_eq!(row[0], (index + 1).to_string());
        assert_eq!(row[1], "pond");
        assert!(["rock", "tyre", "log"].contains(&row[2].as_str()));
        assert!((0.5..=1.0).contains(&row[3].parse::<f64>().expect("a score")));
        assert_eq!(row[4], "proposed");
        let number = |column: usize| row[column].parse::<u32>().expect("a whole number");
        assert!(number(6) < number(7) && number(8) <= number(9), "{row:?}");
        assert!(
            folder.join(format!("out/objects/chips/{:04}-{}.png", index + 1, row[2])).is_file()
        );
    }
}

#[test]
fn pictures_are_searched_in_their_own_pixels() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let speckle = |x: u32, y: u32| image::Luma([(x * x / 7 + y * y / 5 + x * y) as u8]);
    for (name, width) in [("small.png", 80), ("large.jpg", 300)] {
        image::GrayImage::from_fn(width, 90, speckle).save(folder.join(name)).expect("a picture");
    }
    let model = model();
    run(folder, &["detect", "small.png", "large.jpg", "-o", "out", "--model", &model]);
    for (name, file, width) in [("small", "small.png", 80.0), ("large", "large.jpg", 300.0)] {
        let table = folder.join("out").join(name).join("objects/detections.csv");
        assert_eq!(header(&table), "id,file,class,score,state,x_from,x_to,y_from,y_to");
        let rows = rows(&table);
        assert!(!rows.is_empty());
        for row in rows {
            assert_eq!(row[1], file);
            let edge = |column: usize| row[column].parse::<f64>().expect("a number");
            assert!(edge(5) <= edge(6) && edge(6) <= width, "{row:?}");
            assert!(edge(7) <= edge(8) && edge(8) <= 90.0, "{row:?}");
        }
    }
}

#[test]
fn chips_of_an_earlier_search_give_way() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let model = model();
    let chips = || {
        let entries = fs::read_dir(folder.join("out/objects/chips")).expect("chips");
        let names = entries.map(|entry| entry.expect("a chip").file_name());
        let names = names.map(|name| name.into_string().expect("a plain name"));
        names.collect::<BTreeSet<String>>()
    };
    let search = |iou: &str| {
        let args = ["detect", "pond.sl2", "-o", "out", "--model", &model];
        run(folder, &[&args[..], &["--iou", iou]].concat());
        rows(&folder.join("out/objects/detections.csv"))
    };
    let named = |rows: &[Vec<String>]| {
        let rows = rows.iter().enumerate();
        rows.map(|(index, row)| format!("{:04}-{}.png", index + 1, row[2]))
            .collect::<BTreeSet<String>>()
    };
    let many = search("0.45");
    assert_eq!(chips(), named(&many));
    fs::write(folder.join("out/objects/chips/0001-mine.png"), "mine").expect("a file");
    let few = search("0");
    assert!(!few.is_empty() && few.len() < many.len());
    let mut expected = named(&few);
    expected.insert("0001-mine.png".to_owned());
    assert_eq!(chips(), expected);
    assert!(!folder.join("out/chips.part").exists());
}

#[test]
fn what_cannot_be_searched_is_refused() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::write(folder.join("text.onnx"), "no model").expect("a file");
    fs::write(folder.join("torn.png"), b"\x89PNG\r\n\x1a\n").expect("a file");
    let text = refusal(folder, &["detect", "x.sl2", "-o", "out", "--model", "text.onnx"], 1);
    assert!(text.contains("it is no ONNX file"), "{text}");
    assert!(!folder.join("out").exists());
    let model = model();
    let text = refusal(folder, &["detect", "torn.png", "-o", "out", "--model", &model], 1);
    assert!(text.contains("cannot read the picture"), "{text}");
    let text = refusal(folder, &["detect", "x.sl2", "-o", "out", "--score", "2"], 2);
    assert!(text.contains("between 0 and 1"), "{text}");
}

#[test]
fn objects_lie_where_the_settings_put_them_and_process_agrees() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let model = model();
    let [which, deeper] = [format!("detector.model={model}"), "draft_m=0.5".to_owned()];
    let with = |command: &[&str], settings: &[&str]| {
        let settings = settings.iter().flat_map(|setting| ["--set", setting]);
        run(folder, &command.iter().copied().chain(settings).collect::<Vec<_>>());
    };
    let score = "detector.score=0.5";
    with(&["detect", "pond.sl2", "-o", "plain"], &[&which, score]);
    with(&["detect", "pond.sl2", "-o", "deeper"], &[&which, score, &deeper]);
    with(&["process", "pond.sl2", "-o", "out"], &[&which, score, &deeper]);
    let [plain, deep, of_process] = ["plain", "deeper", "out"]
        .map(|name| rows(&folder.join(name).join("objects/detections.csv")));
    assert_eq!(deep, of_process);
    let depths = |rows: &[Vec<String>]| -> Vec<f64> {
        rows.iter().filter_map(|row| row[17].parse().ok()).collect()
    };
    let (plain, deep) = (depths(&plain), depths(&deep));
    assert!(!plain.is_empty() && plain.len() == deep.len());
    for (plain, deep) in plain.iter().zip(&deep) {
        assert!((deep - plain - 0.5).abs() < 0.011, "{plain} {deep}");
    }
    // What a log does not hold is refused before the search.
    let asked = ["detect", "pond.sl2", "-o", "no", "--set", "calibration.pings=5-99999"];
    assert!(refusal(folder, &asked, 1).contains("calibration.pings"));
}

#[test]
fn process_writes_the_same_objects_as_detect_unless_switched_off() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let model = model();
    let of_detect = ["detect", "pond.sl2", "-o", "detected", "--model", &model, "--score", "0.5"];
    run(folder, &of_detect);
    let which = format!("detector.model={model}");
    let text = run(
        folder,
        &["process", "pond.sl2", "-o", "out", "--set", &which, "--set", "detector.score=0.5"],
    );
    let [of_process, of_detect] =
        ["out", "detected"].map(|name| rows(&folder.join(name).join("objects/detections.csv")));
    assert!(!of_process.is_empty());
    assert_eq!(of_process, of_detect);
    assert!(text.contains("proposed by the detector: "), "{text}");
    assert!(folder.join("out/objects/detections.geojson").is_file());

    run(folder, &["process", "pond.sl2", "-o", "bare", "--no-objects"]);
    assert!(folder.join("bare/report.json").is_file());
    assert!(!folder.join("bare/objects/detections.csv").exists());

    // A model that cannot be used is reported before anything is computed or written.
    let refused = refusal(
        folder,
        &["process", "pond.sl2", "-o", "none", "--set", "detector.model=missing.onnx"],
        1,
    );
    assert!(refused.contains("missing.onnx"), "{refused}");
    assert!(!folder.join("none").exists());
}
