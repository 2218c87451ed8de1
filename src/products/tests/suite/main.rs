//! Whole runs without a window: simulated surveys of known truth through all stages, and the real
//! recordings.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

/// Surfaces and what is drawn from them, against what other programs make of the same numbers and
/// against simulated truth.
mod bathymetry {
    mod change;
    mod height_offsets;
    mod isobaths;
    mod ponds;
}
mod calibration;
mod cloud;
mod detection_targets;
mod export;
mod garbled;
mod html_report;
mod large_boxes;
mod mosaic;
mod mosaic_gain;
mod navigation;
mod offsets;
mod picture_log;
mod point_classes;
mod rates;
mod sizes;
mod swath;
mod trusted_depths;
mod truth;

use bathyscope_log::support::progress::Progress;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::{self, Order, Product, RunFolder, Written};
use bathyscope_products::pipeline::{Derived, ProcessedLog};
use std::path::Path;

/// Writes the files of logs into a folder.
fn written(
    logs: &[ProcessedLog],
    requested: &[Product],
    review: &SurveyReview,
    folder: &Path,
) -> Written {
    let order = Order {
        logs,
        derived: &Derived::default(),
        requested,
        reference: None,
        search: None,
        review,
        corrections: &[],
    };
    let run = RunFolder::begin(folder).expect("a folder");
    outputs::write(&order, run, &Progress::new(), |_| ()).expect("a whole set of products")
}

/// Uniform numbers from a seed, and normal ones as sums of twelve of them.
struct Dice(u64);

impl Dice {
    /// Returns a random number from 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a normally distributed random number with a mean of zero.
    fn normal(&mut self, sd: f64) -> f64 {
        sd * ((0..12).map(|_| self.uniform()).sum::<f64>() - 6.0)
    }

    /// Returns a random number between two.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Returns one of some values.
    fn of<T: Copy>(&mut self, values: &[T]) -> T {
        values[((self.uniform() * values.len() as f64) as usize).min(values.len() - 1)]
    }
}
