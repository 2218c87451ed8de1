//! Converts the bytes of a block to colours, and makes pixels transparent that its mask hides.
//!
//! The TIFF decoder reads neither palettes nor masks. [`AsGrey`] shows both to the decoder as grey
//! levels, which are then the indices into the palette, or the bits of the mask.

use super::{BaseMapFault, Tiff};
use crate::formats::geotiff::{DirectoryWalk, check_claims};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use tiff::ColorType;
use tiff::tags::Tag;

/// Red, green, blue and opacity; all four are 0 where transparent.
pub type RgbaPixel = [u8; 4];

/// TIFF tag for the meaning of a sample (`PhotometricInterpretation`), with its values for a
/// palette, a mask and grey levels.
const PHOTOMETRIC: u16 = 262;
const PALETTE: u16 = 3;
const MASK: u16 = 4;
const GREY: u8 = 1;
/// Kinds of directory (TIFF's `NewSubfileType`) that are masks: the mask of the full picture, and
/// the mask of an overview. GDAL stores masks in a GeoTIFF as pictures of one bit a pixel, set
/// where the pixel is visible.
const KINDS: [u32; 2] = [4, 5];

/// Encoding of the colour of a pixel in its bytes.
#[derive(Clone, Debug)]
pub(super) struct Coding {
    kind: Kind,
    /// Bytes of a pixel.
    pub bytes: usize,
    /// Value for "no data" of the grey level, of the index, or of each of the three colours; `None`
    /// where the file has no such value.
    nodata: Option<u8>,
}

#[derive(Clone, Debug)]
enum Kind {
    Grey,
    GreyAlpha,
    Rgb,
    Rgba,
    /// YCbCr colours of JPEG, ITU-R BT.601 over the full range.
    YCbCr,
    Palette(Vec<RgbaPixel>),
    /// Bands whose meaning the file does not state: the first three are shown as a colour, or the
    /// first as a grey level.
    Bands,
}

impl Coding {
    /// Reads the encoding of the current picture of the decoder.
    ///
    /// # Errors
    /// When the colours of the picture cannot be read, or their type is not supported.
    pub(super) fn read(decoder: &mut Tiff) -> Result<Self, BaseMapFault> {
        let colours = decoder.colortype()?;
        let (kind, bytes) = match colours {
            // The file states a palette, or GDAL left the type at grey because the palette was
            // added later.
            ColorType::Gray(8) if has_palette(decoder) => (Kind::Palette(palette(decoder)?), 1),
            ColorType::Gray(8) => (Kind::Grey, 1),
            ColorType::GrayA(8) => (Kind::GreyAlpha, 2),
            ColorType::RGB(8) => (Kind::Rgb, 3),
            ColorType::RGBA(8) => (Kind::Rgba, 4),
            ColorType::YCbCr(8) => (Kind::YCbCr, 3),
            ColorType::Multiband { bit_depth: 8, num_samples } => {
                (Kind::Bands, usize::from(num_samples.max(1)))
            }
            _ => {
                let what = "the base map is no picture of 8 bits a colour (RGB, grey or paletted); make one with gdal_translate";
                return Err(BaseMapFault::unsuitable(what));
            }
        };
        let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).ok().flatten();
        if planar == Some(2) && bytes > 1 {
            let what = "the base map keeps its colours apart; write it with INTERLEAVE=PIXEL";
            return Err(BaseMapFault::unsuitable(what));
        }
        let nodata = decoder.get_tag_ascii_string(Tag::GdalNodata).ok();
        let nodata = nodata.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
        Ok(Self {
            kind,
            bytes,
            nodata: nodata.filter(|value| (0.0..=255.0).contains(value)).map(|value| value as u8),
        })
    }

    /// Returns the colours of a block.
    pub(super) fn colours(&self, bytes: &[u8]) -> Vec<RgbaPixel> {
        bytes.chunks_exact(self.bytes).map(|pixel| self.colour(pixel)).collect()
    }

    fn colour(&self, pixel: &[u8]) -> RgbaPixel {
        let colour = match (&self.kind, pixel) {
            (Kind::Palette(palette), &[index]) => {
                palette.get(usize::from(index)).copied().unwrap_or_default()
            }
            (Kind::Bands, &[r, g, b, ..]) => [r, g, b, 255],
            (Kind::Bands, &[grey, ..]) | (_, &[grey]) => [grey, grey, grey, 255],
            (_, &[grey, alpha]) => [grey, grey, grey, alpha],
            (Kind::YCbCr, &[y, cb, cr]) => rgb(y, cb, cr),
            (_, &[r, g, b]) => [r, g, b, 255],
            (_, &[r, g, b, a]) => [r, g, b, a],
            _ => RgbaPixel::default(),
        };
        let colours = match self.kind {
            Kind::GreyAlpha => &pixel[..1],
            Kind::Rgba => &pixel[..3],
            Kind::Bands if pixel.len() > 3 => &pixel[..3],
            _ => pixel,
        };
        let is_nodata =
            self.nodata.is_some_and(|nodata| colours.iter().all(|value| *value == nodata));
        if is_nodata || colour[3] == 0 { RgbaPixel::default() } else { colour }
    }
}

