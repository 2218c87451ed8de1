//! Compresses tiles for storage, with a separate mask for levels and classes, and reduces tiles to
//! half the resolution.

use super::{CellFormat, NODATA, RASTER_TILE};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use std::io::{self, Read as _, Write as _};

/// Level of deflate; higher levels take half as long again, and make echoes no smaller.
const EFFORT: u32 = 3;

/// Compressed bytes of a tile, and of its mask; `None` for cells that have no mask.
pub(super) struct Packed {
    pub image: Vec<u8>,
    pub mask: Option<Vec<u8>>,
}

/// Compresses a tile; colours are stored as differences to the cell before (predictor 2).
pub(super) fn pack(cells: CellFormat, mut bytes: Vec<u8>) -> io::Result<Packed> {
    let mask = match cells {
        CellFormat::Level | CellFormat::Class => Some(deflate(&mask(&bytes))?),
        CellFormat::Rgba | CellFormat::Metres => None,
    };
    if cells == CellFormat::Rgba {
        for row in bytes.chunks_exact_mut(RASTER_TILE * cells.bytes()) {
            for at in (cells.bytes()..row.len()).rev() {
                row[at] = row[at].wrapping_sub(row[at - cells.bytes()]);
            }
        }
    }
    let image = deflate(&bytes)?;
    Ok(Packed { image, mask })
}

/// Decompresses a tile; the inverse of [`pack`].
pub(super) fn unpack(cells: CellFormat, packed: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(RASTER_TILE * RASTER_TILE * cells.bytes());
    ZlibDecoder::new(packed).read_to_end(&mut bytes)?;
    if cells == CellFormat::Rgba {
        for row in bytes.chunks_exact_mut(RASTER_TILE * cells.bytes()) {
            for at in cells.bytes()..row.len() {
                row[at] = row[at].wrapping_add(row[at - cells.bytes()]);
            }
        }
    }
    Ok(bytes)
}

fn deflate(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let packed = Vec::with_capacity(bytes.len() / 2);
    let mut encoder = ZlibEncoder::new(packed, Compression::new(EFFORT));
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Returns a mask of one bit for each cell, the first cell in the highest bit of a byte: 1 where a
/// level is known.
fn mask(levels: &[u8]) -> Vec<u8> {
    let byte = |eight: &[u8]| {
        let bit = |byte: u8, &level: &u8| byte << 1 | u8::from(level > 0);
        eight.iter().fold(0, bit)
    };
    levels.chunks_exact(8).map(byte).collect()
}

/// Reduces a tile of the finer level into a quarter (row and column, 0 or 1) of a coarser tile:
/// each cell becomes the mean of the known ones of its four cells, for classes the greatest. Both
/// tiles have [`RASTER_TILE`] rows of as many cells.
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

/// Returns the mean of the colours that are not transparent.
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

/// Returns the mean of the known levels; 0 where none is known.
fn mean_level(four: [[u8; 1]; 4]) -> [u8; 1] {
    let sum: u16 = four.iter().map(|level| u16::from(level[0])).sum();
    let count: u16 = four.iter().map(|level| u16::from(level[0] > 0)).sum();
    // Where a level is known the mean is never 0, because each known level is at least 1.
    [((sum + count / 2) / count.max(1)) as u8]
}

/// Returns the greatest class.
fn greatest(four: [[u8; 1]; 4]) -> [u8; 1] {
    [four.map(|[class]| class).into_iter().fold(0, u8::max)]
}

/// Returns the mean of the known values; [`NODATA`] where none is known.
fn mean_metres(four: [[u8; 4]; 4]) -> [u8; 4] {
    let known = four.map(f32::from_le_bytes);
    let known = known.iter().filter(|&&metres| metres != NODATA);
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), metres| (sum + metres, count + 1.0));
    if count > 0.0 { sum / count } else { NODATA }.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_can_be_undone() {
        for cells in [CellFormat::Rgba, CellFormat::Level, CellFormat::Metres] {
            let count = cells.bytes() * RASTER_TILE * RASTER_TILE;
            let bytes: Vec<u8> = (0..count).map(|index| (index * index / 7) as u8).collect();
            let packed = pack(cells, bytes.clone()).unwrap();
            assert_eq!(unpack(cells, &packed.image).unwrap(), bytes);
            assert_eq!(packed.mask.is_some(), cells == CellFormat::Level);
        }
    }

    #[test]
    fn a_mask_has_a_bit_for_each_known_level() {
        let levels = [0, 1, 0, 255, 7, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 1];
        assert_eq!(mask(&levels), [0b0101_1000, 0b1000_0001]);
    }
}
