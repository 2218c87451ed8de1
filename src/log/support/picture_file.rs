//! Decodes pictures of other programs, PNG and JPEG, within a limit of memory, whatever size their
//! headers state. This module depends on no other module of the crate.

use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use std::io::{self, BufRead, Seek};

/// Reason why a picture cannot be decoded; its text is a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum PictureFault {
    /// The system cannot read the picture.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The decoder refuses the picture.
    #[error(transparent)]
    Undecodable(#[from] ImageError),
    /// The picture ends too early, or contradicts itself.
    #[error("it is cut or damaged")]
    Damaged,
    /// The picture needs too much memory.
    #[error(
        "its {width} by {height} pixels take more than {} MiB to unpack; cut it into pieces, or save it as grey with 8 bits", .most_bytes >> 20
    )]
    TooLarge {
        /// Width, pixels.
        width: u32,
        /// Height, pixels.
        height: u32,
        /// Allowed number of bytes.
        most_bytes: u64,
    },
}

/// Creates the decoder of a picture that needs `most_bytes` at most while it is decoded. `copied`
/// returns, by the colours of the picture, the bytes per pixel of the copies that the caller makes
/// of it.
///
/// # Errors
/// When the header of the picture cannot be read, or the picture needs more than `most_bytes`.
pub fn bounded_decoder<'a>(
    from: impl BufRead + Seek + 'a,
    most_bytes: u64,
    copied: fn(ColorType) -> u64,
) -> Result<impl ImageDecoder + 'a, PictureFault> {
    let mut reader = ImageReader::new(from).with_guessed_format()?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(most_bytes);
    reader.limits(limits);
    let format = reader.format();
    let decoder = reader.into_decoder()?;
    let (width, height) = decoder.dimensions();
    let copies = copied(decoder.color_type());
    let mut bytes = (u64::from(width) * u64::from(height)).saturating_mul(copies);
    bytes = bytes.saturating_add(decoder.total_bytes());
    if format == Some(ImageFormat::Jpeg) {
        // The decoder keeps a progressive JPEG as 16-bit coefficients.
        bytes = bytes.saturating_add(decoder.total_bytes().saturating_mul(2));
    }
    if bytes > most_bytes {
        Err(PictureFault::TooLarge { width, height, most_bytes })
    } else {
        Ok(decoder)
    }
}
