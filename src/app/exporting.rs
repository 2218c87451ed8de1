//! Products and reviewed boxes on their way into a folder.

use super::{App, Jobs, Outcome, Task};
use crate::outputs::{self, Order, Product, RunFolder, Searched, refuse_overwrite};
use crate::progress::Progress;
use std::path::PathBuf;

/// Products or boxes being written.
pub(super) struct Exporting {
    /// What was written, in a sentence.
    task: Task<Result<String, String>>,
}

impl Exporting {
    /// Starts writing.
    pub fn start(
        jobs: &Jobs,
        write: impl FnOnce(&Progress) -> Result<String, String> + Send + 'static,
    ) -> Self {
        Self {
            task: Task::start(jobs, write),
        }
    }

    pub fn fraction(&self) -> f32 {
        self.task.fraction()
    }
}

impl App {
    /// Writes something off the window's thread, and tells the sentence that comes of it.
    pub fn write(
        &mut self,
        write: impl FnOnce(&Progress) -> Result<String, String> + Send + 'static,
    ) {
        self.exporting = Some(Exporting::start(&self.jobs, write));
    }

    /// Writes the products that are wanted, the comparison with the reference among them, and the report with the boxes as they
    /// are decided, into a folder.
    pub(super) fn export(&mut self, folder: PathBuf) {
        let (Some(survey), Some(products)) = (&self.log.survey, &self.log.products) else {
            return;
        };
        let (survey, mut products) = (survey.clone(), products.clone());
        // No stage depends on it: the results are as good for any system.
        products.settings.crs = self.log.settings.crs;
        let left_out = &self.options.left_out;
        let wanted = Product::ALL.into_iter();
        let wanted: Vec<Product> = wanted.filter(|one| !left_out.contains(one)).collect();
        let against = self.comparing.against(&products);
        let against = against.filter(|_| wanted.contains(&Product::Residuals));
        let boxes = (self.log.reviewing.has_boxes()).then_some(&self.log.reviewing.review);
        let boxes = boxes.cloned().zip(self.log.reviewing.raster().cloned());
        self.exporting = Some(Exporting::start(&self.jobs, move |progress| {
            let reference = against.as_ref().map(|(reference, _)| reference.path());
            refuse_overwrite(reference.into_iter(), &folder)?;
            let run = RunFolder::begin(&folder)?;
            let order = Order {
                survey: &survey,
                products: &products,
                wanted: &wanted,
                reference: (against.as_ref()).map(|(reference, matching)| (reference, *matching)),
                boxes: (boxes.as_ref()).map_or(Searched::Not, |(review, raster)| {
                    Searched::Reviewed(review, raster)
                }),
            };
            let written = outputs::write(&order, run, progress, |_| ())?;
            Ok(written.summary(&folder).replacen("wrote", "Wrote", 1))
        }));
    }

    /// Tells what was written, once it is.
    pub(super) fn poll_export(&mut self) {
        let Some(exporting) = &self.exporting else {
            return;
        };
        let written = match exporting.task.poll() {
            Outcome::Pending => return,
            Outcome::Done(written) => written,
            Outcome::Failed => Err("the export failed unexpectedly".to_owned()),
        };
        self.exporting = None;
        match written {
            Ok(text) => self.tell(text, false),
            Err(text) => self.tell(text, true),
        }
    }
}
