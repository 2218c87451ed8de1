//! A figure that the analyst draws to measure.

use crate::project::Measurement;

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Figure {
    /// What it measures, and between which corners.
    pub measurement: Measurement,
    /// The next corner begins another figure.
    pub done: bool,
}
