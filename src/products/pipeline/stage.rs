//! The stages of a run, and which of them a change of settings makes stale.

use super::Settings;
use bathyscope_log::named;

/// A stage of the pipeline, in the order of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Position and heading of every ping.
    Navigation,
    /// First return on both sides.
    FirstReturn,
    /// Flat stretches of the track, and scales.
    Calibration,
    /// Points.
    Cloud,
    /// Class of each point; the outlier filter runs here.
    Outliers,
    /// The bottom across the track.
    Relief,
}

named! {
    /// All stages in order.
    pub Stage {
        Navigation: "track",
        FirstReturn: "first return",
        Calibration: "calibration",
        Cloud: "cloud",
        Outliers: "outliers",
        Relief: "relief",
    }
}

impl Stage {
    /// The first stage whose result differs between two settings; `None` when all results are the
    /// same.
    pub fn first_stale(old: &Settings, new: &Settings) -> Option<Stage> {
        // With the sides of a log all that is known of it is another, its places included.
        let same_log =
            old.track == new.track && old.source == new.source && old.mounting == new.mounting;
        let same_places = old.heading == new.heading
            && old.projection == new.projection
            && old.position_shift == new.position_shift;
        if !same_places || !same_log {
            Some(Stage::Navigation)
        } else if old.image != new.image
            || !old.first_return.finds_the_same(&new.first_return)
            || old.bottom != new.bottom
        {
            Some(Stage::FirstReturn)
        } else if old.calibration != new.calibration || old.excluded != new.excluded {
            Some(Stage::Calibration)
        } else if old.cloud != new.cloud || old.depth() != new.depth() {
            Some(Stage::Cloud)
        } else if old.class_rules() != new.class_rules() || old.first_return != new.first_return {
            Some(Stage::Outliers)
        } else if !old.surface.counts_the_same(&new.surface) {
            Some(Stage::Relief)
        } else {
            None
        }
    }
}
