//! Encodes pictures for the page: pixels as PNG or JPEG, and these as text.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};

/// JPEG quality of noisy pictures: speckle hides the losses.
const JPEG_QUALITY: u8 = 82;

/// Encodes pixels of 4 bytes, row by row, as the address of a PNG.
pub(super) fn rgba(pixels: &[u8], width: usize, height: usize) -> String {
    let mut png = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive);
    let written =
        encoder.write_image(pixels, width as u32, height as u32, ExtendedColorType::Rgba8);
    address("image/png", written.is_ok().then_some(png))
}

/// Encodes pixels of one byte, row by row, as the address of a JPEG.
pub(super) fn grey(pixels: &[u8], width: usize, height: usize) -> String {
    let mut jpeg = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY);
    let written = encoder.write_image(pixels, width as u32, height as u32, ExtendedColorType::L8);
    address("image/jpeg", written.is_ok().then_some(jpeg))
}

/// Returns the address of a picture; empty where encoding failed, so that the page shows the
/// description instead.
fn address(kind: &str, picture: Option<Vec<u8>>) -> String {
    picture.map_or_else(String::new, |picture| {
        format!("data:{kind};base64,{}", STANDARD.encode(picture))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_from_its_address() {
        let pixels: Vec<u8> = (0..6 * 5 * 4).map(|byte| byte as u8 * 2).collect();
        let text = rgba(&pixels, 6, 5);
        let encoded = text.strip_prefix("data:image/png;base64,").unwrap();
        let back = image::load_from_memory(&STANDARD.decode(encoded).unwrap()).unwrap();
        assert_eq!(back.to_rgba8().into_raw(), pixels);
    }

    #[test]
    fn a_picture_that_cannot_be_made_has_no_address() {
        assert_eq!(address("image/png", None), "");
    }
}
