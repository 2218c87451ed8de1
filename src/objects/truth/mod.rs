//! Holds known objects of a survey, and compares them with a review's boxes.
//!
//! In: a file of known objects, and the boxes of a review. Out: which boxes are right, and the
//! mistakes.
//!
//! `file` reads the truth: the table of objects that `bathyscope simulate` writes, or a review of
//! the same log by somebody who knew the objects. [`RasterTruth`] converts it to boxes in the
//! survey's raster and ignores objects that nobody could see; `compare` pairs it with boxes.

mod compare;
mod file;

/// The objects of a truth as boxes in the pixels of a raster.
#[derive(Clone, Debug)]
pub struct RasterTruth {
    truth: Arc<SurveyTruth>,
    /// Boxes on each of the two sides, each with the index of its object.
    sides: [Vec<(metrics::TrueBox, usize)>; 2],
}

impl RasterTruth {
    /// Converts the objects to boxes in the raster. Objects that a detector cannot be expected to
    /// find, by the rule for training data ([`KnownObject::is_plain`]), are ignored unless a person
    /// saw them.
    pub fn new(raster: &Raster, truth: Arc<SurveyTruth>) -> Self {
        let rasterise = |known: &KnownObject| metrics::TrueBox {
            class: known.class,
            rect: raster.rect_of(&known.whole),
            ignored: !truth.was_seen && !known.is_plain(raster),
        };
        let on_raster: Vec<metrics::TrueBox> = truth.objects.iter().map(rasterise).collect();
        let on = |side: Side| {
            let all = on_raster.iter().zip(&truth.objects).enumerate();
            all.filter(|(_, (_, known))| known.whole.side == side)
                .map(|(object, (on_raster, _))| (*on_raster, object))
                .collect()
        };
        Self { sides: Side::BOTH.map(on), truth }
    }

    /// Ignores the objects for which `is_out` is true, and returns how many of them counted until
    /// then.
    fn ignore(&mut self, is_out: impl Fn(&Mark) -> bool) -> usize {
        let mut count = 0;
        for (on_raster, object) in self.sides.iter_mut().flatten() {
            if !on_raster.ignored && is_out(&self.truth.objects[*object].whole) {
                on_raster.ignored = true;
                count += 1;
            }
        }
        count
    }

    /// Returns the two sides as pictures without predicted boxes. Classes are indices into
    /// `classes`, matched by name; classes that only the truth has are appended to it.
    pub fn images(&self, classes: &mut Vec<String>) -> [metrics::Image; 2] {
        let names = self.truth.classes.iter();
        let class_of: Vec<usize> = names.map(|name| class_index(classes, name)).collect();
        [0, 1].map(|side: usize| {
            let of_side = self.sides[side].iter();
            metrics::Image {
                truth: of_side
                    .map(|(known, _)| metrics::TrueBox {
                        class: class_of.get(known.class).copied().unwrap_or(usize::MAX),
                        ..*known
                    })
                    .collect(),
                predicted: Vec::new(),
            }
        })
    }
}

#[cfg(test)]
mod tests;

pub use compare::{Mistake, Standing, TruthComparison};
pub use file::{TruthError, TruthFileError};

use super::dataset::KnownObject;
use super::{Mark, Raster, class_index, metrics};
use bathyscope_log::survey::Side;
use std::sync::Arc;

/// Ending of the file name of the table of objects that `bathyscope simulate` writes next to a log;
/// it replaces the ending of the log's name.
pub const SIDECAR: &str = "objects.csv";

/// Objects whose place in a survey is known.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyTruth {
    /// Class names that [`KnownObject::class`] is an index into.
    pub classes: Vec<String>,
    /// Sightings of the objects: one entry for each pass that insonified an object.
    pub objects: Vec<KnownObject>,
    /// True if somebody drew the boxes around what they saw: all boxes count. Otherwise the boxes
    /// are computed from the geometry, and objects that do not stand out in the picture are
    /// ignored.
    pub was_seen: bool,
}

impl SurveyTruth {
    /// Returns the name of a class; empty if there is no class with this index.
    pub fn class_name(&self, class: usize) -> &str {
        self.classes.get(class).map_or("", String::as_str)
    }
}
