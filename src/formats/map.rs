//! The read-only memory map of a log.

use crate::survey::Bytes;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Maps a file for reading; an empty file, which no system maps, becomes empty bytes. A pipe or a device is refused before
/// it is opened: opening a pipe waits for somebody to write.
///
/// The map follows the file: another process that rewrites it in place changes the picture, and one that truncates it
/// makes the system stop this process (SIGBUS) at the next touch of the missing pages. Recorders write logs once, so that risk
/// is taken for not reading gigabytes before the first picture; `medium` keeps it from logs on a card that may be pulled out.
pub(super) fn map(path: &Path) -> io::Result<Bytes> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is a pipe or a device, not a file"));
    }
    let file = File::open(path)?;
    if file.metadata()?.len() == 0 {
        return Ok(Bytes::Held(Arc::default()));
    }
    // SAFETY: the file is opened read only and the map is never written through; its bytes are only ever read as plain
    // integers, floats and byte slices, for which every bit pattern is valid, and no reference outlives the `Arc`.
    // What stays with the user is said above: no other process may truncate the file while it is open.
    #[allow(unsafe_code)]
    let map = unsafe { memmap2::Mmap::map(&file)? };
    Ok(Bytes::Mapped(Arc::new(map)))
}
