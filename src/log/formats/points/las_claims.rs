//! Compares the sizes that a LAS header claims with the size of the file, before the las crate
//! allocates memory by them.

use crate::support::regular_file;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// First version of LAS (bytes 24 and 25) whose header has fields for extended records (LAS 1.4
/// R15, table 3).
const VERSION_14: [u8; 2] = [1, 4];
/// Bytes before the data of an extended record, and offset of the data's length (8 bytes) in the
/// record.
const EXTENDED_HEADER: u64 = 60;
const EXTENDED_LENGTH: u64 = 20;
/// Bit of the point format byte that marks LAZ.
const COMPRESSED: u8 = 0x80;

/// User id and record id of the record that describes the compression of LAZ points.
const PACKING_USER: &[u8] = b"laszip encoded";
const PACKING_RECORD: u16 = 22_204;
/// Bytes before the data of a record that is not extended.
const RECORD_HEADER: u64 = 54;
/// Number of the compressor that compresses a chunk in layers, one for each kind of number in a
/// point.
const LAYERED: u16 = 3;

/// Refuses a file whose header claims an extended record, a table of LAZ chunks, or layers of a
/// chunk that are larger than the file, or compressed points whose length differs from that of the
/// points: the crate would allocate memory for all of these before it reads them.
pub(super) fn check(path: &Path) -> io::Result<()> {
    let mut file = regular_file::open(path)?;
    let len = file.metadata()?.len();
    let mut at = |offset: u64| Field::at(&mut file, offset);
    // The las crate uses the version and ignores the header's stated length; it reads only the
    // first extended record.
    let [major, minor, ..] = at(24)?.0;
    if [major, minor] >= VERSION_14 && at(243)?.u32() > 0 {
        let start = at(235)?.u64();
        let data = start.saturating_add(EXTENDED_HEADER);
        if data > len || at(start + EXTENDED_LENGTH)?.u64() > len - data {
            return Err(io::Error::other("its extended record reaches beyond the end of the file"));
        }
    }
    if at(104)?.0[0] & COMPRESSED != 0 {
        let points = u64::from(at(96)?.u32());
        let mut table = at(points)?.i64();
        if table <= points as i64 {
            // The writer could not seek back: the offset of the table is at the end of the file.
            table = at(len.saturating_sub(8))?.i64();
        }
        let table = u64::try_from(table).unwrap_or(len).min(len);
        let chunks = table.checked_add(4);
        if let Some(chunks) = chunks.filter(|&chunks| chunks < len)
            && u64::from(at(chunks)?.u32()) > len
        {
            return Err(io::Error::other("its table claims more chunks than it has bytes"));
        }
        if let Some(layers) = layers(&mut at, len)? {
            let record = u64::from(at(105)?.u16());
            check_layers(&mut at, points + 8, table, record, layers)?;
        }
    }
    Ok(())
}

/// Returns the number of layers in every chunk, from the record for the compression; `None` where
/// points are compressed one after the other, or there is no such record.
fn layers(at: &mut impl FnMut(u64) -> io::Result<Field>, len: u64) -> io::Result<Option<u64>> {
    let Some(data) = packing(at, len)? else {
        return Ok(None);
    };
    let (mut layers, mut bytes) = (0, 0);
    for item in 0..u64::from(at(data + 32)?.u16()) {
        let (kind, size) = (at(data + 34 + 6 * item)?.u16(), at(data + 36 + 6 * item)?.u16());
        bytes += u64::from(size);
        layers += match kind {
            10 => 9,
            12 => 2,
            // Each extra byte has its own layer.
            14 => u64::from(size),
            _ => 1,
        };
    }
    if bytes != u64::from(at(105)?.u16()) {
        return Err(io::Error::other("its points are packed with another length than they have"));
    }
    Ok((at(data)?.u16() == LAYERED).then_some(layers))
}

/// Returns the offset of the data of the record for the compression, which is one of the records,
/// or the first extended one; `None` where there is none.
fn packing(at: &mut impl FnMut(u64) -> io::Result<Field>, len: u64) -> io::Result<Option<u64>> {
    let [major, minor, ..] = at(24)?.0;
    // The records begin after the fields of this version; the header's stated length is ignored.
    let fields = match [major, minor] {
        version if version >= VERSION_14 => 375,
        [1, 3] => 235,
        _ => 227,
    };
    let mut record = u64::from(at(94)?.u16()).max(fields);
    for _ in 0..at(100)?.u32() {
        if record >= len {
            break;
        }
        let data = record + RECORD_HEADER;
        if is_packing(at, record)? {
            return Ok(Some(data));
        }
        record = data + u64::from(at(record + 20)?.u16());
    }
    if [major, minor] < VERSION_14 || at(243)?.u32() == 0 {
        return Ok(None);
    }
    let record = at(235)?.u64();
    Ok(is_packing(at, record)?.then(|| record.saturating_add(EXTENDED_HEADER)))
}

/// Returns true if a record, extended or not, is the record for the compression.
fn is_packing(at: &mut impl FnMut(u64) -> io::Result<Field>, record: u64) -> io::Result<bool> {
    let mut user = Vec::new();
    for part in [2, 10] {
        user.extend(at(record.saturating_add(part))?.0);
    }
    let number = at(record.saturating_add(18))?.u16();
    Ok(user.starts_with(PACKING_USER) && number == PACKING_RECORD)
}

/// Checks the layers of each chunk in turn. A chunk has one uncompressed point, the number of
/// points, the size of every layer, and the layers.
fn check_layers(
    at: &mut impl FnMut(u64) -> io::Result<Field>,
    mut chunk: u64,
    table: u64,
    record: u64,
    layers: u64,
) -> io::Result<()> {
    while chunk < table {
        let sizes = chunk + record + 4;
        let mut next = sizes + 4 * layers;
        for layer in 0..layers {
            next += u64::from(at(sizes + 4 * layer)?.u32());
            if next > table {
                return Err(io::Error::other("a chunk of its points reaches beyond their end"));
            }
        }
        chunk = next;
    }
    Ok(())
}

/// Eight bytes at an offset; zeros beyond the end of the file.
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
