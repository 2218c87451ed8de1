//! Labelled pictures of simulated surveys: boxes against what objects really change in the picture,
//! and the files.

use bathyscope::cli::known_objects;
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{HeadingSettings, Projection, Survey, navigate};
use bathyscope_objects::dataset::Chip;
use bathyscope_objects::{Raster, Rect, TILE_PX};
use bathyscope_simulation::{
    Scene, Simulated, TrainingScene, simulate, training_scene, training_seed,
};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const PIXEL_M: f64 = 0.04;

fn survey(scene: &Scene, seed: u64) -> (Simulated, Survey, Raster) {
    let quiet = Progress::new();
    let simulated = simulate(scene, seed, &quiet).expect("nobody cancels");
    let survey = formats::open_bytes("scene.sl2", simulated.sl2_bytes(), &quiet).expect("our log");
    let navigation = navigate(&survey, &HeadingSettings::default(), Projection::Enu, &quiet);
    let raster = Raster::new(&survey, &navigation.expect("nobody cancels"), PIXEL_M);
    (simulated, survey, raster)
}

/// Pixels of a tile that its objects changed: the same survey without them has the same ground,
/// noise and speckle.
struct Changed(Vec<bool>);

impl Changed {
    /// The box around the changed pixels near a place, without the outermost hundredth on each
    /// side.
    fn around(&self, near: &Rect) -> Option<Rect> {
        let (mut columns, mut rows) = (Vec::new(), Vec::new());
        for y in near.y0.max(0.0) as usize..near.y1.min(TILE_PX as f32) as usize {
            for x in near.x0.max(0.0) as usize..near.x1.min(TILE_PX as f32) as usize {
                if self.0[y * TILE_PX + x] {
                    columns.push(x as f32);
                    rows.push(y as f32);
                }
            }
        }
        let ends = |mut places: Vec<f32>| {
            places.sort_by(f32::total_cmp);
            let cut = places.len() / 100;
            Some([*places.get(cut)?, places.get(places.len() - 1 - cut)? + 1.0])
        };
        let ([x0, x1], [y0, y1]) = (ends(columns)?, ends(rows)?);
        Some(Rect { x0, y0, x1, y1 })
    }
}

/// Compares labels with the pixels that objects change: adds the IoU of every label that has no
/// other near it, and counts the changed pixels in and outside of all boxes.
fn compare(training: &TrainingScene, seed: u64, ious: &mut Vec<f32>) -> [usize; 2] {
    let (simulated, with, raster) = survey(&training.scene, seed);
    let bare = Scene { objects: Vec::new(), ..training.scene.clone() };
    let (_, without, _) = survey(&bare, seed);
    let known = known_objects(&simulated);
    let mut changed_pixels = [0, 0];
    for look in &training.looks {
        let row = (look.along * raster.rows().saturating_sub(TILE_PX) as f64) as usize;
        let tile = raster.tile(&with, look.side, row, 0);
        let plain = raster.tile(&without, look.side, row, 0);
        let pairs = tile.pixels.iter().zip(&plain.pixels);
        let changed = Changed(pairs.map(|(a, b)| a.abs_diff(*b) > 8).collect());
        let boxes = Chip::new(tile, &raster, &known).boxes;
        let all: Vec<Rect> =
            boxes.labels.iter().chain(&boxes.ignored).map(|label| label.rect).collect();
        for label in &boxes.labels {
            let near = widened(&label.rect, 15.0);
            if all.iter().filter(|other| other.intersection(&near).area() > 0.0).count() == 1 {
                ious.push(changed.around(&near).map_or(0.0, |found| found.iou(&label.rect)));
            }
        }
        for (index, _) in changed.0.iter().enumerate().filter(|(_, changed)| **changed) {
            let (x, y) = ((index % TILE_PX) as f32, (index / TILE_PX) as f32);
            let pixel = Rect { x0: x, y0: y, x1: x + 1.0, y1: y + 1.0 };
            let inside =
                all.iter().any(|rect| widened(rect, 3.0).intersection(&pixel).area() > 0.0);
            changed_pixels[usize::from(!inside)] += 1;
        }
    }
    changed_pixels
}

fn widened(rect: &Rect, margin: f32) -> Rect {
    Rect { x0: rect.x0 - margin, y0: rect.y0 - margin, x1: rect.x1 + margin, y1: rect.y1 + margin }
}

#[test]
fn boxes_hold_what_objects_change_in_the_picture() {
    let mut ious = Vec::new();
    let (mut inside, mut outside) = (0, 0);
    for index in 0..8 {
        let seed = training_seed(77, 0, index);
        let mut training = training_scene(seed, 4, TILE_PX as f64 * PIXEL_M);
        // Objects also change what reaches the weed and the second echo; those are not theirs.
        training.scene.artefacts.second_echo_db = 0.0;
        let [these, others] = compare(&training, seed, &mut ious);
        inside += these;
        outside += others;
    }
    ious.sort_by(f32::total_cmp);
    eprintln!(
        "{} boxes: IoU {ious:.2?}; changed pixels inside {inside}, outside {outside}",
        ious.len()
    );
    assert!(ious.len() >= 8, "{ious:?}");
    assert!(ious[ious.len() / 2] > 0.85, "{ious:?}");
    assert!(outside * 50 < inside, "{outside} of {inside}");
}

