//! `evaluate`: predicted boxes against true ones.

use super::{bathyscope, refusal, run};
use std::fs;
use std::path::Path;

/// Two pictures: a rock found, a tyre taken for a rock, a ghost; and a rock below the score.
fn labels(folder: &Path) {
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a label file");
    };
    write("truth/classes.txt", "rock\ntyre\n");
    write("truth/a.txt", "0 0.5 0.5 0.1 0.1\n1 0.2 0.2 0.1 0.1\n");
    write("truth/b.txt", "0 0.5 0.5 0.2 0.2\n");
    write("found/a.txt", "0 0.5 0.5 0.1 0.08 0.9\n0 0.2 0.2 0.1 0.1 0.8\n");
    write("found/b.txt", "0 0.9 0.9 0.1 0.1 0.7\n0 0.5 0.5 0.2 0.2 0.1\n");
}

const ARGS: [&str; 5] = ["evaluate", "--truth", "truth", "--predicted", "found"];

#[test]
fn evaluate_tells_figures_matrix_and_mistakes() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    labels(folder);
    let text = run(folder, &ARGS);
    for line in [
        "truth      YOLO labels, 2 pictures, 3 boxes: truth",
        "predicted  YOLO labels, 2 pictures, 4 boxes: found",
        "rock             2       1       2       1      0.333   0.500  0.400         0.800          0.267",
        "all              3       1       2       2      0.333   0.333  0.333         0.800          0.267",
        "rock             1       0           1",
        "tyre             1       0           0",
        "background       1       0           0",
        "False alarms: 2 (background 1, duplicate 0, other class 1, loose box 0). --json lists them and the misses.",
    ] {
        assert!(text.lines().any(|found| found == line), "{line}\n{text}");
    }

    let mut args = ARGS.to_vec();
    args.extend(["--json", "--score", "0.05"]);
    let json: serde_json::Value = serde_json::from_str(&run(folder, &args)).expect("JSON");
    assert_eq!(json["all"]["found"], 2);
    assert_eq!(json["confusion"]["rows"], "truth");
    assert_eq!(json["confusion"]["labels"][2], "background");
    assert_eq!(json["false_alarms"][0]["cause"], "other class");
    assert_eq!(json["misses"][0]["class"], "tyre");
    // Rock: recall 1/2 at precision 1, then 1 at 2/4; tyre: 0.
    assert_eq!(json["classes"][0]["ap_all_points"], 0.75);
    assert_eq!(json["all"]["map_all_points"], 0.375);
    assert_eq!(json["classes"][1]["precision"], serde_json::Value::Null);
}

#[test]
fn evaluate_draws_curves_and_lists_mistakes_on_a_page() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    labels(folder);
    fs::write(folder.join("truth/classes.txt"), "rock & roll\ntyre\n").expect("names");
    let mut args = ARGS.to_vec();
    args.extend(["-o", "page.html"]);
    run(folder, &args);
    let page = fs::read_to_string(folder.join("page.html")).expect("the page");
    assert_eq!(page.matches("<svg ").count(), 2);
    assert!(page.contains(">rock &amp; roll</") && !page.contains("rock & roll"));
    // Of all classes: 0.9 finds a rock, 0.8 and 0.7 find nothing, 0.1 finds a rock: recall 1/3,
    // 1/3, 1/3, 2/3 at precision 1, 1/2, 1/3, 1/2.
    assert!(page.contains("M168.00 10.00L168.00 190.00L168.00 250.00L288.00 190.00"), "{page}");
    let rows: Vec<&str> =
        page.lines().filter(|line| line.contains("<tr><td class=\"text\">")).collect();
    let cells =
        |row: &str, words: &[&str]| words.iter().all(|word| row.contains(&format!(">{word}<")));
    assert_eq!(rows.len(), 4);
    assert!(cells(rows[0], &["a", "other class", "0.800"]));
    assert!(cells(rows[1], &["b", "background", "0.700"]));
    assert!(cells(rows[2], &["b", "rock &amp; roll", "missed"]), "the largest miss: {}", rows[2]);
    assert!(cells(rows[3], &["a", "tyre", "missed"]));
    args.pop();
    args.push("truth/a.txt");
    assert!(refusal(folder, &args, 1).contains("ends in .html"));
    assert!(fs::read_to_string(folder.join("truth/a.txt")).expect("labels").starts_with("0 0.5"));
}

#[test]
fn evaluate_refuses_what_it_cannot_use() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    labels(folder);
    fs::write(folder.join("found/b.txt"), "0 0.5 0.5 0.2\n").expect("a label file");
    let sentence = refusal(folder, &ARGS, 1);
    assert_eq!(
        sentence.trim_end(),
        "bathyscope: cannot use line 1: 4 numbers where a box is written class cx cy w h score: found/b.txt"
    );
    let mut args = ARGS.to_vec();
    args.extend(["--iou", "50"]);
    assert_eq!(bathyscope(folder, &args).status.code(), Some(2));
}

#[test]
fn evaluate_searches_logs_whose_objects_are_known() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let make = [
        "simulate",
        "--dataset",
        "set",
        "--split",
        "0/0/4",
        "--per-scene",
        "2",
        "--seed",
        "41",
        "--surveys",
    ];
    run(folder, &make);
    let logs = ["set/surveys/test/0000.sl2", "set/surveys/test/0001.sl2"];
    let json = |arguments: &[&str]| -> serde_json::Value {
        let text = run(folder, &[&["evaluate", "--json"], arguments].concat());
        serde_json::from_str(&text).expect("JSON")
    };
    let both = json(&logs);
    assert_eq!(both["truth"]["pictures"], 4);
    assert_eq!(both["all"]["truths"], both["truth"]["boxes"]);
    let each = logs.map(|log| json(&[log]));
    for what in ["truths", "found", "false_alarms"] {
        let of = |record: &serde_json::Value| record["all"][what].as_u64().expect("a count");
        assert_eq!(of(&both), each.iter().map(of).sum::<u64>(), "{what}");
    }
    let found = both["all"]["found"].as_u64().expect("a count");
    assert!(found > 0, "{both:#}");
    // A lower score finds no less; what average precision is made of does not hang on it.
    let low = json(&[&logs[..], &["--score", "0.05"]].concat());
    assert!(low["all"]["found"].as_u64() >= Some(found));
    assert_eq!(low["all"]["map_coco"], both["all"]["map_coco"]);

    fs::rename(folder.join("set/surveys/test/0001.objects.csv"), folder.join("known.csv"))
        .expect("renamed");
    let named = json(&[logs[1], "--truth", "known.csv"]);
    assert_eq!(named["all"], each[1]["all"]);
    let refused = |arguments: &[&str]| refusal(folder, &[&["evaluate"], arguments].concat(), 1);
    assert!(refused(&[logs[1]]).contains("with --truth"));
    let of_another = refused(&[logs[0], "--truth", "known.csv", logs[1]]);
    assert!(of_another.contains("about one log"));
}
