//! Compares the boxes of a review with the truth.

use super::RasterTruth;
use crate::metrics::{AtScore, Cause, Confusion, CurvePoint, MatchCounts, Matched, MetricSettings};
use crate::review::{BoxId, Review};
use crate::{NAMELESS_CLASS, Raster, Rect, Scored};

/// Boxes of the model, paired with the truth at every score, whatever the decision about them.
/// Boxes without a score, which no model has found, are left out.
#[derive(Clone, Debug)]
pub struct TruthComparison {
    on_raster: RasterTruth,
    /// Class names: those of the review, then those that only the truth has.
    classes: Vec<String>,
    /// Paired boxes; the two sides are two pictures.
    pub(super) matched: Matched,
    boxes: [Vec<BoxId>; 2],
    /// Number of objects that do not count only because no search has covered their pings.
    unsearched: usize,
    curve: Vec<CurvePoint>,
    pixel_m: f64,
}

/// A mistake to examine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// A box that found no object.
    FalseAlarm {
        /// Number of the box.
        id: BoxId,
        /// Score of the box.
        score: f32,
        /// Cause of the false alarm.
        cause: Cause,
        /// Longer side of the box, metres.
        size_m: f64,
    },
    /// An object that no box found.
    Miss {
        /// Index into the truth's objects.
        object: usize,
        /// Longer side of the object's box, metres.
        size_m: f64,
    },
}

impl Mistake {
    /// Returns the longer side of the box, metres.
    pub fn size_m(&self) -> f64 {
        match self {
            Mistake::FalseAlarm { size_m, .. } | Mistake::Miss { size_m, .. } => *size_m,
        }
    }
}

/// Result of the comparison for the boxes of at least a score.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Least score of the boxes.
    pub score: f32,
    /// Counts of found, false and missed, all classes together.
    pub counts: MatchCounts,
    /// Boxes by true and by predicted class, with the names in [`TruthComparison::classes`].
    pub confusion: Confusion,
    /// False alarms by falling score, then misses by falling size.
    pub mistakes: Vec<Mistake>,
}

impl TruthComparison {
    /// Pairs the boxes with the truth, by Darknet's rule at IoU 0.5, in the raster's pixels, each
    /// side by itself. Classes are compared by name; a box of unknown class gets the class of the
    /// object that it overlaps most. Objects and boxes in pings that the review's searches have not
    /// covered are left out: an object is not missed where there was no search.
    pub fn new(review: &Review, mut on_raster: RasterTruth, raster: &Raster) -> Self {
        let gaps = review.unsearched();
        let unsearched = on_raster.ignore(|whole| Review::reaches_into(&gaps, whole));
        let mut classes = review.classes().to_vec();
        let mut images = on_raster.images(&mut classes);
        let mut boxes = [Vec::new(), Vec::new()];
        for review_box in
            review.boxes().filter(|review_box| !Review::reaches_into(&gaps, &review_box.mark))
        {
            let Some(score) = review_box.score else {
                continue;
            };
            let side = review_box.mark.side as usize;
            boxes[side].push(review_box.id);
            let rect = raster.rect_of(&review_box.mark);
            images[side].predicted.push(Scored::new(review_box.class, score, rect));
        }
        if let Some(nameless) = classes.iter().position(|name| name == NAMELESS_CLASS) {
            for image in &mut images {
                image.name_by_truth(nameless);
            }
        }
        let matched = Matched::new(&images, classes.len(), &MetricSettings::darknet());
        Self {
            curve: matched.curve(),
            matched,
            on_raster,
            classes,
            boxes,
            unsearched,
            pixel_m: raster.pixel_m(),
        }
    }

    /// Returns the class names, in the order of the confusion's indices.
    pub fn classes(&self) -> &[String] {
        &self.classes
    }

    /// Returns precision and recall for every score that occurs, by falling score.
    pub fn curve(&self) -> &[CurvePoint] {
        &self.curve
    }

    /// Returns the truth that boxes are compared with.
    pub fn truth(&self) -> &super::SurveyTruth {
        &self.on_raster.truth
    }

    /// Returns the number of visible objects that do not count, because no search has covered them.
    pub fn unsearched(&self) -> usize {
        self.unsearched
    }

    /// Returns the number of objects that count: the visible ones in searched pings.
    pub fn counted(&self) -> usize {
        let all = self.on_raster.sides.iter().flatten();
        all.filter(|(truth, _)| !truth.ignored).count()
    }

    /// Returns the result of the boxes of at least a score.
    pub fn at(&self, score: f32) -> Standing {
        let AtScore { counts, confusion, false_alarms, misses, .. } = self.matched.at(score);
        let images = self.matched.images();
        let size_m =
            |rect: &Rect| f64::from((rect.x1 - rect.x0).max(rect.y1 - rect.y0)) * self.pixel_m;
        let mut mistakes: Vec<Mistake> = false_alarms
            .iter()
            .map(|alarm| {
                let predicted = &images[alarm.image].predicted[alarm.predicted];
                Mistake::FalseAlarm {
                    id: self.boxes[alarm.image][alarm.predicted],
                    score: predicted.score,
                    cause: alarm.cause,
                    size_m: size_m(&predicted.rect),
                }
            })
            .collect();
        let first_miss = mistakes.len();
        mistakes.extend(misses.iter().map(|miss| Mistake::Miss {
            object: self.on_raster.sides[miss.image][miss.truth].1,
            size_m: size_m(&images[miss.image].truth[miss.truth].rect),
        }));
        mistakes[first_miss..].sort_by(|a, b| b.size_m().total_cmp(&a.size_m()));
        Standing { score, counts, confusion, mistakes }
    }
}
