//! YOLOX: rows whose boxes are still in units of their grid cell.

use super::{Found, centred};
use crate::Scored;

/// `values` holds 5 + `classes` numbers a grid cell, the grids of `strides` one after the other,
/// row by row: the centre's offset in cells, the logarithm of the size in cells, objectness, a
/// score a class. `input` is the network's width and height.
///
/// `x = (tx + column) stride`, `w = e^tw stride` (Megvii's `demo_postprocess`).
pub(crate) fn yolox(
    values: &[f32],
    classes: usize,
    input: [usize; 2],
    strides: &[usize],
    least: f32,
) -> Vec<Scored> {
    let cells = strides.iter().flat_map(|&stride| {
        let [columns, rows] = input.map(|size| size / stride);
        (0..rows).flat_map(move |row| (0..columns).map(move |column| (stride, column, row)))
    });
    let mut found = Found::new(least);
    for (cell, (stride, column, row)) in values.chunks_exact(5 + classes).zip(cells) {
        let size = stride as f32;
        found.add(cell[4], cell[5..].iter().copied(), || {
            centred([
                (cell[0] + column as f32) * size,
                (cell[1] + row as f32) * size,
                cell[2].exp() * size,
                cell[3].exp() * size,
            ])
        });
    }
    found.boxes
}
