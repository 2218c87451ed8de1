//! Writes the evaluation as one HTML page: figures, curves, matrix and the list of mistakes.

use super::{Outcome, table};
use bathyscope_bottom::presentation::page::{Template, TemplateFault, Value, context, fill};
use bathyscope_bottom::presentation::plot::{Axis, Plot, PlotCurve};
use bathyscope_objects::Rect;
use bathyscope_objects::metrics::{CurvePoint, TrueBox};

/// Size of the plot of the curves, pixels.
const PLOT_PX: [f64; 2] = [360.0, 360.0];
/// Most rows of a list on the page; the JSON lists all.
const MOST_ROWS: usize = 2000;

const TEMPLATE: Template<'static> = ("evaluation.html", include_str!("templates/evaluation.html"));

/// Returns the page as HTML.
pub(super) fn of(outcome: &Outcome) -> Result<String, TemplateFault> {
    let plots = [precision_over_recall(outcome), shares_over_score(outcome)];
    let confusion = confusion(outcome);
    let values = context! {
        iou => outcome.iou.to_string(),
        score => outcome.boxes.score.to_string(),
        plots => plots.map(|plot| Value::from_safe_string(plot.svg(PLOT_PX))),
        columns => confusion.len(),
        confusion,
        figures => table::of(outcome).trim_end(),
        notes => &outcome.boxes.paired.notes,
        mistakes => mistakes(outcome),
    };
    fill(&[TEMPLATE], values)
}

fn precision_over_recall(outcome: &Outcome) -> Plot {
    let all = &outcome.darknet;
    let curve = |name: &str, points: &[CurvePoint]| PlotCurve {
        name: name.to_owned(),
        points: (points.iter()).map(|point| [point.recall, point.precision]).collect(),
    };
    let of_class = (outcome.boxes.paired.classes.iter().zip(&all.classes))
        .map(|(name, class)| curve(name, &class.curve));
    Plot {
        title: "Precision over recall".to_owned(),
        across: Axis::new("recall", [0.0, 1.0]),
        up: Axis::new("precision", [0.0, 1.0]),
        curves: [curve("all classes", &all.curve)].into_iter().chain(of_class).collect(),
        mark: Some(([all.shown.counts.recall(), all.shown.counts.precision()], at_score(outcome))),
        limit: None,
    }
}

fn shares_over_score(outcome: &Outcome) -> Plot {
    let curve = |name: &str, of: fn(&CurvePoint) -> f64| PlotCurve {
        name: name.to_owned(),
        points: steps(&outcome.darknet.curve, of),
    };
    Plot {
        title: "F1, precision and recall over the score".to_owned(),
        across: Axis::new("score from which boxes are shown", [0.0, 1.0]),
        up: Axis::new("share, all classes", [0.0, 1.0]),
        curves: vec![
            curve("F1", |point| point.f1),
            curve("precision", |point| point.precision),
            curve("recall", |point| point.recall),
        ],
        mark: None,
        limit: Some((outcome.boxes.score, at_score(outcome))),
    }
}

fn at_score(outcome: &Outcome) -> String {
    format!("score {}", outcome.boxes.score)
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

/// Returns the rows of the matrix, whose names are those of the columns too.
fn confusion(outcome: &Outcome) -> Vec<Value> {
    let names = outcome.boxes.paired.classes.iter().map(String::as_str).chain(["background"]);
    let rows = names.zip(outcome.darknet.shown.confusion.rows()).enumerate();
    rows.map(|(index, (name, cells))| context!(index, name, cells => cells.to_vec())).collect()
}

/// Lists false alarms by falling score, then misses by falling size.
fn mistakes(outcome: &Outcome) -> Value {
    let (paired, shown) = (&outcome.boxes.paired, &outcome.darknet.shown);
    let line = |picture: usize, class: usize, what: &str, score: Option<f32>, rect: &Rect| {
        let Rect { x0, y0, x1, y1 } = rect;
        context! {
            picture => &paired.names[picture],
            class => &paired.classes[class],
            what,
            score => score.map(|score| format!("{score:.3}")),
            edges => format!("{x0:.0}, {y0:.0}, {x1:.0}, {y1:.0}"),
        }
    };
    let alarms = shown.false_alarms.iter().map(|alarm| {
        let predicted = &paired.images[alarm.image].predicted[alarm.predicted];
        let score = Some(predicted.score);
        line(alarm.image, predicted.class, alarm.cause.name(), score, &predicted.rect)
    });
    let misses = shown.misses.iter();
    let mut misses: Vec<(usize, &TrueBox)> =
        misses.map(|miss| (miss.image, &paired.images[miss.image].truth[miss.truth])).collect();
    misses.sort_by(|(_, a), (_, b)| b.rect.area().total_cmp(&a.rect.area()));
    let misses = misses.into_iter();
    let misses =
        misses.map(|(picture, truth)| line(picture, truth.class, "missed", None, &truth.rect));
    let lines: Vec<Value> = alarms.chain(misses).take(MOST_ROWS).collect();
    let all = shown.false_alarms.len() + shown.misses.len();
    context!(all, most => MOST_ROWS, lines)
}
