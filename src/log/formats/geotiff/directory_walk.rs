//! Walks through the stored directories of a TIFF and checks the sizes that they claim, before the
//! decoder allocates memory by them. Fields as in "TIFF Revision 6.0" and the BigTIFF proposal.

use std::io::{self, Read, Seek, SeekFrom};

/// Most directories of a file that are visited: pictures, overviews and masks.
const MOST_DIRECTORIES: usize = 64;
/// Most entries of a directory that are visited.
const MOST_ENTRIES: u64 = 4096;

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
}
