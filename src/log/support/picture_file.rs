//! Pictures of other programs, PNG and JPEG, unpacked within a bound of memory, whatever they state
//! of themselves. It depends on no other module; any may use it.

use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use std::io::{self, BufRead, Seek};

/// Reason why a picture cannot be unpacked, in a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum PictureFault {
    /// The system does not give it.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The decoder refuses it.
    #[error(transparent)]
    Undecodable(#[from] ImageError),
    /// It ends too early, or contradicts itself.
    #[error("it is cut or damaged")]
    Damaged,
    /// It takes too much memory.
    #[error(
        "its {width} by {height} pixels take more than {} MiB to unpack; cut it into pieces, or save it as grey with 8 bits", .most_bytes >> 20
    )]
    TooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Bytes that it may take.
        most_bytes: u64,
    },
}

/// The decoder of a picture that takes so many bytes at most while it is unpacked. `copied` says
/// how many bytes a pixel takes in copies that are made beside the picture, by its colours.
///
/// # Errors
/// When its header cannot be read, or it is too large.
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
        // A progressive one is held as 16-bit coefficients.
        bytes = bytes.saturating_add(decoder.total_bytes().saturating_mul(2));
    }
    if bytes > most_bytes {
        Err(PictureFault::TooLarge { width, height, most_bytes })
    } else {
        Ok(decoder)
    }
}
