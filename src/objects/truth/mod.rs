//! Known objects in a survey, and their comparison with a review's boxes.
//!
//! In: a file of known objects, and the boxes of a review. Out: which boxes are right, and the
//! mistakes.
//!
//! `file` reads it: the table of objects that `bathyscope simulate` writes, or a review of the same
//! log by somebody who knew. [`RasterTruth`] puts it into the survey's raster and leaves out what
//! nobody could see; `compare` pairs it with boxes.

mod compare;
mod file;

/// The objects of a truth as boxes in the pixels of a raster.
#[derive(Clone, Debug)]
pub struct RasterTruth {
    truth: Arc<SurveyTruth>,
    /// Boxes to the two sides, and which object each is.
    sides: [Vec<(metrics::TrueBox, usize)>; 2],
}

impl RasterTruth {
    /// Lays the objects out. Those that nobody could be asked for, by the rule by which a detector
    /// is taught ([`KnownObject::is_plain`]), are marked to be ignored unless somebody saw them.
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

    /// Leaves out some of the objects that count, by their boxes; how many.
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

    /// The two sides as pictures with nothing proposed yet. Classes are those of `classes`, the
    /// same where their names are; those that only the truth has are added to them.
    pub fn images(&self, classes: &mut Vec<String>) -> [metrics::Image; 2] {
        let names = self.truth.classes.iter();
        let class_of: Vec<usize> = names.map(|name| class_index(classes, name)).collect();
        [0, 1].map(|side: usize| {
            let of_side = self.sides[side].iter();
            metrics::Image {
                truth: of_side
                    .map(|(one, _)| metrics::TrueBox {
                        class: class_of.get(one.class).copied().unwrap_or(usize::MAX),
                        ..*one
                    })
                    .collect(),
                predicted: Vec::new(),
            }
        })
    }

    /// The truth.
    pub fn truth(&self) -> &Arc<SurveyTruth> {
        &self.truth
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

/// End of the name of the table of objects that `bathyscope simulate` writes next to a log, in
/// place of the log's own.
pub const SIDECAR: &str = "objects.csv";

/// Objects whose place in a survey is known.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyTruth {
    /// Class names that [`KnownObject::class`] means.
    pub classes: Vec<String>,
    /// The objects, one entry for each pass that insonified one.
    pub objects: Vec<KnownObject>,
    /// Somebody drew the boxes because they saw something there: all of them count. Otherwise they
    /// follow from geometry, and what does not stand out in the picture is neither to be found nor
    /// to be missed.
    pub was_seen: bool,
}

impl SurveyTruth {
    /// Name of a class; empty for an index that has none.
    pub fn class_name(&self, class: usize) -> &str {
        self.classes.get(class).map_or("", String::as_str)
    }
}
