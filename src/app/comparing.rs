//! Opens the reference that the survey is compared with, a file of points or another mission, in a
//! background thread, and computes the agreement of points with it on demand only, because the
//! comparison needs a triangulation of all soundings.

use super::error::AppError;
use super::jobs::{JobKey, JobQueue};
use super::{App, MapLayer};
use bathyscope_bottom::bathymetry::SurfaceSettings;
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_bottom::cloud::{PointClass, PointSource};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::Error;
use bathyscope_products::outputs::finish_killed_run;
use bathyscope_products::pipeline::{Agreement, ProcessedLog, Reference, Same, Settings};
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

/// Sources of the points that are compared with the soundings of the survey itself.
const WITH_SOUNDINGS: [PointSource; 3] =
    [PointSource::Port, PointSource::Starboard, PointSource::Swath];
/// Problem that is shown when the comparison was stopped.
const STOPPED: &str = "Comparing was stopped; Update results starts it again.";
/// Initial largest distance of a nearest point, metres.
const RADIUS_M: f64 = 1.0;

/// The reference, and the method that finds the reference of a point.
#[derive(Clone)]
pub struct Comparing {
    /// Reference that the survey is compared with; `None` compares with the survey's own soundings.
    pub reference: Option<Arc<Reference>>,
    /// Method that finds the reference of a point.
    pub by: ReferenceBy,
    /// Largest distance of the nearest point for [`ReferenceBy::Nearest`], metres.
    pub radius_m: f64,
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

/// The last comparison that was requested, and its result.
#[derive(Default)]
pub struct ReferenceComparison {
    of: Option<Of>,
    agreement: Option<Arc<Agreement>>,
    problem: Option<String>,
}

/// Inputs of an agreement, found or requested.
#[derive(Clone, PartialEq)]
struct Of {
    /// The classes of the points of each log, and the settings of its surface with the widest gap.
    logs: Vec<(Same<Vec<PointClass>>, SurfaceSettings)>,
    /// The reference, and the method that finds the reference of a point; `None` for the survey's
    /// own soundings.
    reference: Option<(Same<Reference>, Matching)>,
}

impl Of {
    /// Collects the inputs from the kept points of some logs.
    fn new(logs: &[ProcessedLog], reference: Option<(Arc<Reference>, Matching)>) -> Self {
        let of_log = |log: &ProcessedLog| {
            let products = &log.products;
            (Same(products.classes.clone()), products.settings.surface.clone())
        };
        let reference = reference.map(|(reference, matching)| (Same(reference), matching));
        Self { logs: logs.iter().map(of_log).collect(), reference }
    }
}

impl ReferenceComparison {
    /// Returns the agreement of the points with the reference, or of side-scan with soundings if
    /// there is no reference; `None` until it is computed, and if no point is over the reference.
    pub fn agreement(&self) -> Option<&Arc<Agreement>> {
        self.agreement.as_ref()
    }

    /// Returns the reason that there is no agreement, as a sentence; `None` if there is no problem.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self { of: self.of.clone(), agreement: self.agreement.clone(), ..Self::default() }
    }

    /// Drops the agreement, and stops the comparison.
    pub(super) fn forget(&mut self, jobs: &mut JobQueue) {
        jobs.stop(&JobKey::CompareReference);
        *self = Self::default();
    }

    /// Stops the comparison until [`ReferenceComparison::resume`] is called.
    pub(super) fn stop(&mut self, jobs: &mut JobQueue) {
        if jobs.stop(&JobKey::CompareReference) {
            self.agreement = None;
            self.problem = Some(STOPPED.to_owned());
        }
    }

    /// Permits a stopped comparison to start again.
    pub(super) fn resume(&mut self) {
        if self.problem.take().is_some() {
            self.of = None;
        }
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
            |app, opened: Result<(Of, Agreement), AppError>| match opened {
                Ok((of, agreement)) => {
                    app.notices.notify(words_about(&agreement));
                    app.view.options.map.layers.set_visible(MapLayer::Residuals, true);
                    app.map.comparing.reference = agreement.reference.clone();
                    app.findings.reference_comparison = ReferenceComparison {
                        of: Some(of),
                        agreement: Some(Arc::new(agreement)),
                        problem: None,
                    };
                }
                Err(error) => app.notices.warn(error),
            },
        );
    }

    /// Closes the reference, so that side-scan is compared with soundings again, and stops opening
    /// another.
    pub(super) fn leave_reference(&mut self) {
        self.jobs.stop(&JobKey::OpenReference);
        self.map.comparing.reference = None;
        self.findings.reference_comparison.forget(&mut self.jobs);
    }

    /// Starts comparing the results of the visible logs, unless that is done or running.
    pub(super) fn compare_with_reference(&mut self) {
        let logs = self.logs.processed();
        let Some(first) = logs.first() else {
            return;
        };
        let of = Of::new(&logs, self.map.comparing.against(&first.products.settings));
        let made = &mut self.findings.reference_comparison;
        if made.of.as_ref() == Some(&of) {
            return;
        }
        made.of = Some(of.clone());
        self.jobs.run(
            JobKey::CompareReference,
            move |progress| match &of.reference {
                Some((Same(reference), matching)) => {
                    let made = Agreement::with_reference(&logs, reference, *matching, progress);
                    Ok(Some(made?))
                }
                None => Ok(Agreement::with_soundings(&logs, &WITH_SOUNDINGS, progress)?),
            },
            |app, found: Result<_, AppError>| {
                let made = &mut app.findings.reference_comparison;
                (made.agreement, made.problem) = match found {
                    Ok(agreement) => (agreement.map(Arc::new), None),
                    Err(error) => (None, Some(error.to_string())),
                };
            },
        );
    }
}

/// Opens a reference, and compares the survey with it.
fn open(
    path: &Path,
    logs: &[ProcessedLog],
    matching: Matching,
    progress: &Progress,
) -> Result<(Of, Agreement), Error> {
    let Some(first) = logs.first() else {
        return Err("there is no log to compare with the reference".into());
    };
    let settings = &first.products.settings;
    let reference = Reference::open(path.as_os_str(), &first.survey, settings, progress)?;
    let reference = Arc::new(reference);
    let agreement = Agreement::with_reference(logs, &reference, matching, progress)?;
    let of = Of::new(logs, Some((reference, matching)));
    Ok((of, agreement))
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
