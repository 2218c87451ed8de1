//! A zip archive of one file (PKWARE APPNOTE 6.3), which is all that a KMZ is: three headers around
//! a deflated text.
//!
//! The `zip` crate would do, but switches features of crates that the GPU and the network runtime
//! are built on.

use flate2::write::DeflateEncoder;
use flate2::{Compression, CrcWriter};
use std::fs::File;
use std::io::{self, BufWriter, Seek as _, SeekFrom, Write};

/// "Version needed": 2.0, deflate.
const VERSION: u16 = 20;
/// Method 8, deflate.
const DEFLATE: u16 = 8;
/// The first of January 1980, so that the same survey gives the same file.
const DATE: u16 = 0x0021;

/// Writes an archive that holds one file, with what `write` puts into it.
pub(super) fn one_file<T>(
    file: File,
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> io::Result<T> {
    let mut out = BufWriter::new(file);
    // Check sum and sizes are filled in once they are known.
    out.write_all(&local_header(name, [0; 3]))?;
    let start = out.stream_position()?;
    let mut counted = ByteCounter {
        inner: CrcWriter::new(DeflateEncoder::new(out, Compression::default())),
        bytes: 0,
    };
    let made = write(&mut counted)?;
    let (crc, bytes) = (counted.inner.crc().sum(), counted.bytes);
    let mut out = counted.inner.into_inner().finish()?;
    let end = out.stream_position()?;
    let [packed, bytes, place] = [end - start, bytes, end].map(u32::try_from);
    let too_large = |_| io::Error::other("the archive would pass 4 GB, which zip cannot hold");
    let (packed, bytes) = (packed.map_err(too_large)?, bytes.map_err(too_large)?);
    let sizes = [crc, packed, bytes];
    let directory = directory(name, sizes);
    out.write_all(&directory)?;
    out.write_all(&end_record(directory.len() as u32, place.map_err(too_large)?))?;
    out.seek(SeekFrom::Start(0))?;
    out.write_all(&local_header(name, sizes))?;
    out.flush()?;
    Ok(made)
}

struct ByteCounter<W> {
    inner: W,
    bytes: u64,
}

impl<W: Write> Write for ByteCounter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Returns the fields that both headers of a file share: version, flags, method, time, date, check
/// sum, sizes, length of the name, extra fields.
fn shared(name: &str, sizes: [u32; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for value in [VERSION, 0, DEFLATE, 0, DATE] {
        bytes.extend(value.to_le_bytes());
    }
    for value in sizes {
        bytes.extend(value.to_le_bytes());
    }
    for value in [name.len() as u16, 0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

fn local_header(name: &str, sizes: [u32; 3]) -> Vec<u8> {
    [b"PK\x03\x04", shared(name, sizes).as_slice(), name.as_bytes()].concat()
}

/// The directory's entry: made by which version, the shared part, then comment, disk, attributes
/// and place, all 0.
fn directory(name: &str, sizes: [u32; 3]) -> Vec<u8> {
    let made_by = VERSION.to_le_bytes();
    let parts =
        [b"PK\x01\x02", made_by.as_slice(), &shared(name, sizes), &[0; 14], name.as_bytes()];
    parts.concat()
}

/// Returns the end record of the archive: one entry, on one disk; length and place of the
/// directory; no comment.
fn end_record(length: u32, place: u32) -> Vec<u8> {
    let mut bytes = b"PK\x05\x06\0\0\0\0\x01\0\x01\0".to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend(place.to_le_bytes());
    bytes.extend([0, 0]);
    bytes
}
