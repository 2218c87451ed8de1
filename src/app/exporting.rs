//! Products and reviewed boxes on their way into a folder.

use super::{App, Jobs, LogId, Outcome, Task};
use crate::outputs::{self, EarlierRun, Order, OutputFile, Product};
use crate::pipeline::ProcessedLog;
use crate::progress::Progress;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Products or boxes being written.
pub(super) struct Exporting {
    /// What was written, in a sentence.
    task: Task<Result<String, String>>,
    /// Where the files of a run go, and of which log.
    run: Option<(LogId, PathBuf)>,
}

/// The files of a run that this window wrote.
pub(super) struct Exported {
    log: LogId,
    folder: PathBuf,
    run: EarlierRun,
}

impl Exporting {
    /// Starts writing.
    pub fn start(
        jobs: &Jobs,
        write: impl FnOnce(&Progress) -> Result<String, String> + Send + 'static,
    ) -> Self {
        Self {
            task: Task::start(jobs, write),
            run: None,
        }
    }

    pub fn fraction(&self) -> f32 {
        self.task.fraction()
    }
}

impl App {
    /// Writes something off the window's thread, and notifies of the outcome.
    pub fn write(
        &mut self,
        write: impl FnOnce(&Progress) -> Result<String, String> + Send + 'static,
    ) {
        self.exporting = Some(Exporting::start(&self.jobs, write));
    }

    /// Writes the products that are requested, the comparison with the reference among them, and the report with the boxes as they
    /// are decided, into a folder.
    pub(super) fn export(&mut self, folder: PathBuf) {
        let (Some(survey), Some(products)) = (&self.log.survey, &self.log.products) else {
            return;
        };
        let shown = self.shown_logs();
        if shown.len() > 1 {
            return self.export_survey(shown.into_iter().map(|shown| shown.log).collect(), folder);
        }
        let (survey, mut products) = (survey.clone(), products.clone());
        // No stage depends on it: the results are as good for any system.
        Arc::make_mut(&mut products.settings).crs = self.log.settings.crs;
        let requested = self.requested();
        let against = self.comparing.against(&products);
        let against = against.filter(|_| requested.contains(&Product::Residuals));
        let boxes = (self.log.reviewing.has_boxes()).then_some(&self.log.reviewing.review);
        let boxes = boxes.cloned().zip(self.log.reviewing.raster().cloned());
        let run = Some((self.log.id, folder.clone()));
        let derived = self.deriving.results.clone();
        let exporting = Exporting::start(&self.jobs, move |progress| {
            let reference = against.as_ref().map(|(reference, _)| &**reference);
            let run = outputs::begin(&folder, &survey, reference)?;
            let logs = [ProcessedLog { survey, products }];
            let order = Order {
                logs: &logs,
                derived: &derived,
                requested: &requested,
                reference: (against.as_ref()).map(|(reference, matching)| (reference, *matching)),
                search: None,
                review: (boxes.as_ref()).map(|(review, raster)| (&**review, &**raster)),
            };
            let written = outputs::write(&order, run, progress, |_| ())?;
            Ok(written.summary(&folder).replacen("wrote", "Wrote", 1))
        });
        self.exporting = Some(Exporting { run, ..exporting });
    }

    /// The products that are ticked.
    fn requested(&self) -> Vec<Product> {
        let left_out = &self.options.left_out;
        let all = Product::ALL.into_iter();
        all.filter(|one| !left_out.contains(one)).collect()
    }

    /// Writes one set of products of several logs, as `process` does.
    fn export_survey(&mut self, mut logs: Vec<ProcessedLog>, folder: PathBuf) {
        for log in &mut logs {
            Arc::make_mut(&mut log.products.settings).crs = self.log.settings.crs;
        }
        let (requested, derived) = (self.requested(), self.deriving.results.clone());
        self.write(move |progress| {
            let Some(first) = logs.first() else {
                return Err("there is no log to write products of".to_owned());
            };
            let run = outputs::begin(&folder, &first.survey, None)?;
            let order = Order {
                logs: &logs,
                derived: &derived,
                requested: &requested,
                reference: None,
                search: None,
                review: None,
            };
            let written = outputs::write(&order, run, progress, |_| ())?;
            Ok(written.summary(&folder).replacen("wrote", "Wrote", 1))
        });
    }

    /// Files that were written last of the log at hand and would be others with its settings of now, and their folder.
    pub fn out_of_date(&self) -> Option<(&Path, Vec<&'static OutputFile>)> {
        let Exported { log, folder, run } = self.exported.as_ref()?;
        let files = run.out_of_date(&self.log.settings);
        (*log == self.log.id && !files.is_empty()).then_some((folder, files))
    }

    /// Notifies of what was written.
    pub(super) fn poll_export(&mut self) {
        let Some(exporting) = &self.exporting else {
            return;
        };
        let written = match exporting.task.poll() {
            Outcome::Pending => return,
            Outcome::Done(written) => written,
            Outcome::Failed => Err("the export failed unexpectedly".to_owned()),
        };
        let run = exporting.run.clone();
        self.exporting = None;
        match written {
            Ok(text) => {
                if let Some((log, folder)) = run {
                    let run = EarlierRun::read(&folder);
                    self.exported = run.map(|run| Exported { log, folder, run });
                }
                self.notify(text, false);
            }
            Err(text) => self.notify(text, true),
        }
    }
}
