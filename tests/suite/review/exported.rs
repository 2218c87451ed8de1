//! Tests the files that the export of a review writes, by reading them back.

use super::*;

/// Runs a command of the palette, then answers the path field.
pub(super) fn export_by_keys(window: &mut Window, folder: &Path) {
    press(window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text("export boxes");
    window.run();
    press(window, Modifiers::NONE, Key::Enter);
    window
        .get_by_role_and_label(Role::TextInput, "Folder to write into")
        .type_text(&folder.to_string_lossy());
    window.run();
    window.get_by_label("Export").click();
    window.run();
    assert!(window.query_by_label_contains("Wrote 50 boxes").is_some());
}

pub(super) fn check_tables(folder: &Path, review: &Review) {
    let objects = review.boxes().filter(|review_box| review_box.state.is_object()).count();
    let read = |name: &str| fs::read_to_string(folder.join(name)).expect("a file");
    let table = read("detections.csv");
    let mut table = csv::Reader::from_reader(table.as_bytes());
    let lines: Vec<csv::StringRecord> = table.records().map(|line| line.expect("a line")).collect();
    assert_eq!(lines.len(), 50);
    for (line, review_box) in lines.iter().zip(review.boxes()) {
        assert_eq!(line[0], review_box.id.0.to_string());
        assert_eq!(&line[2], review.class_name(review_box.class));
        assert_eq!(&line[4], review_box.state.name());
        // The pond of the demo lies at 29.41 N 82.11 W.
        let [lon, lat]: [f64; 2] =
            [&line[10], &line[11]].map(|degrees| degrees.parse().expect("degrees"));
        assert!(f64::abs(lon + 82.11) < 1e-3 && f64::abs(lat - 29.41) < 1e-3, "{line:?}");
    }
    // A point for each object, however many of the accepted boxes show it.
    let decided = lines.iter().filter(|line| ["accepted", "added"].contains(&&line[4]));
    let numbers: std::collections::BTreeSet<&str> = decided.map(|line| &line[20]).collect();
    assert!(!numbers.contains("") && numbers.len() <= objects);
    let points = numbers.len();
    assert_eq!(read("objects.kml").matches("<Placemark>").count(), points);
    assert_eq!(read("objects.gpx").matches("<wpt ").count(), points);
    let all: std::collections::BTreeSet<&str> = lines.iter().map(|line| &line[20]).collect();
    let points: serde_json::Value = serde_json::from_str(&read("objects.geojson")).expect("JSON");
    assert_eq!(points["features"].as_array().map(Vec::len), Some(all.len()));
    assert_eq!(read("objects.csv").lines().count(), 1 + all.len());
}

pub(super) fn check_dataset(folder: &Path, review: &Review) {
    let coco = fs::read_to_string(folder.join("train.json")).expect("annotations");
    let coco: serde_json::Value = serde_json::from_str(&coco).expect("JSON");
    let images = coco["images"].as_array().expect("images");
    let annotations = coco["annotations"].as_array().expect("annotations");
    let classes = fs::read_to_string(folder.join("classes.txt")).expect("classes");
    let list = bathyscope_objects::ReviewSettings::default().classes;
    let names: Vec<&str> = classes.lines().collect();
    assert_eq!(names[..list.len()], list, "the analyst's list comes first");
    let used = review.boxes().map(|review_box| review.class_name(review_box.class));
    assert!(used.into_iter().all(|name| names.contains(&name)));
    let manifest = fs::read_to_string(folder.join("manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(manifest["pixel_m"], 0.04);
    assert_eq!(manifest["tile_px"], 416);
    assert_eq!(manifest["parts"][0]["images"], images.len());
    assert_eq!(manifest["survey"]["pings"], review.identity().pings);
    for part in ["val", "test"] {
        assert!(
            folder.join("images").join(part).is_dir()
                && folder.join(format!("{part}.json")).is_file()
        );
    }
    let mut negatives = 0;
    let mut labelled = 0;
    for image in images {
        let name = image["file_name"].as_str().expect("a name");
        let stem = name.trim_end_matches(".png");
        let picture = image::open(folder.join("images/train").join(name)).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (416, 416));
        let yolo = fs::read_to_string(folder.join("labels/train").join(format!("{stem}.txt")));
        let yolo = yolo.expect("labels");
        let voc = fs::read_to_string(folder.join("voc/train").join(format!("{stem}.xml")));
        let voc = voc.expect("labels");
        let sure = |annotation: &&serde_json::Value| {
            annotation["image_id"] == image["id"] && annotation["iscrowd"] == 0
        };
        let sure: Vec<_> = annotations.iter().filter(sure).collect();
        assert_eq!(yolo.lines().count(), sure.len());
        assert_eq!(voc.matches("<difficult>0<").count(), sure.len());
        for (line, annotation) in yolo.lines().zip(&sure) {
            let numbers: Vec<f64> =
                line.split(' ').map(|number| number.parse().expect("a number")).collect();
            assert_eq!(numbers[0] as u64 + 1, annotation["category_id"].as_u64().expect("a class"));
            let [left, width] =
                [0, 2].map(|index| annotation["bbox"][index].as_f64().expect("pixels"));
            assert!((numbers[1] * 416.0 - (left + 0.5 * width)).abs() < 0.01);
        }
        labelled += sure.len();
        negatives += usize::from(yolo.is_empty());
    }
    assert_eq!(manifest["hard_negatives"], negatives);
    let objects = review.boxes().filter(|review_box| review_box.state.is_object()).count();
    assert!(labelled >= objects, "{labelled} labels of {objects} objects");
}

/// Returns the names of the files in a dataset's folder.
fn listed(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn a_second_export_replaces_the_first_and_never_other_peoples_pictures() {
    let (folder, mut window) = proposed(4);
    let out = folder.path().join("out");
    let dataset = out.join("dataset");
    let export = |window: &mut Window| {
        app_mut(window).apply(Command::Write(FileToWrite::Boxes(out.clone())));
        window.run();
        app(window).notices.shown().last().expect("a notice").clone()
    };
    for id in [1, 2, 3, 4].map(BoxId) {
        let edit = Edit::Reject(id);
        app_mut(&mut window).apply(Command::Edit { edit, live: false });
    }
    window.run();
    assert!(!export(&mut window).is_error);
    let pictures = listed(&dataset.join("images/train"));
    assert!(pictures.len() > 1 && pictures[0] == "000000.png", "{pictures:?}");
    for name in listed(&dataset.join("labels/train")) {
        let label = fs::read_to_string(dataset.join("labels/train").join(name));
        assert_eq!(label.expect("a label"), "", "all was rejected");
    }
    let note = dataset.join("images/train/mine.txt");
    fs::write(&note, "a remark").expect("a file");
    // One decision left: one picture.
    for id in [2, 3, 4].map(BoxId) {
        let edit = Edit::Undecide(id);
        app_mut(&mut window).apply(Command::Edit { edit, live: false });
    }
    window.run();
    assert!(!export(&mut window).is_error);
    assert_eq!(listed(&dataset.join("images/train")), ["000000.png", "mine.txt"]);
    assert_eq!(listed(&dataset.join("voc/train")), ["000000.xml"]);

    let manifest = dataset.join("manifest.json");
    fs::write(&manifest, "{\"program\": \"another\"}").expect("a file");
    let refused = export(&mut window);
    assert!(refused.is_error && refused.text.contains("pictures of something else"), "{refused:?}");
    assert_eq!(fs::read_to_string(manifest).expect("a file"), "{\"program\": \"another\"}");
}
