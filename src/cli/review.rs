//! `bathyscope review`: writes the decisions about the boxes of a log, or of all logs of a survey,
//! for maps and for training.

use super::process::all_processed;
use super::settings::SettingsArgs;
use super::status_line::StatusLine;
use super::survey_logs::{OpenedLog, all_or, inputs, open, survey_review, take_reviews};
use super::{Failure, output};
use bathyscope_objects::review::{Review, ReviewError};
use bathyscope_products::export::DatasetPart;
use bathyscope_products::outputs;
use std::path::PathBuf;

/// `bathyscope review SURVEY... -o DIR`.
#[derive(Debug, clap::Args)]
pub(super) struct ReviewArgs {
    /// The logs, or folders of logs; several are one survey, in which sightings of one object are
    /// one. Or a project, NAME.bathyscope, with its decisions
    #[arg(required = true)]
    surveys: Vec<PathBuf>,
    /// The decisions about the boxes of a log; without it, SURVEY.review.json next to each log. May
    /// be given again
    #[arg(long, value_name = "FILE")]
    review: Vec<PathBuf>,
    /// Folder for detections.csv, objects.csv, .geojson, .kml, .gpx, .gpkg and dataset; made when
    /// missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Part of a training set that these logs belong to: train, val or test
    #[arg(long, default_value = "train", value_parser = parse_part)]
    part: DatasetPart,
    #[command(flatten)]
    settings: SettingsArgs,
}

fn parse_part(text: &str) -> Result<DatasetPart, &'static str> {
    let part = DatasetPart::ALL.into_iter().find(|part| part.name() == text);
    part.ok_or("it is train, val or test")
}

/// Places the boxes and writes the files.
pub(super) fn run(args: ReviewArgs) -> Result<(), Failure> {
    let inputs = inputs(&args.surveys, &args.settings, None)?;
    let (mut opened, failed) = open(&inputs)?;
    match args.review.as_slice() {
        [] => take_sidecars(&mut opened)?,
        named => take_reviews(&mut opened, named)?,
    }
    let status = StatusLine::new();
    let logs = all_processed(&opened, &status)?;
    status.step("writing");
    let review = survey_review(&opened);
    let written = outputs::write_boxes(&logs, &review, args.part, &args.output, &status.progress)?;
    drop(status);
    output::results(written.summary(&args.output))?;
    all_or(failed, inputs.len())
}

/// Reads the review files next to the logs whose boxes have no review in a project. With several
/// logs, some may lack the file; a single log must have it.
fn take_sidecars(logs: &mut [OpenedLog]) -> Result<(), ReviewError> {
    let is_single = logs.len() == 1;
    for log in logs.iter_mut().filter(|log| log.review.is_none()) {
        let file = log.survey.source.files.first();
        let path = file.map(|file| file.with_extension("review.json"));
        let Some(path) = path.filter(|path| is_single || path.is_file()) else {
            continue;
        };
        log.review = Some(Review::open_for(&path, &log.survey)?.into());
    }
    Ok(())
}
