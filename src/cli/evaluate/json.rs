//! Writes the figures as JSON. A ratio whose denominator is 0 is null.

use super::{BoxSource, Outcome};
use bathyscope_objects::Rect;
use bathyscope_objects::metrics::{CurvePoint, MatchCounts};
use serde_json::{Value, json};

/// Returns all figures, with the lists of mistakes and the curve.
pub(super) fn of(outcome: &Outcome) -> Value {
    let (darknet, coco) = (&outcome.darknet, &outcome.coco);
    let classes: Vec<Value> = (0..outcome.boxes.paired.classes.len())
        .map(|class| {
            let mut report = counts(&darknet.shown.classes[class]);
            report["name"] = json!(outcome.boxes.paired.classes[class]);
            report["ap_all_points"] = json!(darknet.classes[class].ap);
            report["ap_11_points"] = json!(outcome.eleven.classes[class].ap);
            report["ap_coco"] = json!(coco.classes[class].ap);
            report["ap_coco_50_95"] = json!(coco.classes[class].ap_50_95);
            report["curve"] = curve(&darknet.classes[class].curve);
            report
        })
        .collect();
    let mut all = counts(&darknet.shown.counts);
    all["map_all_points"] = json!(darknet.map);
    all["map_11_points"] = json!(outcome.eleven.map);
    all["map_coco"] = json!(coco.map);
    all["map_coco_50_95"] = json!(coco.map_50_95);
    all["curve"] = curve(&darknet.curve);
    json!({
        "truth": source(&outcome.boxes.truth),
        "predicted": source(&outcome.boxes.predicted),
        "iou": outcome.iou,
        "score": outcome.boxes.score,
        "all": all,
        "classes": classes,
        "sizes": sizes(outcome),
        "confusion": confusion(outcome),
        "false_alarms": false_alarms(outcome),
        "misses": misses(outcome),
        "notes": outcome.boxes.paired.notes,
    })
}

fn source(source: &BoxSource) -> Value {
    json!({
        "path": source.path,
        "format": source.format,
        "pictures": source.pictures,
        "boxes": source.boxes,
    })
}

fn counts(counts: &MatchCounts) -> Value {
    json!({
        "truths": counts.truths,
        "found": counts.found,
        "false_alarms": counts.false_alarms,
        "missed": counts.missed(),
        "precision": counts.precision(),
        "recall": counts.recall(),
        "f1": counts.f1(),
        "iou_of_matches": counts.iou_of_matches(),
        "darknet_iou": counts.darknet_iou(),
    })
}

/// Returns the columns of a curve, one list for each, by falling score.
fn curve(points: &[CurvePoint]) -> Value {
    let column = |of: fn(&CurvePoint) -> f64| -> Vec<f64> { points.iter().map(of).collect() };
    json!({
        "score": column(|point| f64::from(point.score)),
        "precision": column(|point| point.precision),
        "recall": column(|point| point.recall),
        "f1": column(|point| point.f1),
    })
}

fn sizes(outcome: &Outcome) -> Vec<Value> {
    let size = |size: &bathyscope_objects::metrics::SizeReport| {
        let mut report = counts(&size.counts);
        report["side_px"] = json!(size.side_px);
        report["map_coco"] = json!(size.map);
        report["map_coco_50_95"] = json!(size.map_50_95);
        report
    };
    outcome.coco.sizes.iter().map(size).collect()
}

fn confusion(outcome: &Outcome) -> Value {
    let mut labels = outcome.boxes.paired.classes.clone();
    labels.push("background".into());
    let cells: Vec<&[usize]> = outcome.darknet.shown.confusion.rows().collect();
    json!({ "rows": "truth", "columns": "predicted", "labels": labels, "cells": cells })
}

fn edges(rect: &Rect) -> [f32; 4] {
    [rect.x0, rect.y0, rect.x1, rect.y1]
}

fn false_alarms(outcome: &Outcome) -> Vec<Value> {
    let paired = &outcome.boxes.paired;
    let list = outcome.darknet.shown.false_alarms.iter().map(|alarm| {
        let predicted = &paired.images[alarm.image].predicted[alarm.predicted];
        json!({
            "picture": paired.names[alarm.image],
            "class": paired.classes[predicted.class],
            "score": predicted.score,
            "cause": alarm.cause.name(),
            "box_px": edges(&predicted.rect),
        })
    });
    list.collect()
}

fn misses(outcome: &Outcome) -> Vec<Value> {
    let paired = &outcome.boxes.paired;
    let list = outcome.darknet.shown.misses.iter().map(|miss| {
        let truth = &paired.images[miss.image].truth[miss.truth];
        json!({
            "picture": paired.names[miss.image],
            "class": paired.classes[truth.class],
            "box_px": edges(&truth.rect),
        })
    });
    list.collect()
}
