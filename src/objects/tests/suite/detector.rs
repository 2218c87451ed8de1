//! Tests models of other makers: the boxes agree with onnxruntime and a separate decoding
//! (`detector_models/make.py`); a model that cannot be used is refused with a sentence about the
//! remedy; and no file makes the program panic.

use bathyscope_log::support::progress::Progress;
use bathyscope_objects::model::Unusable;
use bathyscope_objects::{DetectorSettings, Model, Picture, Scored, find_in_picture};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Least score of a box in `make.py`.
const SCORE: f32 = 0.35;
const IOU: f32 = 0.45;

fn models() -> PathBuf {
    bathyscope_test_support::detector_models()
}

fn load(name: &str) -> Model {
    Model::load(&models().join(format!("{name}.onnx"))).expect("a usable model")
}

fn refusal(path: &Path) -> String {
    Model::load(path).expect_err("a refused model").to_string()
}

/// Loads the YOLOv8 model with a sidecar text.
fn yolov8(sidecar: &str) -> Result<Model, Unusable> {
    let bytes = fs::read(models().join("yolov8.onnx")).expect("a model");
    Model::from_bytes(bytes, Some(sidecar))
}

/// Returns the boxes that the YOLOv8 model finds in the picture with a sidecar text.
fn found(sidecar: &str, score: f32) -> Vec<Scored> {
    let model = yolov8(sidecar).expect("a usable sidecar");
    model.detect(&picture(), score, IOU).expect("boxes")
}

/// Creates the picture that `make.py` draws: 96 x 80 in colour.
fn picture() -> Picture {
    let mut levels = Vec::new();
    for y in 0..80 {
        for x in 0..96 {
            levels.extend((0..3).map(|c| (x * x / 9 + y * (5 + c) * 3 + c * 40 + x * y / 7) as u8));
        }
    }
    Picture { width: 96, height: 80, channels: 3, levels }
}

/// Class, score, x0, y0, x1, y1.
type Expected = BTreeMap<String, Vec<[f32; 6]>>;

fn expected() -> Expected {
    let text = fs::read_to_string(models().join("expected.json")).expect("a readable file");
    serde_json::from_str(&text).expect("boxes of each model")
}

/// Returns the largest differences of scores and of edges in pixels; boxes of nearly equal scores
/// may be in a different order.
fn differences(found: &[Scored], expected: &[[f32; 6]]) -> (f32, f32) {
    assert_eq!(found.len(), expected.len());
    let mut left: Vec<&Scored> = found.iter().collect();
    let (mut score, mut edge) = (0.0_f32, 0.0_f32);
    for row in expected {
        let away = |found: &Scored| {
            let edges = [found.rect.x0, found.rect.y0, found.rect.x1, found.rect.y1];
            let edges = edges.iter().zip(&row[2..]);
            edges.fold(0.0_f32, |away, (a, b)| away.max((a - b).abs()))
        };
        let nearest = (0..left.len())
            .filter(|&index| left[index].class as f32 == row[0])
            .min_by(|&a, &b| away(left[a]).total_cmp(&away(left[b])))
            .expect("a box of that class");
        let nearest_box = left.swap_remove(nearest);
        edge = edge.max(away(nearest_box));
        score = score.max((nearest_box.score - row[1]).abs());
    }
    (score, edge)
}

#[test]
fn every_family_is_recognised_and_finds_what_onnxruntime_finds() {
    let families = [
        ("tianxiaomo", "YOLOv4 (boxes and scores) with 3 classes"),
        ("darknet", "YOLOv4 (boxes and scores) with 3 classes"),
        ("outside", "YOLOv4 (boxes and scores) with 3 classes"),
        ("raw_heads", "raw YOLO heads with 3 classes"),
        ("yolov5", "YOLOv5 or v7 with 3 classes"),
        ("yolov5_one_class", "YOLOv5 or v7 with 1 class,"),
        ("yolov8", "YOLOv8 to v12 with 3 classes"),
        ("half", "YOLOv8 to v12 with 3 classes"),
        ("end_to_end", "an end-to-end YOLO with 3 classes"),
        ("yolox", "YOLOX with 3 classes"),
    ];
    let expected = expected();
    assert_eq!(expected.len(), families.len());
    for (name, family) in families {
        let model = load(name);
        let text = &model.description;
        assert!(text.starts_with(family), "{name}: {text}");
        assert_eq!(text.contains("guessed"), name != "raw_heads", "{text}");
        let found = model.detect(&picture(), SCORE, IOU).expect("boxes");
        // onnxruntime computes in f16, which rounds to three digits.
        let tolerance = if name == "half" { (3e-3, 0.3) } else { (1e-5, 1e-3) };
        let away = differences(&found, &expected[name]);
        assert!(
            away.0 <= tolerance.0 && away.1 <= tolerance.1,
            "{name}: scores differ by {}, edges by {} pixels",
            away.0,
            away.1
        );
    }
}

