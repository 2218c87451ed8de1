//! Where the recorder's own depth can be believed.
//!
//! A recorder that loses the bottom goes on writing depths: on the river survey of the tests the
//! last quarter of the log jumps between one and four times the depth within a second. Nothing may
//! lean on such depths, but they stay visible.

use super::{SidePing, Sounding, nearest_in_time};
use crate::support::statistics::upper_median;

/// A step between soundings is a jump beyond this many metres and this share of the depth: at any
/// boat's speed a bed that rises so from one sounding to the next stands upright.
const JUMP_M: f32 = 0.5;
const JUMP_SHARE: f32 = 0.15;
/// Soundings further apart in time are not compared, seconds.
const NEIGHBOURS_S: f64 = 1.0;
/// Jumps that follow each other within this time are one loss of the bottom, seconds.
const TOGETHER_S: f64 = 3.0;
/// So many jumps together are a loss; fewer are boulders, piers and ledges, which come in twos.
const JUMPS: usize = 4;
/// Soundings to both sides of one that a glitch is judged against.
const REACH: usize = 4;

/// A side-scan ping takes its depth from the nearest sounding, not from one this far away in time,
/// seconds.
pub(super) const NEAREST_SOUNDING_S: f64 = 5.0;
/// How far back the lock is looked at anew where soundings are added: unless the bottom is lost for
/// longer, it is quiet somewhere there.
const LONGEST_LOSS: usize = 4096;

/// Gives every ping the depth of the sounding nearest in time. Both are in time order.
pub(crate) fn give_depths(pings: &mut [SidePing], soundings: &[Sounding]) {
    for ping in pings {
        let nearest = nearest_in_time(soundings, ping.time_s, |sounding| sounding.time_s)
            .map(|index| &soundings[index])
            .filter(|sounding| (sounding.time_s - ping.time_s).abs() <= NEAREST_SOUNDING_S);
        ping.depth_m = nearest.map_or(f32::NAN, |sounding| sounding.depth_m);
        ping.depth_locked = nearest.is_some_and(|sounding| sounding.locked);
    }
}

/// As [`mark_bottom_lock`], where all before `from` was marked already and what follows is new.
/// Returns the first sounding that was marked anew.
pub(super) fn mark_bottom_lock_from(soundings: &mut [Sounding], from: usize) -> usize {
    let from = from.min(soundings.len());
    let mut quiet = from;
    // Back to where no jump belongs to one that comes after: to the last jump that is followed by a
    // pause.
    for index in (from.saturating_sub(LONGEST_LOSS)..from).rev() {
        let after = soundings.get(quiet).unwrap_or(&soundings[index]);
        if after.time_s - soundings[index].time_s > 2.0 * TOGETHER_S {
            break;
        }
        if index > 0 && is_jump(soundings, index) {
            quiet = index;
        }
    }
    let first = quiet.saturating_sub(REACH + 1);
    let start = first.saturating_sub(2 * REACH + 1);
    let mut tail = soundings[start..].to_vec();
    mark_bottom_lock(&mut tail);
    // The first ones of the tail lack their neighbours.
    soundings[first..].copy_from_slice(&tail[first - start..]);
    first
}

/// Sets [`Sounding::locked`]: false from the first to the last jump of a loss of the bottom, to the
/// end of a log that ends in one, and on single glitches.
pub fn mark_bottom_lock(soundings: &mut [Sounding]) {
    for sounding in &mut *soundings {
        sounding.locked = true;
    }
    let glitches: Vec<usize> =
        (0..soundings.len()).filter(|&index| is_glitch(soundings, index)).collect();
    let jumps: Vec<usize> =
        (1..soundings.len()).filter(|&index| is_jump(soundings, index)).collect();
    let together = |a: &usize, b: &usize| soundings[*b].time_s - soundings[*a].time_s < TOGETHER_S;
    let end = soundings.len().saturating_sub(1);
    let until = |last: usize| if together(&last, &end) { end } else { last };
    let losses: Vec<_> = jumps
        .chunk_by(together)
        .filter(|loss| loss.len() >= JUMPS)
        .map(|loss| loss[0]..=until(loss[loss.len() - 1]))
        .collect();
    let lost = losses.into_iter().flatten();
    for index in lost.chain(glitches) {
        soundings[index].locked = false;
    }
}

