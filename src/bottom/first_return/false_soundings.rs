//! Finds false soundings: those that the first returns of both sides contradict.
//!
//! A first return is no farther away than the bottom below the boat; over weed, boulders and fish
//! it is nearer. A first return nearer than the sounding is therefore no evidence against the
//! sounding. Two faults of recorders, however, leave patterns that nothing in the water leaves. The
//! second echo, from the bottom to the surface and back again, is twice as far: the depth changes
//! to twice its value while neither side moves. Where a recorder has lost the bottom, it repeats
//! the last depth: the depth stays the same to the last digit while both sides move.

use super::{FirstReturns, joined};
use bathyscope_log::support::statistics::{median, median_of, quantile, sorted};
use bathyscope_log::survey::{Side, SidePing, Sounding, SoundingFault, Survey, nearest_in_time};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Number of pings before and after a sounding whose first returns are used.
const REACH: usize = 10;
/// Least number of these pings that must have a first return.
const LEAST: usize = 5;
/// Largest difference of the two sides over the same bottom, as a share: on a bank of 33 degrees
/// they differ by a sixth.
const SIDES_AGREE: f64 = 0.25;
/// Ratios of a second echo to the first return: two, and more on a bank, where the first return
/// comes from higher on the slope.
const SECOND_ECHO: Range<f64> = 1.75..2.6;
/// Ratios by which the depth changes at both ends of a stretch of second echoes.
const LEAP: Range<f64> = 1.75..2.25;
/// Ratios of such a leap from one sounding to the next, for stretches without first returns, or
/// with first returns near the depth at less than a share of [`MOST_SEEN`] of the soundings.
const EXACT_LEAP: Range<f64> = 1.9..2.1;
const MOST_SEEN: f64 = 0.1;
/// Largest change of the first returns over a leap of the depth, as a share.
const STAYS: f64 = 0.25;
/// Number of soundings before and after an end that are compared; both values are tried: on a steep
/// bank only the soundings next to the end are still at the same depth.
const BESIDE: [usize; 2] = [3, 1];
/// Least number of soundings in a false stretch.
const SHORTEST: usize = 5;
/// Largest number of consecutive soundings within a stretch that do not show the fault.
const LONGEST_PAUSE: usize = 8;
/// Number of soundings, and multiple of the usual length of constant depths over a level bottom
/// with the log's coarse steps, that a constant depth must exceed to count as held.
const HELD: usize = 12;
const HELD_TIMES: usize = 3;
/// Least movement of the first returns over a held depth, metres and share of the depth.
const MOVES: (f64, f64) = (0.1, 0.015);

/// Stretch of soundings with a fault, which are not used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FalseSoundings {
    /// Indices in [`Survey::soundings`].
    pub soundings: Range<usize>,
    /// Fault of the soundings.
    pub fault: SoundingFault,
}

impl FalseSoundings {
    /// Returns a sentence about the stretch, for a warning.
    fn summary(&self, survey: &Survey) -> String {
        let time_s =
            |index: usize| survey.soundings.get(index).map_or(f64::NAN, |sounding| sounding.time_s);
        let [from_s, to_s] = [self.soundings.start, self.soundings.end - 1].map(time_s);
        format!(
            "{} soundings between {from_s:.0} s and {to_s:.0} s {}; they do not count",
            self.soundings.len(),
            self.fault.sentence()
        )
    }
}

/// Sets [`FirstReturns::false_soundings`], adds a warning for each stretch, and accepts the first
/// returns at the pings of these soundings as bottom: first returns above a false depth, such as a
/// second echo, are the bottom all the same.
pub(super) fn judge(survey: &Survey, returns: &mut FirstReturns) {
    let found = find(&survey.soundings, &Witnesses::new(survey, returns));
    if found.is_empty() {
        return;
    }
    returns.warnings.extend(found.iter().map(|stretch| stretch.summary(survey)));
    for ping in pings_of(survey, &found) {
        for side in Side::BOTH {
            if let Some(pick) = returns.side_mut(side).get_mut(ping) {
                pick.accept();
            }
        }
    }
    returns.false_soundings = Arc::new(found);
}

