//! The masks that GDAL keeps in a GeoTIFF: a picture of one bit a pixel beside that of the colours,
//! set where these are seen.

use super::{RgbaPixel, Tiff};
use tiff::ColorType;

/// Kinds of directory (TIFF's `NewSubfileType`): the mask of the full picture, and that of an
/// overview.
const KINDS: [u32; 2] = [4, 5];

/// Returns the size of the picture that the mask at the decoder belongs to, columns and rows, and
/// the size of a block; `None` where the decoder is at no mask.
pub(super) fn masked_size(tiff: &mut Tiff, kind: Option<u32>) -> Option<([u32; 2], [u32; 2])> {
    if !KINDS.contains(&kind?) || tiff.colortype().ok()? != ColorType::Gray(1) {
        return None;
    }
    let (columns, rows) = tiff.dimensions().ok()?;
    let (across, down) = tiff.chunk_dimensions();
    Some(([columns, rows], [across, down.min(rows)]))
}

/// Makes the pixels of a block transparent that its mask does not show; both lie row by row, `wide`
/// pixels in each.
pub(super) fn hide(colours: &mut [RgbaPixel], mask: &[u8], wide: usize) {
    if wide == 0 || colours.is_empty() {
        return;
    }
    let rows = colours.len().div_ceil(wide);
    let stride = mask.len() / rows;
    for (row, colours) in colours.chunks_mut(wide).enumerate() {
        for (column, colour) in colours.iter_mut().enumerate() {
            let byte = mask.get(row * stride + column / 8);
            // The first pixel is the highest bit.
            let is_seen = byte.is_some_and(|byte| byte >> (7 - column % 8) & 1 == 1);
            if !is_seen {
                *colour = RgbaPixel::default();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_outside_the_mask_are_transparent() {
        let seen = [9, 9, 9, 255];
        let mut colours = vec![seen; 20];
        hide(&mut colours, &[0b0000_0001, 0b1000_0000, 0xff, 0xff], 10);
        let shown: Vec<usize> = (0..20).filter(|&index| colours[index] == seen).collect();
        assert_eq!(shown, [[7, 8].as_slice(), &(10..20).collect::<Vec<_>>()].concat());
    }
}