fn differ(a: &Sounding, b: &Sounding) -> bool {
    (a.depth_m - b.depth_m).abs() > JUMP_M.max(JUMP_SHARE * a.depth_m.min(b.depth_m))
}

fn is_jump(soundings: &[Sounding], index: usize) -> bool {
    let (before, here) = (&soundings[index - 1], &soundings[index]);
    here.time_s - before.time_s < NEIGHBOURS_S && differ(before, here)
}

/// Whether a sounding departs from the median of those around it, which was taken soon before or
/// after.
fn is_glitch(soundings: &[Sounding], index: usize) -> bool {
    let around = index.saturating_sub(REACH)..(index + REACH + 1).min(soundings.len());
    if around.len() <= REACH {
        return false;
    }
    let mut near: Vec<Sounding> = soundings[around].to_vec();
    let here = &soundings[index];
    upper_median(&mut near, |a, b| a.depth_m.total_cmp(&b.depth_m)).is_some_and(|median| {
        (median.time_s - here.time_s).abs() < TOGETHER_S && differ(&median, here)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn locked(depths: impl Iterator<Item = f32>) -> Vec<bool> {
        let mut soundings: Vec<Sounding> = depths
            .enumerate()
            .map(|(index, depth_m)| Sounding { time_s: 0.1 * index as f64, depth_m, locked: false })
            .collect();
        mark_bottom_lock(&mut soundings);
        soundings.iter().map(|sounding| sounding.locked).collect()
    }

    fn all_locked<'a>(locked: impl IntoIterator<Item = &'a bool>) -> bool {
        locked.into_iter().all(|locked| *locked)
    }

    /// Depths about a bed of 1.5 m while the recorder has lost it.
    fn wandering(lost: std::ops::Range<usize>) -> impl Fn(usize) -> f32 {
        move |i| match lost.contains(&i) {
            true => [1.5, 5.0, 3.0, 6.0][i / 7 % 4],
            false => 1.5,
        }
    }

    #[test]
    fn slopes_noise_and_ledges_keep_the_lock() {
        let slope = locked((0..300).map(|i| 2.0 + 0.02 * i as f32));
        let noise = locked((0..300).map(|i| 2.0 + 0.1 * (i % 3) as f32));
        assert!(all_locked(&slope) && all_locked(&noise));
        // A block on the bed, a metre high and two seconds long.
        let block = |i| if (100..120).contains(&i) { 2.0 } else { 3.0 };
        assert!(all_locked(&locked((0..300).map(block))));
    }

    #[test]
    fn a_wandering_lock_is_lost_from_its_first_to_its_last_jump() {
        let locked = locked((0..300).map(wandering(100..200)));
        assert!(all_locked(locked[..90].iter().chain(&locked[210..])));
        assert!(locked[110..190].iter().all(|locked| !*locked));
    }

    #[test]
    fn a_log_that_ends_without_the_bottom_does_not_find_it_in_its_last_second() {
        let locked = locked((0..160).map(wandering(100..160)));
        assert!(locked[110..].iter().all(|locked| !*locked));
    }

    #[test]
    fn soundings_that_are_added_are_marked_as_if_they_had_been_there() {
        let depth = |i: usize| match i {
            100..180 => [1.5, 5.0, 3.0, 6.0][i / 7 % 4],
            250 => 9.0,
            _ => 2.0,
        };
        let sounding = |index: usize| Sounding {
            time_s: 0.1 * index as f64,
            depth_m: depth(index),
            locked: false,
        };
        let mut whole: Vec<Sounding> = (0..300).map(sounding).collect();
        mark_bottom_lock(&mut whole);
        for shorter in (1..300).step_by(3) {
            let mut grown = whole[..shorter].to_vec();
            mark_bottom_lock(&mut grown);
            grown.extend((shorter..300).map(sounding));
            mark_bottom_lock_from(&mut grown, shorter);
            assert_eq!(grown, whole, "grown from {shorter} soundings");
        }
    }

    #[test]
    fn one_wild_depth_is_a_glitch() {
        let locked = locked((0..50).map(|i| if i == 20 { 9.0 } else { 2.0 }));
        let wild: Vec<usize> = (0..50).filter(|&i| !locked[i]).collect();
        assert_eq!(wild, [20]);
    }
}
