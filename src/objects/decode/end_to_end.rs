//! YOLOv10, YOLO26 and others that suppress overlapping boxes themselves.

use super::Found;
use crate::{Rect, Scored};

/// `values` holds six numbers a box: x1, y1, x2, y2 in pixels, score, class. Classes from `classes`
/// on are no boxes.
pub(crate) fn end_to_end(values: &[f32], classes: usize, least: f32) -> Vec<Scored> {
    let mut found = Found::new(least);
    for row in values.chunks_exact(6) {
        let class = row[5].round();
        // Written so that a NaN is no class.
        if class >= 0.0 && class < classes as f32 {
            found.add_one(class as usize, row[4], || Rect::new([row[0], row[1]], [row[2], row[3]]));
        }
    }
    found.boxes
}
