//! Finds faults of soundings by comparing them with their neighbours along the track.
//!
//! A recorder that loses the bottom goes on writing depths: in the river survey of the tests the
//! depths of the last quarter of the log jump between one and four times the true depth within a
//! second. Such depths are not used for results, but they stay visible.

use crate::support::geo::distance_m;
use crate::support::statistics::upper_median;
use crate::survey::{Fix, SidePing, Sounding, SoundingFault, nearest_within};
use std::ops::RangeInclusive;

/// Largest step between soundings that is not a jump: metres, and share of the smaller depth,
/// whichever is larger.
const JUMP_M: f32 = 0.5;
const JUMP_SHARE: f32 = 0.15;
/// Steepest slope of a bed, metres per metre that the boat went. A step is a jump only if it is
/// steeper, as slow recorders pass a steep bank in a few soundings.
const STEEPEST: f64 = 1.0;
/// Longest time between soundings that are compared, seconds.
const NEIGHBOURS_S: f64 = 10.0;
/// Longest time, seconds, and, for slow recorders, largest number of soundings between two jumps
/// that belong to one loss of the bottom.
const TOGETHER_S: f64 = 3.0;
const TOGETHER: usize = 8;
/// Largest number of soundings before and after the jumps of a loss that are checked whether they
/// belong to it.
const BESIDE: usize = 4 * TOGETHER;
/// Fewest jumps close together, up and down, that are a loss of the bottom; fewer are boulders,
/// piers and ledges, which make two jumps each.
const JUMPS: usize = 4;
/// Smallest leap to a second echo, or to noise far below the bottom, and back: the ratio of the
/// depths, the difference, metres, and the steepness, metres per metre that the boat went. A bed
/// that really is deeper for a while has a slope on at least one side.
const LEAP_RATIO: f32 = 1.8;
const LEAP_M: f32 = 2.0;
const LEAP_STEEPNESS: f64 = 2.0;
/// Number of deep soundings between two leaps for each shallow sounding that is needed around them
/// to mark the deep ones as false. Where there are only a few shallow soundings, these are false.
const LEAP_SHARE: usize = 3;
/// Number of soundings before and after a sounding that it is compared with to find a glitch.
const REACH: usize = 4;

/// Longest time between a side-scan ping and the nearest sounding, whose depth the ping gets,
/// seconds.
pub(crate) const NEAREST_SOUNDING_S: f64 = 5.0;
/// Largest number of earlier soundings that are marked again where soundings are added: unless the
/// bottom was lost for longer, there is a stretch without jumps among them.
const LONGEST_LOSS: usize = 4096;

/// Sets depth and fault of every ping from the sounding nearest in time; NaN where none is near.
/// Soundings are in time order.
pub(crate) fn give_depths(pings: &mut [SidePing], soundings: &[Sounding]) {
    for ping in pings {
        let nearest =
            nearest_within(soundings, ping.time_s, NEAREST_SOUNDING_S, |sounding| sounding.time_s);
        ping.depth_m = nearest.map_or(f32::NAN, |sounding| sounding.depth_m);
        ping.depth_fault = nearest.and_then(|sounding| sounding.fault);
    }
}

