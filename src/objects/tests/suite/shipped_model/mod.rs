//! Tests the detector that comes with the program: on the demo survey, whose objects are known, and
//! against onnxruntime (`oracle.py` made `boxes.json` from the shipped file and a chip of the test
//! split).

use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{HeadingSettings, Projection, Survey, navigate};
use bathyscope_objects::model::shipped;
use bathyscope_objects::{Detection, DetectorSettings, Mark, Model, Picture, Raster, find};
use bathyscope_simulation::{ObjectPass, Scene, simulate};

const ONNX: &[u8] = include_bytes!("../../../../../assets/detector/default.onnx");
const SIDECAR: &str = include_str!("../../../../../assets/detector/default.json");
const DEMO: &[u8] = include_bytes!("../../../../../assets/demo.sl2");
const SCENE: &str = include_str!("../../../../../assets/demo.toml");

/// Returns the box around echo and shadow of a sighting; `None` for a sighting of under four pings,
/// or a shadow that continues beyond the range.
fn clear_box(seen: &ObjectPass) -> Option<Mark> {
    let pings = seen.first_ping..seen.last_ping + 1;
    let far_m = seen.shadow_m[1].max(seen.far_m);
    (pings.len() >= 4 && seen.shadow_m[1].is_finite()).then_some(Mark {
        side: seen.side,
        pings,
        near_m: seen.near_m,
        far_m,
    })
}

fn meets(raster: &Raster, found: &Detection, mark: &Mark, iou: f32) -> bool {
    let [a, b] = [&found.mark, mark].map(|mark| raster.rect_of(mark));
    found.mark.side == mark.side && a.iou(&b) >= iou
}

fn searched(survey: &Survey) -> (Vec<String>, Raster, Vec<Detection>) {
    let progress = Progress::new();
    let heading = HeadingSettings::default();
    let navigation = navigate(survey, &heading, Projection::Enu, &progress).expect("not cancelled");
    let model = shipped().expect("a model that loads");
    let settings = DetectorSettings::default();
    let found = find(survey, &navigation, &model, &settings, &progress, |_| ()).expect("a search");
    let raster = Raster::new(survey, &navigation, model.pixel_m);
    (model.names().to_vec(), raster, found)
}

#[test]
fn finds_the_objects_of_the_demo() {
    let progress = Progress::new();
    let survey = formats::open_bytes("demo.sl2", DEMO.to_vec(), &progress).expect("the demo");
    let (names, raster, found) = searched(&survey);
    let scene: Scene = toml::from_str(SCENE).expect("the demo's scene");
    let truth = simulate(&scene, 1, &progress).expect("not cancelled");
    let (mut clear, mut hit) = (0, 0);
    for object in &truth.objects {
        let marks: Vec<Mark> = object.sightings.iter().filter_map(clear_box).collect();
        let seen =
            |mark: &&Mark| found.iter().any(|detection| meets(&raster, detection, mark, 0.5));
        let named = |mark: &&Mark| {
            found.iter().any(|detection| {
                names[detection.class] == object.kind.name() && meets(&raster, detection, mark, 0.5)
            })
        };
        clear += marks.len();
        hit += marks.iter().filter(seen).count();
        let kind = object.kind.name();
        assert!(marks.iter().any(|mark| named(&mark)), "no pass over a {kind} found it");
    }
    // A box on any object or its shadow is no false alarm, even if the sighting is short.
    let known: Vec<Mark> = truth
        .objects
        .iter()
        .flat_map(|object| &object.sightings)
        .map(|seen| Mark {
            side: seen.side,
            pings: seen.first_ping.saturating_sub(3)..seen.last_ping + 4,
            near_m: seen.near_m - 0.5,
            far_m: f64::INFINITY,
        })
        .collect();
    let on_something = |detection: &&Detection| {
        known.iter().any(|mark| {
            detection.mark.side == mark.side
                && detection.mark.pings.start < mark.pings.end
                && mark.pings.start < detection.mark.pings.end
                && detection.mark.far_m > mark.near_m
        })
    };
    let false_alarms = found.len() - found.iter().filter(on_something).count();
    println!(
        "{hit} of {clear} clear sightings, {} boxes, {false_alarms} false alarms",
        found.len()
    );
    assert!(hit * 10 >= clear * 8, "{hit} of {clear}");
    assert!(false_alarms * 5 <= found.len(), "{false_alarms} of {}", found.len());
}

/// A box from onnxruntime.
#[derive(serde::Deserialize)]
struct Expected {
    class: usize,
    score: f32,
    #[serde(rename = "box")]
    edges_px: [f32; 4],
}

#[test]
fn agrees_with_onnxruntime() {
    let expected: Vec<Expected> =
        serde_json::from_str(include_str!("boxes.json")).expect("boxes of the oracle");
    let mut sidecar: serde_json::Value = serde_json::from_str(SIDECAR).expect("the sidecar");
    // The oracle does not change the chip's levels or the network's boxes.
    sidecar["level"] = "raw".into();
    sidecar["thresholds"]["vote"] = serde_json::Value::Null;
    sidecar["test_time_augmentation"] = serde_json::Value::Null;
    sidecar["calibration"] = serde_json::Value::Null;
    let model =
        Model::from_bytes(ONNX.to_vec(), Some(&sidecar.to_string())).expect("a usable model");
    let chip = image::load_from_memory(include_bytes!("chip.png")).expect("a picture");
    let (width, height) = (chip.width() as usize, chip.height() as usize);
    let picture = Picture::grey(width, height, chip.into_luma8().into_raw());
    let found = model.detect(&picture, 0.3, 0.45).expect("boxes");
    assert!(!expected.is_empty());
    assert_eq!(found.len(), expected.len());
    for (one, other) in found.iter().zip(&expected) {
        assert_eq!(one.class, other.class);
        assert!((one.score - other.score).abs() < 1e-4, "{} {}", one.score, other.score);
        let rect = [one.rect.x0, one.rect.y0, one.rect.x1, one.rect.y1];
        for (edge, other) in rect.iter().zip(other.edges_px) {
            // The tolerance is a ten-thousandth of the picture's width.
            assert!((edge - other).abs() < 1e-4 * 416.0, "{rect:?} {other}");
        }
    }
}
