//! Makes the pictures that train a detector on the analyst's decisions: tiles around the decided
//! boxes, and the true boxes in each.

use super::{Review, Reviewed, State};
use crate::dataset::{LEAST_PX, LEAST_SHARE, PictureBoxes};
use crate::{Labelled, NAMELESS_CLASS, ObjectExtent, Raster, Rect, TILE_PX};
use bathyscope_log::survey::Side;

/// Side of the square around a point in which detections are ignored, metres.
const POINT_M: f32 = 2.0;

/// A tile of the raster with the decisions about the boxes in it.
#[derive(Clone, Debug, PartialEq)]
pub struct ReviewedTile {
    /// Side of the survey.
    pub side: Side,
    /// Row of the raster at which the tile starts.
    pub row: usize,
    /// Column of the raster at which the tile starts.
    pub column: usize,
    /// Boxes in the tile. Accepted and added boxes are labels; if all boxes were rejected there are
    /// none, which makes a hard negative. Undecided boxes, points, and objects that the edge cuts
    /// off are ignored boxes.
    pub boxes: PictureBoxes,
    /// Number of rejected boxes in the tile.
    pub rejected: usize,
}

impl Review {
    /// Returns the class names to train with, and the index of each class of the review among them.
    /// The names are the analyst's list, then other classes that boxes have, with the class of
    /// unknown objects last. So the classes of the list have the same numbers in the data of all
    /// logs of a survey.
    pub fn training_classes(&self, list: &[String]) -> (Vec<String>, Vec<Option<usize>>) {
        let is_used = |class: usize| self.boxes().any(|review_box| review_box.class == class);
        let others = self.classes.iter().enumerate();
        let others = others.filter(|(class, name)| !list.contains(name) && is_used(*class));
        let (nameless, named): (Vec<_>, Vec<_>) =
            others.partition(|(_, name)| *name == NAMELESS_CLASS);
        let others = named.into_iter().chain(nameless).map(|(_, name)| name);
        let names: Vec<String> = list.iter().chain(others).cloned().collect();
        let place = |class: &String| names.iter().position(|name| name == class);
        let places = self.classes.iter().map(place).collect();
        (names, places)
    }

    /// Returns tiles that hold every decided box, as few as a walk along the track needs. Undecided
    /// boxes and points make no tile of their own.
    pub fn tiles(&self, raster: &Raster) -> Vec<ReviewedTile> {
        let mut tiles = Vec::new();
        for side in Side::BOTH {
            let mut boxes: Vec<(Rect, &Reviewed)> = self
                .boxes()
                .filter(|review_box| review_box.mark.side == side)
                .map(|review_box| (rect_of(raster, review_box), review_box))
                .collect();
            boxes.sort_by(|(a, _), (b, _)| a.y0.total_cmp(&b.y0));
            let first = tiles.len();
            for (rect, review_box) in &boxes {
                let is_held = |tile: &ReviewedTile| {
                    let inside = rect.intersection(&frame(tile));
                    inside.area() >= 0.999 * rect.area()
                };
                // Tiles follow the track, so only the last few can hold the box.
                let is_seen = tiles[first..].iter().rev().take(8).any(is_held);
                let is_picture =
                    review_box.state != State::Proposed && review_box.extent != ObjectExtent::Point;
                if is_picture && !is_seen {
                    tiles.push(around(rect, side, raster, &boxes));
                }
            }
        }
        tiles
    }
}

/// Returns a box in the pixels of the raster; for a point, the square that an object there may
/// cover.
fn rect_of(raster: &Raster, review_box: &Reviewed) -> Rect {
    let rect = raster.rect_of(&review_box.mark);
    if review_box.extent != ObjectExtent::Point {
        return rect;
    }
    let half = 0.5 * POINT_M / raster.pixel_m as f32;
    let [x, y] = [0.5 * (rect.x0 + rect.x1), 0.5 * (rect.y0 + rect.y1)];
    Rect::new([(x - half).max(0.0), (y - half).max(0.0)], [x + half, y + half])
}

fn frame(tile: &ReviewedTile) -> Rect {
    let (x0, y0) = (tile.column as f32, tile.row as f32);
    Rect::new([x0, y0], [x0 + TILE_PX as f32, y0 + TILE_PX as f32])
}

/// Creates a tile around the middle of a box, limited to the picture.
fn around(rect: &Rect, side: Side, raster: &Raster, boxes: &[(Rect, &Reviewed)]) -> ReviewedTile {
    let [row, column] = raster.start_about(rect);
    let mut tile = ReviewedTile { side, row, column, boxes: PictureBoxes::default(), rejected: 0 };
    let frame = frame(&tile);
    for (rect, review_box) in boxes {
        let inside = rect.intersection(&frame);
        if inside.area() <= 0.0 {
            continue;
        }
        let label =
            Labelled { class: review_box.class, rect: inside.shifted(-frame.x0, -frame.y0) };
        let large = (inside.x1 - inside.x0).min(inside.y1 - inside.y0) >= LEAST_PX;
        let whole_enough = large && inside.area() >= LEAST_SHARE * rect.area();
        // The size of a point is unknown.
        let is_plain = whole_enough && review_box.extent != ObjectExtent::Point;
        match review_box.state {
            State::Rejected => tile.rejected += 1,
            State::Accepted | State::Added if is_plain => tile.boxes.labels.push(label),
            State::Accepted | State::Added | State::Proposed => tile.boxes.ignored.push(label),
        }
    }
    tile
}