#[test]
fn class_names_come_from_the_file_or_its_sidecar() {
    assert_eq!(load("yolov8").classes(), ["rock", "tyre", "log"]);
    assert_eq!(load("raw_heads").classes(), ["rock", "tyre", "log"]);
    assert_eq!(load("yolox").classes(), ["class 0", "class 1", "class 2"]);
}

#[test]
fn what_cannot_be_used_is_refused_with_what_to_do() {
    let refused = [
        ("upsample", "export it again with opset 11"),
        ("nms_inside", "export it again without (nms=False"),
        ("classifier", "name the family in the sidecar JSON file"),
        ("loop", "may never end"),
        ("huge", "asks for a size of [1, 1, 1000000, 1000000]"),
        ("huge_input", "is 1099511627776 x 1099511627776 pixels"),
        ("costly", "billion multiplications; export a smaller network"),
        ("outer_product", "makes 1,1048576,1048576 numbers of constants"),
        ("worked_out", "makes 1,3,19200,19200 numbers of constants"),
        ("many_constants", "numbers of its constants"),
        ("gathering", "gathers 68183654400 numbers under its kernel"),
        ("held", "one picture holds"),
    ];
    for (name, sentence) in refused {
        let path = models().join(format!("{name}.onnx"));
        let text = refusal(&path);
        assert!(text.contains(sentence), "{name}: {text}");
        assert!(text.starts_with("cannot use the model: "), "{text}");
        assert!(text.ends_with(&path.display().to_string()), "{text}");
    }
}

#[test]
fn missing_companions_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["outside", "raw_heads"] {
        let file = format!("{name}.onnx");
        fs::copy(models().join(&file), folder.path().join(&file)).expect("a copy");
    }
    let text = refusal(&folder.path().join("outside.onnx"));
    assert!(text.contains("its weights lie in `outside.onnx.data`"), "{text}");
    let text = refusal(&folder.path().join("raw_heads.onnx"));
    assert!(text.contains("write them into the sidecar JSON file"), "{text}");
    let text = refusal(&folder.path().join("none.onnx"));
    assert!(text.contains("cannot be read"), "{text}");
    let text = refusal(folder.path());
    assert!(text.contains("it is a folder"), "{text}");
}

