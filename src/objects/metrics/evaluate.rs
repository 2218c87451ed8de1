//! Pairs predictions with truths once, so that they can be counted at any score, and computes all
//! figures of one set of pictures.

use super::mistakes::{Confusion, FalseAlarm, Miss, confusion, false_alarms, misses, shown_images};
use super::precision::{CurvePoint, MatchCounts, average_precision, curve};
use super::ranking::{ANY_SIZE, Ranked, Ranking, Sizes};
use super::{BoxMatching, Image, MetricSettings};
use rayon::prelude::*;

/// Pictures whose boxes are paired. Predictions choose their truths by falling score, so the pairs
/// at a score are those of the whole set down to that score: to move a confidence slider takes a
/// count, not a new pairing.
#[derive(Clone, Debug)]
pub(crate) struct Matched {
    /// Boxes by picture, in the order that the indices of false alarms and misses refer to.
    pub images: Vec<Image>,
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
    pub(crate) fn new(images: &[Image], classes: usize, settings: &MetricSettings) -> Self {
        let images: Vec<Image> =
            images.iter().map(|boxes| ignore_classes_from(boxes, classes)).collect();
        Self {
            rankings: rank(&images, classes, settings, settings.iou, &ANY_SIZE),
            images,
            settings: *settings,
        }
    }

    /// Counts the predictions of at least a score.
    pub(crate) fn at(&self, score: f32) -> AtScore {
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
    pub(crate) fn curve(&self) -> Vec<CurvePoint> {
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
fn rank(
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

fn total(counts: impl Iterator<Item = MatchCounts>) -> MatchCounts {
    counts.fold(MatchCounts::default(), MatchCounts::plus)
}

/// Results for one class.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassReport {
    /// Average precision at the IoU of the settings; NaN without truths.
    pub ap: f64,
    /// Mean of the average precisions at IoU 0.5, 0.55 .. 0.95; NaN without truths.
    pub ap_50_95: f64,
    /// Precision, recall and F1 for every score that occurs, by falling score.
    pub curve: Vec<CurvePoint>,
}

/// Results for the boxes of one range of sizes, all classes together. A truth whose area is exactly
/// a limit counts on both sides of it, as in COCO.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeReport {
    /// Square roots of the smallest and the largest area, pixels; the largest is infinite in the
    /// last range.
    pub side_px: [f64; 2],
    /// Counts at the score of the settings.
    pub counts: MatchCounts,
    /// Mean of the classes' average precisions at the IoU of the settings; NaN without truths.
    pub map: f64,
    /// Mean of the classes' average precisions at IoU 0.5, 0.55 .. 0.95; NaN without truths.
    pub map_50_95: f64,
}

/// Agreement of predictions with truths.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Results for each class.
    pub classes: Vec<ClassReport>,
    /// Counts and mistakes at the score of the settings.
    pub shown: AtScore,
    /// Mean of the classes' `ap`; NaN without truths.
    pub map: f64,
    /// Mean of the classes' `ap_50_95`; NaN without truths.
    pub map_50_95: f64,
    /// Precision, recall and F1 of all classes together, for every score that occurs, by falling
    /// score.
    pub curve: Vec<CurvePoint>,
    /// Results for each range of sizes, from small to large.
    pub sizes: Vec<SizeReport>,
}

impl Evaluation {
    /// Returns these average precisions and curves with the counts, confusion and mistakes of
    /// `shown`. `shown` is the evaluation of the same pictures with only the boxes that an analyst
    /// is shown.
    pub fn counted_as(self, shown: Evaluation) -> Self {
        let sizes = self.sizes.into_iter().zip(shown.sizes);
        let sizes = sizes.map(|(ranked, shown)| SizeReport { counts: shown.counts, ..ranked });
        Self { sizes: sizes.collect(), shown: shown.shown, ..self }
    }
}

/// Measures predictions against truths of `classes` classes; boxes whose class index is not below
/// `classes` are left out.
pub fn evaluate(images: &[Image], classes: usize, settings: &MetricSettings) -> Evaluation {
    let matched = Matched::new(images, classes, settings);
    let images = &matched.images;
    let reports: Vec<ClassReport> = matched
        .rankings
        .iter()
        .zip(ap_50_95(images, classes, settings, &ANY_SIZE))
        .map(|(ranking, ap_50_95)| ClassReport {
            ap: average_precision(ranking, settings.ap),
            ap_50_95,
            curve: curve(&ranking.ranked, ranking.truths),
        })
        .collect();
    Evaluation {
        map: mean(reports.iter().map(|report| report.ap), settings),
        map_50_95: mean(reports.iter().map(|report| report.ap_50_95), settings),
        curve: matched.curve(),
        sizes: sizes(images, classes, settings),
        shown: matched.at(settings.score),
        classes: reports,
    }
}

/// Returns IoU 0.5, 0.55 .. 0.95, computed in the same way as numpy does it, so that an IoU of 3/5
/// is on the same side of its threshold as in numpy.
fn thresholds() -> [f64; 10] {
    let step = (0.95 - 0.5) / 9.0;
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|index| match index {
        9 => 0.95,
        _ => f64::from(index) * step + 0.5,
    })
}

/// Returns the mean over the IoU thresholds of the average precision of each class.
fn ap_50_95(
    images: &[Image],
    classes: usize,
    settings: &MetricSettings,
    sizes: &Sizes,
) -> Vec<f64> {
    let mut sums = vec![0.0; classes];
    for threshold in thresholds() {
        let rankings = rank(images, classes, settings, threshold, sizes);
        for (sum, ranking) in sums.iter_mut().zip(&rankings) {
            *sum += average_precision(ranking, settings.ap);
        }
    }
    let count = thresholds().len() as f64;
    sums.into_iter().map(|sum| sum / count).collect()
}

/// Returns the mean over the classes. The rule in the settings determines whether a class without
/// truths counts as 0 or is left out. NaN where no class has truths.
fn mean(precisions: impl Iterator<Item = f64>, settings: &MetricSettings) -> f64 {
    let all: Vec<f64> = precisions.collect();
    let known = all.iter().filter(|ap| !ap.is_nan());
    let sum: f64 = known.clone().sum();
    let count = match settings.matching {
        BoxMatching::Coco => known.count(),
        BoxMatching::DarknetVoc if known.count() == 0 => 0,
        BoxMatching::DarknetVoc => all.len(),
    };
    sum / count as f64
}

/// Ranges of sizes: square roots of the smallest and the largest area of a box, pixels.
const SIDES_PX: [[f64; 2]; 3] = [[0.0, 32.0], [32.0, 96.0], [96.0, f64::INFINITY]];

fn sizes(images: &[Image], classes: usize, settings: &MetricSettings) -> Vec<SizeReport> {
    let report = |side_px: [f64; 2]| {
        let areas = side_px[0] * side_px[0]..=side_px[1] * side_px[1];
        let rankings = rank(images, classes, settings, settings.iou, &areas);
        let counts = rankings.iter().map(|ranking| MatchCounts::shown(ranking, settings.score));
        let ap = rankings.iter().map(|ranking| average_precision(ranking, settings.ap));
        SizeReport {
            side_px,
            counts: total(counts),
            map: mean(ap, settings),
            map_50_95: mean(ap_50_95(images, classes, settings, &areas).into_iter(), settings),
        }
    };
    SIDES_PX.into_iter().map(report).collect()
}
