//! Compares the detector's figures with `pycocotools` 2.0.11 and `mean_average_precision` 2024.1.5,
//! on the boxes that `detection_fixtures/make_metrics.py` made.

use bathyscope_objects::metrics::{
    ApMethod, Cause, Evaluation, Image, MetricSettings, TrueBox, evaluate,
};
use bathyscope_objects::{Rect, Scored};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    name: String,
    classes: usize,
    images: Vec<Boxes>,
    coco: Option<Coco>,
    voc: Option<Voc>,
}

#[derive(Deserialize)]
struct Boxes {
    /// Class, edges, ignored.
    truth: Vec<(usize, f32, f32, f32, f32, u8)>,
    /// Class, score, edges.
    predicted: Vec<(usize, f32, f32, f32, f32, f32)>,
}

#[derive(Deserialize)]
struct Coco {
    ap50: Vec<Option<f64>>,
    ap50_95: Vec<Option<f64>>,
    map50: Option<f64>,
    map50_95: Option<f64>,
    sizes_map50: Vec<Option<f64>>,
    sizes_map50_95: Vec<Option<f64>>,
    recall50: Vec<Option<f64>>,
    hits50: usize,
    iou_sum50: f64,
}

#[derive(Deserialize)]
struct Voc {
    all: Points,
    #[serde(rename = "11")]
    eleven: Points,
}

#[derive(Deserialize)]
struct Points {
    ap: Vec<f64>,
    map: f64,
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("detection_fixtures/metrics.json")).expect("the fixtures")
}

fn images(case: &Case) -> Vec<Image> {
    let image = |boxes: &Boxes| Image {
        truth: boxes
            .truth
            .iter()
            .map(|&(class, x0, y0, x1, y1, ignored)| TrueBox {
                class,
                rect: Rect { x0, y0, x1, y1 },
                ignored: ignored == 1,
            })
            .collect(),
        predicted: boxes
            .predicted
            .iter()
            .map(|&(class, score, x0, y0, x1, y1)| Scored {
                class,
                score,
                rect: Rect { x0, y0, x1, y1 },
            })
            .collect(),
    };
    case.images.iter().map(image).collect()
}

/// Evaluates at score 0, so that all boxes are counted, as in the oracles.
fn measured(case: &Case, settings: MetricSettings) -> Evaluation {
    let settings = MetricSettings { score: 0.0, ..settings };
    evaluate(&images(case), case.classes, &settings)
}

fn same(what: &str, ours: f64, theirs: Option<f64>) {
    let theirs = theirs.unwrap_or(f64::NAN);
    assert!(
        (ours - theirs).abs() < 1e-6 || (ours.is_nan() && theirs.is_nan()),
        "{what}: {ours} instead of {theirs}"
    );
}

#[test]
fn cocos_rule_gives_the_figures_of_pycocotools() {
    let mut seen = 0;
    for case in cases() {
        let Some(theirs) = &case.coco else { continue };
        let ours = measured(&case, MetricSettings::coco());
        let name = &case.name;
        same(&format!("{name}, mAP50"), ours.map, theirs.map50);
        same(&format!("{name}, mAP"), ours.map_50_95, theirs.map50_95);
        for (class, report) in ours.classes.iter().enumerate() {
            let what = format!("{name}, class {class}");
            same(&what, report.ap, theirs.ap50[class]);
            same(&what, report.ap_50_95, theirs.ap50_95[class]);
            same(&what, ours.shown.classes[class].recall(), theirs.recall50[class]);
        }
        for (size, report) in ours.sizes.iter().enumerate() {
            let what = format!("{name}, size {size}");
            same(&what, report.map, theirs.sizes_map50[size]);
            same(&what, report.map_50_95, theirs.sizes_map50_95[size]);
        }
        assert_eq!(ours.shown.counts.found, theirs.hits50, "{name}");
        same(name, ours.shown.counts.iou_sum, Some(theirs.iou_sum50));
        seen += 1;
    }
    assert_eq!(seen, 21);
}

#[test]
fn darknets_rule_gives_the_figures_of_mean_average_precision() {
    let mut seen = 0;
    for case in cases() {
        let Some(theirs) = &case.voc else { continue };
        for (method, theirs) in
            [(ApMethod::AllPoint, &theirs.all), (ApMethod::Voc11, &theirs.eleven)]
        {
            let ours = measured(&case, MetricSettings { ap: method, ..MetricSettings::darknet() });
            // The oracle sets the AP of a class without truths to 0; here it is NaN, and counts as
            // 0 in the mean.
            let or_zero = |ap: f64| if ap.is_nan() { 0.0 } else { ap };
            let what = format!("{}, {method:?}", case.name);
            same(&what, or_zero(ours.map), Some(theirs.map));
            for (report, &ap) in ours.classes.iter().zip(&theirs.ap) {
                same(&what, or_zero(report.ap), Some(ap));
            }
        }
        seen += 1;
    }
    assert_eq!(seen, 16);
}

