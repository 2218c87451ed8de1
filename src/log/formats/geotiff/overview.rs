//! Tiles at half the resolution.

use super::{CellFormat, NODATA, RASTER_TILE};

/// Draws a tile of the finer level into a quarter (row and column, 0 or 1) of a coarser one: each
/// cell the mean of those of its four that hold something, of classes the greatest. Both hold
/// [`RASTER_TILE`] rows of as many cells.
pub(super) fn halve_into(cells: CellFormat, finer: &[u8], quarter: [usize; 2], coarser: &mut [u8]) {
    match cells {
        CellFormat::Rgba => halve(finer, quarter, coarser, mean_colour),
        CellFormat::Level => halve(finer, quarter, coarser, mean_level),
        CellFormat::Class => halve(finer, quarter, coarser, greatest),
        CellFormat::Metres => halve(finer, quarter, coarser, mean_metres),
    }
}

fn halve<const BYTES: usize>(
    finer: &[u8],
    quarter: [usize; 2],
    coarser: &mut [u8],
    mean: impl Fn([[u8; BYTES]; 4]) -> [u8; BYTES],
) {
    let half = RASTER_TILE / 2;
    let finer = finer.as_chunks::<BYTES>().0;
    let coarser = coarser.as_chunks_mut::<BYTES>().0;
    for (row, pair) in finer.chunks_exact(2 * RASTER_TILE).enumerate() {
        let (upper, lower) = pair.split_at(RASTER_TILE);
        let first = (quarter[0] * half + row) * RASTER_TILE + quarter[1] * half;
        let pairs = upper.chunks_exact(2).zip(lower.chunks_exact(2));
        for (goal, (upper, lower)) in coarser[first..first + half].iter_mut().zip(pairs) {
            *goal = mean([upper[0], upper[1], lower[0], lower[1]]);
        }
    }
}

/// The mean colour of what is not transparent.
fn mean_colour(four: [[u8; 4]; 4]) -> [u8; 4] {
    let seen = four.iter().filter(|colour| colour[3] > 0);
    let (mut sums, mut count) = ([0_u32; 4], 0);
    for colour in seen {
        sums = std::array::from_fn(|byte| sums[byte] + u32::from(colour[byte]));
        count += 1;
    }
    match count {
        0 => [0; 4],
        count => sums.map(|sum| ((sum + count / 2) / count) as u8),
    }
}

/// The mean of the levels that are known.
fn mean_level(four: [[u8; 1]; 4]) -> [u8; 1] {
    let sum: u16 = four.iter().map(|level| u16::from(level[0])).sum();
    let count: u16 = four.iter().map(|level| u16::from(level[0] > 0)).sum();
    // Never 0, since each of them is at least 1.
    [((sum + count / 2) / count.max(1)) as u8]
}

/// The greatest class.
fn greatest(four: [[u8; 1]; 4]) -> [u8; 1] {
    [four.map(|[class]| class).into_iter().fold(0, u8::max)]
}

/// The mean of what is known.
fn mean_metres(four: [[u8; 4]; 4]) -> [u8; 4] {
    let known = four.map(f32::from_le_bytes);
    let known = known.iter().filter(|&&metres| metres != NODATA);
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), metres| (sum + metres, count + 1.0));
    if count > 0.0 { sum / count } else { NODATA }.to_le_bytes()
}
