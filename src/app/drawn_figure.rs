//! A figure that the analyst draws to measure.

use bathyscope_products::project::Measurement;

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it measures, and between which corners.
    pub measurement: Measurement,
    /// The next corner begins another figure.
    pub done: bool,
}
