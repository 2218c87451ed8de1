use super::*;
use crate::metrics::{Cause, MetricSettings, evaluate};
use crate::review::{BoxId, Edit, Review};
use crate::testing::survey;
use crate::{Detection, Mark, NAMELESS_CLASS, Raster, class_index};
use bathyscope_log::survey::{Identity, Side};
use std::sync::Arc;

const HEADER: &str = "object,kind,side,box_first_ping,box_last_ping,box_near_m,box_far_m,shown\n";

fn identity(pings: usize) -> Identity {
    Identity { swapped_sides: false, file: "pond.sl2".into(), byte_count: 1, pings }
}

fn mark(start: usize, near_m: f64) -> Mark {
    Mark::new(Side::Port, start..start + 10, [near_m, near_m + 2.0])
}

fn read(lines: &str) -> Result<SurveyTruth, TruthError> {
    SurveyTruth::parse(&format!("{HEADER}{lines}"), &identity(200))
}

#[test]
fn the_table_gives_boxes_and_objects_that_were_not_insonified_are_left_out() {
    let truth = read(
        "0,tyre,port,40,49,3.0,5.0,1\n1,rock,,,,,,\n2,log,starboard,0,199,2,3,0\n3,tyre,port,5,5,1,2,1\n",
    );
    let truth = truth.expect("a table");
    assert_eq!(truth.classes, ["tyre", "log"]);
    assert!(!truth.was_seen);
    let [tyre, log, other] = &truth.objects[..] else {
        panic!("{truth:?}");
    };
    assert_eq!(tyre.whole, mark(40, 3.0));
    assert!(tyre.shown && !log.shown && other.shown);
    assert_eq!((log.class, log.whole.side), (1, Side::Starboard));
    assert_eq!((other.class, other.whole.pings.clone()), (0, 5..6));
}

#[test]
fn what_is_no_truth_of_this_log_is_refused_in_a_sentence() {
    for (line, part) in [
        ("0,tyre,port,40,200,3.0,5.0,1", "line 2: ping 200 is beyond the 200"),
        ("0,tyre,left,40,49,3.0,5.0,1", "`left` is no side"),
        ("0,tyre,port,40,49,nan,5.0,1", "`nan` is no range"),
        ("0,tyre,port,-1,49,3.0,5.0,1", "`-1` is no ping"),
        ("0,tyre,port,50,49,3.0,5.0,1", "inside out"),
        ("0,tyre,port,40,49,3.2,3.2,1", "inside out"),
        ("0,tyre,port,40,49,3.0,5.0,yes", "`yes` in `shown`"),
        ("0,tyre,port", "broken"),
    ] {
        let sentence = read(line).expect_err(line).to_string();
        assert!(sentence.contains(part), "{line}: {sentence}");
    }
    let other = SurveyTruth::parse("id,class\n1,rock\n", &identity(9)).expect_err("another table");
    assert!(other.to_string().contains("no column `kind`"), "{other}");
    let review = Review::new(identity(100), vec!["rock".into()]).to_json();
    let other = SurveyTruth::parse(&review, &identity(200)).expect_err("another log's review");
    assert!(other.to_string().contains("another log"), "{other}");
}

#[test]
fn a_review_is_truth_by_what_was_accepted_and_added() {
    let (survey, navigation) = survey(200, |_, _| 0);
    let raster = Raster::new(&survey, &navigation, 0.04);
    let names = ["rock".to_owned()];
    let found = [20, 60].map(|start| Detection { class: 0, score: 0.5, mark: mark(start, 3.0) });
    let review = Review::new(identity(200), names.to_vec());
    let review = review.adopt("model", &names, &found, &raster);
    let review = review.apply(&Edit::Accept(BoxId(1))).expect("accepted");
    let review = review.apply(&Edit::Reject(BoxId(2))).expect("rejected");
    let drawn = Edit::Add { mark: mark(100, 4.0), class: 0 };
    let review = review.apply(&drawn).expect("added");
    let truth = SurveyTruth::parse(&review.to_json(), &identity(200)).expect("a review");
    let marks: Vec<&Mark> = truth.objects.iter().map(|known| &known.whole).collect();
    assert_eq!(marks, [&mark(20, 3.0), &mark(100, 4.0)]);
    assert!(truth.was_seen);
}

#[test]
fn objects_that_nothing_shows_or_that_are_slivers_count_only_when_somebody_saw_them() {
    let (survey, navigation) = survey(200, |_, _| 0);
    let raster = Raster::new(&survey, &navigation, 0.04);
    let lines = "0,tyre,port,40,49,3,5,1\n0,tyre,port,100,109,3,5,0\n0,tyre,port,140,149,3,3.1,1\n";
    let mut truth = read(lines).expect("a table");
    let rasterise = |truth: &SurveyTruth| {
        let [port, starboard] = RasterTruth::new(&raster, Arc::new(truth.clone())).sides;
        assert!(starboard.is_empty());
        port.iter().map(|(truth, _)| truth.ignored).collect::<Vec<_>>()
    };
    assert_eq!(rasterise(&truth), [false, true, true]);
    truth.was_seen = true;
    assert_eq!(rasterise(&truth), [false; 3]);
}

