//! YOLOv5, YOLOv7 and Darknet's row layout: one row a candidate.

use super::{Found, centred};
use crate::Scored;

/// `values` holds 5 + `classes` numbers a candidate: centre x, centre y, width, height in pixels,
/// objectness, then a score a class. A box's score is objectness times class.
pub fn rows(values: &[f32], classes: usize, least: f32) -> Vec<Scored> {
    let mut found = Found::new(least);
    for row in values.chunks_exact(5 + classes) {
        found.add(row[4], row[5..].iter().copied(), || centred([row[0], row[1], row[2], row[3]]));
    }
    found.boxes
}
