//! `bathyscope evaluate`: compares proposed boxes with true ones, of label files or of whole logs.
//!
//! In: arguments of the command. Out: lines of text, and files of the figures.

mod html;
mod json;
mod surveys;
mod table;

use super::output;
use crate::cli::{Failure, check_ending};
use bathyscope_objects::labels::{self, LabelError, LabelSet, Paired};
use bathyscope_objects::metrics::{ApMethod, Evaluation, Image, MetricSettings, evaluate};
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
        write_bytes(page, html::of(&outcome)?)?;
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
