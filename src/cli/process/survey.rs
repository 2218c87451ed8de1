//! The logs of one survey, one or several: opened, processed, written.

use super::{How, all_or};
use crate::app::PIXEL_M;
use crate::bathymetry::compare::Matching;
use crate::bathymetry::height_offsets::Datum;
use crate::cli::settings::Logs;
use crate::cli::status_line::StatusLine;
use crate::cli::{found, output};
use crate::detection::Raster;
use crate::detection::review::Review;
use crate::geo::LocalFrame;
use crate::outputs::{self, Order, RunFolder};
use crate::pipeline::joint::height_offsets;
use crate::pipeline::{self, Derived, ProcessedLog, Reference, Settings};
use crate::progress::Progress;
use crate::survey::{Identity, Survey};
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl How<'_> {
    /// Processes the logs in one frame and writes one set of products. Of several, a log that cannot be used does not keep the others from
    /// being processed, and the same bytes under another name are taken once.
    ///
    /// # Errors
    /// A sentence: nothing could be processed, or some of the logs could not.
    pub fn process_one_survey(
        &self,
        surveys: &[(PathBuf, &Logs)],
        adjust: bool,
        folder: &Path,
    ) -> Result<(), String> {
        if self.review.is_some() && surveys.len() > 1 {
            return Err(
                "--review belongs to one log; name one, or process --each by itself".to_owned(),
            );
        }
        if let [(path, logs)] = surveys {
            return self.process(logs, path, |_| folder.to_owned());
        }
        let mut opened: Vec<(Arc<Survey>, &Settings)> = Vec::new();
        let mut failed = 0;
        for (path, logs) in surveys {
            match logs.open(path, &Progress::new()) {
                Ok(survey) => add(&mut opened, survey, &logs.settings, path),
                Err(sentence) => {
                    failed += 1;
                    output::notify(format_args!("bathyscope: {sentence}"));
                }
            }
        }
        if !opened.is_empty() {
            self.process_into(opened, adjust, folder)?;
        }
        all_or(failed, surveys.len())
    }

    /// Runs the pipeline on the logs of a survey, which lie in one frame, searches them with the model if one is given, writes their
    /// products and reports in a few lines what came out.
    ///
    /// # Errors
    /// A sentence that says what could not be done.
    pub fn process_into(
        &self,
        surveys: Vec<(Arc<Survey>, &Settings)>,
        adjust: bool,
        folder: &Path,
    ) -> Result<(), String> {
        let Some((first, settings)) = surveys.first() else {
            return Ok(());
        };
        let progress = Progress::new();
        let status = StatusLine::new(&progress);
        let open = |argument| Reference::open(argument, first, settings, &progress);
        let reference = self.reference.map(open).transpose()?.map(Arc::new);
        let review = (self.review).map(|path| Review::open(path, &Identity::of(first)));
        let review = review.transpose().map_err(|error| error.to_string())?;
        let all = surveys.iter().map(|(survey, _)| &**survey);
        let run = outputs::begin(folder, all, reference.as_deref())?;
        let mut logs = Vec::with_capacity(surveys.len());
        for (survey, settings) in &surveys {
            logs.push(processed(survey, settings, None, &status, &progress)?);
        }
        if adjust {
            status.step("height offsets");
            logs = adjusted(&logs, &status, &progress)?;
        }
        let raster =
            (review.as_ref()).map(|_| Raster::new(first, &logs[0].products.navigation, PIXEL_M));
        let max_gap_m = settings.surface.max_gap_m;
        let order = Order {
            logs: &logs,
            derived: &Derived::default(),
            requested: self.requested,
            reference: (reference.as_ref())
                .map(|reference| (reference, Matching::Surface { max_gap_m })),
            search: self.model.filter(|_| logs.len() == 1),
            review: review.as_ref().zip(raster.as_ref()),
        };
        self.write(&order, run, folder, status, &progress)
    }

    fn write(
        &self,
        order: &Order<'_>,
        run: RunFolder,
        folder: &Path,
        status: StatusLine,
        progress: &Progress,
    ) -> Result<(), String> {
        let written = outputs::write(order, run, progress, |what| status.step(what))?;
        drop(status);
        for warning in &written.report.warnings {
            output::notify(format_args!("warning: {warning}"));
        }
        output::results(written.report.summary())?;
        if let (Some(found), Some(model)) = (&written.found, self.model) {
            let objects = found::proposed(found, model.names());
            output::results(format_args!("proposed by the detector: {objects}"))?;
        }
        output::results(written.summary(folder))
    }
}

/// Adds a log to those of a survey, in their frame: that of the first log that has a place.
fn add<'a>(
    opened: &mut Vec<(Arc<Survey>, &'a Settings)>,
    survey: Survey,
    settings: &'a Settings,
    path: &Path,
) {
    if let Some((same, _)) = opened.iter().find(|(one, _)| is_same(one, &survey)) {
        return output::notify(format_args!(
            "warning: the log holds the same bytes as {} and is taken once: {}",
            same.name(),
            path.display()
        ));
    }
    let is_placed = |(survey, _): &&(Arc<Survey>, &Settings)| !survey.track.fixes.is_empty();
    let frame: Option<LocalFrame> = opened
        .iter()
        .find(is_placed)
        .map(|(placed, _)| placed.track.frame.clone());
    let survey = match frame {
        Some(frame) => survey.in_frame(&frame),
        None => survey,
    };
    opened.push((Arc::new(survey), settings));
}

fn processed(
    survey: &Arc<Survey>,
    settings: &Settings,
    previous: Option<&ProcessedLog>,
    status: &StatusLine,
    progress: &Progress,
) -> Result<ProcessedLog, String> {
    let previous = previous.map(|log| &log.products);
    let products = pipeline::run(survey, settings, previous, progress, |stage| {
        status.step(stage.name());
    });
    Ok(ProcessedLog {
        survey: survey.clone(),
        products: products.map_err(|error| error.to_string())?,
    })
}

/// The logs with the height offsets that their meetings show.
fn adjusted(
    logs: &[ProcessedLog],
    status: &StatusLine,
    progress: &Progress,
) -> Result<Vec<ProcessedLog>, String> {
    let found = height_offsets(logs, Datum::Mean, progress).map_err(|error| error.to_string())?;
    let with = |(log, offset_m): (&ProcessedLog, f64)| {
        let mut settings = Settings::clone(&log.products.settings);
        // To the tenth of a millimetre: it stands in records, and is no better known.
        settings.height_offset_m = (offset_m * 1e4).round() / 1e4;
        processed(&log.survey, &settings, Some(log), status, progress)
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
