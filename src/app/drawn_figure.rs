//! Defines the figure that the analyst draws to measure.

use bathyscope_products::project::Measurement;

/// A figure that the analyst draws to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Kind of the measurement, and its corners.
    pub measurement: Measurement,
    /// True if the figure is ended, so that the next corner begins another one.
    pub done: bool,
}
