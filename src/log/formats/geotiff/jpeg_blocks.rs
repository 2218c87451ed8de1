//! Checks the sizes that the JPEG blocks of a TIFF state, before the decoder allocates memory by
//! them. Compression 7 as in "TIFF Technical Note 2", markers as in ITU-T T.81 (annex B).

use std::io::{Read, Seek, SeekFrom};
use tiff::decoder::Decoder;
use tiff::tags::{CompressionMethod, Tag};

/// Most bytes of a block, both compressed and decompressed.
const MOST_BYTES: u64 = 16 << 20;
/// Marker at the start of a stream, and marker at the start of the coded samples.
const START: u8 = 0xD8;
const SCAN: u8 = 0xDA;
/// Markers of frames (SOF0 to SOF15), and the three numbers among them with another meaning.
const FRAMES: std::ops::RangeInclusive<u8> = 0xC0..=0xCF;
const NO_FRAMES: [u8; 3] = [0xC4, 0xC8, 0xCC];

/// Returns true if the blocks of a directory are JPEG streams.
pub(crate) fn is_jpeg<R: Read + Seek>(tiff: &mut Decoder<R>) -> bool {
    let method = tiff.find_tag_unsigned::<u16>(Tag::Compression);
    method.is_ok_and(|method| method == Some(CompressionMethod::ModernJPEG.to_u16()))
}

/// The blocks of a directory that are JPEG streams.
pub(crate) struct JpegBlocks {
    /// Tables that are shared by all streams and belong before each of them, without the end
    /// marker.
    tables: Vec<u8>,
    /// Offset and length of each block.
    places: Vec<[u64; 2]>,
    /// Columns and rows of a block.
    size: [u32; 2],
}

impl JpegBlocks {
    /// Reads the blocks of the current directory of the decoder; `None` where they are not JPEG
    /// streams, or the directory does not state their places.
    pub(crate) fn read<R: Read + Seek>(tiff: &mut Decoder<R>) -> Option<Self> {
        let either = |tiff: &mut Decoder<R>, tiles: Tag, strips: Tag| {
            let tiles = tiff.find_tag_unsigned_vec::<u64>(tiles).ok().flatten();
            tiles.or_else(|| tiff.find_tag_unsigned_vec(strips).ok().flatten())
        };
        if !is_jpeg(tiff) {
            return None;
        }
        let offsets = either(tiff, Tag::TileOffsets, Tag::StripOffsets)?;
        let lengths = either(tiff, Tag::TileByteCounts, Tag::StripByteCounts)?;
        let tables = tiff.find_tag(Tag::JPEGTables).ok().flatten();
        let mut tables = tables.map_or_else(Vec::new, |tag| tag.into_u8_vec().unwrap_or_default());
        tables.truncate(tables.len().saturating_sub(2));
        let places = offsets.into_iter().zip(lengths);
        Some(Self {
            tables,
            places: places.map(<[u64; 2]>::from).collect(),
            size: tiff.chunk_dimensions().into(),
        })
    }

    /// Returns true if a block states no more columns and rows than the directory, and not too many
    /// bytes when decompressed.
    pub(crate) fn is_sound<R: Read + Seek>(&self, number: u32, file: &mut R) -> bool {
        self.stream(number, file).is_some_and(|stream| {
            frame_size(&stream).is_some_and(|[columns, rows, bytes]| {
                let unpacked = [columns, rows, bytes].map(u64::from).iter().product::<u64>();
                columns <= self.size[0] && rows <= self.size[1] && unpacked <= MOST_BYTES
            })
        })
    }

    /// Returns a block as the decoder assembles it: the tables, and the stream without its start
    /// marker.
    fn stream<R: Read + Seek>(&self, number: u32, file: &mut R) -> Option<Vec<u8>> {
        let [offset, length] = *self.places.get(number as usize)?;
        if length > MOST_BYTES {
            return None;
        }
        let mut own = Vec::new();
        file.seek(SeekFrom::Start(offset)).ok()?;
        file.take(length).read_to_end(&mut own).ok()?;
        let start = if self.tables.is_empty() { 0 } else { 2 };
        Some([&self.tables, own.get(start..)?].concat())
    }
}

/// Returns the columns, the rows and the bytes a pixel of the only frame of a stream; `None` where
/// the bytes before the samples are no sequence of segments, or contain no frame or several.
fn frame_size(stream: &[u8]) -> Option<[u32; 3]> {
    let mut rest = stream.strip_prefix(&[0xFF, START])?;
    let mut found = None;
    loop {
        let [0xFF, marker, ..] = *rest else {
            return None;
        };
        rest = &rest[1..];
        if marker == 0xFF {
            continue;
        }
        if marker == SCAN {
            return found;
        }
        let segment = rest.get(1..)?;
        let length = usize::from(u16::from_be_bytes([*segment.first()?, *segment.get(1)?]));
        if FRAMES.contains(&marker) && !NO_FRAMES.contains(&marker) {
            let [_, rows_high, rows_low, columns_high, columns_low, components] =
                *segment.get(2..8)?.first_chunk()?;
            let number = |high, low| u32::from(u16::from_be_bytes([high, low]));
            let frame = [
                number(columns_high, columns_low),
                number(rows_high, rows_low),
                u32::from(components),
            ];
            if found.replace(frame).is_some() {
                return None;
            }
        }
        rest = segment.get(length.max(2)..)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a stream with a comment, a frame of these columns and rows, and no valid samples.
    fn stream(columns: u16, rows: u16) -> Vec<u8> {
        let mut bytes = vec![0xFF, START, 0xFF, 0xFE, 0, 4, 0xFF, 0xC0];
        bytes.extend([0xFF, 0xFF, 0xC0, 0, 17, 8]);
        bytes.extend(rows.to_be_bytes());
        bytes.extend(columns.to_be_bytes());
        bytes.extend([3, 1, 0x22, 0, 2, 0x11, 1, 3, 0x11, 1, 0xFF, SCAN, 0, 2]);
        bytes
    }

    #[test]
    fn a_frame_states_its_size() {
        assert_eq!(frame_size(&stream(300, 20)), Some([300, 20, 3]));
        let twice = [&stream(300, 20)[..29], &stream(300, 20)[8..]].concat();
        assert_eq!(frame_size(&twice), None);
        for length in 0..stream(300, 20).len() - 2 {
            assert_eq!(frame_size(&stream(300, 20)[..length]), None, "{length}");
        }
    }

    #[test]
    fn a_block_that_states_more_than_its_directory_is_refused() {
        let blocks = |tables: Vec<u8>| JpegBlocks {
            tables,
            places: vec![[3, 100], [3, u64::MAX]],
            size: [256, 256],
        };
        let file =
            |columns, rows| std::io::Cursor::new([&[9, 9, 9], &stream(columns, rows)[..]].concat());
        for tables in [vec![], vec![0xFF, START, 0xFF, 0xDB, 0, 3, 1]] {
            let blocks = blocks(tables);
            assert!(blocks.is_sound(0, &mut file(256, 256)));
            assert!(blocks.is_sound(0, &mut file(40, 256)));
            assert!(!blocks.is_sound(0, &mut file(257, 256)));
            assert!(!blocks.is_sound(0, &mut file(16_384, 16_384)));
            assert!(!blocks.is_sound(1, &mut file(256, 256)));
            assert!(!blocks.is_sound(2, &mut file(256, 256)));
        }
    }
}
