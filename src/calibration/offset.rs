//! The constant between first-return ranges and recorded depths.

use super::scale::Usable;
use crate::statistics::median;
use crate::survey::Side;

/// Pings that are looked at together: long enough to quiet the noise of the recorded depth, short against slopes.
const BLOCK_PINGS: usize = 24;
/// Picks on each side of a block, at least.
const MIN_PICKS: usize = 8;
/// Blocks that an offset rests on, at least.
const MIN_BLOCKS: usize = 3;

/// The picks, which are in ping order, in blocks of pings.
pub(super) fn blocks(picks: &[Usable]) -> impl Iterator<Item = &[Usable]> {
    picks.chunk_by(|a, b| a.ping / BLOCK_PINGS == b.ping / BLOCK_PINGS)
}

/// How much longer than the recorded depth a first-return range is where nothing but the instrument makes a difference;
/// negative when the first return is picked early. `None` without enough picks on both sides.
///
/// On a slope the nearest bottom on the upper side is nearer than the water is deep, so the deeper side of each block of
/// pings speaks: there, the nearest bottom is straight below.
pub(super) fn range_offset_m(picks: &[Usable]) -> Option<f64> {
    let mut offsets: Vec<f64> = blocks(picks)
        .filter_map(|block| {
            let [port_m, starboard_m] = Side::BOTH.map(|side| excess_m(block, side));
            Some(port_m?.max(starboard_m?))
        })
        .collect();
    (offsets.len() >= MIN_BLOCKS).then(|| median(&mut offsets))
}

/// Median of range minus recorded depth on one side.
fn excess_m(block: &[Usable], side: Side) -> Option<f64> {
    let picks = block.iter().filter(|pick| pick.side == side);
    let mut excess: Vec<f64> = picks.map(|pick| pick.range_m - pick.depth_m).collect();
    (excess.len() >= MIN_PICKS).then(|| median(&mut excess))
}
