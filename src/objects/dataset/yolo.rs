//! Labels as YOLO tools read them: one text file a picture.

use crate::{Labelled, TILE_PX};
use std::fmt::Write as _;

/// One line a box: `class cx cy w h`, the centre and size as shares of the picture.
pub fn yolo_lines(labels: &[Labelled]) -> String {
    let mut text = String::new();
    let side = TILE_PX as f32;
    for Labelled { class, rect } in labels {
        let [cx, cy] = [rect.x0 + rect.x1, rect.y0 + rect.y1].map(|sum| 0.5 * sum / side);
        let [width, height] = [rect.x1 - rect.x0, rect.y1 - rect.y0].map(|size| size / side);
        // Writing to a string does not fail.
        writeln!(text, "{class} {cx:.6} {cy:.6} {width:.6} {height:.6}").ok();
    }
    text
}
