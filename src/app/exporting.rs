//! Writes products and reviewed boxes into a folder in a background thread.

use super::jobs::JobKey;
use super::{Action, App, LogId, OpenLogs};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::export::{LogPartChoice, copy_log};
use bathyscope_products::outputs::{self, Amounts, EarlierRun, Order, OutputFile, Product};
use bathyscope_products::pipeline::map_plane;
use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The files of a run that this window has written.
pub(super) struct Exported {
    log: LogId,
    folder: PathBuf,
    run: EarlierRun,
}

impl OpenLogs {
    /// Returns sentences for the readers of the products: the level that depths count from, missing
    /// corrections, and the coordinate system.
    pub(crate) fn export_statement(&self) -> Vec<String> {
        let logs = self.processed();
        let Some(first) = logs.first() else {
            return Vec::new();
        };
        let of_first = first.products.correction.sentences();
        let of_logs: Vec<_> = logs.iter().map(|log| log.products.correction.sentences()).collect();
        let mut sentences = Vec::new();
        for (index, sentence) in of_first.into_iter().enumerate() {
            sentences.push(match of_logs.iter().all(|of_log| of_log[index] == sentence) {
                true => sentence,
                false if index == 0 => {
                    "What was applied to depths differs between the logs; report.html lists it."
                        .to_owned()
                }
                false => "What is not corrected differs between the logs.".to_owned(),
            });
        }
        let plane = map_plane(&first.survey, &first.products.settings);
        sentences.extend(plane.ok().map(|plane| format!("Coordinates are of {}.", plane.crs)));
        sentences
    }
}

impl App {
    /// Writes something in a background thread; the analyst is notified of the outcome.
    pub fn write<E: Error + Send + Sync + 'static>(
        &mut self,
        write: impl FnOnce(&Progress) -> Result<String, E> + Send + 'static,
    ) {
        self.start_writing(write, |_| (), None);
    }

    /// Writes something in a background thread, `into` a folder if it is one; `written` is called
    /// before the analyst is notified of what was written.
    fn start_writing<E: Error + Send + Sync + 'static>(
        &mut self,
        write: impl FnOnce(&Progress) -> Result<String, E> + Send + 'static,
        written: impl FnOnce(&mut Self) + Send + 'static,
        into: Option<PathBuf>,
    ) {
        self.jobs.run(JobKey::Export, write, |app, text| {
            app.notices.withdraw(Action::OpenExported);
            match text {
                Ok(text) => {
                    written(app);
                    app.written_into = into;
                    match app.written_into {
                        Some(_) => app.notices.offer(text, Action::OpenExported),
                        None => app.notices.notify(text),
                    }
                }
                Err(error) => app.notices.warn(error),
            }
            app.say_lost_logs();
        });
    }

    /// Writes one set of products of the visible logs into a folder, as `process` does: the
    /// requested products, including the comparison with the reference, and the report with the
    /// present decisions about boxes.
    pub(super) fn export(&mut self, folder: PathBuf) {
        let logs = self.logs.processed();
        let Some(first) = logs.first() else {
            return;
        };
        let excluded_products = &self.view.options.excluded_products;
        let requested: Vec<Product> = (Product::ALL.into_iter())
            .filter(|product| !excluded_products.contains(product))
            .collect();
        let against = self.map.comparing.against(&first.products.settings);
        let against = against.filter(|_| requested.contains(&Product::Residuals));
        let review = self.survey_review();
        let run = (logs.len() == 1).then(|| (self.logs.shown.id, folder.clone()));
        let into = folder.clone();
        let derived = self.pipeline.deriving.results.clone();
        let write = move |progress: &Progress| {
            let reference = against.as_ref().map(|(reference, _)| &**reference);
            let surveys = logs.iter().map(|log| &*log.survey);
            let run = outputs::begin(&folder, surveys, reference)?;
            let order = Order {
                logs: &logs,
                derived: &derived,
                requested: &requested,
                reference: (against.as_ref()).map(|(reference, matching)| (reference, *matching)),
                search: None,
                review: &review,
                corrections: &[],
            };
            let written = outputs::write(&order, run, progress, |_| ());
            written.map(|written| written.summary(&folder))
        };
        let written = |app: &mut Self| {
            if let Some((log, folder)) = run {
                let run = EarlierRun::read(&folder);
                app.files.exported = run.map(|run| Exported { log, folder, run });
            }
        };
        self.start_writing(write, written, Some(into));
    }

    /// Writes the shown log, or some of its pings, into a file.
    pub(super) fn export_log(&mut self, path: PathBuf, pings: Option<Range<usize>>) {
        let Some(survey) = self.logs.shown.survey.clone() else {
            return;
        };
        if self.refuses_log(self.logs.shown.id, &path) {
            return;
        }
        let settings = self.logs.shown.settings.clone();
        let pings = pings.map(|pings| PingRange {
            start: pings.start,
            end: pings.end.min(survey.side_scan.len()),
        });
        let choice = LogPartChoice { pings, ..LogPartChoice::default() };
        self.write(move |progress| {
            let positions = settings.position_settings();
            let copied = copy_log(&path, &survey, positions, &choice, progress)?;
            let losses = copied.losses.iter().map(|loss| format!("; {loss}"));
            let losses: String = losses.collect();
            let path = path.display();
            Ok::<_, bathyscope_products::Error>(format!(
                "Wrote {} to {path}{losses}",
                copied.summary()
            ))
        });
    }

    /// Returns the folder for products unless the analyst names another: the one that was written
    /// last, else one beside the project or the log.
    pub(crate) fn export_folder(&self) -> PathBuf {
        if let Some(folder) = &self.written_into {
            return folder.clone();
        }
        let survey = self.logs.shown.survey.as_ref();
        let log = survey.and_then(|survey| survey.source.files.first());
        let beside = self.files.project_saving.path().or(log.map(PathBuf::as_path));
        let name = beside.and_then(Path::file_stem).unwrap_or_default();
        let name = format!("{}-products", name.to_string_lossy());
        beside.and_then(Path::parent).unwrap_or(Path::new("")).join(name)
    }

    /// Returns the amounts that determine the sizes of the products.
    pub fn amounts(&self) -> Amounts {
        let depth_map = self.depth_map().flatten();
        Amounts::of(&self.logs.processed(), depth_map.map(|map| &**map))
    }

    /// Returns the last written files of the shown log that its present settings would change, and
    /// their folder; `None` if there are none.
    pub fn out_of_date(&self) -> Option<(&Path, Vec<&'static OutputFile>)> {
        let Exported { log, folder, run } = self.files.exported.as_ref()?;
        let files = run.out_of_date(&self.logs.shown.settings);
        (*log == self.logs.shown.id && !files.is_empty()).then_some((folder, files))
    }
}
