//! Several logs as one survey.

use super::{How, all_or};
use crate::bathymetry::height_offsets::Datum;
use crate::cli::output;
use crate::cli::settings::Logs;
use crate::cli::status_line::StatusLine;
use crate::geo::LocalFrame;
use crate::outputs::{self, Order};
use crate::pipeline::joint::height_offsets;
use crate::pipeline::{self, Derived, ProcessedLog, Settings};
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Processes the logs in the frame of the first and writes one set of products. A log that cannot be used does not keep the others from
/// being processed, and the same bytes under another name are taken once.
///
/// # Errors
/// A sentence: nothing could be processed, or some of the logs could not.
pub fn process(
    surveys: &[(PathBuf, &Logs)],
    how: &How<'_>,
    adjust: bool,
    folder: &Path,
) -> Result<(), String> {
    if how.reference.is_some() || how.review.is_some() {
        return Err(
            "--reference and --review belong to one log; name one, or process --each by itself"
                .to_owned(),
        );
    }
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    let mut taken: Vec<ProcessedLog> = Vec::new();
    let mut frame: Option<LocalFrame> = None;
    let mut failed = 0;
    for (path, logs) in surveys {
        let opened = logs.open(path, &progress).and_then(|survey| {
            if let Some(same) = taken.iter().find(|log| is_same(&log.survey, &survey)) {
                output::notify(format_args!(
                    "warning: the log holds the same bytes as {} and is taken once: {}",
                    same.survey.name(),
                    path.display()
                ));
                return Ok(None);
            }
            let frame = frame.get_or_insert_with(|| survey.track.frame.clone());
            let survey = Arc::new(survey.in_frame(frame));
            run(survey, &logs.settings, None, &status, &progress).map(Some)
        });
        match opened {
            Ok(log) => taken.extend(log),
            Err(sentence) => {
                failed += 1;
                output::notify(format_args!("bathyscope: {sentence}"));
            }
        }
    }
    if adjust {
        status.step("height offsets");
        taken = adjusted(taken, &status, &progress)?;
    }
    if let Some(first) = taken.first() {
        let run = outputs::begin(folder, &first.survey, None)?;
        let order = Order {
            logs: &taken,
            derived: &Derived::default(),
            requested: how.requested,
            reference: None,
            search: how.model.filter(|_| taken.len() == 1),
            review: None,
        };
        let written = outputs::write(&order, run, &progress, |what| status.step(what))?;
        drop(status);
        for warning in &written.report.warnings {
            output::notify(format_args!("warning: {warning}"));
        }
        output::results(written.report.summary())?;
        output::results(written.summary(folder))?;
    }
    all_or(failed, surveys.len())
}

fn run(
    survey: Arc<Survey>,
    settings: &Settings,
    previous: Option<&ProcessedLog>,
    status: &StatusLine,
    progress: &Progress,
) -> Result<ProcessedLog, String> {
    let previous = previous.map(|log| &log.products);
    let products = pipeline::run(&survey, settings, previous, progress, |stage| {
        status.step(stage.name());
    });
    let products = products.map_err(|error| error.to_string())?;
    Ok(ProcessedLog { survey, products })
}

/// The logs with the height offsets that their meetings show.
fn adjusted(
    logs: Vec<ProcessedLog>,
    status: &StatusLine,
    progress: &Progress,
) -> Result<Vec<ProcessedLog>, String> {
    let found = height_offsets(&logs, Datum::Mean, progress).map_err(|error| error.to_string())?;
    let with = |(log, offset_m): (&ProcessedLog, f64)| {
        let mut settings = Settings::clone(&log.products.settings);
        // To the tenth of a millimetre: it stands in records, and is no better known.
        settings.height_offset_m = (offset_m * 1e4).round() / 1e4;
        run(log.survey.clone(), &settings, Some(log), status, progress)
    };
    let offsets = found.logs.iter().map(|log| log.offset_m);
    logs.iter().zip(offsets).map(with).collect()
}

/// Whether two logs are the same recording: byte for byte, whatever their names.
fn is_same(one: &Survey, other: &Survey) -> bool {
    let own = |survey: &Survey| {
        let track = usize::from(survey.track.external.is_some());
        survey.bytes.len().saturating_sub(track)
    };
    let (count, others) = (own(one), own(other));
    count == others
        && one.source.byte_count == other.source.byte_count
        && one
            .bytes
            .iter()
            .zip(&other.bytes)
            .take(count)
            .all(|(one, other)| one[..] == other[..])
}