/// Marks faults as [`mark_faults`] does, where all soundings before `from` were marked already and
/// the rest are new. Returns the index of the first sounding that was marked again.
pub(crate) fn mark_faults_from(
    soundings: &mut [Sounding],
    fixes: &[Fix],
    has_side_scan: bool,
    from: usize,
) -> usize {
    let from = from.min(soundings.len());
    let mut quiet = from;
    // Goes back until no earlier jump can belong to the same loss as a later one, that is, to a
    // long enough stretch without jumps.
    for index in (from.saturating_sub(LONGEST_LOSS)..from).rev() {
        let after_s = soundings.get(quiet).unwrap_or(&soundings[index]).time_s;
        let is_long_ago = after_s - soundings[index].time_s > 2.0 * TOGETHER_S;
        if is_long_ago && quiet - index > 2 * BESIDE {
            break;
        }
        if index > 0 && jump(soundings, fixes, index - 1, index).is_some() {
            quiet = index;
        }
    }
    // A leap below the bottom may not have been followed by the leap back yet.
    if !has_side_scan {
        let leap = (from.saturating_sub(LONGEST_LOSS).max(1)..quiet).find(|&index| {
            is_leap(soundings, fixes, index - 1, index)
                && soundings[index].depth_m > soundings[index - 1].depth_m
        });
        quiet = leap.unwrap_or(quiet);
    }
    let first = quiet.saturating_sub(BESIDE + REACH + 1);
    let counted = if has_side_scan { 0 } else { LONGEST_LOSS / LEAP_SHARE };
    let start = first.saturating_sub(2 * REACH + 1 + counted);
    let mut tail = soundings[start..].to_vec();
    mark_faults(&mut tail, fixes, has_side_scan);
    // The first soundings of the tail lack their neighbours and are not copied.
    soundings[first..].copy_from_slice(&tail[first - start..]);
    first
}

/// Sets [`Sounding::fault`] of all soundings: from the first to the last jump of a loss of the
/// bottom (or to the end of a log that ends in a loss), with the soundings beside it that are as
/// rough; between a leap far below the bottom and the leap back; and on single glitches. `fixes`
/// give the way of the boat from one sounding to the next; both are in time order. In a log with
/// side-scan, leaps mark nothing: they are checked against the first returns elsewhere.
pub fn mark_faults(soundings: &mut [Sounding], fixes: &[Fix], has_side_scan: bool) {
    for sounding in &mut *soundings {
        sounding.fault = None;
    }
    let glitches: Vec<usize> =
        (0..soundings.len()).filter(|&index| is_glitch(soundings, fixes, index)).collect();
    let others: Vec<usize> = {
        let is_spike = spikes(soundings, &glitches);
        (0..soundings.len()).filter(|&index| !is_spike[index]).collect()
    };
    let jumps: Vec<Jump> =
        others.windows(2).filter_map(|pair| jump(soundings, fixes, pair[0], pair[1])).collect();
    let together = |a: usize, b: usize| {
        b - a <= TOGETHER || soundings[b].time_s - soundings[a].time_s < TOGETHER_S
    };
    let end = soundings.len().saturating_sub(1);
    let until = |last: usize| if together(last, end) { end } else { last };
    let is_loss = |jumps: &&[Jump]| {
        let deeper = jumps.iter().filter(|jump| jump.is_deeper).count();
        jumps.len() >= JUMPS && (1..jumps.len()).contains(&deeper)
    };
    let losses: Vec<_> = jumps
        .chunk_by(|a, b| together(a.index, b.index))
        .filter(is_loss)
        .map(|loss| with_beside(soundings, loss[0].index..=until(loss[loss.len() - 1].index)))
        .collect();
    let below = if has_side_scan { Vec::new() } else { leaps_below(soundings, fixes, &others) };
    let found = [
        (SoundingFault::Glitch, glitches),
        (SoundingFault::FarBelow, below.into_iter().flatten().collect()),
        (SoundingFault::LostBottom, losses.into_iter().flatten().collect()),
    ];
    for (fault, indices) in found {
        for index in indices {
            soundings[index].fault = Some(fault);
        }
    }
}

/// Returns a loss of the bottom with the soundings before and after its jumps that belong to it:
/// random depths of a slow recorder, metres apart, are now and then no steeper than a bed. Only a
/// bed goes on as it was.
fn with_beside(soundings: &[Sounding], loss: RangeInclusive<usize>) -> RangeInclusive<usize> {
    let (first, last) = (*loss.start(), *loss.end());
    let before = rough_soundings(soundings[..first].iter().rev());
    first - before..=last + rough_soundings(&soundings[last + 1..])
}

