//! The pixels of a picture as levels of grey, within a bound of memory.

use crate::support::catch_panic::catch_panic;
use crate::support::picture_file::{PictureFault, bounded_decoder};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat};
use std::io::Cursor;

/// Bytes that a picture may take while it is unpacked.
const LARGEST_UNPACKED: u64 = 1 << 30;
/// Pixels of a byte at most: Deflate packs 1032 bytes into one, and a byte holds eight pixels of
/// one bit. What states more is damaged.
const MOST_PIXELS_A_BYTE: u64 = 8 * 1032;
/// The last marker of a JPEG, and that before its pixels.
const END_OF_JPEG: [u8; 2] = [0xFF, 0xD9];
const SCAN_OF_JPEG: [u8; 2] = [0xFF, 0xDA];

/// Returns true if a file is a PNG or a JPEG, by its first bytes.
pub(super) fn is_picture(bytes: &[u8]) -> bool {
    format_of(bytes).is_some()
}

fn format_of(bytes: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(bytes).ok()?;
    matches!(format, ImageFormat::Png | ImageFormat::Jpeg).then_some(format)
}

/// A picture whose header was read.
pub(super) struct PackedPicture<'a> {
    decoder: Box<dyn ImageDecoder + 'a>,
}

/// Levels of grey.
pub(super) struct GreyPicture {
    /// Columns.
    pub(super) width: usize,
    /// True if a level has two bytes, the low one first.
    pub(super) is_wide: bool,
    /// Row by row.
    pub(super) samples: Vec<u8>,
}

impl<'a> PackedPicture<'a> {
    /// Reads the header of a picture.
    ///
    /// # Errors
    /// When it is damaged, or states more pixels than its bytes can hold or than are unpacked.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, PictureFault> {
        let open = || bounded_decoder(Cursor::new(bytes), LARGEST_UNPACKED, bytes_copied);
        let decoder = catch_panic(open).unwrap_or(Err(PictureFault::Damaged))?;
        let (width, height) = decoder.dimensions();
        let most = MOST_PIXELS_A_BYTE.saturating_mul(bytes.len() as u64);
        let is_whole = format_of(bytes) != Some(ImageFormat::Jpeg) || is_whole_jpeg(bytes);
        if width < 2 || u64::from(width) * u64::from(height) > most || !is_whole {
            return Err(PictureFault::Damaged);
        }
        Ok(Self { decoder: Box::new(decoder) })
    }

    /// Rows.
    pub(super) fn height(&self) -> usize {
        self.decoder.dimensions().1 as usize
    }

    /// Its levels.
    ///
    /// # Errors
    /// When it is cut or damaged.
    pub(super) fn unpack(self) -> Result<GreyPicture, PictureFault> {
        catch_panic(|| unpack(self.decoder)).unwrap_or(Err(PictureFault::Damaged))
    }
}

fn unpack(decoder: Box<dyn ImageDecoder + '_>) -> Result<GreyPicture, PictureFault> {
    let picture = DynamicImage::from_decoder(decoder)?;
    let width = picture.width() as usize;
    let is_wide = is_wide(picture.color());
    let samples = if is_wide {
        // Their bytes are in the order of the machine, which is that of a sample.
        bytemuck::cast_slice(picture.into_luma16().as_raw()).to_vec()
    } else {
        picture.into_luma8().into_raw()
    };
    Ok(GreyPicture { width, is_wide, samples })
}

fn is_wide(colours: ColorType) -> bool {
    colours.bytes_per_pixel() > colours.channel_count()
}

/// Bytes that a pixel takes in the copies that [`unpack`] makes beside the picture.
fn bytes_copied(colours: ColorType) -> u64 {
    match colours {
        ColorType::L8 => 0,
        colours if is_wide(colours) => 4,
        _ => 1,
    }
}

/// Returns true if the pixels of a JPEG end with its last marker: the decoder makes grey of those
/// that are missing. Neither marker can stand among pixels.
fn is_whole_jpeg(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|two| two == marker);
    last(END_OF_JPEG) > last(SCAN_OF_JPEG)
}
