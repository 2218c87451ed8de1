//! Processes the logs of one survey, one or several, and writes the products.

use crate::cli::detect::proposed_in_words;
use crate::cli::status_line::StatusLine;
use crate::cli::survey_logs::{OpenedLog, open_reference, survey_review};
use crate::cli::{Failure, output};
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_bottom::bathymetry::height_offsets::Datum;
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{MountingSettings, Survey};
use bathyscope_objects::Model;
use bathyscope_products::outputs::{self, Order, Product};
use bathyscope_products::pipeline::joint::{
    LogPositions, RequestedCorrection, compare_heights, position_offsets,
};
use bathyscope_products::pipeline::{self, Derived, ProcessedLog, Settings};
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

/// Options for processing the logs of a survey.
#[derive(Clone, Copy)]
pub(crate) struct How<'a> {
    /// Detector that searches for objects; `None` for no search.
    pub model: Option<&'a Model>,
    /// Products to write.
    pub requested: &'a [Product],
    /// Points or logs with which the survey is also compared; `None` for no comparison.
    pub reference: Option<&'a OsStr>,
    /// True if the height offsets of several logs are applied.
    pub adjust: bool,
    /// Name of the log whose height stays when offsets are applied; `None` for the mean of
    /// connected logs.
    pub held: Option<&'a str>,
    /// Further corrections of positions and times.
    pub wanted: Wanted,
}

impl How<'_> {
    /// Runs the pipeline on the logs of a survey, which are in one local coordinate frame, searches
    /// them with the model if one is given, writes their products and prints a short report.
    ///
    /// # Errors
    /// When the reference cannot be used, no log is called as `held`, a file cannot be written, or
    /// the work was cancelled.
    pub(crate) fn process_into(&self, opened: &[OpenedLog], folder: &Path) -> Result<(), Failure> {
        let Some(first) = opened.first() else {
            return Ok(());
        };
        let progress = Progress::new();
        let status = StatusLine::new(&progress);
        let datum = datum(self.held, opened)?;
        let open = |argument| open_reference(argument, first, &progress);
        let reference = self.reference.map(open).transpose()?.map(Arc::new);
        let surveys = opened.iter().map(|log| &*log.survey);
        let run = outputs::begin(folder, surveys, reference.as_deref())?;
        let mut logs = all_processed(opened, &status, &progress)?;
        let mut corrections = Vec::new();
        if let ([log], true) = (logs.as_slice(), self.adjust) {
            corrections = RequestedCorrection::of_one_log(&log.survey.name(), self.wanted);
        }
        if self.wanted.latencies {
            status.step("sounding lag");
            logs = timed(opened, &logs, &mut corrections, &status, &progress)?;
        }
        // The shift of the positions of a single log cannot be found.
        let wanted = Wanted { shifts: self.wanted.shifts && logs.len() > 1, ..self.wanted };
        if wanted.is_anything() {
            status.step("positions");
            logs = placed(&logs, wanted, &mut corrections, &status, &progress)?;
        }
        if self.adjust && logs.len() > 1 {
            status.step("height offsets");
            logs = adjusted(&logs, datum, &mut corrections, &status, &progress)?;
        }
        let review = survey_review(opened);
        let max_gap_m = first.settings.surface.max_gap_m;
        let order = Order {
            logs: &logs,
            derived: &Derived::default(),
            requested: self.requested,
            reference: (reference.as_ref())
                .map(|reference| (reference, Matching::Surface { max_gap_m })),
            search: self.model,
            review: &review,
            corrections: &corrections,
        };
        let written = outputs::write(&order, run, &progress, |what| status.step(what))?;
        drop(status);
        for warning in &written.report.warnings {
            output::notify(format_args!("warning: {warning}"));
        }
        output::results(written.report.summary())?;
        if let Some(sentence) = &written.report.depths_between_lines {
            output::results(sentence)?;
        }
        if let (Some(found), Some(model)) = (&written.found, self.model) {
            let objects = proposed_in_words(found, model.names());
            output::results(format_args!("proposed by the detector: {objects}"))?;
        }
        output::results(written.summary(folder))
    }
}

/// Runs the pipeline on every log of a survey with its own settings.
///
/// # Errors
/// When a log was cut or changed after it was opened, or the work was cancelled.
pub(crate) fn all_processed(
    opened: &[OpenedLog],
    status: &StatusLine,
    progress: &Progress,
) -> Result<Vec<ProcessedLog>, Failure> {
    let process = |(number, log): (usize, &OpenedLog)| -> Result<ProcessedLog, Failure> {
        let name = match opened.len() {
            1 => String::new(),
            count => format!("log {number} of {count}"),
        };
        status.work_on(&name, log.survey.side_scan.len());
        let log = processed(&log.survey, &log.settings, None, status, progress)?;
        log.survey.check_files()?;
        Ok(log)
    };
    let logs = (1..).zip(opened).map(process).collect();
    let all = opened.iter().map(|log| log.survey.side_scan.len());
    status.work_on("", all.sum());
    logs
}

