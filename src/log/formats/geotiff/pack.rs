//! Tiles as they are stored: compressed, a mask of their own beside those of levels.

use super::{CellFormat, RASTER_TILE};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use std::io::{self, Read as _, Write as _};

/// Higher levels of deflate take half as long again, and make echoes no smaller.
const EFFORT: u32 = 3;

/// The compressed bytes of a tile, and of its mask where the cells have one.
pub(super) struct Packed {
    pub image: Vec<u8>,
    pub mask: Option<Vec<u8>>,
}

/// Compresses a tile; bytes of colour as differences to the cell before (predictor 2).
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

/// Inverse of [`pack`].
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

/// A bit for each cell, the first one the highest of its byte: set where a level is known.
fn mask(levels: &[u8]) -> Vec<u8> {
    let byte = |eight: &[u8]| {
        let bit = |byte: u8, &level: &u8| byte << 1 | u8::from(level > 0);
        eight.iter().fold(0, bit)
    };
    levels.chunks_exact(8).map(byte).collect()
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
