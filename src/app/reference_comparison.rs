//! Computes the agreement of points with a reference, on demand only, because the comparison needs
//! a triangulation of all soundings.

use super::error::AppError;
use super::{App, Task, TaskOutcome};
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

/// An agreement, `None` if no point is over the reference, or the error of the comparison.
type Found = Result<Option<Agreement>, AppError>;

/// State of the comparison, and its last result.
#[derive(Default)]
pub(super) struct ReferenceComparison {
    of: Option<Of>,
    task: Option<Task<Found>>,
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
    /// Returns true if points are being compared.
    pub(super) fn is_busy(&self) -> bool {
        self.task.is_some()
    }

    /// Returns the done share of the comparison, 0 to 1; `None` if none is running.
    pub(super) fn fraction(&self) -> Option<f32> {
        self.task.as_ref().map(Task::fraction)
    }

    /// Returns a copy that holds only the drawn parts.
    pub(super) fn for_picture(&self) -> Self {
        Self { of: self.of.clone(), agreement: self.agreement.clone(), ..Self::default() }
    }

    /// Sets an agreement that was computed elsewhere.
    pub(super) fn take(&mut self, of: Of, agreement: Agreement) {
        *self = Self { of: Some(of), agreement: Some(Arc::new(agreement)), ..Self::default() };
    }

    /// Stops the comparison.
    pub(super) fn stop(&mut self) {
        if self.task.take().is_some() {
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
    /// Returns the agreement of the points with the reference, or of side-scan with soundings if
    /// there is no reference; `None` until it is computed, and if no point is over the reference.
    pub fn agreement(&self) -> Option<&Arc<Agreement>> {
        self.findings.reference_comparison.agreement.as_ref()
    }

    /// Returns the reason that there is no agreement, as a sentence; `None` if there is no problem.
    pub fn agreement_problem(&self) -> Option<&str> {
        self.findings.reference_comparison.problem.as_deref()
    }

    /// Returns true if depths are being compared with the reference.
    pub(crate) fn is_comparing_with_reference(&self) -> bool {
        self.findings.reference_comparison.is_busy()
    }

    /// Starts comparing the results of the visible logs, unless that is done or running.
    pub(super) fn compare_with_reference(&mut self) {
        let logs = self.processed_logs();
        let Some(first) = logs.first() else {
            return;
        };
        let of = Of::new(&logs, self.map.comparing.against(&first.products.settings));
        let made = &mut self.findings.reference_comparison;
        if made.of.as_ref() == Some(&of) {
            return;
        }
        made.of = Some(of.clone());
        made.task = Some(Task::start(&self.jobs, move |progress| match &of.reference {
            Some((reference, matching)) => {
                let made = Agreement::with_reference(&logs, reference, *matching, progress);
                Ok(Some(made?))
            }
            None => Ok(Agreement::with_soundings(&logs, &WITH_SOUNDINGS, progress)?),
        }));
    }

    /// Collects the result of the comparison.
    pub(super) fn poll_tables(&mut self) {
        let made = &mut self.findings.reference_comparison;
        let found = match made.task.as_ref().map(Task::poll) {
            Some(TaskOutcome::Done(found)) => found,
            Some(TaskOutcome::Failed) => Err(AppError::Failed("comparing")),
            Some(TaskOutcome::Pending) | None => return,
        };
        made.task = None;
        (made.agreement, made.problem) = match found {
            Ok(agreement) => (agreement.map(Arc::new), None),
            Err(error) => (None, Some(error.to_string())),
        };
    }
}
