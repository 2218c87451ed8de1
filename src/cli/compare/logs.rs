//! Logs on either side of a comparison: processed as `bathyscope process` would, all with the same settings.

use super::{CompareArgs, table};
use crate::cli::output;
use crate::cli::settings::{Logs, SettingsArgs};
use crate::cli::status_line::StatusLine;
use crate::formats::points::{Elevations, Plane};
use crate::outputs::{ComparisonRecord, write_differences};
use crate::pipeline::{self, Agreement, ProcessedLog, Reference};
use crate::progress::Progress;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

/// Compares the points that a log's depth map is made of, and prints the statistics.
pub fn run(args: &CompareArgs) -> Result<(), String> {
    let logs = Logs::new(args.settings.resolve()?)?;
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    let measured = [processed(&args.measured, &logs, &status, &progress)?];
    status.step("comparing");
    let survey = &measured[0].survey;
    let reference = Reference::open(&args.reference, survey, &logs.settings, &progress)?;
    let (reference, matching) = (Arc::new(reference), args.matching());
    let agreement = Agreement::with_reference(&measured, &reference, matching, &progress)?;
    if let Some(path) = &args.output {
        write_differences(path, &measured, &agreement)?;
    }
    let inputs = reference.inputs(&progress)?;
    let record = ComparisonRecord::new(&measured, &agreement, &inputs)?;
    drop(status);
    for note in &reference.notes {
        let path = reference.path().display();
        output::notify(format_args!("warning: {note}: {path}"));
    }
    match args.json {
        true => output::json(&record),
        false => output::results(table(&agreement.comparison, record.by())),
    }
}

/// The same points of a log as a file of points would hold them.
pub fn elevations(argument: &OsStr, settings: &SettingsArgs) -> Result<Elevations, String> {
    let logs = Logs::new(settings.resolve()?)?;
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    let ProcessedLog { survey, products } = processed(argument, &logs, &status, &progress)?;
    Ok(Elevations {
        path: argument.into(),
        points: pipeline::positions(&survey, &products),
        plane: Plane::Degrees,
        blank: 0,
        note: None,
    })
}

fn processed(
    argument: &OsStr,
    logs: &Logs,
    status: &StatusLine,
    progress: &Progress,
) -> Result<ProcessedLog, String> {
    let survey = Arc::new(logs.open(Path::new(argument), progress)?);
    let products = logs.process(&survey, status, progress)?;
    Ok(ProcessedLog { survey, products })
}
