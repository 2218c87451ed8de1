//! Decodes a picture to grey levels, within a memory limit.

use crate::support::catch_panic::catch_panic;
use crate::support::picture_file::{PictureFault, bounded_decoder};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat};
use std::io::Cursor;

/// Most bytes that a picture may take while it is decoded.
const LARGEST_UNPACKED: u64 = 1 << 30;
/// Most pixels for each byte of a file: Deflate compresses 1032 bytes into one, and a byte has
/// eight pixels of one bit. A file that states more is damaged.
const MOST_PIXELS_A_BYTE: u64 = 8 * 1032;
/// Marker of the end of a JPEG, and marker before its pixels.
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

/// A picture decoded to grey levels.
pub(super) struct GreyPicture {
    /// Number of columns.
    pub(super) width: usize,
    /// True if a level has two bytes, the low byte first.
    pub(super) is_wide: bool,
    /// Levels, row by row.
    pub(super) samples: Vec<u8>,
}

impl<'a> PackedPicture<'a> {
    /// Reads the header of a picture.
    ///
    /// # Errors
    /// When the picture is damaged, or states more pixels than its bytes can contain or than are
    /// decoded.
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

    /// Returns the number of rows.
    pub(super) fn height(&self) -> usize {
        self.decoder.dimensions().1 as usize
    }

    /// Decodes the picture to grey levels.
    ///
    /// # Errors
    /// When the picture is truncated or damaged.
    pub(super) fn unpack(self) -> Result<GreyPicture, PictureFault> {
        catch_panic(|| unpack(self.decoder)).unwrap_or(Err(PictureFault::Damaged))
    }
}

fn unpack(decoder: Box<dyn ImageDecoder + '_>) -> Result<GreyPicture, PictureFault> {
    let picture = DynamicImage::from_decoder(decoder)?;
    let width = picture.width() as usize;
    let is_wide = is_wide(picture.color());
    let samples = if is_wide {
        // The bytes have the machine's byte order, which is that of the samples.
        bytemuck::cast_slice(picture.into_luma16().as_raw()).to_vec()
    } else {
        picture.into_luma8().into_raw()
    };
    Ok(GreyPicture { width, is_wide, samples })
}

fn is_wide(colours: ColorType) -> bool {
    colours.bytes_per_pixel() > colours.channel_count()
}

/// Returns the bytes for each pixel of the copies that [`unpack`] makes in addition to the picture.
fn bytes_copied(colours: ColorType) -> u64 {
    match colours {
        ColorType::L8 => 0,
        colours if is_wide(colours) => 4,
        _ => 1,
    }
}

/// Returns true if the pixels of a JPEG are followed by its end marker: the decoder would fill
/// missing pixels with grey. Neither marker can occur among pixels.
fn is_whole_jpeg(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|two| two == marker);
    last(END_OF_JPEG) > last(SCAN_OF_JPEG)
}