/// Returns the pings whose depth comes from false soundings.
fn pings_of(survey: &Survey, false_soundings: &[FalseSoundings]) -> Vec<usize> {
    let is_false = |sounding: usize| {
        false_soundings.iter().any(|stretch| stretch.soundings.contains(&sounding))
    };
    let pings = 0..survey.side_scan.len();
    pings.filter(|&ping| sounding_of(survey, ping).is_some_and(is_false)).collect()
}

/// Returns the ranges of pings, in order, that hold the given pings and the [`REACH`] pings on both
/// sides of each.
pub(super) fn ranges_around(survey: &Survey, pings: &[usize]) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for &ping in pings {
        let around = ping.saturating_sub(REACH)..(ping + REACH + 1).min(survey.side_scan.len());
        match ranges.last_mut() {
            Some(last) if around.start <= last.end => last.end = around.end,
            _ => ranges.push(around),
        }
    }
    ranges
}

/// Returns the survey with the false soundings and the depths of their pings marked with the fault;
/// `None` where all these soundings have a fault already.
pub(super) fn judged(survey: &Survey, false_soundings: &[FalseSoundings]) -> Option<Survey> {
    let is_marked = |stretch: &FalseSoundings| {
        let soundings = survey.soundings.get(stretch.soundings.clone()).unwrap_or_default();
        soundings.iter().all(|sounding| !sounding.is_good())
    };
    if false_soundings.iter().all(is_marked) {
        return None;
    }
    let mut judged = survey.clone();
    let soundings = Arc::make_mut(&mut judged.soundings);
    for stretch in false_soundings {
        for sounding in soundings.get_mut(stretch.soundings.clone()).unwrap_or_default() {
            sounding.fault.get_or_insert(stretch.fault);
        }
    }
    let soundings = &judged.soundings;
    let pings = Arc::make_mut(&mut judged.side_scan);
    for ping in pings_of(survey, false_soundings) {
        let sounding = sounding_of(survey, ping).and_then(|index| soundings.get(index));
        pings[ping].depth_fault = sounding.and_then(|sounding| sounding.fault);
    }
    Some(judged)
}

/// Returns the survey with the depths that are expected at false soundings, and the pings with such
/// depths. For a second echo this is half of the depth; for a held depth it is interpolated between
/// the soundings before and after the stretch.
pub(super) fn explained(survey: &Survey, found: &[FalseSoundings]) -> (Survey, Vec<usize>) {
    let mut explained = survey.clone();
    let pings: &mut Vec<SidePing> = Arc::make_mut(&mut explained.side_scan);
    for stretch in found {
        let ends = (stretch.soundings.start.checked_sub(1)).zip(Some(stretch.soundings.end));
        let ends = ends.and_then(|(before, after)| {
            Some((survey.soundings.get(before)?, survey.soundings.get(after)?))
        });
        for ping in pings_of(survey, std::slice::from_ref(stretch)) {
            let ping = &mut pings[ping];
            match (stretch.fault, ends) {
                (SoundingFault::SecondEcho, _) => ping.depth_m *= 0.5,
                (SoundingFault::Held, Some((before, after))) => {
                    let share = (ping.time_s - before.time_s) / (after.time_s - before.time_s);
                    ping.depth_m += share as f32 * (after.depth_m - ping.depth_m);
                }
                _ => {}
            }
        }
    }
    (explained, pings_of(survey, found))
}

/// Returns the pings whose depth was held.
pub(super) fn held_pings(survey: &Survey, found: &[FalseSoundings]) -> Vec<usize> {
    let held = found.iter().filter(|stretch| stretch.fault == SoundingFault::Held);
    pings_of(survey, &held.cloned().collect::<Vec<_>>())
}