/// Returns the number of soundings beside a loss of the bottom that belong to it; `away` leads away
/// from the loss. They end with the farthest rough one up to which half or more are rough: their
/// depth differs from that to which the next two lead by more than depths of one place do.
fn rough_soundings<'a>(away: impl IntoIterator<Item = &'a Sounding>) -> usize {
    let away: Vec<&Sounding> = away.into_iter().take(BESIDE + 2).collect();
    let (mut rough, mut belong) = (0, 0);
    for (index, three) in away.windows(3).enumerate() {
        let is_near = (three[2].time_s - three[0].time_s).abs() < 2.0 * NEIGHBOURS_S;
        if !is_near || index - belong >= TOGETHER {
            break;
        }
        let [depth_m, next_m, second_m] = [0, 1, 2].map(|at| three[at].depth_m);
        if differ_as_no_bed([depth_m, 2.0 * next_m - second_m]) {
            rough += 1;
            if 2 * rough > index {
                belong = index + 1;
            }
        }
    }
    belong
}

/// Returns for each sounding true if it is a single glitch between two soundings that agree: the
/// steps to it and back are then not counted as jumps of a loss.
fn spikes(soundings: &[Sounding], glitches: &[usize]) -> Vec<bool> {
    let mut is_spike = vec![false; soundings.len()];
    for (rank, &index) in glitches.iter().enumerate() {
        let is_beside = |other: Option<&usize>| other.is_some_and(|&at| at.abs_diff(index) == 1);
        let is_alone = !is_beside(rank.checked_sub(1).and_then(|rank| glitches.get(rank)))
            && !is_beside(glitches.get(rank + 1));
        let beside = index.checked_sub(1).map(|before| &soundings[before]);
        let agree = beside.zip(soundings.get(index + 1)).is_some_and(|(a, b)| !differ(a, b));
        is_spike[index] = is_alone && agree;
    }
    is_spike
}

/// Returns the soundings between each leap far below the bottom and the leap back; `others` are the
/// soundings that are not single spikes.
fn leaps_below(
    soundings: &[Sounding],
    fixes: &[Fix],
    others: &[usize],
) -> Vec<RangeInclusive<usize>> {
    let leaps = |at: &usize| is_leap(soundings, fixes, others[*at - 1], others[*at]);
    let depth_m = |at: usize| soundings[others[at]].depth_m;
    let below = |entry: usize| {
        let last = others.len().min(entry + LONGEST_LOSS);
        let before_m = depth_m(entry - 1);
        let back = (entry + 1..last).find(|&at| depth_m(at) < LEAP_RATIO * before_m)?;
        let least = (back - entry).div_ceil(LEAP_SHARE);
        let before = (1..entry).rev().take(least).find(leaps).unwrap_or(0);
        let after = (back + 1..others.len()).take(least).find(leaps);
        let after = after.unwrap_or(others.len());
        let is_back = leaps(&back) && depth_m(back) < depth_m(back - 1);
        let is_false = is_back && entry - before + after - back >= least;
        is_false.then_some(entry..back)
    };
    let mut found: Vec<RangeInclusive<usize>> = Vec::new();
    let mut next = 1;
    let goes_down = |at: &usize| leaps(at) && depth_m(*at) > depth_m(*at - 1);
    while let Some(entry) = (next..others.len()).find(goes_down) {
        let lost = below(entry);
        next = lost.as_ref().map_or(entry + 1, |lost| lost.end);
        found.extend(lost.map(|lost| others[lost.start]..=others[lost.end - 1]));
    }
    found
}

