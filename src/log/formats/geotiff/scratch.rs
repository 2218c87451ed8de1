//! Keeps packed tiles in a file until the lengths of all of them are known.

use super::pack::Packed;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};

/// Place of some bytes in the scratch file.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScratchBlock {
    at: u64,
    /// Their number.
    pub length: u32,
}

/// A tile in the scratch file, and its mask where it has one.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScratchTile {
    pub image: ScratchBlock,
    pub mask: Option<ScratchBlock>,
}

/// Packed tiles in the order in which they were made.
pub(super) struct Scratch {
    file: File,
    end: u64,
}

impl Scratch {
    /// Creates a store of tiles in an empty file.
    pub(super) fn new(file: File) -> Self {
        Self { file, end: 0 }
    }

    /// Adds a tile.
    pub(super) fn keep(&mut self, packed: &Packed) -> io::Result<ScratchTile> {
        let image = self.append(&packed.image)?;
        let mask = match &packed.mask {
            Some(mask) => Some(self.append(mask)?),
            None => None,
        };
        Ok(ScratchTile { image, mask })
    }

    fn append(&mut self, bytes: &[u8]) -> io::Result<ScratchBlock> {
        let length = u32::try_from(bytes.len()).map_err(io::Error::other)?;
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(bytes)?;
        let block = ScratchBlock { at: self.end, length };
        self.end += u64::from(length);
        Ok(block)
    }

    /// Replaces `out` with the bytes of a block.
    pub(super) fn read(&mut self, block: ScratchBlock, out: &mut Vec<u8>) -> io::Result<()> {
        out.resize(block.length as usize, 0);
        self.file.seek(SeekFrom::Start(block.at))?;
        self.file.read_exact(out)
    }
}
