//! Palettes and masks for a decoder that knows neither: it is shown grey levels, which are the indices, or what is seen.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

/// The tag that says what a sample means, and its values for a palette, a mask and grey levels.
const PHOTOMETRIC: u16 = 262;
const PALETTE: u16 = 3;
const MASK: u16 = 4;
const GREY: u8 = 1;
/// Directories that are looked through.
const MOST_DIRECTORIES: usize = 64;
/// Entries that a directory may have.
const MOST_ENTRIES: u64 = 4096;

/// A file in which every palette and mask is said to be grey levels.
pub(super) struct AsGrey {
    file: BufReader<File>,
    at: u64,
    /// Where the bytes lie that say palette or mask.
    said: Vec<u64>,
}

impl AsGrey {
    /// Looks through the directories of a TIFF; what cannot be followed is left to the decoder to refuse.
    pub(super) fn new(file: File) -> io::Result<Self> {
        let mut file = BufReader::new(file);
        let said = Walk::begin(&mut file)
            .map(|walk| walk.palettes())
            .unwrap_or_default();
        file.seek(SeekFrom::Start(0))?;
        Ok(Self { file, at: 0, said })
    }
}

impl Read for AsGrey {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        for said in &self.said {
            let index = said
                .checked_sub(self.at)
                .and_then(|index| usize::try_from(index).ok());
            if let Some(byte) = index.and_then(|index| buffer[..count].get_mut(index)) {
                *byte = GREY;
            }
        }
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for AsGrey {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = self.file.seek(to)?;
        Ok(self.at)
    }
}

/// The chain of directories of a TIFF or BigTIFF.
struct Walk<'a> {
    file: &'a mut BufReader<File>,
    is_big_endian: bool,
    /// BigTIFF: offsets and counts of 8 bytes.
    is_big: bool,
    next: u64,
}

impl<'a> Walk<'a> {
    fn begin(file: &'a mut BufReader<File>) -> Option<Self> {
        let mut order = [0; 2];
        file.read_exact(&mut order).ok()?;
        let mut walk = Self {
            file,
            is_big_endian: &order == b"MM",
            is_big: false,
            next: 0,
        };
        walk.is_big = walk.number(2)? == 43;
        if walk.is_big {
            walk.number(4)?;
        }
        walk.next = walk.offset()?;
        Some(walk)
    }

    /// Where the low bytes lie of all values that say palette or mask.
    fn palettes(mut self) -> Vec<u64> {
        let mut found = Vec::new();
        for _ in 0..MOST_DIRECTORIES {
            if self.next == 0 || self.directory(&mut found).is_none() {
                break;
            }
        }
        found
    }

    fn directory(&mut self, found: &mut Vec<u64>) -> Option<()> {
        let start = self.file.seek(SeekFrom::Start(self.next)).ok()?;
        let (head, length) = if self.is_big { (8, 20) } else { (2, 12) };
        let count = self.number(head)?.min(MOST_ENTRIES);
        for index in 0..count {
            let entry = start + head as u64 + index * length;
            self.file.seek(SeekFrom::Start(entry)).ok()?;
            let tag = self.number(2)?;
            if tag == u64::from(PHOTOMETRIC) {
                // The value, a short, fills the first two bytes of the last field.
                let value = entry + length - if self.is_big { 8 } else { 4 };
                self.file.seek(SeekFrom::Start(value)).ok()?;
                if [PALETTE, MASK].map(u64::from).contains(&self.number(2)?) {
                    found.push(value + u64::from(self.is_big_endian));
                }
            }
        }
        let end = start + head as u64 + count * length;
        self.file.seek(SeekFrom::Start(end)).ok()?;
        self.next = self.offset()?;
        Some(())
    }

    fn offset(&mut self) -> Option<u64> {
        self.number(if self.is_big { 8 } else { 4 })
    }

    /// An unsigned number of up to 8 bytes.
    fn number(&mut self, bytes: usize) -> Option<u64> {
        let mut read = [0; 8];
        let read = read.get_mut(..bytes)?;
        self.file.read_exact(read).ok()?;
        let add = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        Some(match self.is_big_endian {
            true => read.iter().fold(0, add),
            false => read.iter().rev().fold(0, add),
        })
    }
}
