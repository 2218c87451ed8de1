//! Compares logs with a reference: one log, or those of a folder or project, processed as by
//! `bathyscope process`.

use super::{CompareArgs, table};
use crate::cli::process::all_processed;
use crate::cli::settings::SettingsArgs;
use crate::cli::status_line::StatusLine;
use crate::cli::survey_logs::{OpenedLog, all_or, inputs, open, open_reference};
use crate::cli::{Failure, output};
use bathyscope_log::formats::points::{Elevations, PointPlane};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::outputs::{ComparisonRecord, write_differences};
use bathyscope_products::pipeline::{self, Agreement};
use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::Arc;

/// Compares the points from which the depth map of some logs is made, and prints the statistics.
pub(super) fn run(args: &CompareArgs) -> Result<(), Failure> {
    let opened = opened(&args.measured, &args.settings)?;
    let Some(first) = opened.first() else {
        return Ok(());
    };
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    let measured = all_processed(&opened, &status, &progress)?;
    status.step("comparing");
    let reference = Arc::new(open_reference(&args.reference, first, &progress)?);
    let matching = args.matching();
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
    if args.json {
        output::json(&record)
    } else {
        output::results(table(&agreement.comparison, record.by()))?;
        match record.summary_of_logs() {
            Some(lines) => output::results(lines),
            None => Ok(()),
        }
    }
}

/// Returns the points from which the depth map of some logs is made, as if read from a file of
/// points.
pub(super) fn elevations(argument: &OsStr, settings: &SettingsArgs) -> Result<Elevations, Failure> {
    let opened = opened(argument, settings)?;
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    let logs = all_processed(&opened, &status, &progress)?;
    let points = logs.iter().flat_map(|log| pipeline::positions(&log.survey, &log.products));
    Ok(Elevations {
        path: argument.into(),
        points: points.collect(),
        plane: PointPlane::Degrees,
        blank: 0,
        note: None,
    })
}

/// Opens the logs that an argument names, in one local coordinate frame.
fn opened(argument: &OsStr, settings: &SettingsArgs) -> Result<Vec<OpenedLog>, Failure> {
    let inputs = inputs(&[PathBuf::from(argument)], settings, None)?;
    let (opened, failed) = open(&inputs)?;
    all_or(failed, inputs.len())?;
    Ok(opened)
}
