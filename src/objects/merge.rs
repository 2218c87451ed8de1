//! Makes one box of an object that several overlapping tiles show.
//!
//! A box is *whole* when it ends inside its tile, and *cut* when it touches an edge beyond which
//! the picture goes on. Of whole boxes that overlap, the one with the highest score is kept, as
//! within a tile. A cut box is a piece of a whole box of another tile if that one covers half of it
//! within the strip that both tiles share. The cut box is then dropped if the whole box is of the
//! same class, and the whole box gets the higher score of the two; or if the whole box is of
//! another class and has at least half the score: otherwise a whole box of low score would hide a
//! cut box of high score. Two cut boxes are pieces of one object (longer than the strip) when their
//! overlap within the strip is at least one half (IoU): the box around both is kept, with the class
//! and score of the piece with the higher score. A cut box without a counterpart is kept as it is.

use super::{Nms, Rect, Scored, suppress};
use std::collections::HashMap;

/// Pixels from a tile's edge within which a box counts as cut.
const EDGE_PX: f32 = 2.0;
/// Overlap within the strip from which two boxes show the same object.
const SAME: f32 = 0.5;
/// Least score of a whole box that replaces a piece of another class, as a share of the score of
/// the piece.
const SURE_ENOUGH: f32 = 0.5;
/// Height of a band of rows of the picture, pixels; only boxes that share a band are compared.
const BAND_PX: f32 = 512.0;

/// A box that was found in a tile, in the whole picture's pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TileDetection {
    /// Class, score and box.
    pub found: Scored,
    /// Edges of the tile.
    pub tile: Rect,
    /// True if the object may continue beyond the tile.
    pub cut: bool,
}

impl TileDetection {
    /// Converts a box in the pixels of `tile`, which lies in a picture of `width` by `height`, and
    /// determines whether it is cut.
    pub(super) fn new(found: Scored, tile: Rect, width: f32, height: f32) -> Self {
        let rect = found.rect.shifted(tile.x0, tile.y0);
        let cut = (tile.x0 > 0.0 && rect.x0 < tile.x0 + EDGE_PX)
            || (tile.y0 > 0.0 && rect.y0 < tile.y0 + EDGE_PX)
            || (tile.x1 < width && rect.x1 > tile.x1 - EDGE_PX)
            || (tile.y1 < height && rect.y1 > tile.y1 - EDGE_PX);
        Self { found: Scored { rect, ..found }, tile, cut }
    }

    /// Returns true if the object may continue behind the row of pixels at which its tile ends.
    pub(super) fn is_cut_at(&self, row: f32) -> bool {
        self.tile.y1 >= row && self.found.rect.y1 > row - EDGE_PX
    }

    /// Returns the parts of the two boxes within the strip that both tiles share; `None` if both
    /// boxes are from the same tile.
    fn in_strip(&self, other: &TileDetection) -> Option<[Rect; 2]> {
        let strip = self.tile.intersection(&other.tile);
        (self.tile != other.tile)
            .then(|| [self, other].map(|seen| seen.found.rect.intersection(&strip)))
    }

    /// Returns true if this cut box and another one show the same object.
    fn continues(&self, other: &TileDetection) -> bool {
        self.in_strip(other).is_some_and(|[mine, theirs]| mine.iou(&theirs) >= SAME)
    }

    /// Returns true if a whole box replaces this cut box.
    fn yields_to(&self, whole: &TileDetection) -> bool {
        let same = whole.found.class == self.found.class;
        let sure = whole.found.score >= SURE_ENOUGH * self.found.score;
        (same || sure) && self.is_piece_of(whole)
    }

    /// Returns the rank of this whole box among those that can replace a cut one: boxes of the cut
    /// box's class come first, then the higher score.
    fn rank_for(&self, cut: &TileDetection) -> f32 {
        self.found.score + f32::from(u8::from(self.found.class == cut.found.class))
    }

    /// Returns true if this cut box is a piece of a whole one.
    fn is_piece_of(&self, whole: &TileDetection) -> bool {
        self.in_strip(whole).is_some_and(|[mine, theirs]| {
            let covered = mine.intersection(&theirs).area();
            covered > 0.0 && covered >= SAME * mine.area()
        })
    }
}

/// Returns the objects, each once, by falling score. Takes time and memory in proportion to the
/// boxes.
pub(super) fn merge(seen: Vec<TileDetection>, nms: Nms, iou: f32) -> Vec<Scored> {
    let (mut cut, mut whole): (Vec<TileDetection>, Vec<TileDetection>) =
        seen.into_iter().partition(|seen| seen.cut);
    cut.sort_by(|a, b| b.found.score.total_cmp(&a.found.score));

    let mut wholes = Bands::default();
    for (index, seen) in whole.iter().enumerate() {
        wholes.add(index, *seen);
    }
    let mut pieces = Bands::default();
    let mut joined: Vec<Scored> = Vec::new();
    for seen in cut {
        let rect = seen.found.rect;
        let taken_by = wholes.near(&rect).filter(|(_, whole)| seen.yields_to(whole));
        let surest =
            taken_by.max_by(|(_, a), (_, b)| a.rank_for(&seen).total_cmp(&b.rank_for(&seen)));
        if let Some(&(index, _)) = surest {
            let object = &mut whole[index].found;
            if object.class == seen.found.class {
                object.score = object.score.max(seen.found.score);
            }
            continue;
        }
        let piece = pieces.near(&rect).find(|(_, other)| other.continues(&seen));
        let object = piece.map_or(joined.len(), |(object, _)| *object);
        match joined.get_mut(object) {
            Some(object) => object.rect = object.rect.hull(&rect),
            None => joined.push(seen.found),
        }
        pieces.add(object, seen);
    }
    joined.extend(whole.iter().map(|seen| seen.found));
    suppress(&mut joined, nms, iou);
    joined
}

