//! Pairs predictions with truths once, so that they can be counted at any score.

use super::mistakes::{Confusion, FalseAlarm, Miss, confusion, false_alarms, misses, shown_images};
use super::precision::{CurvePoint, MatchCounts, curve};
use super::ranking::{ANY_SIZE, Ranked, Ranking, Sizes};
use super::{Image, MetricSettings};
use rayon::prelude::*;

/// Pictures whose boxes are paired. Predictions choose their truths by falling score, so the pairs
/// at a score are those of the whole set down to that score: to move a confidence slider takes a
/// count, not a new pairing.
#[derive(Clone, Debug)]
pub struct Matched {
    images: Vec<Image>,
    rankings: Vec<Ranking>,
    settings: MetricSettings,
}

/// Counts and mistakes of the boxes of at least a score.
#[derive(Clone, Debug, PartialEq)]
pub struct AtScore {
    /// Counts of each class.
    pub classes: Vec<MatchCounts>,
    /// Counts of all classes together.
    pub counts: MatchCounts,
    /// Boxes by true and by predicted class.
    pub confusion: Confusion,
    /// False alarms, by falling score.
    pub false_alarms: Vec<FalseAlarm>,
    /// Misses, picture by picture.
    pub misses: Vec<Miss>,
}

impl Matched {
    /// Pairs predictions with truths of `classes` classes at the IoU of the settings; boxes whose
    /// class index is not below `classes` are left out.
    pub fn new(images: &[Image], classes: usize, settings: &MetricSettings) -> Self {
        let images: Vec<Image> =
            images.iter().map(|boxes| ignore_classes_from(boxes, classes)).collect();
        Self {
            rankings: rank(&images, classes, settings, settings.iou, &ANY_SIZE),
            images,
            settings: settings.clone(),
        }
    }

    /// Returns the boxes by picture, in the order that the indices of false alarms and misses refer
    /// to.
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    pub(super) fn rankings(&self) -> &[Ranking] {
        &self.rankings
    }

    /// Counts the predictions of at least a score.
    pub fn at(&self, score: f32) -> AtScore {
        let classes: Vec<MatchCounts> =
            self.rankings.iter().map(|ranking| MatchCounts::shown(ranking, score)).collect();
        let shown = self.rankings.iter().flat_map(|ranking| ranking.shown(score));
        let shown = shown_images(&self.images, shown);
        AtScore {
            counts: total(classes.iter().copied()),
            confusion: confusion(&self.images, &shown, classes.len(), &self.settings),
            false_alarms: false_alarms(&self.images, &shown, &self.settings),
            misses: misses(&self.images, &shown),
            classes,
        }
    }

    /// Returns precision, recall and F1 of all classes together, for every score that occurs, by
    /// falling score.
    pub fn curve(&self) -> Vec<CurvePoint> {
        let all = self.rankings.iter().flat_map(|ranking| &ranking.ranked);
        let mut all: Vec<Ranked> = all.copied().collect();
        all.sort_by(|a, b| b.score.total_cmp(&a.score));
        let truths = self.rankings.iter().map(|ranking| ranking.truths).sum();
        curve(&all, truths)
    }
}

/// Returns a copy whose truths of classes from `classes` on are ignored. They are not removed,
/// because the indices of the boxes must stay.
fn ignore_classes_from(boxes: &Image, classes: usize) -> Image {
    let mut boxes = boxes.clone();
    for truth in &mut boxes.truth {
        truth.ignored |= truth.class >= classes;
    }
    boxes
}

/// Pairs and sorts the boxes of each class.
pub(super) fn rank(
    images: &[Image],
    classes: usize,
    settings: &MetricSettings,
    threshold: f64,
    sizes: &Sizes,
) -> Vec<Ranking> {
    (0..classes)
        .into_par_iter()
        .map(|class| Ranking::new(images, class, settings, threshold, sizes))
        .collect()
}

pub(super) fn total(counts: impl Iterator<Item = MatchCounts>) -> MatchCounts {
    counts.fold(MatchCounts::default(), MatchCounts::plus)
}
