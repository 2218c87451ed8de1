//! Adds the detections of a new model to a review that may hold decisions.

use super::{BoxId, Review, Reviewed, State, held};
use crate::{Detection, Raster, Rect, class_index};
use bathyscope_log::survey::{Identity, Side};
use std::ops::Range;
use std::sync::Arc;

/// Overlap from which two boxes show the same object, intersection over union.
const SAME: f32 = 0.5;

impl Review {
    /// Creates the review of a log from the boxes that a model found: all are proposals, numbered
    /// from `first`. `names` are the classes that the class indices of `found` refer to.
    pub fn of_found(
        identity: Identity,
        names: &[String],
        first: u32,
        found: &[Detection],
    ) -> Review {
        let boxes = (first..).zip(found).map(|(id, detection)| {
            Arc::new(Reviewed {
                score: Some(detection.score),
                state: State::Proposed,
                ..Reviewed::drawn(BoxId(id), detection.mark.clone(), detection.class)
            })
        });
        Review {
            boxes: boxes.collect(),
            next_id: first + found.len() as u32,
            ..Review::new(identity, names.to_vec())
        }
    }

    /// Returns the review with `detections`, from a search of the pings `pings`, as proposals.
    /// Boxes that the analyst accepted, rejected, added or corrected stay; a detection that
    /// overlaps such a box on its side (IoU of at least 0.5 in the raster's pixels) is not added,
    /// but its score becomes the score of that box. Undecided boxes in these pings are replaced;
    /// one that the model finds again keeps its number. Undecided boxes elsewhere stay, because
    /// they were not searched again. New class names are appended; `classes` are the names that the
    /// detections' class indices refer to.
    pub fn adopt(
        &self,
        model: &str,
        classes: &[String],
        detections: &[Detection],
        raster: &Raster,
        pings: Range<usize>,
    ) -> Review {
        let is_elsewhere = |review_box: &Reviewed| {
            review_box.mark.pings.start < pings.start || review_box.mark.pings.end > pings.end
        };
        let mut after = self.clone();
        let stays = |review_box: &Arc<Reviewed>| review_box.is_kept() || is_elsewhere(review_box);
        let (kept, open): (Vec<_>, Vec<_>) = after.boxes.into_iter().partition(stays);
        after.boxes = kept;
        let class_of: Vec<usize> =
            (classes.iter()).map(|name| class_index(&mut after.classes, name)).collect();
        let decided = Places::of(&after.boxes, raster);
        let mut earlier = Places::of(&open, raster);
        let mut lent = vec![None; after.boxes.len()];
        let model: Arc<str> = model.into();
        after.note_search(&model, pings);
        for detection in detections {
            let (Some(mark), Some(&class)) =
                (held(&detection.mark, self.identity.pings), class_of.get(detection.class))
            else {
                continue;
            };
            let rect = raster.rect_of(&mark);
            if let Some(index) = decided.nearest(mark.side, &rect) {
                let best = lent[index].get_or_insert(detection.score);
                *best = best.max(detection.score);
                continue;
            }
            let id = match earlier.take_nearest(mark.side, &rect) {
                Some(index) => open[index].id,
                None => after.take_id(),
            };
            after.boxes.push(Arc::new(Reviewed {
                score: Some(detection.score),
                state: State::Proposed,
                model: Some(model.clone()),
                ..Reviewed::drawn(id, mark, class)
            }));
        }
        for (review_box, score) in after.boxes.iter_mut().zip(lent) {
            if score.is_some() && review_box.score != score {
                Arc::make_mut(review_box).score = score;
            }
        }
        after.boxes.sort_unstable_by_key(|review_box| review_box.id);
        after
    }
}

/// Boxes of each side, sorted by their first row, so that only neighbours need to be compared.
struct Places {
    sides: [Vec<(Rect, usize)>; 2],
    tallest: f32,
}

impl Places {
    fn of(boxes: &[Arc<Reviewed>], raster: &Raster) -> Self {
        let mut places = Self { sides: [Vec::new(), Vec::new()], tallest: 0.0 };
        for (index, review_box) in boxes.iter().enumerate() {
            let rect = raster.rect_of(&review_box.mark);
            places.tallest = places.tallest.max(rect.y1 - rect.y0);
            places.sides[review_box.mark.side as usize].push((rect, index));
        }
        for side in &mut places.sides {
            side.sort_by(|(a, _), (b, _)| a.y0.total_cmp(&b.y0));
        }
        places
    }

    /// Returns the place in the list of the box with the greatest overlap; `None` if no box
    /// overlaps by [`SAME`] or more.
    fn find(&self, side: Side, rect: &Rect) -> Option<usize> {
        let list = &self.sides[side as usize];
        let from = list.partition_point(|(other, _)| other.y0 < rect.y0 - self.tallest);
        let near = list.iter().enumerate().skip(from);
        near.take_while(|(_, (other, _))| other.y0 <= rect.y1)
            .map(|(place, (other, _))| (place, rect.iou(other)))
            .filter(|(_, iou)| *iou >= SAME)
            .max_by(|(_, a), (_, b)| a.total_cmp(b))
            .map(|(place, _)| place)
    }

    fn nearest(&self, side: Side, rect: &Rect) -> Option<usize> {
        let place = self.find(side, rect)?;
        Some(self.sides[side as usize][place].1)
    }

    /// Removes the box that `nearest` returns, so that it is not found again, and returns its
    /// index.
    fn take_nearest(&mut self, side: Side, rect: &Rect) -> Option<usize> {
        let place = self.find(side, rect)?;
        Some(self.sides[side as usize].remove(place).1)
    }
}
