//! Determines the edges of an object from all boxes that propose it.
//!
//! Suppression keeps the surest box of a cluster, whose edges need not be the best: its neighbours
//! saw the same object. Box voting (S. Gidaris, N. Komodakis: Object detection via a multi-region
//! and semantic segmentation-aware CNN model, ICCV 2015, section 5) takes the mean of all of them.

use super::{Rect, Scored};

/// Moves each kept box to the mean of the candidates of its class that it overlaps by more than
/// `iou` (0 to 1), edge by edge, weighted by the squared score. A box without such candidates
/// stays; scores and classes stay as they are. All overlaps are those before the vote. `candidates`
/// should hold the kept boxes, too.
pub(crate) fn vote(kept: &mut [Scored], candidates: &[Scored], iou: f32) {
    for one in kept {
        let voters = candidates
            .iter()
            .filter(|other| other.class == one.class && other.rect.iou(&one.rect) > iou);
        if let Some(rect) = mean(voters) {
            one.rect = rect;
        }
    }
}

/// The mean box, weighted by the squared score; `None` where nothing weighs.
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
    // Written so that a NaN does not weigh.
    (weights > 0.0).then_some(Rect { x0, y0, x1, y1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(class: usize, score: f32, [x0, x1]: [f32; 2]) -> Scored {
        Scored::new(class, score, Rect::new([x0, 0.0], [x1, 1.0]))
    }

    fn voted(kept: Scored, others: &[Scored]) -> [f32; 2] {
        let mut boxes = [kept];
        vote(&mut boxes, &[others, &[kept]].concat(), 0.65);
        assert_eq!((boxes[0].class, boxes[0].score), (kept.class, kept.score));
        [boxes[0].rect.x0, boxes[0].rect.x1]
    }

    #[test]
    fn edges_become_the_mean_weighted_by_the_squared_score() {
        let kept = scored(0, 0.8, [0.0, 10.0]);
        // Shares 9 of 11, weighs 0.16 against 0.64: a fifth of its metre on either side.
        let [x0, x1] = voted(kept, &[scored(0, 0.4, [1.0, 11.0])]);
        assert!((x0 - 0.2).abs() < 1e-6 && (x1 - 10.2).abs() < 1e-5, "{x0} {x1}");
        // With a third that shares 8 of 10 and weighs 0.04: (0.16 + 0.08) / 0.84 and (6.4 + 1.76 +
        // 0.4) / 0.84.
        let others = [scored(0, 0.4, [1.0, 11.0]), scored(0, 0.2, [2.0, 10.0])];
        let [x0, x1] = voted(kept, &others);
        assert!((x0 - 0.285_714).abs() < 1e-6 && (x1 - 10.190_476).abs() < 1e-5, "{x0} {x1}");
    }

    #[test]
    fn other_classes_and_boxes_apart_have_no_vote() {
        let kept = scored(0, 0.8, [0.0, 10.0]);
        // Of another class; sharing 6 of 14; sharing 6.5 of 10, which is not above 0.65.
        let others =
            [scored(1, 0.8, [1.0, 11.0]), scored(0, 0.7, [4.0, 14.0]), scored(0, 0.7, [3.5, 10.0])];
        assert_eq!(voted(kept, &others), [0.0, 10.0]);
    }

    #[test]
    fn what_weighs_nothing_moves_nothing() {
        let mut boxes = [scored(0, 0.0, [0.0, 10.0])];
        let candidates = boxes;
        vote(&mut boxes, &candidates, 0.65);
        assert_eq!(boxes, candidates);
        let odd = [scored(0, f32::NAN, [0.0, 10.0])];
        vote(&mut boxes, &odd, 0.65);
        assert_eq!(boxes, candidates);
    }

    #[test]
    fn a_vote_looks_at_the_boxes_as_they_were() {
        // In a chain each box meets the next, but not the one after: a moved box must not reach
        // further.
        let chain = [[0.0, 10.0], [2.0, 12.0], [4.0, 14.0]].map(|edges| scored(0, 0.5, edges));
        let mut boxes = chain;
        vote(&mut boxes, &chain, 0.65);
        let left = boxes.map(|one| one.rect.x0);
        assert_eq!(left, [1.0, 2.0, 3.0]);
    }
}