fn make(folder: &Path, arguments: &[&str]) {
    let output = Command::new(crate::support::program())
        .args(["simulate", "--dataset"])
        .arg(folder)
        .args(arguments)
        .output()
        .expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{errors}");
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a file")).expect("JSON")
}

/// All files of a folder with their bytes.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("inside").to_path_buf();
                found.insert(name, fs::read(&path).expect("a file"));
            }
        }
    }
    found
}

#[test]
fn a_dataset_is_whole_and_the_same_for_a_seed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (once, again) = (folder.path().join("once"), folder.path().join("again"));
    let arguments = ["--images", "12", "--split", "2/1/1", "--per-scene", "3", "--seed", "5"];
    make(&once, &[&arguments[..], &["--threads", "1"]].concat());
    make(&again, &[&arguments[..], &["--threads", "3"]].concat());
    let files = contents(&once);
    assert!(files == contents(&again), "threads change the pictures");

    let manifest = json(&once.join("manifest.json"));
    let mut seeds = BTreeSet::new();
    for (part, images) in [("train", 6), ("val", 3), ("test", 3)] {
        let coco = json(&once.join(format!("{part}.json")));
        assert_eq!(coco["images"].as_array().expect("images").len(), images);
        assert_same_boxes(&once, part, &coco);
        let parts = manifest["parts"].as_array().expect("parts");
        let entry = parts.iter().find(|entry| entry["name"] == part).expect("the part");
        for seed in entry["scene_seeds"].as_array().expect("seeds") {
            assert!(seeds.insert(seed.to_string()), "a scene is in two parts");
        }
    }
    assert_eq!(seeds.len(), 4);
    let names = String::from_utf8(files[Path::new("classes.txt")].clone()).expect("text");
    assert_eq!(names, "rock\nblock\ncylinder\ntyre\nboat\nlog\neffigy\n");

    let refused = Command::new(crate::support::program())
        .args(["simulate", "--images", "1", "--dataset"])
        .arg(&once)
        .output()
        .expect("the program starts");
    let sentence = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(1) && sentence.contains("not empty"), "{sentence}");
}

/// YOLO lines and COCO annotations of every picture are the same boxes, and lie in the picture.
fn assert_same_boxes(folder: &Path, part: &str, coco: &Value) {
    for image in coco["images"].as_array().expect("images") {
        let name = image["file_name"].as_str().expect("a name");
        let size = image::image_dimensions(folder.join("images").join(part).join(name));
        assert_eq!(size.expect("a picture"), (416, 416));
        let text = folder.join("labels").join(part).join(name).with_extension("txt");
        let text = fs::read_to_string(text).expect("labels");
        let annotations = coco["annotations"].as_array().expect("annotations");
        let boxes: Vec<&Value> = annotations
            .iter()
            .filter(|annotation| {
                annotation["image_id"] == image["id"] && annotation["iscrowd"] == 0
            })
            .collect();
        assert_eq!(text.lines().count(), boxes.len());
        for (line, annotation) in text.lines().zip(boxes) {
            let yolo: Vec<f64> =
                line.split(' ').map(|word| word.parse().expect("a number")).collect();
            let [x, y, w, h] =
                [0, 1, 2, 3].map(|i| annotation["bbox"][i].as_f64().expect("a number") / 416.0);
            assert_eq!(annotation["category_id"].as_f64(), Some(yolo[0] + 1.0));
            for (ours, theirs) in
                [(x + 0.5 * w, yolo[1]), (y + 0.5 * h, yolo[2]), (w, yolo[3]), (h, yolo[4])]
            {
                assert!((ours - theirs).abs() < 2e-6, "{line} {annotation}");
            }
            assert!(x >= 0.0 && y >= 0.0 && x + w <= 1.0 + 1e-6 && y + h <= 1.0 + 1e-6);
        }
    }
}

/// The 41 scenes that models are judged on, six pictures each: `bathyscope simulate --dataset
/// DIR --split 0/0/246 --seed 41`. Training never draws a scene of a test part.
#[test]
fn the_committed_test_split_is_what_its_seed_gives() {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/detector/test-split.json");
    let committed = json(&committed);
    let seed = committed["seed"].as_u64().expect("a seed");
    let scenes: Vec<u64> = (0..41).map(|scene| training_seed(seed, 2, scene)).collect();
    assert_eq!(committed["scene_seeds"], Value::from(scenes.clone()));
    assert_eq!(committed["images"], 41 * 6);

    let folder = tempfile::tempdir().expect("a folder");
    let made = folder.path().join("test");
    make(&made, &["--images", "6", "--split", "0/0/1", "--seed", &seed.to_string()]);
    let manifest = json(&made.join("manifest.json"));
    assert_eq!(manifest["parts"][2]["scene_seeds"][0], scenes[0]);
    assert_eq!(manifest["per_scene"], committed["per_scene"]);
}
