//! `review`: decisions about boxes, written for maps and for training.

use super::{refusal, run};
use bathyscope_log::survey::{Identity, Side};
use bathyscope_objects::Mark;
use bathyscope_objects::review::{Edit, Review};
use std::fs;

#[test]
fn review_writes_what_the_window_writes_into_the_part_that_is_asked_for() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let log = folder.join("pond.sl2");
    fs::copy(crate::support::demo_log(), &log).expect("a log");
    let identity = Identity {
        swapped_sides: false,
        file: "pond.sl2".into(),
        byte_count: fs::metadata(&log).expect("the log").len(),
        pings: 1385,
    };
    let review = Review::new(identity.clone(), vec!["rock".into(), "sunken boat".into()]);
    let drawn = Edit::Add {
        mark: Mark { side: Side::Port, pings: 440..452, near_m: 4.0, far_m: 6.5 },
        class: 1,
    };
    let review = review.apply(&drawn).expect("a box");
    fs::write(folder.join("pond.review.json"), review.to_json()).expect("a review");
    let said = run(folder, &["review", "pond.sl2", "-o", "out", "--part", "val"]);
    assert_eq!(
        said.trim_end(),
        "Wrote 1 boxes and 1 pictures for training, 0 of them hard negatives, into out"
    );
    let text = |name: &str| fs::read_to_string(folder.join("out").join(name)).expect(name);
    assert_eq!(text("objects.csv").lines().count(), 2);
    let names = text("dataset/classes.txt");
    assert!(names.starts_with("wreck\nanchor\n"), "the usual list: {names}");
    assert!(names.ends_with("\nsunken boat\n"), "and its own: {names}");
    let args = ["review", "pond.sl2", "-o", "deeper", "--part", "val", "--set", "draft_m=0.5"];
    run(folder, &args);
    let depth_m = |name: &str| -> f64 {
        let mut table = csv::Reader::from_path(folder.join(name)).expect("a table");
        let column =
            |header: &csv::StringRecord| header.iter().position(|heading| heading == "depth_m");
        let column = column(table.headers().expect("a header")).expect("the column");
        let row = table.records().next().expect("an object").expect("a row");
        row[column].parse().expect("a depth")
    };
    let deeper_m = depth_m("deeper/objects.csv") - depth_m("out/objects.csv");
    assert!((deeper_m - 0.5).abs() < 0.011, "{deeper_m}");
    let label = text("dataset/labels/val/000000.txt");
    assert!(label.starts_with("14 ") && label.lines().count() == 1, "{label}");
    assert!(!folder.join("out/dataset/images/train/000000.png").exists());

    let other = Identity { pings: 9, ..identity };
    let other = Review::new(other, vec!["rock".into()]).to_json();
    fs::write(folder.join("other.json"), other).expect("a review");
    let args = ["review", "pond.sl2", "--review", "other.json", "-o", "out"];
    assert!(refusal(folder, &args, 1).contains("another log"));
}
