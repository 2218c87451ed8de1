//! Checks the sizes that the directories of a TIFF and its JPEG blocks claim, before the decoder
//! allocates memory by them. Fields as in "TIFF Revision 6.0" and the BigTIFF proposal, compression
//! 7 as in "TIFF Technical Note 2", markers of JPEG as in ITU-T T.81 (annex B).

use std::io::{self, Read, Seek, SeekFrom};
use tiff::decoder::Decoder;
use tiff::tags::{CompressionMethod, Tag};

/// Most directories of a file that are visited: pictures, overviews and masks.
const MOST_DIRECTORIES: usize = 64;
/// Most entries of a directory that are visited.
const MOST_ENTRIES: u64 = 4096;
/// Most bytes of a block, both compressed and decompressed.
const MOST_BYTES: u64 = 16 << 20;
/// Marker at the start of a stream, and marker at the start of the coded samples.
const START: u8 = 0xD8;
const SCAN: u8 = 0xDA;
/// Markers of frames (SOF0 to SOF15), and the three numbers among them with another meaning.
const FRAMES: std::ops::RangeInclusive<u8> = 0xC0..=0xCF;
const NO_FRAMES: [u8; 3] = [0xC4, 0xC8, 0xCC];

/// An entry of a directory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectoryEntry {
    /// Number of the entry's tag, which gives the meaning of the values.
    pub tag: u64,
    /// Bytes that the values claim to take.
    pub bytes: u64,
    /// Offset of the value field in the file.
    pub value_at: u64,
}

/// A walk along the chain of directories of a TIFF or BigTIFF.
pub(crate) struct DirectoryWalk<'a, R> {
    /// The file.
    pub file: &'a mut R,
    /// True if the numbers of the file are big-endian.
    pub is_big_endian: bool,
    /// True for BigTIFF, in which offsets and counts have 8 bytes.
    is_big: bool,
    next: u64,
}

impl<'a, R: Read + Seek> DirectoryWalk<'a, R> {
    /// Starts a walk over a file; `None` where its header cannot be read.
    pub(crate) fn begin(file: &'a mut R) -> Option<Self> {
        let mut order = [0; 2];
        file.read_exact(&mut order).ok()?;
        let mut walk = Self { file, is_big_endian: &order == b"MM", is_big: false, next: 0 };
        walk.is_big = walk.number(2)? == 43;
        if walk.is_big {
            walk.number(4)?;
        }
        walk.next = walk.offset()?;
        Some(walk)
    }

    /// Calls `take` with every entry, until the chain ends or cannot be followed.
    pub(crate) fn run(mut self, mut take: impl FnMut(&mut Self, DirectoryEntry) -> Option<()>) {
        for _ in 0..MOST_DIRECTORIES {
            if self.next == 0 || self.directory(&mut take).is_none() {
                break;
            }
        }
    }

    fn directory(
        &mut self,
        take: &mut impl FnMut(&mut Self, DirectoryEntry) -> Option<()>,
    ) -> Option<()> {
        let start = self.file.seek(SeekFrom::Start(self.next)).ok()?;
        let (head, length) = if self.is_big { (8, 20) } else { (2, 12) };
        let count = self.number(head)?.min(MOST_ENTRIES);
        let first = start.checked_add(head as u64)?;
        for index in 0..count {
            let entry = first.checked_add(index * length)?;
            self.file.seek(SeekFrom::Start(entry)).ok()?;
            let (tag, kind, values) = (self.number(2)?, self.number(2)?, self.offset()?);
            let entry = DirectoryEntry {
                tag,
                bytes: values.saturating_mul(bytes_of(kind)),
                value_at: entry + length - if self.is_big { 8 } else { 4 },
            };
            take(self, entry)?;
        }
        let end = first.checked_add(count * length)?;
        self.file.seek(SeekFrom::Start(end)).ok()?;
        self.next = self.offset()?;
        Some(())
    }

    fn offset(&mut self) -> Option<u64> {
        self.number(if self.is_big { 8 } else { 4 })
    }

    /// Reads an unsigned number of up to 8 bytes; `None` at the end of the file.
    pub(crate) fn number(&mut self, bytes: usize) -> Option<u64> {
        let mut read = [0; 8];
        let read = read.get_mut(..bytes)?;
        self.file.read_exact(read).ok()?;
        let add = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        Some(if self.is_big_endian {
            read.iter().fold(0, add)
        } else {
            read.iter().rev().fold(0, add)
        })
    }
}

/// Returns the bytes of one value of a type.
fn bytes_of(kind: u64) -> u64 {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => 1,
    }
}

/// Refuses a file with an entry whose values claim more bytes than the file has, because the
/// decoder would allocate memory for them before it reads them. Leaves the file at its beginning.
///
/// # Errors
/// When the file has such an entry, or the operating system cannot read the file.
pub fn check_claims<R: Read + Seek>(file: &mut R) -> io::Result<()> {
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(0))?;
    let mut is_sound = true;
    if let Some(walk) = DirectoryWalk::begin(file) {
        walk.run(|_, entry| {
            is_sound &= entry.bytes <= length;
            Some(())
        });
    }
    file.seek(SeekFrom::Start(0))?;
    if is_sound {
        Ok(())
    } else {
        Err(io::Error::new(
            io::ErrorKind::InvalidData,
            "one of its tags claims more bytes than the file has",
        ))
    }
}

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
    use std::io::Cursor;

    /// Returns a file with a directory of one entry.
    fn tiff(count: u32) -> Cursor<Vec<u8>> {
        let mut bytes = b"II*\0\x08\0\0\0\x01\0".to_vec();
        bytes.extend([0x11, 0x01, 4, 0]);
        bytes.extend(count.to_le_bytes());
        bytes.extend([0; 8]);
        Cursor::new(bytes)
    }

    #[test]
    fn what_claims_more_than_there_is_is_refused() {
        assert!(check_claims(&mut tiff(1)).is_ok());
        assert!(check_claims(&mut tiff(6)).is_ok());
        for count in [7, 8_000_000, u32::MAX] {
            let error = check_claims(&mut tiff(count)).unwrap_err();
            assert!(error.to_string().contains("more bytes"), "{error}");
        }
        assert!(check_claims(&mut Cursor::new(b"II*\0".to_vec())).is_ok());
    }

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
        let file = |columns, rows| Cursor::new([&[9, 9, 9], &stream(columns, rows)[..]].concat());
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
