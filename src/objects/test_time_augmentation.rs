//! Test-time augmentation: a second pass over a picture, mirrored along the track.
//!
//! The boat may come from either end, so a picture and its mirror image show the same objects, and
//! what a network sees in one of them by chance it mostly does not see in the other: the mean of
//! both passes raises fewer false alarms and places edges better (figures in the detector's model
//! card). Columns are never mirrored: shadows fall outward.

use super::{Rect, Scored};

/// Overlap (IoU) above which boxes of both passes are the same object.
const SAME: f32 = 0.6;

/// The candidates of both passes, each as sure as the mean of its own confidence and that of the
/// surest of its class that the other pass has there; 0 where it has none. `second` holds the boxes
/// of the mirrored picture, mirrored back.
pub(super) fn agree(first: &[Scored], second: &[Scored]) -> Vec<Scored> {
    let weighed = |own: &[Scored], other: &[Scored]| -> Vec<Scored> {
        own.iter()
            .map(|one| Scored { score: (one.score + surest_there(one, other)) / 2.0, ..*one })
            .collect()
    };
    let mut both = weighed(first, second);
    both.extend(weighed(second, first));
    both
}

/// Confidence of the surest box of the same class at the same place; 0 without one.
fn surest_there(one: &Scored, others: &[Scored]) -> f32 {
    others
        .iter()
        .filter(|other| other.class == one.class && other.rect.iou(&one.rect) > SAME)
        .map(|other| other.score)
        .fold(0.0, f32::max)
}

/// A box of a picture of `height` pixels as it lies in the mirrored one, and back.
pub(super) fn mirrored(found: Scored, height: f32) -> Scored {
    let Rect { x0, y0, x1, y1 } = found.rect;
    Scored { rect: Rect::new([x0, height - y1], [x1, height - y0]), ..found }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(class: usize, score: f32, [y0, y1]: [f32; 2]) -> Scored {
        Scored::new(class, score, Rect::new([0.0, y0], [10.0, y1]))
    }

    fn scores(first: &[Scored], second: &[Scored]) -> Vec<f32> {
        agree(first, second).iter().map(|one| one.score).collect()
    }

    #[test]
    fn what_both_passes_see_is_as_sure_as_their_mean() {
        // They share 9 of 11.
        let first = [scored(0, 0.75, [0.0, 10.0])];
        let second = [scored(0, 0.25, [1.0, 11.0])];
        assert_eq!(scores(&first, &second), [0.5, 0.5]);
        let boxes = agree(&first, &second);
        assert_eq!([boxes[0].rect, boxes[1].rect], [first[0].rect, second[0].rect]);
    }

    #[test]
    fn what_one_look_sees_is_half_as_sure() {
        let first = [scored(0, 0.5, [0.0, 10.0])];
        // Of another class; sharing 7 of 13.
        let others = [scored(1, 0.75, [0.0, 10.0]), scored(0, 1.0, [3.0, 13.0])];
        assert_eq!(scores(&first, &others), [0.25, 0.375, 0.5]);
        assert_eq!(scores(&first, &[]), [0.25]);
        assert_eq!(scores(&[], &first), [0.25]);
    }

    #[test]
    fn the_surest_of_the_other_look_counts() {
        let first = [scored(0, 0.5, [0.0, 10.0])];
        let second = [scored(0, 0.25, [0.0, 10.0]), scored(0, 1.0, [1.0, 10.0])];
        assert_eq!(scores(&first, &second)[0], 0.75);
    }

    #[test]
    fn a_box_mirrored_twice_is_where_it_was() {
        let found = scored(2, 0.5, [30.0, 50.0]);
        let there = mirrored(found, 416.0);
        assert_eq!([there.rect.y0, there.rect.y1], [366.0, 386.0]);
        assert_eq!(mirrored(there, 416.0), found);
    }
}