/// Returns true if the depth leaps, down or up, from one sounding to a later one.
fn is_leap(soundings: &[Sounding], fixes: &[Fix], earlier: usize, index: usize) -> bool {
    let (before, here) = (&soundings[earlier], &soundings[index]);
    let shallow_m = before.depth_m.min(here.depth_m);
    let deep_m = before.depth_m.max(here.depth_m);
    let leap_m = deep_m - shallow_m;
    deep_m >= LEAP_RATIO * shallow_m
        && leap_m > LEAP_M
        && here.time_s - before.time_s < NEIGHBOURS_S
        && f64::from(leap_m) > LEAP_STEEPNESS * travelled_m(fixes, before.time_s, here.time_s)
}

/// A step between two soundings that no bed has.
#[derive(Clone, Copy, Debug)]
struct Jump {
    /// Index of the sounding after the step.
    index: usize,
    is_deeper: bool,
}

/// Returns true if two depths, metres, differ by more than depths of one place do.
pub fn differ_as_no_bed([one_m, other_m]: [f32; 2]) -> bool {
    (one_m - other_m).abs() > JUMP_M.max(JUMP_SHARE * one_m.min(other_m))
}

/// Returns true if two depths, metres, differ by more than a bed does over `way_m`.
pub fn is_step_of_no_bed(depths_m: [f32; 2], way_m: f64) -> bool {
    let [one_m, other_m] = depths_m;
    differ_as_no_bed(depths_m) && f64::from((one_m - other_m).abs()) > STEEPEST * way_m
}

fn differ(a: &Sounding, b: &Sounding) -> bool {
    differ_as_no_bed([a.depth_m, b.depth_m])
}

/// Returns the jump from an earlier sounding to a later one; `None` where there is none.
fn jump(soundings: &[Sounding], fixes: &[Fix], earlier: usize, index: usize) -> Option<Jump> {
    let (before, here) = (&soundings[earlier], &soundings[index]);
    let is_jump = here.time_s - before.time_s < NEIGHBOURS_S
        && is_step(before, here, travelled_m(fixes, before.time_s, here.time_s));
    is_jump.then_some(Jump { index, is_deeper: here.depth_m > before.depth_m })
}

fn is_step(a: &Sounding, b: &Sounding, travelled_m: f64) -> bool {
    is_step_of_no_bed([a.depth_m, b.depth_m], travelled_m)
}

/// Returns true if a sounding differs from the median of the soundings around it by more than a bed
/// does, and the median is near in time. The way to the median is taken as that over half of
/// [`REACH`], because at the top of a ridge half of the neighbours are farther away than that.
fn is_glitch(soundings: &[Sounding], fixes: &[Fix], index: usize) -> bool {
    let around = index.saturating_sub(REACH)..(index + REACH + 1).min(soundings.len());
    if around.len() <= REACH {
        return false;
    }
    let mut near: Vec<Sounding> = soundings[around].to_vec();
    let here = &soundings[index];
    let median = upper_median(&mut near, |a, b| a.depth_m.total_cmp(&b.depth_m));
    median.is_some_and(|median| {
        let is_near = (median.time_s - here.time_s).abs() < NEIGHBOURS_S;
        is_near && differ(&median, here) && {
            let from = &soundings[index.saturating_sub(REACH / 2)];
            let to = &soundings[(index + REACH / 2).min(soundings.len() - 1)];
            let behind_m = travelled_m(fixes, from.time_s, here.time_s);
            let ahead_m = travelled_m(fixes, here.time_s, to.time_s);
            is_step(&median, here, behind_m.max(ahead_m))
        }
    })
}

