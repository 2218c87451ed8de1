use super::*;
use std::fs;

/// Creates a folder with files of these names and texts.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    folder
}

const COCO: &str = r#"{
  "info": {"year": 2026},
  "images": [{"id": 7, "file_name": "a.png", "width": 200, "height": 100}, {"id": 9, "file_name": "b.png", "width": 200, "height": 100}],
  "annotations": [{"id": 1, "image_id": 7, "category_id": 5, "bbox": [20, 10, 40, 20], "area": 800, "iscrowd": 0},
                  {"id": 2, "image_id": 9, "category_id": 2, "bbox": [0, 0, 100, 100], "area": 10000, "iscrowd": 1}],
  "categories": [{"id": 5, "name": "tyre"}, {"id": 2, "name": "rock"}]
}"#;

const RESULTS: &str =
    r#"[{"image_id": 7, "category_id": 5, "bbox": [20, 10, 40, 20], "score": 0.75}]"#;

fn refusal(files: &[(&str, &str)]) -> String {
    let folder = folder(files);
    let truth = read_truth(&folder.path().join("truth"));
    let error = truth
        .and_then(|truth| {
            let predicted = read_predicted(&folder.path().join("predicted"), &truth)?;
            pair(&truth, &predicted)
        })
        .expect_err("unusable labels");
    let path = error.path.strip_prefix(folder.path());
    let path = path.expect("a path in the folder").display().to_string();
    format!("{}: {path}", error.what)
}

#[test]
fn both_formats_give_the_same_boxes() {
    let folder = folder(&[
        ("yolo/labels/a.txt", "1 0.2 0.2 0.2 0.2\n\n"),
        ("yolo/labels/b.txt", ""),
        ("yolo/classes.txt", "rock\ntyre\n"),
        ("predicted/a.txt", "1 0.2 0.2 0.2 0.2 0.75\n"),
        ("coco/truth.json", COCO),
        ("results.json", RESULTS),
    ]);
    let at = |name: &str| folder.path().join(name);
    let coco = read_truth(&at("coco")).expect("the data set");
    assert_eq!(coco.names, ["rock", "tyre"]);
    let yolo = read_truth(&at("yolo")).expect("the labels");
    assert_eq!(yolo.names, coco.names);
    let results = read_predicted(&at("results.json"), &coco).expect("the results");
    let texts = read_predicted(&at("predicted"), &coco).expect("the labels");
    let expected = Rect::new([20.0, 10.0], [60.0, 30.0]);
    for predicted in [&results, &texts] {
        let paired = pair(&coco, predicted).expect("the same pictures");
        assert_eq!(paired.names, ["a", "b"]);
        assert_eq!(paired.classes, ["rock", "tyre"]);
        assert_eq!(paired.notes, [""; 0]);
        let [a, b] = &paired.images[..] else { panic!("{paired:?}") };
        assert_eq!((a.truth[0].class, a.truth[0].rect), (1, expected));
        assert!(b.truth[0].ignored && b.predicted.is_empty());
        let [x0, x1] = [a.predicted[0].rect.x0, a.predicted[0].rect.x1];
        assert!((x0 - 20.0).abs() < 1e-4 && (x1 - 60.0).abs() < 1e-4);
        assert_eq!((a.predicted[0].class, a.predicted[0].score), (1, 0.75));
    }
    // There are no pictures beside the labels: one note is about their unknown size.
    let paired = pair(&yolo, &texts).expect("the same pictures");
    assert!((paired.images[0].truth[0].rect.x0 - 0.1 * 416.0).abs() < 1e-3);
    assert_eq!(paired.notes.len(), 1);
}

#[test]
fn a_picture_next_to_its_labels_gives_its_size() {
    let folder = folder(&[("set/labels/a.txt", "0 0.5 0.5 0.5 0.5\n")]);
    let images = folder.path().join("set/images");
    fs::create_dir(&images).expect("a folder");
    let picture = image::GrayImage::new(64, 32);
    picture.save(images.join("a.png")).expect("a picture");
    let truth = read_truth(&folder.path().join("set/labels")).expect("the labels");
    assert_eq!(truth.pictures["a"].size_px, Some([64, 32]));
}

#[test]
fn unusable_labels_are_refused_with_their_place() {
    let good = ("truth/a.txt", "0 0.5 0.5 0.1 0.1");
    let cases: [(&[(&str, &str)], &str); 10] = [
        (
            &[("truth/a.png", "")],
            "no labels in the folder; name one that holds YOLO label files (*.txt) or a COCO file (*.json): truth",
        ),
        (
            &[("truth/a.txt", "\n0 0.5 x 0.1 0.1")],
            "cannot use line 2: `x` is no number: truth/a.txt",
        ),
        (
            &[("truth/a.txt", "0 0.5 0.5 0.1 0.1 0.9")],
            "cannot use line 1: a true box has no sixth number (these may be predictions): class cx cy w h: truth/a.txt",
        ),
        (
            &[("truth/a.txt", "0 12 40 8 8")],
            "cannot use line 1: centre and size are shares of the picture, from 0 to 1: truth/a.txt",
        ),
        (
            &[("truth/a.txt", "99999999999 0.5 0.5 0.1 0.1")],
            "cannot use line 1: `99999999999` is no class (a whole number from 0, below 1000): truth/a.txt",
        ),
        (
            &[good, ("predicted/a.txt", "0 0.5 0.5 0.1 0.1")],
            "cannot use line 1: a predicted box needs a score: class cx cy w h score: predicted/a.txt",
        ),
        (
            &[good, ("predicted/a.txt", "0 0.5 0.5 0.1 0.1 7")],
            "cannot use line 1: the score `7` is not within 0 to 1: predicted/a.txt",
        ),
        (
            &[good, ("predicted/z.txt", "0 0.5 0.5 0.1 0.1 0.7")],
            "no predictions have the name of a labelled picture; name the folders of the same pictures: predicted",
        ),
        (
            &[
                ("truth/t.json", COCO),
                (
                    "predicted/p.json",
                    r#"[{"image_id": 8, "category_id": 5, "bbox": [0, 0, 1, 1], "score": 1}]"#,
                ),
            ],
            "cannot use the box 1 of the file: there is no picture 8: predicted/p.json",
        ),
        (
            &[("truth/t.json", "{\"images\": [],\n \"annotations\": 3}")],
            "cannot use the COCO file: invalid type: integer `3`, expected a sequence at line 2 column 17: truth/t.json",
        ),
    ];
    for (files, sentence) in cases {
        assert_eq!(refusal(files), sentence);
    }
}
