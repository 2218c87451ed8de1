//! What is grouped: the boxes that may show one object, and how near they have to lie.

use super::Target;

/// How near two sightings of one object lie.
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
    /// Which log of the survey saw it; places of all logs are in one plane.
    pub log: usize,
    /// Where it lies.
    pub target: &'a Target,
    /// What it is taken for; `None` where that is not known.
    pub class: Option<usize>,
    /// How sure that is, 0 to 1.
    pub score: f64,
}
