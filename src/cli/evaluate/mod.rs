//! `bathyscope evaluate`: compares proposed boxes with true ones, of label files or of whole logs.
//!
//! In: arguments of the command. Out: lines of text, and files of the figures.

mod json;
mod surveys;
mod table;

use super::output;
use crate::cli::{Failure, check_ending};
use bathyscope_bottom::presentation::page::{Template, TemplateFault, Value, context, fill};
use bathyscope_bottom::presentation::plot::{Axis, Plot, PlotCurve};
use bathyscope_objects::Rect;
use bathyscope_objects::labels::{self, LabelError, LabelSet, Paired};
use bathyscope_objects::metrics::{
    ApMethod, CurvePoint, Evaluation, Image, MetricSettings, TrueBox, evaluate,
};
use bathyscope_products::export::write_bytes;
use std::path::{Path, PathBuf};

/// `bathyscope evaluate SURVEY... [--truth FILE]`, `bathyscope evaluate --truth DIR --predicted DIR
/// [-o PAGE.html]`.
#[derive(Debug, clap::Args)]
pub(super) struct EvaluateArgs {
    /// Logs to search, each compared with the objects that are known to lie in it: those of
    /// LOG.objects.csv beside it
    #[arg(conflicts_with = "predicted", value_name = "SURVEY")]
    surveys: Vec<PathBuf>,
    /// True boxes: a folder of YOLO labels (class cx cy w h), or a COCO file; of one log its table
    /// of objects, or a review
    #[arg(long, value_name = "DIR|FILE", required_unless_present = "surveys")]
    truth: Option<PathBuf>,
    /// Predicted boxes: a folder of YOLO labels (class cx cy w h score), or COCO results
    #[arg(long, value_name = "DIR", required_unless_present = "surveys")]
    predicted: Option<PathBuf>,
    /// Another YOLO model to search logs with than the one that comes with the program
    #[arg(long, value_name = "MODEL.onnx", requires = "surveys")]
    model: Option<PathBuf>,
    /// Print JSON for scripts
    #[arg(long)]
    json: bool,
    /// Also draw the curves, and list every false alarm and miss, on a page for a browser
    #[arg(short, long, value_name = "PAGE.html")]
    output: Option<PathBuf>,
    /// Intersection over union that makes a match
    #[arg(long, default_value_t = 0.5, value_parser = parse_share)]
    iou: f64,
    /// Score from which boxes are counted (average precision counts all); without it the
    /// model's own, of labels 0.25
    #[arg(long, value_parser = parse_share)]
    score: Option<f64>,
}

/// Score from which boxes of label files are counted, the default of Darknet.
const LABEL_SCORE: f64 = 0.25;

fn parse_share(text: &str) -> Result<f64, &'static str> {
    let share = text.parse().ok();
    share.filter(|share| (0.0..=1.0).contains(share)).ok_or("it is a number from 0 to 1")
}

/// Source of one of the two sets of boxes.
struct BoxSource {
    /// Kind of the source in words, such as `YOLO labels`.
    format: String,
    pictures: usize,
    boxes: usize,
    path: String,
}

impl BoxSource {
    fn of_labels(set: &LabelSet) -> Self {
        Self {
            format: set.format.name().to_owned(),
            pictures: set.pictures.len(),
            boxes: set.boxes(),
            path: set.path.display().to_string(),
        }
    }
}

/// Boxes ready to be measured.
struct Boxes {
    truth: BoxSource,
    predicted: BoxSource,
    paired: Paired,
    /// Same pictures with the boxes for average precision and curves; `None` if these are the boxes
    /// of `paired`.
    ranked: Option<Vec<Image>>,
    score: f64,
}

/// Boxes, and the results of the evaluation.
struct Outcome {
    boxes: Boxes,
    iou: f64,
    /// Evaluation by Darknet's rule, with the average precision over all points.
    darknet: Evaluation,
    /// Evaluation by Darknet's rule, with the average precision over 11 points.
    eleven: Evaluation,
    /// Evaluation by COCO's rule.
    coco: Evaluation,
}

impl Outcome {
    /// Evaluates the boxes. Counts, confusion and mistakes are of the boxes that are shown; average
    /// precision and curves of the ranked ones.
    fn of(boxes: Boxes, iou: f64) -> Self {
        let classes = boxes.paired.classes.len();
        let measure = |settings: MetricSettings| {
            let settings = MetricSettings { iou, score: boxes.score as f32, ..settings };
            let shown = evaluate(&boxes.paired.images, classes, &settings);
            match &boxes.ranked {
                Some(ranked) => evaluate(ranked, classes, &settings).counted_as(shown),
                None => shown,
            }
        };
        let darknet = MetricSettings::darknet();
        Self {
            eleven: measure(MetricSettings { ap: ApMethod::Voc11, ..darknet }),
            darknet: measure(darknet),
            coco: measure(MetricSettings::coco()),
            boxes,
            iou,
        }
    }
}

/// Evaluates the boxes, prints the figures and writes the page.
pub(super) fn run(args: EvaluateArgs) -> Result<(), Failure> {
    if let Some(page) = &args.output {
        check_ending(page, &["html", "htm"], "a page's name ends in .html")?;
    }
    let boxes = match (&args.truth, &args.predicted) {
        (Some(truth), Some(predicted)) => of_labels(truth, predicted, args.score)?,
        (truth, _) => {
            surveys::search(&args.surveys, truth.as_deref(), args.model.as_deref(), args.score)?
        }
    };
    let outcome = Outcome::of(boxes, args.iou);
    if let Some(page) = &args.output {
        write_bytes(page, html_page(&outcome)?)?;
    }
    if args.json {
        return output::json(&json::of(&outcome));
    }
    for note in &outcome.boxes.paired.notes {
        output::notify(format_args!("note: {note}"));
    }
    output::results(table::of(&outcome).trim_end())
}

fn of_labels(truth: &Path, predicted: &Path, score: Option<f64>) -> Result<Boxes, LabelError> {
    let truth = labels::read_truth(truth)?;
    let predicted = labels::read_predicted(predicted, &truth)?;
    Ok(Boxes {
        paired: labels::pair(&truth, &predicted)?,
        truth: BoxSource::of_labels(&truth),
        predicted: BoxSource::of_labels(&predicted),
        ranked: None,
        score: score.unwrap_or(LABEL_SCORE),
    })
}

/// Size of the plot of the curves, pixels.
const PLOT_PX: [f64; 2] = [360.0, 360.0];
/// Most rows of a list on the page; the JSON lists all.
const MOST_ROWS: usize = 2000;

const TEMPLATE: Template<'static> = ("evaluation.html", include_str!("templates/evaluation.html"));

/// Returns the evaluation as one HTML page: figures, curves, matrix and the list of mistakes.
fn html_page(outcome: &Outcome) -> Result<String, TemplateFault> {
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