/// Returns the index of the sounding nearest in time to a ping, from which the ping has its depth.
fn sounding_of(survey: &Survey, ping: usize) -> Option<usize> {
    nearest_in_time(&survey.soundings, survey.side_scan[ping].time_s, |sounding| sounding.time_s)
}

/// Median slant range of the first returns of each side around each sounding, metres; NaN where
/// there are too few first returns.
struct Witnesses {
    sides_m: [Vec<f64>; 2],
}

impl Witnesses {
    fn new(survey: &Survey, returns: &FirstReturns) -> Self {
        let of_side = |side: Side| {
            let pings = 0..survey.side_scan.len();
            let ranges_m: Vec<f64> =
                pings.map(|ping| returns.range_m(survey, ping, side)).collect();
            let around = |sounding: &Sounding| {
                let ping = nearest_in_time(&survey.side_scan, sounding.time_s, |ping| ping.time_s)?;
                let near =
                    &ranges_m[ping.saturating_sub(REACH)..(ping + REACH + 1).min(ranges_m.len())];
                let near = near.iter().copied().filter(|range_m| range_m.is_finite());
                let mut near: Vec<f64> = near.collect();
                (near.len() >= LEAST).then(|| median(&mut near))
            };
            let soundings = survey.soundings.par_iter();
            soundings.map(|sounding| around(sounding).unwrap_or(f64::NAN)).collect()
        };
        Self { sides_m: Side::BOTH.map(of_side) }
    }

    /// Returns the slant range of the bottom below the boat at a sounding, metres: the larger range
    /// of both sides, or the smaller one where the sides do not agree, since a false depth may have
    /// moved the first return of one side away from the boat.
    fn below_m(&self, sounding: usize) -> f64 {
        let [port_m, starboard_m] = [0, 1].map(|side| self.sides_m[side][sounding]);
        let deeper_m = port_m.max(starboard_m);
        if (port_m - starboard_m).abs() <= SIDES_AGREE * deeper_m {
            deeper_m
        } else {
            port_m.min(starboard_m)
        }
    }

    /// Returns true if the first returns of every side that has enough of them move by more than
    /// `more_than_m` metres over these soundings, and at least one side has enough.
    fn move_over(&self, soundings: &Range<usize>, more_than_m: f64) -> bool {
        let moves = |side: &Vec<f64>| {
            let ranges = side[soundings.clone()].iter().copied();
            let ranges = sorted(ranges.filter(|range_m| range_m.is_finite()));
            let tells = 2 * ranges.len() > soundings.len();
            tells.then(|| quantile(&ranges, 0.95) - quantile(&ranges, 0.05) > more_than_m)
        };
        let sides = self.sides_m.iter().filter_map(moves);
        sides.reduce(|one, other| one && other) == Some(true)
    }
}

/// Returns the stretches of false soundings, in order.
fn find(soundings: &[Sounding], witnesses: &Witnesses) -> Vec<FalseSoundings> {
    let mut found = second_echoes(soundings, witnesses);
    let fault = SoundingFault::Held;
    let held = held_depths(soundings, witnesses).into_iter();
    add_new(&mut found, held.map(|soundings| FalseSoundings { soundings, fault }));
    found.sort_by_key(|stretch| stretch.soundings.start);
    found
}

/// Adds the stretches that overlap none of those before them.
fn add_new(found: &mut Vec<FalseSoundings>, more: impl Iterator<Item = FalseSoundings>) {
    for stretch in more {
        let Range { start, end } = stretch.soundings;
        if !found.iter().any(|known| known.soundings.start < end && start < known.soundings.end) {
            found.push(stretch);
        }
    }
}

