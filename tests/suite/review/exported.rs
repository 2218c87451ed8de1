//! What the export of a review writes, read back.

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
    let objects = review.boxes().filter(|one| one.state.is_object()).count();
    let read = |name: &str| fs::read_to_string(folder.join(name)).expect("a file");
    let table = read("objects.csv");
    let mut table = csv::Reader::from_reader(table.as_bytes());
    let lines: Vec<csv::StringRecord> = table.records().map(|line| line.expect("a line")).collect();
    assert_eq!(lines.len(), 50);
    for (line, one) in lines.iter().zip(review.boxes()) {
        assert_eq!(line[0], one.id.0.to_string());
        assert_eq!(&line[2], review.class_name(one.class));
        assert_eq!(&line[4], one.state.name());
        // The pond of the demo lies at 29.41 N 82.11 W.
        let [lon, lat]: [f64; 2] =
            [&line[10], &line[11]].map(|degrees| degrees.parse().expect("degrees"));
        assert!(
            f64::abs(lon + 82.11) < 1e-3 && f64::abs(lat - 29.41) < 1e-3,
            "{line:?}"
        );
    }
    assert_eq!(read("objects.kml").matches("<Placemark>").count(), objects);
    assert_eq!(read("objects.gpx").matches("<wpt ").count(), objects);
    let points: serde_json::Value = serde_json::from_str(&read("objects.geojson")).expect("JSON");
    assert_eq!(points["features"].as_array().map(Vec::len), Some(50));
}

pub(super) fn check_dataset(folder: &Path, review: &Review) {
    let coco = fs::read_to_string(folder.join("annotations.json")).expect("annotations");
    let coco: serde_json::Value = serde_json::from_str(&coco).expect("JSON");
    let images = coco["images"].as_array().expect("images");
    let annotations = coco["annotations"].as_array().expect("annotations");
    let classes = fs::read_to_string(folder.join("classes.txt")).expect("classes");
    assert!(classes.lines().eq(review.classes()));
    let mut labelled = 0;
    for image in images {
        let name = image["file_name"].as_str().expect("a name");
        let stem = name.trim_end_matches(".png");
        let picture = image::open(folder.join("images").join(name)).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (416, 416));
        let yolo = fs::read_to_string(folder.join("labels").join(format!("{stem}.txt")));
        let yolo = yolo.expect("labels");
        let voc = fs::read_to_string(folder.join("voc").join(format!("{stem}.xml")));
        let voc = voc.expect("labels");
        let sure = |one: &&serde_json::Value| one["image_id"] == image["id"] && one["iscrowd"] == 0;
        let sure: Vec<_> = annotations.iter().filter(sure).collect();
        assert_eq!(yolo.lines().count(), sure.len());
        assert_eq!(voc.matches("<difficult>0<").count(), sure.len());
        for (line, one) in yolo.lines().zip(&sure) {
            let numbers: Vec<f64> = line
                .split(' ')
                .map(|number| number.parse().expect("a number"))
                .collect();
            assert_eq!(
                numbers[0] as u64 + 1,
                one["category_id"].as_u64().expect("a class")
            );
            let [left, width] = [0, 2].map(|index| one["bbox"][index].as_f64().expect("pixels"));
            assert!((numbers[1] * 416.0 - (left + 0.5 * width)).abs() < 0.01);
        }
        labelled += sure.len();
    }
    let objects = review.boxes().filter(|one| one.state.is_object()).count();
    assert!(
        labelled >= objects,
        "{labelled} labels of {objects} objects"
    );
}
