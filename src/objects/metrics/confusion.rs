//! Counts the boxes by true and by predicted class.

use super::mistakes::ShownImage;
use super::{Image, MetricSettings, TrueBox, iou};
use crate::Scored;

/// Boxes by their true class (rows) and their predicted class (columns), at the score and IoU of
/// the settings. The last index is the background: the last row counts predictions that overlap no
/// truth (or a truth that another prediction has found), the last column counts truths that no
/// prediction has found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confusion {
    classes: usize,
    cells: Vec<usize>,
}

impl Confusion {
    fn new(classes: usize) -> Self {
        Self { classes, cells: vec![0; (classes + 1) * (classes + 1)] }
    }

    /// Returns the number of classes; this number as an index is the background.
    pub fn classes(&self) -> usize {
        self.classes
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