/// Finds second echoes in three ways: by both sides together; by each side alone where the range of
/// the other side is nearer, as at a wall; and at depths where no side has a first return.
fn second_echoes(soundings: &[Sounding], witnesses: &Witnesses) -> Vec<FalseSoundings> {
    let all = 0..soundings.len();
    let below_m = all.clone().map(|sounding| witnesses.below_m(sounding)).collect();
    let mut found = second_echoes_by(soundings, below_m);
    let alone_m = |side: Side| {
        let [own_m, other_m] = [side, side.other()].map(|side| &witnesses.sides_m[side as usize]);
        let range_m = |sounding: usize| {
            if other_m[sounding] < own_m[sounding] { own_m[sounding] } else { f64::NAN }
        };
        all.clone().map(range_m).collect()
    };
    let alone = Side::BOTH.map(|side| second_echoes_by(soundings, alone_m(side))).concat();
    let unseen = unseen_second_echoes(soundings, witnesses);
    add_new(&mut found, alone.into_iter().chain(unseen));
    found
}

/// Returns the stretches between a leap of the depth to twice its value and a leap back, each from
/// one sounding to the next, over which the sides have first returns but hardly any near the depth:
/// a bottom at that depth would give first returns.
fn unseen_second_echoes(soundings: &[Sounding], witnesses: &Witnesses) -> Vec<FalseSoundings> {
    let depth_m = |index: usize| f64::from(soundings[index].depth_m);
    let times = |index: usize| depth_m(index) / depth_m(index - 1);
    let is_unseen = |stretch: &Range<usize>| {
        let count = |is: &dyn Fn(usize, f64) -> bool| {
            let is_any =
                |index: usize| witnesses.sides_m.iter().any(|side_m| is(index, side_m[index]));
            stretch.clone().filter(|&index| is_any(index)).count()
        };
        let near = count(&|index, range_m| (range_m / depth_m(index) - 1.0).abs() < SIDES_AGREE);
        let any = count(&|_, range_m| range_m.is_finite());
        2 * any > stretch.len() && (near as f64) < MOST_SEEN * stretch.len() as f64
    };
    let mut found = Vec::new();
    let mut start = None;
    for index in 1..soundings.len() {
        if EXACT_LEAP.contains(&times(index)) {
            start = Some(index);
        } else if EXACT_LEAP.contains(&times(index).recip()) {
            let stretch = start.take().map(|start| start..index);
            let stretch = stretch.filter(|stretch| stretch.len() >= SHORTEST);
            found.extend(stretch.filter(&is_unseen));
        }
    }
    let fault = SoundingFault::SecondEcho;
    found.into_iter().map(|soundings| FalseSoundings { soundings, fault }).collect()
}

/// Returns the stretches of second echoes by `ranges_m`, the slant range of the bottom below the
/// boat at each sounding, metres.
fn second_echoes_by(soundings: &[Sounding], ranges_m: Vec<f64>) -> Vec<FalseSoundings> {
    let depth_m = |index: usize| f64::from(soundings[index].depth_m);
    let is_double = |index: usize| SECOND_ECHO.contains(&(depth_m(index) / ranges_m[index]));
    let mut found = Vec::new();
    let doubles = (0..soundings.len()).filter(|&index| is_double(index));
    for stretch in stretches(doubles, |between| ranges_m[between].iter().all(|m| m.is_nan())) {
        let stretch = stretch.start..unseen_end(soundings, &ranges_m, stretch.end);
        let leaps_at = |inside: Range<usize>, outside: Range<usize>| {
            let middle = |of: &dyn Fn(usize) -> f64, at: Range<usize>| {
                median_of(at.map(of).filter(|value| value.is_finite()))
            };
            let ratio = middle(&depth_m, inside.clone()) / middle(&depth_m, outside.clone());
            let ranges = |at| middle(&|index: usize| ranges_m[index], at);
            let (here_m, there_m) = (ranges(inside), ranges(outside));
            let stays = (here_m - there_m).abs() <= STAYS * here_m.max(there_m);
            let is_unseen = here_m.is_nan() && there_m.is_nan() && EXACT_LEAP.contains(&ratio);
            LEAP.contains(&ratio) && (stays || is_unseen)
        };
        let (start, end, last) = (stretch.start, stretch.end, soundings.len());
        let at_start = BESIDE.into_iter().any(|beside| {
            leaps_at(start..(start + beside).min(end), start.saturating_sub(beside)..start)
        });
        let at_end = BESIDE.into_iter().any(|beside| {
            let inside = end.saturating_sub(beside).max(start)..end;
            leaps_at(inside, end..(end + beside).min(last))
        });
        let (begins_log, ends_log) = (start < SHORTEST, end + SHORTEST > last);
        let is_bounded = match (at_start, at_end) {
            (true, true) => true,
            (true, false) => ends_log,
            (false, true) => begins_log,
            (false, false) => false,
        };
        if is_bounded {
            found.push(FalseSoundings { soundings: stretch, fault: SoundingFault::SecondEcho });
        }
    }
    found
}