/// Runs the pipeline on a log; results that do not depend on the changed settings are taken from
/// `previous`.
///
/// # Errors
/// When the work was cancelled.
fn processed(
    survey: &Arc<Survey>,
    settings: &Settings,
    previous: Option<&ProcessedLog>,
    status: &StatusLine,
    progress: &Progress,
) -> Result<ProcessedLog, Cancelled> {
    let previous = previous.map(|log| &log.products);
    let products = pipeline::run(survey, settings, previous, progress, |stage| {
        status.step(stage.name());
    })?;
    Ok(ProcessedLog::new(survey.clone(), products))
}

/// Returns the logs with their soundings corrected for the lag that first returns show; adds the
/// corrections to `corrections`.
fn timed(
    opened: &[OpenedLog],
    logs: &[ProcessedLog],
    corrections: &mut Vec<RequestedCorrection>,
    status: &StatusLine,
    progress: &Progress,
) -> Result<Vec<ProcessedLog>, Cancelled> {
    let names = outputs::log_names(logs);
    let with = |((opened, log), name): ((&OpenedLog, &ProcessedLog), &String)| {
        let Some(lag) = log.products.calibration.sounding_lag else {
            return Ok(log.clone());
        };
        corrections.push(RequestedCorrection::of_sounding_lag(name, &lag));
        let mut settings = Settings::clone(&log.products.settings);
        let more = MountingSettings { sounding_lag_s: lag.told_s(), ..MountingSettings::default() };
        settings.mounting.sounding_lag_s += more.sounding_lag_s;
        let survey = Arc::new(Survey::clone(&opened.survey).mounted(&more));
        processed(&survey, &settings, None, status, progress)
    };
    opened.iter().zip(logs).zip(&names).map(with).collect()
}

/// Returns the logs with their positions corrected as crossings show; adds the corrections to
/// `corrections`.
fn placed(
    logs: &[ProcessedLog],
    wanted: Wanted,
    corrections: &mut Vec<RequestedCorrection>,
    status: &StatusLine,
    progress: &Progress,
) -> Result<Vec<ProcessedLog>, Cancelled> {
    let found = position_offsets(logs, wanted, progress)?;
    for (index, name) in outputs::log_names(logs).iter().enumerate() {
        let of_log = found.as_ref().and_then(|found| found.get(index));
        corrections.extend(RequestedCorrection::of_positions(name, wanted, of_log));
    }
    let Some(found) = found else {
        return Ok(logs.to_vec());
    };
    let with = |(log, found): (&ProcessedLog, &LogPositions)| {
        let mut settings = Settings::clone(&log.products.settings);
        if let Some(shift) = found.told_shift() {
            settings.position_shift = shift;
        }
        if let Some(latency_s) = found.told_latency_s() {
            settings.mounting.latency_s = latency_s;
        }
        if settings == *log.products.settings {
            Ok(log.clone())
        } else {
            processed(&log.survey, &settings, Some(log), status, progress)
        }
    };
    logs.iter().zip(&found).map(with).collect()
}

/// Returns the datum of the logs' heights: the log named `held`, by the name of its file with or
/// without its ending, or the mean of the logs.
fn datum(held: Option<&str>, opened: &[OpenedLog]) -> Result<Datum, Failure> {
    let Some(held) = held else {
        return Ok(Datum::Mean);
    };
    let names: Vec<String> = opened.iter().map(|log| log.survey.name()).collect();
    let stem = Path::new(held).file_stem().unwrap_or_default().to_string_lossy();
    let place = names.iter().position(|name| name == held || *name == stem);
    place.map(Datum::Log).ok_or_else(|| {
        format!("no log is called {held}; give --hold one of these: {}", names.join(", ")).into()
    })
}

/// Returns the logs with the height offsets that their overlaps show, and without the soundings
/// that other logs show to be false; adds both to `corrections`.
fn adjusted(
    logs: &[ProcessedLog],
    datum: Datum,
    corrections: &mut Vec<RequestedCorrection>,
    status: &StatusLine,
    progress: &Progress,
) -> Result<Vec<ProcessedLog>, Cancelled> {
    let mut found = compare_heights(logs, datum, progress)?;
    if let Datum::Log(held) = datum {
        found.offsets.raise(held, logs[held].products.correction.height_offset_m());
    }
    let names = outputs::log_names(logs);
    let mut with = |(index, log): (usize, &ProcessedLog)| {
        let mut settings = Settings::clone(&log.products.settings);
        let offset = &found.offsets.logs[index];
        if offset.log_overlaps == 0 || offset.is_determined() {
            settings.height_offset_m = offset.applied_m();
        }
        for stretch in found.contradicted.iter().filter(|stretch| stretch.log == index) {
            settings.excluded = settings.excluded.excluding(&log.survey, stretch.part());
            corrections.push(RequestedCorrection::of_false_soundings(&names[index], stretch));
        }
        processed(&log.survey, &settings, Some(log), status, progress)
    };
    logs.iter().enumerate().map(&mut with).collect()
}
