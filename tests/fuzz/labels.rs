//! Boxes of other programs: COCO and YOLO.

use super::projects::held_as;
use super::{say, scratch};
use bathyscope_objects::labels::{LabelError, LabelSet, pair, read_predicted, read_truth};
use std::path::Path;

fn compare(truth: Result<LabelSet, LabelError>, predicted: &Path) {
    let paired = truth.and_then(|truth| {
        // The same file on both sides: true boxes are predictions where they have scores.
        let predicted = read_predicted(predicted, &truth)?;
        pair(&truth, &predicted)
    });
    match paired {
        Ok(paired) => assert_eq!(paired.names.len(), paired.images.len()),
        Err(error) => say(&error),
    }
}

pub(super) fn coco(bytes: &[u8]) {
    held_as("labels.json", bytes, |path| compare(read_truth(path), path));
}

pub(super) fn coco_seeds() -> Vec<Vec<u8>> {
    let data_set = r#"{"images": [{"id": 7, "file_name": "a.png", "width": 200, "height": 100}, {"id": "b", "file_name": "b.png"}],
        "annotations": [{"id": 1, "image_id": 7, "category_id": 5, "bbox": [20, 10, 40, 20], "iscrowd": 0, "score": 0.5},
        {"id": 2, "image_id": "b", "category_id": 2, "bbox": [0, 0, 100, 100], "iscrowd": 1, "score": 0.25}],
        "categories": [{"id": 5, "name": "tyre"}, {"id": 2, "name": "rock"}]}"#;
    let results = r#"[{"image_id": 7, "category_id": 5, "bbox": [20, 10, 40, 20], "score": 0.75}]"#;
    [data_set, results].map(|text| text.as_bytes().to_vec()).into()
}

pub(super) fn yolo(bytes: &[u8]) {
    scratch::with_file("yolo/a.txt", bytes, |path| {
        let folder = path.parent().expect("a folder");
        compare(read_truth(folder), folder);
    });
}

pub(super) fn yolo_seeds() -> Vec<Vec<u8>> {
    let lines = "0 0.5 0.5 0.25 0.125\n3 0.1 0.9 0.05 0.05\n";
    let with_scores = "0 0.5 0.5 0.25 0.125 0.75\n3 0.1 0.9 0.05 0.05 0.5\n";
    [lines, with_scores].map(|text| text.as_bytes().to_vec()).into()
}
