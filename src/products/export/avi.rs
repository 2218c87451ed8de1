//! Writes a film as Motion JPEG in AVI. Every frame is a separate picture, which every player opens
//! and no patent covers, and the file is written as it grows. The layout follows Microsoft's AVI
//! RIFF File Reference and OpenDML's `MJPG`.

use image::RgbImage;
use image::codecs::jpeg::JpegEncoder;
use std::io::{self, Seek, SeekFrom, Write};

/// Largest size of a film, bytes: players of this format count in 31 bits.
pub const LARGEST: u64 = 0x7fff_ffff;
/// Quality of the pictures, 1 to 100: at this quality speckle is kept and no JPEG artefact is
/// visible.
const QUALITY: u8 = 90;
/// Bytes from the start of the file to the first frame.
const HEAD: u32 = 224;
/// Flag of a frame that playing can start with; every frame has it.
const KEY_FRAME: u32 = 0x10;
/// Flag of a film with an index at the end.
const HAS_INDEX: u32 = 0x10;

/// Writes a film, frame by frame.
pub struct AviWriter<W> {
    out: W,
    size: [u32; 2],
    frames_per_s: u32,
    /// Start of each frame, counted from the word `movi`, and its length, both in bytes.
    frames: Vec<[u32; 2]>,
    /// Number of bytes of all frames with their heads.
    bytes: u32,
    jpeg: Vec<u8>,
}

