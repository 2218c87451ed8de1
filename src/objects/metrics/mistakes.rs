//! Lists the mistakes to examine, every false alarm and every miss, and counts the boxes by true
//! and by predicted class.

use super::ranking::{MatchOutcome, Ranked};
use super::{Image, MetricSettings, TrueBox, iou};
use crate::{Rect, Scored};
use bathyscope_log::named;

/// Cause of a false alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// There is no object at the box.
    Background,
    /// An object of the same class is there and was found by a box of a higher score.
    Duplicate,
    /// There is an object of another class at the box.
    OtherClass,
    /// An object of the same class is near, but the box overlaps it too little.
    Loose,
}

named! {
    /// All causes, in the order of tables.
    pub Cause {
        Background: "background",
        Duplicate: "duplicate",
        OtherClass: "other class",
        Loose: "loose box",
    }
}

/// A prediction of at least the least score that found no truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseAlarm {
    /// Index of the picture.
    pub image: usize,
    /// Index into the predictions of this picture.
    pub predicted: usize,
    /// Cause of the false alarm.
    pub cause: Cause,
}

/// A truth that no prediction of at least the least score found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Miss {
    /// Index of the picture.
    pub image: usize,
    /// Index into the truths of this picture.
    pub truth: usize,
}

/// Hits and false alarms among the boxes of at least the score, in one picture.
#[derive(Debug)]
pub(super) struct ShownImage {
    /// True for each truth that was found, in the order of the picture's truths.
    pub found: Vec<bool>,
    /// Indices of the predictions that found no truth, by falling score.
    pub false_alarms: Vec<usize>,
}

/// Sorts the shown predictions of all classes by picture.
pub(super) fn shown_images<'a>(
    images: &[Image],
    shown: impl Iterator<Item = &'a Ranked>,
) -> Vec<ShownImage> {
    let none = |boxes: &Image| ShownImage {
        found: vec![false; boxes.truth.len()],
        false_alarms: Vec::new(),
    };
    let mut sorted: Vec<ShownImage> = images.iter().map(none).collect();
    for ranked in shown {
        let image = &mut sorted[ranked.image];
        match ranked.outcome {
            MatchOutcome::Hit { truth, .. } => image.found[truth] = true,
            _ => image.false_alarms.push(ranked.predicted),
        }
    }
    for (image, boxes) in sorted.iter_mut().zip(images) {
        let score = |index: &usize| boxes.predicted[*index].score;
        image.false_alarms.sort_by(|a, b| score(b).total_cmp(&score(a)));
    }
    sorted
}

/// Returns every false alarm with its cause, by falling score.
pub(super) fn false_alarms(
    images: &[Image],
    shown: &[ShownImage],
    settings: &MetricSettings,
) -> Vec<FalseAlarm> {
    let mut all: Vec<FalseAlarm> = Vec::new();
    for (image, (boxes, shown)) in images.iter().zip(shown).enumerate() {
        all.extend(shown.false_alarms.iter().map(|&predicted| FalseAlarm {
            image,
            predicted,
            cause: cause(boxes, predicted, settings),
        }));
    }
    let score = |alarm: &FalseAlarm| images[alarm.image].predicted[alarm.predicted].score;
    all.sort_by(|a, b| score(b).total_cmp(&score(a)));
    all
}

/// Returns every miss, picture by picture.
pub(super) fn misses(images: &[Image], shown: &[ShownImage]) -> Vec<Miss> {
    let mut all = Vec::new();
    for (image, (boxes, shown)) in images.iter().zip(shown).enumerate() {
        let missed = (0..boxes.truth.len())
            .filter(|&truth| !shown.found[truth] && !boxes.truth[truth].ignored);
        all.extend(missed.map(|truth| Miss { image, truth }));
    }
    all
}

/// Least overlap (IoU) of a box that is near an object.
const NEAR_IOU: f64 = 0.1;

fn cause(boxes: &Image, predicted: usize, settings: &MetricSettings) -> Cause {
    let predicted_box = &boxes.predicted[predicted];
    let best = |same_class: bool| {
        let of_interest = boxes
            .truth
            .iter()
            .filter(|truth| !truth.ignored && (truth.class == predicted_box.class) == same_class);
        let overlap = |rect: &Rect| iou(&predicted_box.rect, rect, false);
        of_interest.fold(0.0, |best, truth| f64::max(best, overlap(&truth.rect)))
    };
    let (own, other) = (best(true), best(false));
    if settings.matching.passes(own, settings.iou) {
        Cause::Duplicate
    } else if settings.matching.passes(other, settings.iou) {
        Cause::OtherClass
    } else if own >= NEAR_IOU {
        Cause::Loose
    } else {
        Cause::Background
    }
}

/// Boxes by their true class (rows) and their predicted class (columns), at the score and IoU of
/// the settings. The last index is the background: the last row counts predictions that overlap no
/// truth (or a truth that another prediction has found), the last column counts truths that no
/// prediction has found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confusion {
    /// Number of classes; this number as an index is the background.
    pub classes: usize,
    cells: Vec<usize>,
}

impl Confusion {
    fn new(classes: usize) -> Self {
        Self { classes, cells: vec![0; (classes + 1) * (classes + 1)] }
    }

    /// Returns the number of boxes of the class `truth` that were predicted as `predicted`.
    ///
    /// # Panics
    /// When the cell is beyond the last one, as when `truth` is above the background.
    pub fn at(&self, truth: usize, predicted: usize) -> usize {
        self.cells[truth * (self.classes + 1) + predicted]
    }

    /// Returns the rows, one for each true class, the background last.
    pub fn rows(&self) -> impl Iterator<Item = &[usize]> {
        self.cells.chunks(self.classes + 1)
    }

    fn count(&mut self, truth: usize, predicted: usize) {
        self.cells[truth * (self.classes + 1) + predicted] += 1;
    }
}

/// Counts the predictions that are shown. The pairs of the matching within each class are on the
/// diagonal. Each remaining prediction, by falling score, is paired with the truth of another class
/// that it overlaps most, if the overlap passes the threshold.
pub(super) fn confusion(
    images: &[Image],
    shown: &[ShownImage],
    classes: usize,
    settings: &MetricSettings,
) -> Confusion {
    let mut confusion = Confusion::new(classes);
    for (boxes, shown) in images.iter().zip(shown) {
        let mut free: Vec<&TrueBox> = Vec::new();
        for (truth, &found) in boxes.truth.iter().zip(&shown.found) {
            if found {
                confusion.count(truth.class, truth.class);
            } else if !truth.ignored {
                free.push(truth);
            }
        }
        for &index in &shown.false_alarms {
            let predicted = &boxes.predicted[index];
            let mistaken = mistaken(predicted, &free, settings);
            let truth = mistaken.map_or(classes, |index| free.swap_remove(index).class);
            confusion.count(truth, predicted.class);
        }
        for missed in free {
            confusion.count(missed.class, classes);
        }
    }
    confusion
}

/// Returns the index of the truth of another class that a prediction overlaps most, if the overlap
/// passes the threshold.
fn mistaken(predicted: &Scored, free: &[&TrueBox], settings: &MetricSettings) -> Option<usize> {
    let others = free.iter().enumerate().filter(|(_, truth)| truth.class != predicted.class);
    others
        .map(|(index, truth)| (index, iou(&predicted.rect, &truth.rect, false)))
        .filter(|&(_, iou)| settings.matching.passes(iou, settings.iou))
        .max_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(index, _)| index)
}
