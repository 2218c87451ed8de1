//! YOLOv8 to v12: one column a candidate.

use super::{Found, centred};
use crate::Scored;

/// `values` holds 4 + `classes` rows of as many columns as there are candidates: centre x, centre
/// y, width, height in pixels, then a score a class; there is no objectness.
pub fn columns(values: &[f32], classes: usize, least: f32) -> Vec<Scored> {
    let count = values.len() / (4 + classes);
    let mut found = Found::new(least);
    let at = |row: usize, column: usize| values.get(row * count + column).copied();
    for column in 0..count {
        let scores = (4..4 + classes).filter_map(|row| at(row, column));
        found.add(1.0, scores, || {
            centred([0, 1, 2, 3].map(|row| at(row, column).unwrap_or(f32::NAN)))
        });
    }
    found.boxes
}
