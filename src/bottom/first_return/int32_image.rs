//! Reads the picture as the published code does: four stored bytes as one little-endian int32.
//!
//! The rows of a composite picture run from far port over the middle to far starboard, and a word
//! takes four neighbours in that order. Outward from the middle, the most significant byte of word
//! `k` is therefore sample `4 k + 3` on starboard and sample `4 k` on port. A word is negative when
//! that byte is 128 or more.

use bathyscope_log::survey::{SampleOrder, Samples, Side};

/// Samples in a word.
pub(super) const WORD: usize = 4;

/// Returns the words of one side that lie completely beyond `dead` samples, nearest first.
pub(super) fn outward<'a>(
    samples: Samples<'a>,
    side: Side,
    dead: usize,
) -> impl Iterator<Item = i32> + 'a {
    (dead.div_ceil(WORD)..samples.len() / WORD).map(move |index| word(&samples, side, index))
}

fn word(samples: &Samples, side: Side, index: usize) -> i32 {
    let outward: [u8; WORD] = std::array::from_fn(|byte| samples.get(WORD * index + byte));
    match side {
        Side::Starboard => i32::from_le_bytes(outward),
        Side::Port => i32::from_be_bytes(outward),
    }
}

/// Returns the stored bytes beyond `dead` samples outward, in stored order.
pub(super) fn beyond(stored: &[u8], order: SampleOrder, dead: usize) -> &[u8] {
    let dead = dead.min(stored.len());
    match order {
        SampleOrder::NearToFar => &stored[dead..],
        SampleOrder::FarToNear => &stored[..stored.len() - dead],
    }
}
