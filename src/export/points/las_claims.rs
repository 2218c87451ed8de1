//! What a LAS header claims, held against the size of the file before the las crate allocates by it.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// LAS 1.4 R15, table 3: the header that knows extended records is this long.
const HEADER_14: u16 = 375;
/// Bytes before the data of an extended record; its length is 8 of them.
const EXTENDED_HEADER: u64 = 60;
const EXTENDED_LENGTH: u64 = 20;
/// Bit of the point format byte that marks LAZ.
const COMPRESSED: u8 = 0x80;

/// Refuses a file whose header claims an extended record, or a table of LAZ chunks, larger than the file: both are
/// allocated before they are read.
pub(super) fn check(path: &Path) -> io::Result<()> {
    let mut file = File::open(path)?;
    let len = file.metadata()?.len();
    let mut at = |offset: u64| Field::at(&mut file, offset);
    if at(94)?.u16() >= HEADER_14 && at(243)?.u32() > 0 {
        let start = at(235)?.u64();
        let data = start.saturating_add(EXTENDED_HEADER);
        if data > len || at(start + EXTENDED_LENGTH)?.u64() > len - data {
            return Err(io::Error::other(
                "its extended record reaches beyond the end of the file",
            ));
        }
    }
    if at(104)?.0[0] & COMPRESSED != 0 {
        let points = u64::from(at(96)?.u32());
        let mut table = at(points)?.i64();
        if table <= points as i64 {
            // The writer could not seek back: the place is told at the end.
            table = at(len.saturating_sub(8))?.i64();
        }
        let chunks = u64::try_from(table)
            .ok()
            .and_then(|table| table.checked_add(4));
        if let Some(chunks) = chunks.filter(|&chunks| chunks < len)
            && u64::from(at(chunks)?.u32()) > len
        {
            return Err(io::Error::other(
                "its table claims more chunks than it has bytes",
            ));
        }
    }
    Ok(())
}

/// Eight bytes at a place; zeros beyond the end of the file.
struct Field([u8; 8]);

impl Field {
    fn at(file: &mut File, offset: u64) -> io::Result<Self> {
        file.seek(SeekFrom::Start(offset))?;
        let mut read = Vec::with_capacity(8);
        file.take(8).read_to_end(&mut read)?;
        let mut bytes = [0; 8];
        for (to, from) in bytes.iter_mut().zip(read) {
            *to = from;
        }
        Ok(Self(bytes))
    }

    fn u16(&self) -> u16 {
        self.u64() as u16
    }

    fn u32(&self) -> u32 {
        self.u64() as u32
    }

    fn u64(&self) -> u64 {
        u64::from_le_bytes(self.0)
    }

    fn i64(&self) -> i64 {
        i64::from_le_bytes(self.0)
    }
}
