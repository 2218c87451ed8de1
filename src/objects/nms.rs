//! Suppresses overlapping boxes: among boxes of the same object, only the one with the highest
//! score is kept, and a vote moves its edges to the mean of all of them.

use super::{Rect, Scored};
use serde::Deserialize;

/// Measure of the overlap of two boxes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OverlapMeasure {
    /// Intersection over union.
    #[default]
    Plain,
    /// Darknet's `greedynms`: `IoU - (d^2 / c^2)^0.6`, with `d` the distance of the centres and `c`
    /// the diagonal of the box around both. Two objects side by side are kept where plain IoU would
    /// drop one.
    Darknet,
}

/// Rule by which boxes are suppressed; by default, plain IoU within each class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Nms {
    /// The measure that is compared with the threshold.
    pub overlap: OverlapMeasure,
    /// True if a box also hides boxes of other classes.
    pub across_classes: bool,
}

impl OverlapMeasure {
    /// Returns the overlap of two boxes; at most their IoU.
    pub fn of(self, a: &Rect, b: &Rect) -> f32 {
        let iou = a.iou(b);
        match self {
            OverlapMeasure::Plain => iou,
            // Boxes that do not overlap never pass a threshold, so that the slow power is computed
            // for others only.
            OverlapMeasure::Darknet if iou > 0.0 => iou - apart(a, b).powf(0.6),
            OverlapMeasure::Darknet => iou,
        }
    }
}

/// Returns the squared distance of the centres over the squared diagonal of the box around both.
fn apart(a: &Rect, b: &Rect) -> f32 {
    let around = a.hull(b);
    let diagonal = (around.x1 - around.x0).powi(2) + (around.y1 - around.y0).powi(2);
    let dx = 0.5 * (a.x0 + a.x1 - b.x0 - b.x1);
    let dy = 0.5 * (a.y0 + a.y1 - b.y0 - b.y1);
    if diagonal > 0.0 { (dx * dx + dy * dy) / diagonal } else { 0.0 }
}

/// Suppresses boxes by greedy non-maximum suppression: the box of the highest score drops every
/// other box that it overlaps by more than `iou` (0 to 1); then the same is done with the next box
/// that is left. On return, `boxes` are sorted by falling score, equal scores in their first order;
/// boxes whose score or edges are not finite are dropped.
pub(crate) fn suppress(boxes: &mut Vec<Scored>, how: Nms, iou: f32) {
    boxes.retain(|proposed| {
        let Rect { x0, y0, x1, y1 } = proposed.rect;
        [proposed.score, x0, y0, x1, y1].iter().all(|value| value.is_finite())
    });
    boxes.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut dropped = overlapped(boxes, how, iou.max(0.0)).into_iter();
    boxes.retain(|_| dropped.next() == Some(false));
}

/// Returns, for each of the sorted boxes, true if a box of a higher score drops it. Two boxes can
/// overlap only if their starts along the track differ by no more than the height of the tallest
/// box, so each box is compared with its neighbours only, even in a long survey.
fn overlapped(boxes: &[Scored], how: Nms, threshold: f32) -> Vec<bool> {
    let start = |index: &usize| boxes[*index].rect.y0;
    let mut by_start: Vec<usize> = (0..boxes.len()).collect();
    by_start.sort_by(|a, b| start(a).total_cmp(&start(b)));
    let heights = boxes.iter().map(|found_box| found_box.rect.y1 - found_box.rect.y0);
    let tallest = heights.fold(0.0, f32::max);

    let mut dropped = vec![false; boxes.len()];
    for (index, kept) in boxes.iter().enumerate() {
        if dropped[index] {
            continue;
        }
        let from = by_start.partition_point(|other| start(other) < kept.rect.y0 - tallest);
        let near = by_start[from..].iter();
        for &other in near.take_while(|other| start(other) < kept.rect.y1) {
            let same = how.across_classes || boxes[other].class == kept.class;
            if other > index && same && !dropped[other] {
                dropped[other] = how.overlap.of(&kept.rect, &boxes[other].rect) > threshold;
            }
        }
    }
    dropped
}

