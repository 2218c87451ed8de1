//! Palettes and masks for a decoder that knows neither: it is shown grey levels, which are the
//! indices, or what is seen.

use crate::formats::geotiff::{DirectoryWalk, check_claims};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

/// The tag that says what a sample means, and its values for a palette, a mask and grey levels.
const PHOTOMETRIC: u16 = 262;
const PALETTE: u16 = 3;
const MASK: u16 = 4;
const GREY: u8 = 1;

/// A file in which every palette and mask is said to be grey levels.
pub(super) struct AsGrey {
    file: BufReader<File>,
    at: u64,
    /// Offsets of the bytes that say palette or mask.
    said: Vec<u64>,
}

impl AsGrey {
    /// Looks through the directories of a TIFF; what cannot be followed is left to the decoder to
    /// refuse.
    pub(super) fn new(file: File) -> io::Result<Self> {
        let mut file = BufReader::new(file);
        check_claims(&mut file)?;
        let said = palettes(&mut file);
        file.seek(SeekFrom::Start(0))?;
        Ok(Self { file, at: 0, said })
    }
}

impl Read for AsGrey {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        for said in &self.said {
            let index = said.checked_sub(self.at).and_then(|index| usize::try_from(index).ok());
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

/// Returns the offsets of the low bytes of all values that say palette or mask.
fn palettes(file: &mut BufReader<File>) -> Vec<u64> {
    let mut found = Vec::new();
    if let Some(walk) = DirectoryWalk::begin(file) {
        walk.run(|walk, entry| {
            if entry.tag == u64::from(PHOTOMETRIC) {
                // The value, a short, fills the first two bytes of the last field.
                walk.file.seek(SeekFrom::Start(entry.value_at)).ok()?;
                if [PALETTE, MASK].map(u64::from).contains(&walk.number(2)?) {
                    found.push(entry.value_at + u64::from(walk.is_big_endian));
                }
            }
            Some(())
        });
    }
    found
}