#[test]
fn counts_confusion_and_mistakes_tell_the_same_story() {
    for case in cases() {
        for settings in [MetricSettings::coco(), MetricSettings::darknet()] {
            let images = images(&case);
            let ours = evaluate(&images, case.classes, &settings).shown;
            let (confusion, counts) = (&ours.confusion, ours.counts);
            let background = confusion.classes;
            let diagonal: usize = (0..background).map(|class| confusion.at(class, class)).sum();
            assert_eq!(diagonal, counts.found, "{}", case.name);
            let rows: Vec<usize> = confusion.rows().map(|row| row.iter().sum()).collect();
            assert_eq!(rows[..background].iter().sum::<usize>(), counts.truths, "{}", case.name);
            let all: usize = rows.iter().sum();
            let unseen: usize = (0..background).map(|class| confusion.at(class, background)).sum();
            assert_eq!(all - unseen, counts.found + counts.false_alarms, "{}", case.name);
            assert_eq!(ours.false_alarms.len(), counts.false_alarms, "{}", case.name);
            assert_eq!(ours.misses.len(), counts.missed(), "{}", case.name);
            if counts.found + counts.false_alarms > 0 {
                assert!(counts.darknet_iou() <= counts.precision() + 1e-12);
            }
        }
    }
}

fn boxed(class: usize, score: f32, [x0, y0, x1, y1]: [f32; 4]) -> Scored {
    Scored { class, score, rect: Rect { x0, y0, x1, y1 } }
}

/// Creates two pictures: a stone found loosely, and a stone found twice; a tyre predicted as a
/// stone; a missed stone; a prediction without an object.
fn worked_example() -> Vec<Image> {
    let truth = |class, [x0, y0, x1, y1]: [f32; 4]| TrueBox {
        class,
        rect: Rect { x0, y0, x1, y1 },
        ignored: false,
    };
    vec![
        Image {
            truth: vec![truth(0, [0.0, 0.0, 10.0, 10.0]), truth(1, [50.0, 0.0, 60.0, 10.0])],
            predicted: vec![
                boxed(0, 0.9, [0.0, 0.0, 10.0, 8.0]),
                boxed(0, 0.8, [0.0, 0.0, 10.0, 9.0]),
                boxed(0, 0.7, [50.0, 0.0, 60.0, 10.0]),
                boxed(1, 0.1, [50.0, 0.0, 60.0, 10.0]),
            ],
        },
        Image {
            truth: vec![truth(0, [0.0, 0.0, 10.0, 10.0])],
            predicted: vec![
                boxed(1, 0.5, [90.0, 90.0, 95.0, 95.0]),
                boxed(0, 0.4, [6.0, 0.0, 16.0, 10.0]),
            ],
        },
    ]
}

#[test]
fn a_worked_example_by_hand() {
    let ours = evaluate(&worked_example(), 2, &MetricSettings::darknet());
    let counts = ours.shown.counts;
    // Found: the first box, IoU 80 / 100. False: the second, the third, the one without an object
    // and the loose one.
    assert_eq!((counts.found, counts.false_alarms, counts.missed()), (1, 4, 2));
    assert_eq!(counts.precision(), 0.2);
    assert_eq!(counts.recall(), 1.0 / 3.0);
    assert_eq!(counts.f1(), 0.25);
    assert!((counts.iou_of_matches() - 0.8).abs() < 1e-12);
    assert!((counts.darknet_iou() - 0.16).abs() < 1e-12);
    // Rows and columns: stone, tyre, background.
    let rows: Vec<&[usize]> = ours.shown.confusion.rows().collect();
    assert_eq!(rows, [[1, 0, 1], [1, 0, 0], [2, 1, 0]]);
    let causes: Vec<Cause> = ours.shown.false_alarms.iter().map(|alarm| alarm.cause).collect();
    assert_eq!(causes, [Cause::Duplicate, Cause::OtherClass, Cause::Background, Cause::Loose]);
    let missed: Vec<(usize, usize)> =
        ours.shown.misses.iter().map(|miss| (miss.image, miss.truth)).collect();
    assert_eq!(missed, [(0, 1), (1, 0)]);
    // The tyre's own box is below the score, but on the curve of its class: 1 of 2 at its end.
    let tyre = &ours.classes[1].curve;
    assert_eq!((tyre[1].score, tyre[1].precision, tyre[1].recall), (0.1, 0.5, 1.0));
    assert_eq!(ours.curve.len(), 6);
    assert_eq!(ours.curve[0].f1, 2.0 / (1.0 + 3.0));
}

#[test]
fn boxes_of_unknown_classes_are_left_out() {
    let ours = evaluate(&worked_example(), 1, &MetricSettings::coco()).shown;
    assert_eq!(ours.counts.truths, 2);
    assert_eq!(ours.confusion.classes, 1);
    assert!(ours.misses.iter().all(|miss| (miss.image, miss.truth) != (0, 1)));
}