/// Returns the sounding at which the depth leaps back to half of its value, if there is no first
/// return from `end` up to it, as over a shallow bottom; `end` if there is no such sounding.
fn unseen_end(soundings: &[Sounding], ranges_m: &[f64], end: usize) -> usize {
    let unseen = ranges_m[end..].iter().take_while(|range_m| range_m.is_nan()).count();
    let depth_m = |index: usize| f64::from(soundings[index].depth_m);
    let mut unseen = end.max(1)..end + unseen;
    unseen.find(|&index| EXACT_LEAP.contains(&(depth_m(index - 1) / depth_m(index)))).unwrap_or(end)
}

/// Returns the ranges of indices that follow each other with gaps of at most [`LONGEST_PAUSE`], or
/// with longer ones in which nothing is seen.
fn stretches(
    indices: impl Iterator<Item = usize>,
    is_unseen: impl Fn(Range<usize>) -> bool,
) -> Vec<Range<usize>> {
    let goes_on = |end: usize, index: usize| index - end <= LONGEST_PAUSE || is_unseen(end..index);
    let mut stretches = joined(indices, goes_on);
    stretches.retain(|stretch| stretch.len() >= SHORTEST);
    stretches
}

/// Returns the stretches over which the depth stays the same to the last digit while the first
/// returns move.
fn held_depths(soundings: &[Sounding], witnesses: &Witnesses) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = 0;
    for run in soundings.chunk_by(|a, b| a.depth_m == b.depth_m) {
        runs.push(start..start + run.len());
        start += run.len();
    }
    let usual = quantile(&sorted(runs.iter().map(|run| run.len() as f64)), 0.95);
    let longest = HELD.max((HELD_TIMES as f64 * if usual.is_nan() { 0.0 } else { usual }) as usize);
    let moves = |run: &Range<usize>| {
        let depth_m = f64::from(soundings[run.start].depth_m);
        witnesses.move_over(run, MOVES.0.max(MOVES.1 * depth_m))
    };
    // The first sounding of a run was measured; those after it repeat it.
    let without_first = |run: Range<usize>| run.start + 1..run.end;
    runs.into_iter().filter(|run| run.len() > longest && moves(run)).map(without_first).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soundings(depths_m: impl Iterator<Item = f64>) -> Vec<Sounding> {
        let sounding =
            |(index, depth_m): (usize, f64)| Sounding::new(0.125 * index as f64, depth_m as f32);
        depths_m.enumerate().map(sounding).collect()
    }

    /// Depth of a sloping bed, metres.
    fn bed_m(index: usize) -> f64 {
        5.0 + 0.01 * index as f64
    }

    fn seen(ranges_m: impl Iterator<Item = f64>) -> Witnesses {
        let side_m: Vec<f64> = ranges_m.collect();
        Witnesses { sides_m: [side_m.clone(), side_m] }
    }

    fn noise_m(index: usize) -> f64 {
        0.01 * (index * 7 % 5) as f64
    }

    #[test]
    fn a_second_echo_is_found_from_end_to_end_and_weed_is_none() {
        let ranges_m = seen((0..400).map(bed_m));
        let doubled = 100..160;
        let depth_m = |index: usize| {
            noise_m(index) + bed_m(index) * if doubled.contains(&index) { 2.0 } else { 1.0 }
        };
        let found = find(&soundings((0..400).map(depth_m)), &ranges_m);
        let expected =
            FalseSoundings { soundings: doubled.clone(), fault: SoundingFault::SecondEcho };
        assert_eq!(found, [expected]);
        // Weed up to half the depth: the first returns leap, the depth does not.
        let weedy = |index: usize| bed_m(index) * if doubled.contains(&index) { 0.5 } else { 1.0 };
        let ranges_m = seen((0..400).map(weedy));
        assert!(find(&soundings((0..400).map(|i| bed_m(i) + noise_m(i))), &ranges_m).is_empty());
    }

    #[test]
    fn a_second_echo_beside_a_wall_is_found_by_the_other_side() {
        let bed = |index: usize| 5.0 + 0.002 * index as f64;
        let starboard_m: Vec<f64> = (0..400).map(bed).collect();
        let wall = Witnesses { sides_m: [vec![2.5; 400], starboard_m] };
        let doubled = 100..160;
        let depths_m = |bed: &dyn Fn(usize) -> f64| {
            let times = |index: usize| if doubled.contains(&index) { 2.0 } else { 1.0 };
            soundings((0..400).map(|index| noise_m(index) + bed(index) * times(index)))
        };
        let found = find(&depths_m(&bed), &wall);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(
            (found[0].soundings.clone(), found[0].fault),
            (doubled.clone(), SoundingFault::SecondEcho)
        );
        // The other side has no first return: nothing is detected at the depth.
        let alone = Witnesses { sides_m: [vec![2.5; 400], vec![f64::NAN; 400]] };
        assert_eq!(find(&depths_m(&bed), &alone), found);
        // A basin that is twice as deep: the other side detects its bottom.
        let starboard_m =
            (0..400).map(|index| bed(index) * if doubled.contains(&index) { 2.0 } else { 1.0 });
        let basin = Witnesses { sides_m: [vec![2.5; 400], starboard_m.collect()] };
        assert!(find(&depths_m(&bed), &basin).is_empty());
    }

    #[test]
    fn a_second_echo_that_ends_where_no_side_sees_the_bottom_is_found() {
        // A bank that rises to a depth of half a metre, over which both sides lose the bottom.
        let bank_m = |index: usize| (4.0 - 0.1 * index.saturating_sub(90) as f64).max(0.5);
        let ranges_m = seen((0..400).map(|i| if i < 110 { bank_m(i) } else { f64::NAN }));
        let depth_m = |doubled: Range<usize>| {
            let times = move |index: usize| if doubled.contains(&index) { 2.0 } else { 1.0 };
            soundings((0..400).map(|index| bank_m(index) * times(index)))
        };
        let found = find(&depth_m(95..160), &ranges_m);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].soundings, 95..160);
        // The sides see the bottom again before the depth is right.
        let again_m = |i: usize| if (110..140).contains(&i) { f64::NAN } else { bank_m(i) };
        assert_eq!(find(&depth_m(95..160), &seen((0..400).map(again_m))), found);
        // Without a leap back, the end of the second echo is unknown.
        assert!(
            find(&depth_m(95..400), &ranges_m).iter().all(|stretch| stretch.soundings.end <= 120)
        );
    }

    #[test]
    fn a_held_depth_is_found_and_coarse_steps_on_a_level_bed_are_none() {
        let ranges_m = seen((0..400).map(bed_m));
        let held = 200..280;
        let depth_m = |index: usize| {
            if held.contains(&index) { bed_m(held.start) } else { bed_m(index) + noise_m(index) }
        };
        let found = find(&soundings((0..400).map(depth_m)), &ranges_m);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].soundings.clone(), found[0].fault), (201..280, SoundingFault::Held));
        // Depths in steps of half a metre, and a bed that moves within one step, under weed.
        let coarse = (0..400).map(|index| 0.5 * (bed_m(index) / 0.5).round());
        assert!(find(&soundings(coarse), &ranges_m).is_empty());
    }
}
