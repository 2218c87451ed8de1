//! Writes the evaluation as one HTML page: figures, curves, matrix and the list of mistakes.

use super::{Outcome, table};
use bathyscope_bottom::presentation::plot::{Axis, Plot, PlotCurve};
use bathyscope_log::support::printable::xml;
use bathyscope_objects::Rect;
use bathyscope_objects::metrics::CurvePoint;

/// Size of the plot of the curves, pixels.
const PLOT_PX: [f64; 2] = [360.0, 360.0];
/// Most rows of a list on the page; the JSON lists all.
const MOST_ROWS: usize = 2000;

const STYLE: &str = "body{font:14px sans-serif;color:#1a1a1a;margin:24px;max-width:1200px}h2{font-size:16px;margin-top:28px}\
pre{font-size:12px;background:#f4f4f4;padding:12px;overflow-x:auto}table{border-collapse:collapse}\
td,th{border:1px solid #cccccc;padding:3px 8px;text-align:right;font-weight:normal}th{background:#f4f4f4}\
td.text,th.text{text-align:left}td.found{background:#cfe8df}td.mistaken{background:#f6d5cf}figure{display:inline-block;margin:0 24px 0 0}";

/// Returns the page as HTML.
pub(super) fn of(outcome: &Outcome) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Boxes against the truth</title><style>{STYLE}</style></head><body>\n<h1>Boxes against the truth</h1>\n"
    );
    for part in [curves, confusion, figures, mistakes] {
        page += &part(outcome);
    }
    page + "</body></html>\n"
}

fn curves(outcome: &Outcome) -> String {
    let all = &outcome.darknet;
    let at_score = format!("score {}", outcome.score);
    let precision_recall = |name: String, points: &[CurvePoint]| PlotCurve {
        name,
        points: (points.iter()).map(|point| [point.recall, point.precision]).collect(),
    };
    let of_class = (outcome.paired.classes.iter().zip(&all.classes))
        .map(|(name, class)| precision_recall(name.clone(), &class.curve));
    let first = precision_recall("all classes".to_owned(), &all.curve);
    let plot = Plot {
        title: "Precision over recall".to_owned(),
        across: Axis::new("recall", [0.0, 1.0]),
        up: Axis::new("precision", [0.0, 1.0]),
        curves: [first].into_iter().chain(of_class).collect(),
        mark: Some(([all.counts.recall(), all.counts.precision()], at_score.clone())),
        limit: None,
    };
    let page = format!(
        "<h2>Curves (Darknet's rule, IoU {})</h2>\n<figure>{}</figure>\n",
        outcome.iou,
        plot.svg(PLOT_PX)
    );
    let over_score = |name: &str, of: fn(&CurvePoint) -> f64| PlotCurve {
        name: name.to_owned(),
        points: steps(&all.curve, of),
    };
    let plot = Plot {
        title: "F1, precision and recall over the score".to_owned(),
        across: Axis::new("score from which boxes are shown", [0.0, 1.0]),
        up: Axis::new("share, all classes", [0.0, 1.0]),
        curves: vec![
            over_score("F1", |point| point.f1),
            over_score("precision", |point| point.precision),
            over_score("recall", |point| point.recall),
        ],
        mark: None,
        limit: Some((outcome.score, at_score)),
    };
    page + &format!("<figure>{}</figure>\n", plot.svg(PLOT_PX))
}

/// Returns a share as a step function of the score: between two scores that occur, the boxes shown
/// stay the same.
fn steps(curve: &[CurvePoint], of: fn(&CurvePoint) -> f64) -> Vec<[f64; 2]> {
    let mut points = Vec::with_capacity(2 * curve.len());
    for (index, point) in curve.iter().enumerate() {
        points.push([f64::from(point.score), of(point)]);
        let below = curve.get(index + 1).map_or(0.0, |next| next.score);
        points.push([f64::from(below), of(point)]);
    }
    points
}

fn confusion(outcome: &Outcome) -> String {
    let names = || {
        let classes = outcome.paired.classes.iter().map(String::as_str);
        classes.chain(["background"])
    };
    let mut page = format!(
        "<h2>What was taken for what</h2>\n<p>Row background: false alarms; column background: missed.</p>\n<table><tr><th class=\"text\" rowspan=\"2\">truth</th><th colspan=\"{}\">proposed from score {} on</th></tr><tr>\n",
        names().count(),
        outcome.score
    );
    for name in names() {
        page += &format!("<th>{}</th>", xml(name));
    }
    page += "</tr>\n";
    for (row, (name, cells)) in names().zip(outcome.darknet.confusion.rows()).enumerate() {
        page += &format!("<tr><th class=\"text\">{}</th>", xml(name));
        for (column, count) in cells.iter().enumerate() {
            let class = match (count, row == column) {
                (0, _) => "",
                (_, true) => " class=\"found\"",
                (_, false) => " class=\"mistaken\"",
            };
            page += &format!("<td{class}>{count}</td>");
        }
        page += "</tr>\n";
    }
    page + "</table>\n"
}

fn figures(outcome: &Outcome) -> String {
    let text = table::of(outcome);
    let mut page = format!("<h2>Figures</h2>\n<pre>{}</pre>\n", xml(text.trim_end()));
    for note in &outcome.paired.notes {
        page += &format!("<p>Note: {}</p>\n", xml(note));
    }
    page
}

/// Line of the list of mistakes.
struct MistakeLine<'a> {
    what: &'static str,
    picture: usize,
    class: usize,
    score: Option<f32>,
    rect: &'a Rect,
}

/// Lists false alarms by falling score, then misses by falling size.
fn list<'a>(outcome: &'a Outcome) -> Vec<MistakeLine<'a>> {
    let (paired, evaluation) = (&outcome.paired, &outcome.darknet);
    let alarms = evaluation.false_alarms.iter().map(|one| {
        let predicted = &paired.images[one.image].predicted[one.predicted];
        MistakeLine {
            what: one.cause.name(),
            picture: one.image,
            class: predicted.class,
            score: Some(predicted.score),
            rect: &predicted.rect,
        }
    });
    let misses = evaluation.misses.iter().map(|one| {
        let truth = &paired.images[one.image].truth[one.truth];
        MistakeLine {
            what: "missed",
            picture: one.image,
            class: truth.class,
            score: None,
            rect: &truth.rect,
        }
    });
    let mut misses: Vec<MistakeLine<'a>> = misses.collect();
    misses.sort_by(|a, b| b.rect.area().total_cmp(&a.rect.area()));
    alarms.chain(misses).collect()
}

fn mistakes(outcome: &Outcome) -> String {
    let all = list(outcome);
    let mut page = format!(
        "<h2>False alarms, the surest first, then misses, the largest first: {}</h2>\n",
        all.len()
    );
    if all.len() > MOST_ROWS {
        page += &format!("<p>The first {MOST_ROWS} are listed; --json lists all.</p>\n");
    }
    page += "<table><tr><th class=\"text\">picture</th><th class=\"text\">class</th><th class=\"text\">what</th><th>score</th><th>left, top, right, bottom, pixels</th></tr>\n";
    let paired = &outcome.paired;
    for one in all.iter().take(MOST_ROWS) {
        let score = one.score.map_or(String::new(), |score| format!("{score:.3}"));
        let Rect { x0, y0, x1, y1 } = one.rect;
        page += &format!(
            "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{score}</td><td>{x0:.0}, {y0:.0}, {x1:.0}, {y1:.0}</td></tr>\n",
            xml(&paired.names[one.picture]),
            xml(&paired.classes[one.class]),
            one.what,
        );
    }
    page + "</table>\n"
}