impl<W: Write + Seek> AviWriter<W> {
    /// Begins a film with frames of `size` pixels.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(mut out: W, size: [u32; 2], frames_per_s: u32) -> io::Result<Self> {
        out.write_all(&[0; HEAD as usize])?;
        Ok(Self {
            out,
            size,
            frames_per_s: frames_per_s.max(1),
            frames: Vec::new(),
            bytes: 0,
            jpeg: Vec::new(),
        })
    }

    /// Adds a frame of the film's size.
    ///
    /// # Errors
    /// When the frame cannot be written or has another size, or the film would be larger than
    /// players can read.
    pub fn push(&mut self, picture: &RgbImage) -> io::Result<()> {
        if <[u32; 2]>::from(picture.dimensions()) != self.size {
            return Err(io::Error::other("a frame has another size than the film"));
        }
        self.jpeg.clear();
        let mut encoder = JpegEncoder::new_with_quality(&mut self.jpeg, QUALITY);
        encoder.encode_image(picture).map_err(io::Error::other)?;
        let length = self.jpeg.len() as u32;
        let padded = length + length % 2;
        if u64::from(HEAD) + self.bytes_with_index() + u64::from(padded) + 24 > LARGEST {
            return Err(io::Error::other("the film is larger than 2 GB"));
        }
        self.out.write_all(b"00dc")?;
        self.out.write_all(&length.to_le_bytes())?;
        self.jpeg.resize(padded as usize, 0);
        self.out.write_all(&self.jpeg)?;
        self.frames.push([4 + self.bytes, length]);
        self.bytes += 8 + padded;
        Ok(())
    }

    /// Returns the number of bytes of the frames and of their index.
    pub fn bytes_with_index(&self) -> u64 {
        u64::from(self.bytes) + 16 * self.frames.len() as u64
    }

    /// Writes the index and the head; returns the output.
    pub fn finish(mut self) -> io::Result<W> {
        let index = 16 * self.frames.len() as u32;
        self.out.write_all(b"idx1")?;
        self.out.write_all(&index.to_le_bytes())?;
        for [offset, length] in &self.frames {
            self.out.write_all(b"00dc")?;
            for word in [KEY_FRAME, *offset, *length] {
                self.out.write_all(&word.to_le_bytes())?;
            }
        }
        self.out.seek(SeekFrom::Start(0))?;
        let head = self.head();
        self.out.write_all(&head)?;
        self.out.flush()?;
        Ok(self.out)
    }

    fn head(&self) -> Vec<u8> {
        let mut head = Vec::with_capacity(HEAD as usize);
        let name = |head: &mut Vec<u8>, name: &[u8; 4]| head.extend_from_slice(name);
        let words = |head: &mut Vec<u8>, words: &[u32]| {
            words.iter().for_each(|word| head.extend_from_slice(&word.to_le_bytes()));
        };
        let [width, height] = self.size;
        let count = self.frames.len() as u32;
        let largest = self.frames.iter().map(|frame| frame[1]).max().unwrap_or(0);
        let index = 16 * count;
        name(&mut head, b"RIFF");
        words(&mut head, &[HEAD - 8 + self.bytes + 8 + index]);
        name(&mut head, b"AVI ");
        name(&mut head, b"LIST");
        words(&mut head, &[192]);
        name(&mut head, b"hdrl");
        name(&mut head, b"avih");
        let per_frame_us = 1_000_000 / self.frames_per_s;
        let per_s = largest.saturating_mul(self.frames_per_s);
        words(&mut head, &[56, per_frame_us, per_s, 0, HAS_INDEX, count]);
        // Initial frames, streams, buffer, sides, and four unused words.
        words(&mut head, &[0, 1, largest, width, height]);
        words(&mut head, &[0; 4]);
        name(&mut head, b"LIST");
        words(&mut head, &[116]);
        name(&mut head, b"strl");
        name(&mut head, b"strh");
        words(&mut head, &[56]);
        name(&mut head, b"vids");
        name(&mut head, b"MJPG");
        // Flags, priority, initial frames, scale, rate, start, length, buffer, quality, sample
        // size.
        words(&mut head, &[0, 0, 0, 1, self.frames_per_s, 0, count, largest, u32::MAX, 0]);
        for side in [0, 0, width as u16, height as u16] {
            head.extend_from_slice(&side.to_le_bytes());
        }
        name(&mut head, b"strf");
        words(&mut head, &[40, 40, width, height]);
        for short in [1_u16, 24] {
            head.extend_from_slice(&short.to_le_bytes());
        }
        name(&mut head, b"MJPG");
        words(&mut head, &[3 * width * height, 0, 0, 0, 0]);
        name(&mut head, b"LIST");
        words(&mut head, &[4 + self.bytes]);
        name(&mut head, b"movi");
        head
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;
    use std::io::Cursor;

    fn word(bytes: &[u8], at: usize) -> usize {
        u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize
    }

    /// Walks the chunks as a player does.
    #[test]
    fn a_player_finds_every_frame() {
        let shades = [10_u8, 120, 250];
        let mut film = AviWriter::new(Cursor::new(Vec::new()), [33, 17], 25).expect("a film");
        for shade in shades {
            let frame = RgbImage::from_pixel(33, 17, Rgb([shade, shade, 40]));
            film.push(&frame).expect("a frame");
        }
        assert!(film.push(&RgbImage::new(4, 4)).is_err());
        let bytes = film.finish().expect("a film").into_inner();
        assert_eq!((&bytes[..4], &bytes[8..12]), (&b"RIFF"[..], &b"AVI "[..]));
        assert_eq!(word(&bytes, 4) + 8, bytes.len());
        // The lists follow each other: head, frames, index.
        assert_eq!(&bytes[12..16], b"LIST");
        let movi = 20 + word(&bytes, 16);
        assert_eq!((&bytes[20..24], &bytes[movi..movi + 4]), (&b"hdrl"[..], &b"LIST"[..]));
        assert_eq!(&bytes[movi + 8..movi + 12], b"movi");
        assert_eq!(movi + 12, HEAD as usize);
        let index = movi + 8 + word(&bytes, movi + 4);
        assert_eq!(&bytes[index..index + 4], b"idx1");
        assert_eq!(word(&bytes, index + 4), 16 * shades.len());
        for (number, shade) in shades.into_iter().enumerate() {
            let entry = index + 8 + 16 * number;
            let [at, length] = [8, 12].map(|offset| word(&bytes, entry + offset));
            let chunk = movi + 8 + at;
            assert_eq!(&bytes[chunk..chunk + 4], b"00dc");
            assert_eq!(word(&bytes, chunk + 4), length);
            let jpeg = &bytes[chunk + 8..chunk + 8 + length];
            let frame = image::load_from_memory(jpeg).expect("a JPEG").to_rgb8();
            assert_eq!(frame.dimensions(), (33, 17));
            assert!(frame.get_pixel(16, 8).0[0].abs_diff(shade) < 4);
        }
        // The values that a player reads: microseconds a frame, frames, width and height; and of
        // the stream its rate and length.
        assert_eq!(word(&bytes, 32), 40_000);
        assert_eq!([48, 64, 68].map(|at| word(&bytes, at)), [3, 33, 17]);
        assert_eq!([132, 140].map(|at| word(&bytes, at)), [25, 3]);
    }
}