/// Moves each kept box to the mean of the candidates of its class that it overlaps by more than
/// `iou` (0 to 1), edge by edge, weighted by the squared score. A box without such candidates is
/// not moved; scores and classes do not change. Overlaps are computed from the boxes before the
/// vote. `candidates` should include the kept boxes.
///
/// Suppression keeps the box of the highest score in a cluster, whose edges need not be the best:
/// its neighbours show the same object. Box voting (S. Gidaris, N. Komodakis: Object detection via
/// a multi-region and semantic segmentation-aware CNN model, ICCV 2015, section 5) computes the
/// mean of all of them.
pub(crate) fn vote(kept: &mut [Scored], candidates: &[Scored], iou: f32) {
    for kept_box in kept {
        let voters = candidates
            .iter()
            .filter(|other| other.class == kept_box.class && other.rect.iou(&kept_box.rect) > iou);
        if let Some(rect) = mean(voters) {
            kept_box.rect = rect;
        }
    }
}

/// Returns the mean box, weighted by the squared score; `None` if the sum of the weights is 0.
fn mean<'a>(voters: impl Iterator<Item = &'a Scored>) -> Option<Rect> {
    let mut sums = [0.0_f64; 4];
    let mut weights = 0.0;
    for voter in voters {
        let weight = f64::from(voter.score).powi(2);
        let Rect { x0, y0, x1, y1 } = voter.rect;
        for (sum, edge) in sums.iter_mut().zip([x0, y0, x1, y1]) {
            *sum += weight * f64::from(edge);
        }
        weights += weight;
    }
    let [x0, y0, x1, y1] = sums.map(|sum| (sum / weights) as f32);
    // Written so that a NaN gives `None`.
    (weights > 0.0).then_some(Rect { x0, y0, x1, y1 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn scored(class: usize, score: f32, [x0, y0, x1, y1]: [f32; 4]) -> Scored {
        Scored::new(class, score, Rect { x0, y0, x1, y1 })
    }

    fn scores(mut boxes: Vec<Scored>, how: Nms, iou: f32) -> Vec<f32> {
        suppress(&mut boxes, how, iou);
        boxes.iter().map(|kept| kept.score).collect()
    }

    fn flat(class: usize, score: f32, [x0, x1]: [f32; 2]) -> Scored {
        Scored::new(class, score, Rect::new([x0, 0.0], [x1, 1.0]))
    }

    fn voted(kept: Scored, others: &[Scored]) -> [f32; 2] {
        let mut boxes = [kept];
        vote(&mut boxes, &[others, &[kept]].concat(), 0.65);
        assert_eq!((boxes[0].class, boxes[0].score), (kept.class, kept.score));
        [boxes[0].rect.x0, boxes[0].rect.x1]
    }

    #[test]
    fn an_overlap_equal_to_the_threshold_is_kept() {
        // Two boxes of 4 x 2 that share 2 x 2: IoU 1/3.
        let pair = vec![scored(0, 0.5, [2.0, 0.0, 6.0, 2.0]), scored(0, 0.9, [0.0, 0.0, 4.0, 2.0])];
        assert_eq!(scores(pair.clone(), Nms::default(), 1.0 / 3.0), [0.9, 0.5]);
        assert_eq!(scores(pair, Nms::default(), 0.33), [0.9]);
    }

    #[test]
    fn darknet_takes_the_distance_of_the_centres_off() {
        let a = Rect::new([0.0, 0.0], [4.0, 2.0]);
        // d^2 = 4, c^2 = 6^2 + 2^2 = 40: 1/3 - 0.1^0.6 = 0.333333 - 0.251189.
        let measure = OverlapMeasure::Darknet.of(&a, &a.shifted(2.0, 0.0));
        assert!((measure - 0.082_144).abs() < 1e-6, "{measure}");
        assert_eq!(OverlapMeasure::Darknet.of(&a, &a), 1.0);
    }

    #[test]
    fn other_classes_are_hidden_only_when_asked() {
        let edges = [0.0, 0.0, 4.0, 2.0];
        let pair = vec![scored(0, 0.9, edges), scored(1, 0.8, edges)];
        assert_eq!(scores(pair.clone(), Nms::default(), 0.5), [0.9, 0.8]);
        let across = Nms { across_classes: true, ..Nms::default() };
        assert_eq!(scores(pair, across, 0.5), [0.9]);
    }

    #[test]
    fn a_dropped_box_drops_none_and_what_is_not_finite_goes() {
        // Each box overlaps the next by 3/5; the first and the third overlap by 1/3.
        let chain = vec![
            scored(0, 0.9, [0.0, 0.0, 4.0, 1.0]),
            scored(0, 0.8, [1.0, 0.0, 5.0, 1.0]),
            scored(0, 0.7, [2.0, 0.0, 6.0, 1.0]),
            scored(0, f32::NAN, [9.0, 9.0, 10.0, 10.0]),
            scored(0, 0.6, [f32::INFINITY, 9.0, 10.0, 10.0]),
        ];
        assert_eq!(scores(chain, Nms::default(), 0.5), [0.9, 0.7]);
    }

    /// Suppresses boxes by the definition of the rule, without the sweep: in falling order of
    /// score, equal scores in their order.
    fn by_the_book(boxes: &[Scored], how: Nms, iou: f32) -> Vec<Scored> {
        let mut left: Vec<Scored> = boxes.to_vec();
        left.sort_by(|a, b| b.score.partial_cmp(&a.score).expect("finite scores"));
        let mut kept: Vec<Scored> = Vec::new();
        for candidate in left {
            let hidden = kept.iter().any(|surer| {
                (how.across_classes || surer.class == candidate.class)
                    && how.overlap.of(&surer.rect, &candidate.rect) > iou
            });
            if !hidden {
                kept.push(candidate);
            }
        }
        kept
    }

    fn any_box() -> impl Strategy<Value = Scored> {
        let edge = || (0_u8..40).prop_map(f32::from);
        (0_usize..3, 0_u8..12, edge(), edge(), 0_u8..15, 0_u8..15).prop_map(
            |(class, score, x, y, width, height)| {
                let (right, bottom) = (x + f32::from(width), y + f32::from(height));
                scored(class, f32::from(score) / 12.0, [x, y, right, bottom])
            },
        )
    }

    proptest! {
        #[test]
        fn the_sweep_keeps_what_the_rule_keeps(
            boxes in prop::collection::vec(any_box(), 0..120),
            iou in 0.0_f32..0.9,
            darknet: bool,
            across_classes: bool,
        ) {
            let overlap = if darknet { OverlapMeasure::Darknet } else { OverlapMeasure::Plain };
            let how = Nms { overlap, across_classes };
            let mut kept = boxes.clone();
            suppress(&mut kept, how, iou);
            prop_assert_eq!(kept, by_the_book(&boxes, how, iou));
        }
    }

    #[test]
    fn edges_become_the_mean_weighted_by_the_squared_score() {
        let kept = flat(0, 0.8, [0.0, 10.0]);
        // The voter shares 9 of 11 and weighs 0.16 against 0.64: the edges move by a fifth of the 1
        // between them.
        let [x0, x1] = voted(kept, &[flat(0, 0.4, [1.0, 11.0])]);
        assert!((x0 - 0.2).abs() < 1e-6 && (x1 - 10.2).abs() < 1e-5, "{x0} {x1}");
        // A third voter shares 8 of 10 and weighs 0.04: (0.16 + 0.08) / 0.84 and (6.4 + 1.76 + 0.4)
        // / 0.84.
        let others = [flat(0, 0.4, [1.0, 11.0]), flat(0, 0.2, [2.0, 10.0])];
        let [x0, x1] = voted(kept, &others);
        assert!((x0 - 0.285_714).abs() < 1e-6 && (x1 - 10.190_476).abs() < 1e-5, "{x0} {x1}");
    }

    #[test]
    fn other_classes_and_boxes_apart_have_no_vote() {
        let kept = flat(0, 0.8, [0.0, 10.0]);
        // The first box is of another class, the second shares 6 of 14, the third shares 6.5 of 10,
        // which is not above 0.65.
        let others =
            [flat(1, 0.8, [1.0, 11.0]), flat(0, 0.7, [4.0, 14.0]), flat(0, 0.7, [3.5, 10.0])];
        assert_eq!(voted(kept, &others), [0.0, 10.0]);
    }

    #[test]
    fn what_weighs_nothing_moves_nothing() {
        let mut boxes = [flat(0, 0.0, [0.0, 10.0])];
        let candidates = boxes;
        vote(&mut boxes, &candidates, 0.65);
        assert_eq!(boxes, candidates);
        let odd = [flat(0, f32::NAN, [0.0, 10.0])];
        vote(&mut boxes, &odd, 0.65);
        assert_eq!(boxes, candidates);
    }

    #[test]
    fn a_vote_looks_at_the_boxes_as_they_were() {
        // In a chain, each box overlaps the next but not the one after it: a box that has moved
        // must not reach farther.
        let chain = [[0.0, 10.0], [2.0, 12.0], [4.0, 14.0]].map(|edges| flat(0, 0.5, edges));
        let mut boxes = chain;
        vote(&mut boxes, &chain, 0.65);
        let left = boxes.map(|found_box| found_box.rect.x0);
        assert_eq!(left, [1.0, 2.0, 3.0]);
    }
}
