//! A figure that the analyst draws to measure.

use bathyscope_products::project::Measurement;

/// Figure that is drawn to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Kind of the measurement, and its corners.
    pub measurement: Measurement,
    /// The next corner begins another figure.
    pub done: bool,
}