/// Returns a comparison with boxes at pings 20 (right), 60 (wrong class), 100 (no object) and 20
/// again (looser), and no box at 140.
fn compared() -> TruthComparison {
    compared_with("tyre")
}

/// Returns the same comparison with another class name for the box at ping 60.
fn compared_with(at_60: &str) -> TruthComparison {
    let (survey, navigation) = survey(200, |_, _| 0);
    let raster = Raster::new(&survey, &navigation, 0.04);
    let truth = SurveyTruth {
        classes: vec!["log".into(), "tyre".into()],
        objects: [(1, 20), (0, 60), (1, 140)]
            .map(|(class, start)| KnownObject {
                class,
                whole: mark(start, 3.0),
                shown: true,
                slices: Vec::new(),
            })
            .to_vec(),
        was_seen: true,
    };
    // The model's class indices differ from those of the truth.
    let mut names = vec!["tyre".to_owned(), "rock".to_owned()];
    let at_60 = class_index(&mut names, at_60);
    let found = [
        (0, 0.9, mark(20, 3.0)),
        (at_60, 0.8, mark(60, 3.0)),
        (1, 0.6, mark(100, 3.0)),
        (0, 0.3, mark(20, 3.4)),
    ];
    let found = found.map(|(class, score, mark)| Detection { class, score, mark });
    let review = Review::new(identity(200), Vec::new());
    let review = review.adopt("model", &names, &found, &raster);
    let review = review.apply(&Edit::Reject(BoxId(3))).expect("rejected");
    let on_raster = RasterTruth::new(&raster, Arc::new(truth));
    TruthComparison::new(&review, on_raster, &raster)
}

#[test]
fn a_box_without_a_name_finds_an_object_of_any_class() {
    let counts = |at_60: &str| {
        let standing = compared_with(at_60).at(0.7);
        (standing.counts.found, standing.counts.false_alarms)
    };
    assert_eq!(counts("tyre"), (1, 1));
    assert_eq!(counts(NAMELESS_CLASS), (2, 0));
}

#[test]
fn the_slider_counts_what_a_full_evaluation_counts() {
    let comparison = compared();
    assert_eq!(comparison.classes(), ["tyre", "rock", "log"]);
    for (score, found, false_alarms) in
        [(0.95, 0, 0), (0.85, 1, 0), (0.7, 1, 1), (0.5, 1, 2), (0.1, 1, 3)]
    {
        let standing = comparison.at(score);
        let counts = standing.counts;
        assert_eq!((counts.found, counts.false_alarms), (found, false_alarms), "{score}");
        assert_eq!(counts.missed(), 3 - found);
        let settings = MetricSettings { score, ..MetricSettings::darknet() };
        let whole = evaluate(comparison.matched.images(), 3, &settings);
        assert_eq!(standing.counts, whole.counts);
        assert_eq!(standing.confusion, whole.confusion);
        assert_eq!(comparison.curve(), whole.curve);
    }
}

#[test]
fn mistakes_name_boxes_and_objects_with_their_cause_and_size() {
    let standing = compared().at(0.1);
    let alarm = |mistake: &Mistake| match *mistake {
        Mistake::FalseAlarm { id, cause, .. } => Some((id.0, cause)),
        Mistake::Miss { .. } => None,
    };
    let alarms: Vec<_> = standing.mistakes.iter().filter_map(alarm).collect();
    assert_eq!(alarms, [(2, Cause::OtherClass), (3, Cause::Background), (4, Cause::Duplicate)]);
    let misses: Vec<usize> = (standing.mistakes.iter())
        .filter_map(|mistake| match mistake {
            Mistake::Miss { object, .. } => Some(*object),
            Mistake::FalseAlarm { .. } => None,
        })
        .collect();
    assert_eq!(misses, [1, 2], "the log and the tyre at ping 140");
    // The boxes are ten pings of 0.2 m long, and 2 m in range.
    for mistake in &standing.mistakes {
        assert!((mistake.size_m() - 2.0).abs() < 0.03, "{mistake:?}");
    }
    assert_eq!(standing.confusion.at(2, 0), 1, "the log was taken for a tyre");
    assert_eq!(standing.confusion.at(3, 1), 1, "a rock where nothing is");
    assert_eq!(standing.confusion.at(0, 3), 1, "a tyre was missed");
}
