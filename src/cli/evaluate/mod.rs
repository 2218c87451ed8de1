//! `bathyscope evaluate`: predicted boxes against true ones.

mod html;
mod json;
mod svg;
mod table;

use super::output;
use crate::detection::labels::{self, LabelSet, Paired};
use crate::detection::metrics::{ApMethod, Evaluation, MetricSettings, evaluate};
use crate::export::write_aside;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// `bathyscope evaluate --truth DIR --predicted DIR [-o PAGE.html]`.
#[derive(Debug, clap::Args)]
pub struct EvaluateArgs {
    /// True boxes: a folder of YOLO labels (class cx cy w h), or a COCO file
    #[arg(long, value_name = "DIR")]
    truth: PathBuf,
    /// Predicted boxes: a folder of YOLO labels (class cx cy w h score), or COCO results
    #[arg(long, value_name = "DIR")]
    predicted: PathBuf,
    /// Print JSON for scripts
    #[arg(long)]
    json: bool,
    /// Also draw the curves, and list every false alarm and miss, on a page for a browser
    #[arg(short, long, value_name = "PAGE.html")]
    output: Option<PathBuf>,
    /// Intersection over union that makes a match
    #[arg(long, default_value_t = 0.5, value_parser = parse_share)]
    iou: f64,
    /// Confidence from which boxes are counted; average precision counts all
    #[arg(long, default_value_t = 0.25, value_parser = parse_share)]
    score: f64,
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok();
    share
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| "it is a number from 0 to 1".to_owned())
}

/// What was read and what came of it.
struct Outcome<'a> {
    truth: &'a LabelSet,
    predicted: &'a LabelSet,
    paired: Paired,
    iou: f64,
    score: f64,
    /// Darknet's rule, all points.
    darknet: Evaluation,
    /// Darknet's rule, 11 points.
    eleven: Evaluation,
    /// COCO's rule.
    coco: Evaluation,
}

/// Measures, prints and draws.
pub fn run(args: EvaluateArgs) -> Result<(), String> {
    if let Some(page) = &args.output {
        check_page(page)?;
    }
    let truth = labels::read_truth(&args.truth).map_err(|error| error.to_string())?;
    let predicted =
        labels::read_predicted(&args.predicted, &truth).map_err(|error| error.to_string())?;
    let paired = labels::pair(&truth, &predicted).map_err(|error| error.to_string())?;
    let measure = |settings: MetricSettings| {
        let settings = MetricSettings {
            iou: args.iou,
            score: args.score as f32,
            ..settings
        };
        evaluate(&paired.images, paired.classes.len(), &settings)
    };
    let darknet = MetricSettings::darknet();
    let outcome = Outcome {
        eleven: measure(MetricSettings {
            ap: ApMethod::Voc11,
            ..darknet.clone()
        }),
        darknet: measure(darknet),
        coco: measure(MetricSettings::coco()),
        truth: &truth,
        predicted: &predicted,
        paired,
        iou: args.iou,
        score: args.score,
    };
    if let Some(page) = &args.output {
        write_page(page, &html::of(&outcome))?;
    }
    if args.json {
        return output::results(format_args!("{:#}", json::of(&outcome)));
    }
    for note in &outcome.paired.notes {
        output::tell(format_args!("note: {note}"));
    }
    output::results(table::of(&outcome).trim_end())
}

/// Refuses a name that is no page's before any work: labels of that name would be replaced.
fn check_page(path: &Path) -> Result<(), String> {
    let suffix = path.extension().unwrap_or_default();
    if ["html", "htm"]
        .iter()
        .any(|known| suffix.eq_ignore_ascii_case(known))
    {
        return Ok(());
    }
    Err(format!("a page's name ends in .html: {}", path.display()))
}

fn write_page(path: &Path, text: &str) -> Result<(), String> {
    write_aside(path, |mut file| file.write_all(text.as_bytes())).map_err(|error| error.to_string())
}
