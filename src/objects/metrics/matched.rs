//! Predictions paired with truths once, to be counted at any score.

use super::confusion::{Confusion, confusion};
use super::mistakes::{FalseAlarm, Miss, ShownImages};
use super::precision::{CurvePoint, MatchCounts, curve};
use super::ranking::{ANY_SIZE, Ranked, Ranking, Sizes};
use super::{Image, MetricSettings};
use rayon::prelude::*;

/// Pictures whose boxes are paired. The pairs of a score are those of the whole set down to that
/// score, because predictions choose by falling score: a confidence slider costs a count, not a
/// pairing.
#[derive(Clone, Debug)]
pub struct Matched {
    images: Vec<Image>,
    rankings: Vec<Ranking>,
    settings: MetricSettings,
}

/// Result of the boxes of at least a score.
#[derive(Clone, Debug, PartialEq)]
pub struct AtScore {
    /// One entry a class.
    pub classes: Vec<MatchCounts>,
    /// All classes together.
    pub counts: MatchCounts,
    /// Boxes by true and by proposed class.
    pub confusion: Confusion,
    /// False alarms, by falling score.
    pub false_alarms: Vec<FalseAlarm>,
    /// Misses, picture by picture.
    pub misses: Vec<Miss>,
}

impl Matched {
    /// Pairs predictions with truths of `classes` classes at the IoU of the settings; boxes of
    /// classes beyond that are left out.
    pub fn new(images: &[Image], classes: usize, settings: &MetricSettings) -> Self {
        let images: Vec<Image> = images.iter().map(|boxes| within(boxes, classes)).collect();
        Self {
            rankings: rank(&images, classes, settings, settings.iou, &ANY_SIZE),
            images,
            settings: settings.clone(),
        }
    }

    /// The boxes, in the order in which false alarms and misses name them.
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    pub(super) fn rankings(&self) -> &[Ranking] {
        &self.rankings
    }

    /// Counts what is shown from a score on.
    pub fn at(&self, score: f32) -> AtScore {
        let of_class = |ranking: &Ranking| MatchCounts::of(ranking.shown(score), ranking.truths);
        let classes: Vec<MatchCounts> = self.rankings.iter().map(of_class).collect();
        let shown = self.rankings.iter().flat_map(|ranking| ranking.shown(score));
        let shown = ShownImages::new(&self.images, shown);
        AtScore {
            counts: total(classes.iter().copied()),
            confusion: confusion(&self.images, &shown, classes.len(), &self.settings),
            false_alarms: shown.false_alarms(&self.images, &self.settings),
            misses: shown.misses(&self.images),
            classes,
        }
    }

    /// Precision, recall and F1 of all classes as one, for every score, falling.
    pub fn curve(&self) -> Vec<CurvePoint> {
        let all = self.rankings.iter().flat_map(|ranking| &ranking.ranked);
        let mut all: Vec<Ranked> = all.copied().collect();
        all.sort_by(|a, b| b.score.total_cmp(&a.score));
        let truths = self.rankings.iter().map(|ranking| ranking.truths).sum();
        curve(&all, truths)
    }
}

/// The boxes whose class is known. Indices must stay, so that a box of no class becomes one that
/// nothing looks at.
fn within(boxes: &Image, classes: usize) -> Image {
    let mut boxes = boxes.clone();
    for truth in &mut boxes.truth {
        truth.ignored |= truth.class >= classes;
    }
    boxes
}

/// One entry a class.
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
