//! A review's boxes against the truth.

use super::RasterTruth;
use crate::metrics::{AtScore, Cause, Confusion, CurvePoint, MatchCounts, Matched, MetricSettings};
use crate::review::{BoxId, Review, Reviewed};
use crate::{NAMELESS_CLASS, Raster, Rect, Scored};
use bathyscope_log::survey::Side;

/// Boxes paired with the truth at every score: the model's, whatever was decided about them. Boxes
/// that no model has seen have no score and are left out.
#[derive(Clone, Debug)]
pub struct TruthComparison {
    on_raster: RasterTruth,
    /// Class names: those of the review, then those that only the truth has.
    classes: Vec<String>,
    /// The two sides as pictures.
    pub(super) matched: Matched,
    boxes: [Vec<BoxId>; 2],
    /// Objects that would count, had a search come to them.
    unsearched: usize,
    curve: Vec<CurvePoint>,
    pixel_m: f64,
}

/// Mistake to examine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// A box that found nothing.
    FalseAlarm {
        /// The box.
        id: BoxId,
        /// Its confidence.
        score: f32,
        /// Cause of the false alarm.
        cause: Cause,
        /// Its longer side, metres.
        size_m: f64,
    },
    /// An object that no box found.
    Miss {
        /// Index into the truth's objects.
        object: usize,
        /// The longer side of its box, metres.
        size_m: f64,
    },
}

impl Mistake {
    /// Longer side of the box, metres.
    pub fn size_m(&self) -> f64 {
        match self {
            Mistake::FalseAlarm { size_m, .. } | Mistake::Miss { size_m, .. } => *size_m,
        }
    }
}

/// Result of the boxes of at least a score.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// The score.
    pub score: f32,
    /// Found, false and missed, all classes together.
    pub counts: MatchCounts,
    /// Boxes by true and by proposed class, with the names in [`TruthComparison::classes`].
    pub confusion: Confusion,
    /// False alarms by falling score, then misses by falling size.
    pub mistakes: Vec<Mistake>,
}

impl TruthComparison {
    /// Pairs the boxes with the truth: Darknet's rule at IoU 0.5, in the raster's pixels, side by
    /// side. Classes are the same when their names are; a box without a name is of the class of the
    /// object that it lies on. Objects and boxes in pings that the review's search has not come to
    /// are left out: nobody has missed what nobody has looked for.
    pub fn new(review: &Review, mut on_raster: RasterTruth, raster: &Raster) -> Self {
        let gaps = review.unsearched();
        let unsearched = on_raster.ignore(|whole| Review::reaches_into(&gaps, whole));
        let mut classes = review.classes().to_vec();
        let mut images = on_raster.images(&mut classes);
        let mut boxes = [Vec::new(), Vec::new()];
        for (index, side) in Side::BOTH.into_iter().enumerate() {
            let of_side =
                |one: &&Reviewed| one.mark.side == side && !Review::reaches_into(&gaps, &one.mark);
            for (one, score) in
                (review.boxes().filter(of_side)).filter_map(|one| Some((one, one.score?)))
            {
                boxes[index].push(one.id);
                images[index].predicted.push(Scored::new(
                    one.class,
                    score,
                    raster.rect_of(&one.mark),
                ));
            }
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

    /// Class names, as the confusion counts them.
    pub fn classes(&self) -> &[String] {
        &self.classes
    }

    /// Precision and recall for every score that occurs, falling.
    pub fn curve(&self) -> &[CurvePoint] {
        &self.curve
    }

    /// The truth that boxes are compared with.
    pub fn truth(&self) -> &super::SurveyTruth {
        self.on_raster.truth()
    }

    /// Objects that can be seen and do not count, because no search has come to them.
    pub fn unsearched(&self) -> usize {
        self.unsearched
    }

    /// Objects that count: those that can be seen, where a search has come to.
    pub fn counted(&self) -> usize {
        let all = self.on_raster.sides.iter().flatten();
        all.filter(|(one, _)| !one.ignored).count()
    }

    /// Returns the result of the boxes of at least a score.
    pub fn at(&self, score: f32) -> Standing {
        let AtScore { counts, confusion, false_alarms, misses, .. } = self.matched.at(score);
        let images = self.matched.images();
        let size_m =
            |rect: &Rect| f64::from((rect.x1 - rect.x0).max(rect.y1 - rect.y0)) * self.pixel_m;
        let mut mistakes: Vec<Mistake> = false_alarms
            .iter()
            .map(|one| {
                let predicted = &images[one.image].predicted[one.predicted];
                Mistake::FalseAlarm {
                    id: self.boxes[one.image][one.predicted],
                    score: predicted.score,
                    cause: one.cause,
                    size_m: size_m(&predicted.rect),
                }
            })
            .collect();
        let first_miss = mistakes.len();
        mistakes.extend(misses.iter().map(|one| Mistake::Miss {
            object: self.on_raster.sides[one.image][one.truth].1,
            size_m: size_m(&images[one.image].truth[one.truth].rect),
        }));
        mistakes[first_miss..].sort_by(|a, b| b.size_m().total_cmp(&a.size_m()));
        Standing { score, counts, confusion, mistakes }
    }
}
