//! The read-only memory map of a log.

use crate::support::regular_file;
use crate::survey::Bytes;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Maps a file for reading; an empty file, which no system maps, becomes empty bytes. A pipe or a device is refused.
///
/// The map follows the file: another process that rewrites it in place changes the picture, and one that truncates it
/// makes the system stop this process (SIGBUS) at the next touch of the missing pages. Recorders write logs once, so that risk
/// is taken for not reading gigabytes before the first picture; `removable` keeps it from logs on a card that may be pulled out.
pub(super) fn map(path: &Path) -> io::Result<Bytes> {
    let file = regular_file::open(path)?;
    let length = file.metadata()?.len();
    map_beginning(&file, length)
}

/// Maps the first bytes of an open file, which nobody changes or takes away: others may only add to it behind them.
pub(super) fn map_beginning(file: &File, length: u64) -> io::Result<Bytes> {
    let length = usize::try_from(length).map_err(io::Error::other)?;
    if length == 0 {
        return Ok(Bytes::Held(Arc::default()));
    }
    // SAFETY: the file is only read and the map is never written through; its bytes are only ever read as plain
    // integers, floats and byte slices, for which every bit pattern is valid, and no reference outlives the `Arc`.
    // What stays with the user is said above: no other process may truncate the file while it is open.
    #[allow(unsafe_code)]
    let map = unsafe { memmap2::MmapOptions::new().len(length).map(file)? };
    Ok(Bytes::Mapped(Arc::new(map)))
}