fn rgb(y: u8, cb: u8, cr: u8) -> RgbaPixel {
    let [y, cb, cr] = [f32::from(y), f32::from(cb) - 128.0, f32::from(cr) - 128.0];
    let byte = |value: f32| value.round().clamp(0.0, 255.0) as u8;
    [byte(y + 1.402 * cr), byte(y - 0.344_136 * cb - 0.714_136 * cr), byte(y + 1.772 * cb), 255]
}

fn has_palette(decoder: &mut Tiff) -> bool {
    decoder.find_tag(Tag::ColorMap).is_ok_and(|map| map.is_some())
}

/// Reads the palette of the picture: all reds, then all greens, then all blues, in 16 bits.
fn palette(decoder: &mut Tiff) -> Result<Vec<RgbaPixel>, BaseMapFault> {
    let map = decoder.get_tag_u16_vec(Tag::ColorMap)?;
    let count = map.len() / 3;
    let byte = |at: usize| (map[at] >> 8) as u8;
    let colours =
        (0..count).map(|index| [byte(index), byte(count + index), byte(2 * count + index), 255]);
    Ok(colours.collect())
}

/// A TIFF file in which every palette and mask reads as grey levels.
pub(super) struct AsGrey {
    file: BufReader<File>,
    at: u64,
    /// Offsets of the bytes with the value for a palette or a mask.
    offsets: Vec<u64>,
}

impl AsGrey {
    /// Searches the directories of a TIFF for palettes and masks; fails where the file cannot be
    /// read or a tag claims more bytes than the file has. Other errors are left to the decoder.
    pub(super) fn new(file: File) -> io::Result<Self> {
        let mut file = BufReader::new(file);
        check_claims(&mut file)?;
        let offsets = palettes(&mut file);
        file.seek(SeekFrom::Start(0))?;
        Ok(Self { file, at: 0, offsets })
    }
}

impl Read for AsGrey {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        for offset in &self.offsets {
            let index = offset.checked_sub(self.at).and_then(|index| usize::try_from(index).ok());
            if let Some(byte) = index.and_then(|index| buffer[..count].get_mut(index)) {
                *byte = GREY;
            }
        }
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for AsGrey {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = self.file.seek(to)?;
        Ok(self.at)
    }
}

/// Returns the offsets of the low bytes of all tags whose value is a palette or a mask.
fn palettes(file: &mut BufReader<File>) -> Vec<u64> {
    let mut found = Vec::new();
    if let Some(walk) = DirectoryWalk::begin(file) {
        walk.run(|walk, entry| {
            if entry.tag == u64::from(PHOTOMETRIC) {
                // The value, a 16-bit number, is in the first two bytes of the last field.
                walk.file.seek(SeekFrom::Start(entry.value_at)).ok()?;
                if [PALETTE, MASK].map(u64::from).contains(&walk.number(2)?) {
                    found.push(entry.value_at + u64::from(walk.is_big_endian));
                }
            }
            Some(())
        });
    }
    found
}

/// Returns the size (columns and rows) of the picture that the current mask of the decoder belongs
/// to, and the size of a block; `None` where the current directory is not a mask.
pub(super) fn masked_size(tiff: &mut Tiff, kind: Option<u32>) -> Option<([u32; 2], [u32; 2])> {
    if !KINDS.contains(&kind?) || tiff.colortype().ok()? != ColorType::Gray(1) {
        return None;
    }
    let (columns, rows) = tiff.dimensions().ok()?;
    let (across, down) = tiff.chunk_dimensions();
    Some(([columns, rows], [across, down.min(rows)]))
}

/// Makes the pixels of a block transparent that its mask hides; both are stored row by row, `wide`
/// pixels in each row.
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