/// Returns the metres that the boat went between two times; 0 without fixes. Because positions are
/// rounded and repeated, the speed is computed over some seconds more.
fn travelled_m(fixes: &[Fix], from_s: f64, to_s: f64) -> f64 {
    const MARGIN_S: f64 = 2.0;
    let at = |time_s: f64| fixes.partition_point(|fix| fix.time_s < time_s);
    let Some(last) = fixes.len().checked_sub(1) else {
        return 0.0;
    };
    let first = at(from_s - MARGIN_S).saturating_sub(1);
    let [from, to] = [&fixes[first], &fixes[at(to_s + MARGIN_S).min(last)]];
    let took_s = to.time_s - from.time_s;
    if took_s > 0.0 {
        distance_m(from.position, to.position) / took_s * (to_s - from_s)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::geo::LonLat;

    fn locked(depths: impl Iterator<Item = f32>) -> Vec<bool> {
        let mut soundings: Vec<Sounding> = depths
            .enumerate()
            .map(|(index, depth_m)| Sounding::new(0.1 * index as f64, depth_m))
            .collect();
        mark_faults(&mut soundings, &[], false);
        soundings.iter().map(|sounding| sounding.is_good()).collect()
    }

    fn all_locked<'a>(locked: impl IntoIterator<Item = &'a bool>) -> bool {
        locked.into_iter().all(|locked| *locked)
    }

    /// Returns depths that wander while the recorder has lost a bed at 1.5 m.
    fn wandering(lost: std::ops::Range<usize>) -> impl Fn(usize) -> f32 {
        move |i| if lost.contains(&i) { [1.5, 5.0, 3.0, 6.0][i / 7 % 4] } else { 1.5 }
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
    fn random_depths_of_a_slow_recorder_are_lost_though_a_bed_could_be_as_steep() {
        // Drawn evenly from 1.7 m to 30 m; the longest part without a jump has ten.
        let random = [
            9.1, 10.1, 24.7, 4.3, 18.7, 22.3, 7.0, 3.3, 9.5, 20.3, 17.6, 5.9, 13.9, 20.6, 13.7,
            19.6, 29.1, 21.0, 12.8, 7.0, 11.5, 16.2, 26.9, 23.6,
        ];
        let lost = 60..60 + random.len();
        let depth_m = |index: usize| match index.checked_sub(lost.start) {
            Some(at) if at < random.len() => random[at],
            _ => 6.0 + 1.5 * (index as f32 / 6.0).sin(),
        };
        let (mut soundings, fixes) = sailed(5.0, (0..120).map(depth_m));
        mark_faults(&mut soundings, &fixes, false);
        let marked: Vec<usize> = (0..120).filter(|&index| !soundings[index].is_good()).collect();
        assert_eq!(marked, lost.collect::<Vec<_>>());
    }

    #[test]
    fn soundings_that_are_added_are_marked_as_if_they_had_been_there() {
        let depth = |i: usize| match i {
            100..180 => [1.5, 5.0, 3.0, 6.0][i / 7 % 4],
            200..235 => 6.0,
            250 => 9.0,
            _ => 2.0,
        };
        let random = |i: usize| match i {
            100..150 => (i * i * 7919 % 283) as f32 / 10.0 + 1.7,
            _ => 6.0,
        };
        for (mut whole, fixes) in
            [sailed(0.1, (0..300).map(depth)), sailed(5.0, (0..300).map(random))]
        {
            let unmarked = whole.clone();
            mark_faults(&mut whole, &fixes, false);
            for shorter in (1..300).step_by(3) {
                let mut grown = whole[..shorter].to_vec();
                mark_faults(&mut grown, &fixes, false);
                grown.extend_from_slice(&unmarked[shorter..]);
                mark_faults_from(&mut grown, &fixes, false, shorter);
                assert_eq!(grown, whole, "grown from {shorter} soundings");
            }
        }
    }

    #[test]
    fn depths_between_a_leap_below_the_bottom_and_the_leap_back_are_lost() {
        for step_s in [0.05, 0.2, 1.0] {
            let second_echo = |index: usize| match index {
                100..250 => 16.0 + 0.01 * (index % 7) as f32,
                _ => 8.0,
            };
            let (mut soundings, fixes) = sailed(step_s, (0..400).map(second_echo));
            mark_faults(&mut soundings, &fixes, false);
            let marked: Vec<usize> =
                (0..400).filter(|&index| !soundings[index].is_good()).collect();
            assert_eq!(marked, (100..250).collect::<Vec<_>>(), "{step_s} s");
            // In a log with side-scan, leaps are checked against the first returns elsewhere.
            mark_faults(&mut soundings, &fixes, true);
            assert!(soundings.iter().all(|sounding| sounding.is_good()), "{step_s} s");
        }
        // Here the shallow depths are false.
        let clutter = |index: usize| if index % 100 < 9 { 1.8 } else { 20.0 };
        let (mut soundings, fixes) = sailed(1.0, (0..400).map(clutter));
        mark_faults(&mut soundings, &fixes, false);
        assert!(soundings.iter().all(|sounding| sounding.is_good() || sounding.depth_m < 2.0));
        // A basin with one wall and a slope of 30 degrees.
        let basin = |index: usize| match index {
            100..200 => 16.0,
            200..270 => 16.0 - 0.115 * (index - 200) as f32,
            _ => 8.0,
        };
        let (mut soundings, fixes) = sailed(0.1, (0..400).map(basin));
        mark_faults(&mut soundings, &fixes, false);
        assert!(soundings.iter().all(|sounding| sounding.is_good()));
    }

    #[test]
    fn one_wild_depth_is_a_glitch() {
        let locked = locked((0..50).map(|i| if i == 20 { 9.0 } else { 2.0 }));
        let wild: Vec<usize> = (0..50).filter(|&i| !locked[i]).collect();
        assert_eq!(wild, [20]);
    }

    /// Creates a sounding and a fix at every time step, of a boat that goes north at 2 m/s.
    fn sailed(step_s: f64, depths: impl Iterator<Item = f32>) -> (Vec<Sounding>, Vec<Fix>) {
        let time_s = |index: usize| step_s * index as f64;
        let soundings: Vec<Sounding> = depths
            .enumerate()
            .map(|(index, depth_m)| Sounding::new(time_s(index), depth_m))
            .collect();
        let north_deg = |time_s: f64| 47.5 + 2.0 * time_s / 111_180.0;
        let fix = |index| Fix::at(time_s(index), LonLat::new(8.5, north_deg(time_s(index))));
        let fixes = (0..soundings.len()).map(fix).collect();
        (soundings, fixes)
    }

    #[test]
    fn a_loss_is_the_same_at_any_rate_and_a_steep_bank_is_none() {
        for step_s in [0.05, 0.2, 1.0] {
            let depth_m = |index: usize| match index {
                100..200 if index % 10 < 5 => 1.8,
                _ => 20.0,
            };
            let (mut soundings, fixes) = sailed(step_s, (0..300).map(depth_m));
            mark_faults(&mut soundings, &fixes, false);
            let marked: Vec<usize> =
                (0..300).filter(|&index| !soundings[index].is_good()).collect();
            assert_eq!(marked, (100..196).collect::<Vec<_>>(), "{step_s} s");
            // Up and down banks of 40 degrees.
            let bank = |index: usize| {
                let along_m = 2.0 * step_s * index as f64;
                2.0 + 0.84 * (along_m % 20.0 - 10.0).abs() as f32
            };
            let (mut soundings, fixes) = sailed(step_s, (0..300).map(bank));
            mark_faults(&mut soundings, &fixes, false);
            assert!(soundings.iter().all(|sounding| sounding.is_good()), "{step_s} s");
        }
    }

    #[test]
    fn single_spikes_of_a_slow_recorder_are_glitches() {
        let depth_m = |index: usize| if index % 5 == 3 { 7.5 } else { 20.0 };
        let (mut soundings, fixes) = sailed(1.0, (0..100).map(depth_m));
        mark_faults(&mut soundings, &fixes, false);
        for (index, sounding) in soundings.iter().enumerate() {
            assert_eq!(sounding.is_good(), sounding.depth_m == 20.0, "sounding {index}");
        }
    }
}
