//! Tiles at half the resolution.

use super::{Cells, NODATA, RASTER_TILE};

/// Draws a tile of the finer level into a quarter (row and column, 0 or 1) of a coarser one: each cell the mean of those of its
/// four that hold something. Both hold [`RASTER_TILE`] rows of as many cells of four bytes.
pub fn halve_into(cells: Cells, finer: &[u8], quarter: [usize; 2], coarser: &mut [u8]) {
    let half = RASTER_TILE / 2;
    let at = |row: usize, column: usize| 4 * (row * RASTER_TILE + column);
    for row in 0..half {
        for column in 0..half {
            let four = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[down, across]| {
                let start = at(2 * row + down, 2 * column + across);
                [0, 1, 2, 3].map(|byte| finer[start + byte])
            });
            let mean = match cells {
                Cells::Rgba => mean_colour(four),
                Cells::Metres => mean_metres(four),
            };
            let goal = at(quarter[0] * half + row, quarter[1] * half + column);
            coarser[goal..goal + 4].copy_from_slice(&mean);
        }
    }
}

/// The mean colour of what is not transparent.
fn mean_colour(four: [[u8; 4]; 4]) -> [u8; 4] {
    let seen: Vec<[u8; 4]> = four.into_iter().filter(|colour| colour[3] > 0).collect();
    if seen.is_empty() {
        return [0; 4];
    }
    let count = seen.len() as u32;
    [0, 1, 2, 3].map(|byte| {
        let sum: u32 = seen.iter().map(|colour| u32::from(colour[byte])).sum();
        ((sum + count / 2) / count) as u8
    })
}

/// The mean of what is known.
fn mean_metres(four: [[u8; 4]; 4]) -> [u8; 4] {
    let known = four.map(f32::from_le_bytes);
    let known = known.iter().filter(|&&metres| metres != NODATA);
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), metres| {
        (sum + metres, count + 1.0)
    });
    if count > 0.0 { sum / count } else { NODATA }.to_le_bytes()
}
