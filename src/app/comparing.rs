//! Opens the reference that the survey is compared with, a file of points or another mission, in a
//! background thread.

use super::error::AppError;
use super::jobs::JobKey;
use super::reference_comparison::Of;
use super::{App, MapLayer};
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::Error;
use bathyscope_products::outputs::finish_killed_run;
use bathyscope_products::pipeline::{Agreement, ProcessedLog, Reference, Settings};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Method that finds the reference of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReferenceBy {
    /// The triangulated points of the reference, across gaps as wide as the depth map spans.
    #[default]
    Surface,
    /// The nearest point of the reference within a radius.
    Nearest,
}

/// Initial largest distance of a nearest point, metres.
const RADIUS_M: f64 = 1.0;

/// The reference, and the method that finds the reference of a point.
pub struct Comparing {
    /// Reference that the survey is compared with; `None` compares with the survey's own soundings.
    pub reference: Option<Arc<Reference>>,
    /// Method that finds the reference of a point.
    pub by: ReferenceBy,
    /// Largest distance of the nearest point for [`ReferenceBy::Nearest`], metres.
    pub radius_m: f64,
}

/// A reference, and the agreement of the survey with it.
struct Opened {
    of: Of,
    agreement: Agreement,
}

impl Default for Comparing {
    fn default() -> Self {
        Self { reference: None, by: ReferenceBy::default(), radius_m: RADIUS_M }
    }
}

impl Comparing {
    /// Sets the method that finds the reference of a point, and its radius.
    pub(super) fn match_by(&mut self, by: ReferenceBy, radius_m: f64) {
        self.by = by;
        if radius_m > 0.0 && radius_m.is_finite() {
            self.radius_m = radius_m;
        }
    }

    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self { reference: self.reference.clone(), by: self.by, radius_m: self.radius_m }
    }

    fn matching(&self, settings: &Settings) -> Matching {
        match self.by {
            ReferenceBy::Surface => Matching::Surface { max_gap_m: settings.surface.max_gap_m },
            ReferenceBy::Nearest => Matching::Nearest { radius_m: self.radius_m },
        }
    }

    /// Returns the reference and the method that finds the reference of a point, with the gap by
    /// the settings of the first log; `None` without a reference.
    pub(super) fn against(&self, settings: &Settings) -> Option<(Arc<Reference>, Matching)> {
        let reference = self.reference.clone()?;
        Some((reference, self.matching(settings)))
    }
}

impl App {
    /// Starts opening a reference; the opening of an earlier one is dropped.
    pub(super) fn compare_with(&mut self, path: PathBuf) {
        let logs = self.logs.processed();
        let Some(first) = logs.first() else {
            let text = "open a log first, then its reference";
            self.notices.warn(format!("{text}: {}", path.display()));
            return;
        };
        let matching = self.map.comparing.matching(&first.products.settings);
        self.jobs.run(
            JobKey::OpenReference,
            move |progress| {
                finish_killed_run(&path)?;
                Ok(open(&path, &logs, matching, progress)?)
            },
            App::take_reference,
        );
    }

    /// Closes the reference, so that side-scan is compared with soundings again, and stops opening
    /// another.
    pub(super) fn leave_reference(&mut self) {
        self.jobs.stop(&JobKey::OpenReference);
        self.map.comparing.reference = None;
        self.forget_agreement();
    }

    /// Shows a reference that was opened, or notifies the analyst of the error.
    fn take_reference(&mut self, opened: Result<Opened, AppError>) {
        match opened {
            Ok(Opened { of, agreement }) => {
                self.notices.notify(words_about(&agreement));
                let layers = &mut self.view.options.map.layers;
                layers.set_visible(MapLayer::Residuals, true);
                self.map.comparing.reference = agreement.reference.clone();
                self.findings.reference_comparison.take(of, agreement);
            }
            Err(error) => self.notices.warn(error.to_string()),
        }
    }
}

/// Opens a reference, and compares the survey with it.
fn open(
    path: &Path,
    logs: &[ProcessedLog],
    matching: Matching,
    progress: &Progress,
) -> Result<Opened, Error> {
    let Some(first) = logs.first() else {
        return Err("there is no log to compare with the reference".into());
    };
    let settings = &first.products.settings;
    let reference = Reference::open(path.as_os_str(), &first.survey, settings, progress)?;
    let reference = Arc::new(reference);
    let agreement = Agreement::with_reference(logs, &reference, matching, progress)?;
    let of = Of::new(logs, Some((reference, matching)));
    Ok(Opened { of, agreement })
}

/// Returns the notice about an opened reference: result of the comparison, remarks, and path.
fn words_about(agreement: &Agreement) -> String {
    let mut words = Vec::new();
    if let Some(found) = &agreement.comparison.residuals {
        words.push(format!(
            "Compared {} points: mean {:+.3} m (above 0 is shallower than the reference), 95 % within {:.3} m",
            found.n, found.mean_m, found.p95_m
        ));
    }
    let Some(reference) = &agreement.reference else {
        return words.join("; ");
    };
    words.extend(reference.notes.iter().cloned());
    format!("{}: {}", words.join("; "), reference.path().display())
}
