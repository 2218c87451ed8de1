//! The blocks of a base map that were read last.

use super::RgbaPixel;
use std::sync::Arc;

/// Bytes of colours that are kept.
const BUDGET: usize = 96 << 20;

/// A directory of the file, and a block of it.
type BlockKey = (usize, u32);

/// Blocks, the one that was used last at the end.
#[derive(Default)]
pub(super) struct BlockCache {
    kept: Vec<(BlockKey, Arc<Vec<RgbaPixel>>)>,
    bytes: usize,
}

impl BlockCache {
    /// A block that is still there.
    pub(super) fn get(&mut self, key: BlockKey) -> Option<Arc<Vec<RgbaPixel>>> {
        let index = self.kept.iter().rposition(|(other, _)| *other == key)?;
        let found = self.kept.remove(index);
        let block = found.1.clone();
        self.kept.push(found);
        Some(block)
    }

    /// Keeps a block in place of those that were not used for longest.
    pub(super) fn keep(&mut self, key: BlockKey, block: Vec<RgbaPixel>) -> Arc<Vec<RgbaPixel>> {
        let block = Arc::new(block);
        self.bytes += size_of_val(&block[..]);
        self.kept.push((key, block.clone()));
        let mut gone = 0;
        while self.bytes > BUDGET && gone + 1 < self.kept.len() {
            self.bytes -= size_of_val(&self.kept[gone].1[..]);
            gone += 1;
        }
        self.kept.drain(..gone);
        block
    }
}
