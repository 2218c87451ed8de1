//! Converts the bytes of a block to colours.

use super::BaseMapFault;
use std::io::{Read, Seek};
use tiff::ColorType;
use tiff::decoder::Decoder;
use tiff::tags::Tag;

/// Red, green, blue and opacity; transparent is all zero.
pub type RgbaPixel = [u8; 4];

/// Encoding of the colour of a pixel in its bytes.
#[derive(Clone, Debug)]
pub(super) struct Coding {
    kind: Kind,
    /// Bytes of a pixel.
    pub bytes: usize,
    /// The grey, the index, or all three of the colour that stand for no data.
    nodata: Option<u8>,
}

#[derive(Clone, Debug)]
enum Kind {
    Grey,
    GreyAlpha,
    Rgb,
    Rgba,
    /// Colours as JPEG holds them, ITU-R BT.601 over the full range.
    YCbCr,
    Palette(Vec<RgbaPixel>),
    /// Bands that the file gives no meaning: the first three are taken for a colour, or the first
    /// for a grey.
    Bands,
}

impl Coding {
    /// Reads the encoding of the picture that the decoder is at.
    ///
    /// # Errors
    /// When its colours cannot be read, or are of a kind that is not shown.
    pub(super) fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, BaseMapFault> {
        let colours = decoder.colortype()?;
        let (kind, bytes) = match colours {
            // Said to be paletted, or left grey by GDAL because its palette came late.
            ColorType::Gray(8) if has_palette(decoder) => (Kind::Palette(palette(decoder)?), 1),
            ColorType::Gray(8) => (Kind::Grey, 1),
            ColorType::GrayA(8) => (Kind::GreyAlpha, 2),
            ColorType::RGB(8) => (Kind::Rgb, 3),
            ColorType::RGBA(8) => (Kind::Rgba, 4),
            ColorType::YCbCr(8) => (Kind::YCbCr, 3),
            ColorType::Multiband { bit_depth: 8, num_samples } => {
                (Kind::Bands, usize::from(num_samples.max(1)))
            }
            other => return Err(BaseMapFault::Colours(other)),
        };
        let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).ok().flatten();
        if planar == Some(2) && bytes > 1 {
            return Err(BaseMapFault::ColoursApart);
        }
        let nodata = decoder.get_tag_ascii_string(Tag::GdalNodata).ok();
        let nodata = nodata.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
        Ok(Self {
            kind,
            bytes,
            nodata: nodata.filter(|value| (0.0..=255.0).contains(value)).map(|value| value as u8),
        })
    }

    /// The colours of a block.
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

fn has_palette<R: Read + Seek>(decoder: &mut Decoder<R>) -> bool {
    decoder.find_tag(Tag::ColorMap).is_ok_and(|map| map.is_some())
}

/// All reds, then all greens, then all blues, in 16 bits.
fn palette<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Vec<RgbaPixel>, BaseMapFault> {
    let map = decoder.get_tag_u16_vec(Tag::ColorMap)?;
    let count = map.len() / 3;
    let byte = |at: usize| (map[at] >> 8) as u8;
    let colours =
        (0..count).map(|index| [byte(index), byte(count + index), byte(2 * count + index), 255]);
    Ok(colours.collect())
}
