//! `bathyscope review`: what was decided about the boxes of a log, written for maps and for training.

use super::output;
use super::settings::{Logs, SettingsArgs};
use super::status_line::StatusLine;
use crate::app::PIXEL_M;
use crate::detection::Raster;
use crate::detection::review::Review;
use crate::export::Part;
use crate::outputs;
use crate::progress::Progress;
use crate::survey::Identity;
use std::path::PathBuf;

/// `bathyscope review SURVEY -o DIR`.
#[derive(Debug, clap::Args)]
pub struct ReviewArgs {
    /// The log
    survey: PathBuf,
    /// The decisions about its boxes; without it, SURVEY.review.json next to the log
    #[arg(long, value_name = "FILE")]
    review: Option<PathBuf>,
    /// Folder for objects.csv, .geojson, .kml, .gpx and dataset; made when missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Part of a training set that this log belongs to: train, val or test
    #[arg(long, default_value = "train", value_parser = parse_part)]
    part: Part,
    #[command(flatten)]
    settings: SettingsArgs,
}

fn parse_part(text: &str) -> Result<Part, String> {
    let part = Part::ALL.into_iter().find(|part| part.name() == text);
    part.ok_or_else(|| "it is train, val or test".to_owned())
}

/// Places the boxes and writes everything.
pub fn run(args: ReviewArgs) -> Result<(), String> {
    let logs = Logs::new(args.settings.resolve()?)?;
    let progress = Progress::new();
    let survey = logs.open(&args.survey, &progress)?;
    let path = args.review.unwrap_or_else(|| {
        let log = survey.source.files.first().unwrap_or(&args.survey);
        log.with_extension("review.json")
    });
    let review = Review::open(&path, &Identity::of(&survey)).map_err(|error| error.to_string())?;
    let status = StatusLine::new(&progress);
    let products = logs.process(&survey, &status, &progress)?;
    status.step("writing");
    let raster = Raster::new(&survey, &products.navigation, PIXEL_M);
    let written = outputs::write_boxes(
        &survey,
        &products,
        &review,
        &raster,
        args.part,
        &args.output,
        &progress,
    )?;
    drop(status);
    output::results(written.summary(&args.output))
}