#[test]
fn a_sidecar_corrects_the_guess_or_is_refused() {
    let model = yolov8(
        r#"{"family": "yolov11", "names": ["a", "b", "c"], "pixel_m": 0.1, "input": {"resize": "stretch"},
            "thresholds": {"score": 0.6, "iou": 0.3, "nms": "darknet"}, "training": {"epochs": 3}}"#,
    )
    .expect("a usable sidecar");
    assert_eq!(model.classes(), ["a", "b", "c"]);
    assert_eq!((model.pixel_m, model.score, model.iou), (0.1, 0.6, 0.3));
    assert!(model.description.contains("stretched (by its JSON file)"));
    let error_of = |text: &str| yolov8(text).expect_err("a wrong sidecar").to_string();
    assert!(error_of("{").contains("sidecar JSON file is wrong"));
    assert!(error_of(r#"{"family": "ssd"}"#).contains("unknown variant `ssd`"));
    assert!(error_of(r#"{"names": ["a"]}"#).contains("1 class names are given, but"));
    assert!(error_of(r#"{"family": "yolov4"}"#).contains("do not fit the family YOLOv4"));
    assert!(error_of(r#"{"pixel_m": 0}"#).contains("pixel_m lies between"));
}

#[test]
fn a_box_is_named_from_a_confidence_on_and_is_an_object_below_it() {
    let named = |sidecar: &str, name_score: Option<f32>| {
        let model = yolov8(sidecar).expect("a usable sidecar");
        assert_eq!(model.names(), ["rock", "tyre", "log", "object"]);
        let settings =
            DetectorSettings { score: Some(SCORE), name_score, ..DetectorSettings::default() };
        let found = find_in_picture(&picture(), &model, &settings, &Progress::new());
        let found = found.expect("boxes").into_iter();
        found.map(|found_box| (found_box.score, found_box.class)).collect::<Vec<_>>()
    };
    // Without a least score for names in its sidecar file, a model keeps the classes of all boxes.
    let all = named("{}", None);
    assert!(all.iter().all(|&(_, class)| class < 3));
    let between = all[all.len() / 2].0;
    let some: Vec<(f32, usize)> = (all.iter())
        .map(|&(score, class)| (score, if score < between { 3 } else { class }))
        .collect();
    assert_ne!(some, all);
    assert_eq!(named("{}", Some(between)), some);
    let sidecar = format!(r#"{{"thresholds": {{"name": {between}}}}}"#);
    assert_eq!(named(&sidecar, None), some);
    assert_eq!(named(&sidecar, Some(0.0)), all);
    let refused = yolov8(r#"{"thresholds": {"name": 2}}"#);
    let error = refused.expect_err("a wrong sidecar").to_string();
    assert!(error.contains("thresholds.name"), "{error}");
}

#[test]
fn boxes_vote_when_the_sidecar_says_so_and_stay_wherever_the_slider_is() {
    let voting = r#"{"thresholds": {"vote": 0.65}}"#;
    let (plain, voted) = (found("{}", SCORE), found(voting, SCORE));
    assert_eq!(plain.len(), voted.len());
    let class_and_score = |found_box: &Scored| (found_box.class, found_box.score);
    assert!(plain.iter().map(class_and_score).eq(voted.iter().map(class_and_score)));
    assert_ne!(plain, voted);
    let surest = voted.len() / 2;
    assert_eq!(found(voting, voted[surest].score), voted[..=surest]);
    assert_eq!(found(voting, 0.02)[..voted.len()], voted);
    let refused = yolov8(r#"{"thresholds": {"vote": 2}}"#);
    assert!(refused.expect_err("a share").to_string().contains("lie between 0 and 1"));
}

#[test]
fn confidences_are_calibrated_as_the_sidecar_says() {
    let halved = r#"{"calibration": [[0.5, 0.25], [1.0, 0.5]]}"#;
    let (plain, calibrated) = (found("{}", 0.4), found(halved, 0.2));
    assert!(plain.len() > 1);
    assert_eq!(plain.len(), calibrated.len());
    for (one, other) in plain.iter().zip(&calibrated) {
        assert_eq!((one.class, one.rect), (other.class, other.rect));
        assert!((one.score / 2.0 - other.score).abs() < 1e-6);
    }
    // No box has such a high score after the calibration.
    assert_eq!(found(halved, 0.6), []);
    let refused = yolov8(r#"{"calibration": [[0.5, 0.2]]}"#);
    let text = refused.expect_err("no map").to_string();
    assert!(text.contains("rise from 0 to a confidence of 1"), "{text}");
}

#[test]
fn a_mirrored_pass_sees_the_same_and_is_less_sure_than_the_surer() {
    let model = |sidecar: &str| yolov8(sidecar).expect("a model");
    let (once, twice) = (model("{}"), model(r#"{"test_time_augmentation": "mirrored"}"#));
    assert!(!once.description.contains("test-time augmentation"));
    assert!(twice.description.contains("test-time augmentation (mirrored)"));
    let scores = |model: &Model, picture: &Picture| -> Vec<f32> {
        // No box is suppressed here: of two boxes of one object with equal scores, either could be
        // kept.
        let found = model.detect(picture, SCORE, 1.0).expect("boxes");
        found.iter().map(|found_box| found_box.score).collect()
    };
    let (there, back) = (picture(), picture().mirrored());
    assert_ne!(scores(&once, &there), scores(&once, &back));
    let both = scores(&twice, &there);
    assert!(!both.is_empty());
    assert_eq!(both, scores(&twice, &back));
    let surest = |picture: &Picture| scores(&once, picture)[0];
    assert!(both[0] <= surest(&there).max(surest(&back)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// A damaged file results in an error or in a model that runs.
    #[test]
    fn a_damaged_model_takes_nothing_down(
        which in 0_usize..4,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        end in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let name = ["tianxiaomo", "yolov8", "end_to_end", "half"][which];
        let mut bytes = fs::read(models().join(format!("{name}.onnx"))).expect("a model");
        for (place, value) in flips {
            let place = place.index(bytes.len());
            bytes[place] ^= value;
        }
        if let Some(end) = end {
            let end = end.index(bytes.len());
            bytes.truncate(end);
        }
        if let Ok(model) = Model::from_bytes(bytes, None) {
            let found = model.detect(&picture(), SCORE, IOU);
            let is_inside = |found_box: &Scored| {
                (0.0..=96.0).contains(&found_box.rect.x0) && found_box.score <= 1.0
            };
            prop_assert!(found.is_err() || found.unwrap().iter().all(is_inside));
        }
    }
}

#[test]
fn files_that_are_no_models_are_refused() {
    for bytes in [&b""[..], b"\x89PNG\r\n\x1a\n", &[0; 4096], &[255; 4096]] {
        let text = Model::from_bytes(bytes.to_vec(), None).expect_err("no model");
        assert!(text.to_string().contains("no ONNX file"), "{text}");
    }
}