/// Boxes by the bands of rows that they lie in, each with an index.
#[derive(Default)]
struct Bands(HashMap<i64, Vec<(usize, TileDetection)>>);

impl Bands {
    fn bands(rect: &Rect) -> std::ops::RangeInclusive<i64> {
        // A box is at most as high as a tile, so that it lies in few bands.
        (rect.y0 / BAND_PX).floor() as i64..=(rect.y1 / BAND_PX).floor() as i64
    }

    fn add(&mut self, index: usize, seen: TileDetection) {
        for band in Self::bands(&seen.found.rect) {
            self.0.entry(band).or_default().push((index, seen));
        }
    }

    fn near(&self, rect: &Rect) -> impl Iterator<Item = &(usize, TileDetection)> {
        Self::bands(rect).flat_map(|band| self.0.get(&band).into_iter().flatten())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHT: f32 = 1040.0;

    /// Returns a tile of 416 rows of a picture that is 416 across; a new tile starts every 312
    /// rows.
    fn tile(index: u8) -> Rect {
        let y0 = 312.0 * f32::from(index);
        Rect::new([0.0, y0], [416.0, y0 + 416.0])
    }

    /// Returns the boxes of an object between two rows in three tiles. Each box has the score of
    /// its tile in `scores`; `None` means no box in that tile.
    fn seen(class: usize, [y0, y1]: [f32; 2], scores: [Option<f32>; 3]) -> Vec<TileDetection> {
        let object = Rect::new([100.0, y0], [150.0, y1]);
        (0..3_u8)
            .zip(scores)
            .filter_map(|(index, score)| {
                let rect = object.intersection(&tile(index)).shifted(0.0, -tile(index).y0);
                let found = Scored::new(class, score?, rect);
                Some(TileDetection::new(found, tile(index), 416.0, HEIGHT))
            })
            .collect()
    }

    fn merged(seen: Vec<TileDetection>) -> Vec<(f32, f32, f32)> {
        merge(seen, Nms::default(), 0.45)
            .iter()
            .map(|merged_box| (merged_box.score, merged_box.rect.y0, merged_box.rect.y1))
            .collect()
    }

    #[test]
    fn a_cut_box_gives_way_to_the_whole_one_and_leaves_it_its_score() {
        let boxes = seen(0, [380.0, 440.0], [Some(0.9), Some(0.6), None]);
        assert!(boxes[0].cut && !boxes[1].cut);
        assert_eq!(merged(boxes), [(0.9, 380.0, 440.0)]);
    }

    #[test]
    fn a_whole_box_that_is_hardly_believed_hides_no_cut_one_of_another_class() {
        let of = |score| {
            let mut boxes = seen(0, [380.0, 440.0], [Some(0.9), None, None]);
            boxes.extend(seen(1, [380.0, 440.0], [None, Some(score), None]));
            merged(boxes)
        };
        assert_eq!(of(0.1), [(0.9, 380.0, 416.0), (0.1, 380.0, 440.0)]);
        assert_eq!(of(0.5), [(0.5, 380.0, 440.0)]);
    }

    #[test]
    fn the_cut_end_of_a_whole_box_is_no_object_of_its_own() {
        let mut boxes = seen(0, [330.0, 420.0], [None, Some(0.8), None]);
        let end = Rect::new([120.0, 400.0], [140.0, 416.0]);
        let found = Scored::new(1, 0.9, end);
        boxes.push(TileDetection::new(found, tile(0), 416.0, HEIGHT));
        assert_eq!(merged(boxes), [(0.8, 330.0, 420.0)]);
    }

    #[test]
    fn a_long_object_is_put_together_from_its_pieces() {
        let boxes = seen(0, [200.0, 900.0], [Some(0.5), Some(0.8), Some(0.7)]);
        assert!(boxes.iter().all(|detection| detection.cut || detection.found.rect.y1 == 900.0));
        assert_eq!(merged(boxes), [(0.8, 200.0, 900.0)]);
    }

    #[test]
    fn whole_boxes_of_two_tiles_are_one_and_neighbours_stay_two() {
        let twice = seen(0, [330.0, 400.0], [Some(0.7), Some(0.8), None]);
        assert_eq!(merged(twice), [(0.8, 330.0, 400.0)]);
        let mut two = seen(0, [330.0, 360.0], [Some(0.7), Some(0.8), None]);
        two.extend(seen(0, [365.0, 400.0], [Some(0.9), Some(0.6), None]));
        assert_eq!(merged(two), [(0.9, 365.0, 400.0), (0.8, 330.0, 360.0)]);
    }

    #[test]
    fn what_only_one_tile_saw_stays_and_the_pictures_own_edge_cuts_nothing() {
        let alone = seen(0, [380.0, 440.0], [Some(0.9), None, None]);
        assert_eq!(merged(alone), [(0.9, 380.0, 416.0)]);
        let last = seen(0, [1000.0, HEIGHT], [None, None, Some(0.4)]);
        assert!(!last[0].cut);
    }
}
