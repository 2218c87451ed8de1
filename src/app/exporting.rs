//! Products and reviewed boxes on their way into a folder.

use super::{App, Jobs, Outcome, Task};
use crate::detection::review::{Review, State};
use crate::handover::{self, Objects};
use crate::pipeline::{
    Agreement, Product, reviewed_rows, spare_files, write_comparison, write_products,
};
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
        let (Some(survey), Some(products)) = (&self.survey, &self.products) else {
            return;
        };
        let (survey, mut products) = (survey.clone(), products.clone());
        // No stage depends on it: the results are as good for any system.
        products.settings.crs = self.settings.crs;
        let left_out = &self.options.left_out;
        let wanted = Product::ALL.into_iter();
        let wanted: Vec<Product> = wanted.filter(|one| !left_out.contains(one)).collect();
        let against = self.comparing.against(&products);
        let against = against.filter(|_| wanted.contains(&Product::Residuals));
        let boxes = (self.reviewing.has_boxes()).then_some(&self.reviewing.review);
        let boxes = boxes.cloned().zip(self.reviewing.raster().cloned());
        self.exporting = Some(Exporting::start(&self.jobs, move |progress| {
            let reference = against.as_ref().map(|(reference, _)| reference.path());
            spare_files(reference.into_iter(), &folder)?;
            let mut written =
                write_products(&survey, &products, &wanted, &folder, progress, |_| ())?;
            if let Some((reference, matching)) = &against {
                let agreement =
                    Agreement::with_reference(&survey, &products, reference, *matching, progress)?;
                let report = &written.report;
                let names =
                    write_comparison(&survey, &products, &agreement, report, &folder, progress)?;
                written.files.extend(names);
                written.comparisons.extend(agreement.by_source(&products));
            }
            let reviewed = boxes.as_ref().map(|(review, raster)| {
                let rows = reviewed_rows(&survey, &products, review, progress)?;
                Ok::<_, String>((rows, raster, told(review)))
            });
            let reviewed = reviewed.transpose()?;
            let objects = reviewed.as_ref().map(|(rows, raster, origin)| Objects {
                rows,
                raster,
                origin: origin.clone(),
            });
            if wanted.contains(&Product::Report) {
                handover::write_page(&survey, &products, &written, objects, &folder, progress)?;
                written.files.push(handover::NAME);
            }
            let files = written.files.join(", ");
            Ok(format!("Wrote {files} into {}", folder.display()))
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

/// How far a review has come: `Boxes of the review: 12 accepted, 1 added, 3 rejected, 4 undecided`.
fn told(review: &Review) -> String {
    let count = |state: State| review.boxes().filter(|one| one.state == state).count();
    let part = match review.coverage() {
        Some(part) => format!(". The search was stopped: it covers {part}"),
        None => String::new(),
    };
    if count(State::Proposed) == review.boxes().len() {
        return format!("Proposed by the detector, not reviewed{part}");
    }
    format!(
        "Boxes of the review: {} accepted, {} added, {} rejected, {} undecided{part}",
        count(State::Accepted),
        count(State::Added),
        count(State::Rejected),
        count(State::Proposed)
    )
}
