//! Boxes that may show one object, and the limits of their distance, for grouping.

use super::Target;

/// Limits of the distance between two sightings of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupSettings {
    /// Standard deviations of the joint uncertainty that sightings of one object may lie apart.
    pub sigmas: f64,
    /// Standard deviation of the receiver's own position between lines, metres: it is not in
    /// [`Target::sigma_m`].
    pub receiver_sigma_m: f64,
    /// Standard deviation of the place of a whole log, metres: another day, another receiver. It
    /// counts between sightings of different logs.
    pub log_sigma_m: f64,
}

impl Default for GroupSettings {
    fn default() -> Self {
        Self { sigmas: 3.0, receiver_sigma_m: 0.3, log_sigma_m: 1.0 }
    }
}

/// One box that may show the same object as others.
#[derive(Clone, Copy, Debug)]
pub struct Sighting<'a> {
    /// Index of the log that saw it; places of all logs are in one plane.
    pub log: usize,
    /// Place and size of its object.
    pub target: &'a Target,
    /// Class of the object; `None` where it is not known.
    pub class: Option<usize>,
    /// Score of the box, 0 to 1.
    pub score: f64,
}
