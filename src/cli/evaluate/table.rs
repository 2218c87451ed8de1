//! Writes the figures as text.

use super::{BoxSource, Outcome};
use bathyscope_objects::metrics::{Cause, MatchCounts};

/// Returns all figures, table by table.
pub(super) fn of(outcome: &Outcome) -> String {
    let mut text = String::new();
    for part in [read, counts, precisions, sizes, confusion, mistakes] {
        text += &part(outcome);
        text.push('\n');
    }
    text
}

/// Returns a share as text such as `0.812`, or a dash if it is NaN.
fn share(value: f64) -> String {
    if value.is_nan() { "-".into() } else { format!("{value:.3}") }
}

/// Returns the number of characters of the widest class name.
fn width(outcome: &Outcome) -> usize {
    let names = outcome.boxes.paired.classes.iter();
    names.map(|name| name.chars().count()).max().unwrap_or(0).max("background".len())
}

fn read(outcome: &Outcome) -> String {
    let mut text = String::new();
    for (what, source) in [("truth", &outcome.boxes.truth), ("predicted", &outcome.boxes.predicted)]
    {
        let BoxSource { format, pictures, boxes, path } = source;
        text += &format!("{what:<10} {format}, {pictures} pictures, {boxes} boxes: {path}\n");
    }
    text
}

fn counts(outcome: &Outcome) -> String {
    let (width, shown) = (width(outcome), &outcome.darknet.shown);
    let mut text = format!(
        "Boxes of score {} and more, found above IoU {} (Darknet's rule)\n",
        outcome.boxes.score, outcome.iou
    );
    text += &format!(
        "{:<width$}  truths   found   false  missed  precision  recall     F1  IoU of found  Darknet's IoU\n",
        "class"
    );
    let mut line = |name: &str, counts: &MatchCounts| {
        text += &format!(
            "{name:<width$}  {:>6}  {:>6}  {:>6}  {:>6}  {:>9}  {:>6}  {:>5}  {:>12}  {:>13}\n",
            counts.truths,
            counts.found,
            counts.false_alarms,
            counts.missed(),
            share(counts.precision()),
            share(counts.recall()),
            share(counts.f1()),
            share(counts.iou_of_matches()),
            share(counts.darknet_iou()),
        );
    };
    for (name, counts) in outcome.boxes.paired.classes.iter().zip(&shown.classes) {
        line(name, counts);
    }
    line("all", &shown.counts);
    text + "Darknet's IoU counts a false alarm as 0.\n"
}

fn precisions(outcome: &Outcome) -> String {
    let width = width(outcome);
    let evaluations = [&outcome.darknet, &outcome.eleven, &outcome.coco];
    let mut text = format!("Average precision at IoU {}\n", outcome.iou);
    text +=
        &format!("{:<width$}  all points  11 points  COCO, 101  COCO, IoU 0.50 to 0.95\n", "class");
    let mut line = |name: &str, at: [f64; 3], range: f64| {
        let [all, eleven, coco] = at.map(share);
        let range = share(range);
        text += &format!("{name:<width$}  {all:>10}  {eleven:>9}  {coco:>9}  {range:>22}\n");
    };
    for (class, name) in outcome.boxes.paired.classes.iter().enumerate() {
        let at = evaluations.map(|evaluation| evaluation.classes[class].ap);
        line(name, at, outcome.coco.classes[class].ap_50_95);
    }
    let means = evaluations.map(|evaluation| evaluation.map);
    line("mean", means, outcome.coco.map_50_95);
    text
}

fn sizes(outcome: &Outcome) -> String {
    let mut text = String::from("By size (side of a square of the same area; COCO's rule)\n");
    text += "pixels        truths   found   false  missed    mAP  mAP 0.50 to 0.95\n";
    for size in &outcome.coco.sizes {
        let [from, to] = size.side_px;
        let name =
            if to.is_finite() { format!("{from} to {to}") } else { format!("{from} and more") };
        let counts = &size.counts;
        text += &format!(
            "{name:<12}  {:>6}  {:>6}  {:>6}  {:>6}  {:>5}  {:>16}\n",
            counts.truths,
            counts.found,
            counts.false_alarms,
            counts.missed(),
            share(size.map),
            share(size.map_50_95),
        );
    }
    text
}

fn confusion(outcome: &Outcome) -> String {
    let width = width(outcome);
    let names = || {
        let classes = outcome.boxes.paired.classes.iter().map(String::as_str);
        classes.chain(["background"])
    };
    let mut text = String::from("What was taken for what (rows: truth; columns: prediction)\n");
    text += &format!("{:<width$}", "truth");
    for name in names() {
        text += &format!("  {name:>6}");
    }
    text += "\n";
    for (name, row) in names().zip(outcome.darknet.shown.confusion.rows()) {
        text += &format!("{name:<width$}");
        for (column, count) in names().zip(row) {
            let wide = column.chars().count().max(6);
            text += &format!("  {count:>wide$}");
        }
        text += "\n";
    }
    text + "Row background: false alarms; column background: missed.\n"
}

fn mistakes(outcome: &Outcome) -> String {
    let false_alarms = &outcome.darknet.shown.false_alarms;
    let mut text = format!("False alarms: {}", false_alarms.len());
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        let count = false_alarms.iter().filter(|alarm| alarm.cause == cause).count();
        let separator = if index == 0 { " (" } else { ", " };
        text += &format!("{separator}{} {count}", cause.name());
    }
    text + "). --json lists them and the misses.\n"
}
