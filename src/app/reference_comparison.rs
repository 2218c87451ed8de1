//! Computes the agreement of points with a reference, on demand only, because the comparison needs
//! a triangulation of all soundings.

use super::App;
use super::error::AppError;
use super::jobs::JobKey;
use bathyscope_bottom::bathymetry::SurfaceSettings;
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_bottom::cloud::{PointClass, PointSource};
use bathyscope_products::pipeline::{Agreement, ProcessedLog, Reference};
use std::sync::Arc;

/// Sources of the points that are compared with the soundings of the survey itself.
const WITH_SOUNDINGS: [PointSource; 3] =
    [PointSource::Port, PointSource::Starboard, PointSource::Swath];
/// Problem that is shown when the comparison was stopped.
const STOPPED: &str = "Comparing was stopped; Update results starts it again.";

/// The last comparison that was requested, and its result.
#[derive(Default)]
pub struct ReferenceComparison {
    of: Option<Of>,
    agreement: Option<Arc<Agreement>>,
    problem: Option<String>,
}

/// Inputs of an agreement, found or requested.
#[derive(Clone)]
pub(super) struct Of {
    /// The classes of the points of each log, and the settings of its surface with the widest gap.
    logs: Vec<(Arc<Vec<PointClass>>, SurfaceSettings)>,
    /// The reference, and the method that finds the reference of a point; `None` for the survey's
    /// own soundings.
    reference: Option<(Arc<Reference>, Matching)>,
}

impl Of {
    /// Collects the inputs from the kept points of some logs.
    pub(super) fn new(
        logs: &[ProcessedLog],
        reference: Option<(Arc<Reference>, Matching)>,
    ) -> Self {
        let of_log = |log: &ProcessedLog| {
            let products = &log.products;
            (products.classes.clone(), products.settings.surface.clone())
        };
        Self { logs: logs.iter().map(of_log).collect(), reference }
    }
}

impl PartialEq for Of {
    fn eq(&self, other: &Self) -> bool {
        let same_reference = match (&self.reference, &other.reference) {
            (Some((one, matching)), Some((other, other_matching))) => {
                Arc::ptr_eq(one, other) && matching == other_matching
            }
            (None, None) => true,
            _ => false,
        };
        let mut pairs = self.logs.iter().zip(&other.logs);
        let same_points = self.logs.len() == other.logs.len()
            && pairs.all(|(one, other)| Arc::ptr_eq(&one.0, &other.0) && one.1 == other.1);
        same_points && same_reference
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

    /// Sets an agreement that was computed elsewhere.
    pub(super) fn take(&mut self, of: Of, agreement: Agreement) {
        *self = Self { of: Some(of), agreement: Some(Arc::new(agreement)), ..Self::default() };
    }

    /// Permits a stopped comparison to start again.
    pub(super) fn resume(&mut self) {
        if self.problem.take().is_some() {
            self.of = None;
        }
    }
}

impl App {
    /// Drops the agreement, and stops the comparison.
    pub(super) fn forget_agreement(&mut self) {
        self.jobs.stop(&JobKey::CompareReference);
        self.findings.reference_comparison = ReferenceComparison::default();
    }

    /// Stops the comparison until [`ReferenceComparison::resume`] is called.
    pub(super) fn stop_comparing(&mut self) {
        if self.jobs.stop(&JobKey::CompareReference) {
            let made = &mut self.findings.reference_comparison;
            made.agreement = None;
            made.problem = Some(STOPPED.to_owned());
        }
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
                Some((reference, matching)) => {
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
