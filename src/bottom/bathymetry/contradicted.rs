//! Finds stretches of a log whose depths are false according to what other logs measured beside
//! them.
//!
//! In: the depths along the tracks of several logs. Out: the stretches that are left out.
//!
//! The depths of a sounder that took something else for the bottom have steps, but a ledge makes
//! steps as well: only another log of the same place distinguishes them. Between two steps the
//! depths are either all of the bottom or all false, so each track is cut into stretches at the
//! steps. Two stretches that come near each other contradict each other where the depths differ by
//! more than a bed does over the distance between them. A third log decides which of two logs is
//! false: the one that more logs contradict.

use super::crosslines::{Gaps, TrackDepth, way_m};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median_of;
use bathyscope_log::survey::{differ_as_no_bed, is_step_of_no_bed};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::{Range, RangeInclusive};

/// Greatest distance at which depths of two logs are compared, metres.
const REACH_M: f64 = 20.0;
/// Greatest distance at which two depths of one bed count as depths of one place, metres.
const SAME_PLACE_M: f64 = 5.0;
/// Longest gap in a track that a depth goes on over, as a multiple of the longest way that is no
/// gap.
const HELD_GAPS: f64 = 10.0;
/// Side of the squares over which the depths of a stretch are averaged, metres.
const SQUARE_M: f64 = 1.0;
/// Fewest other logs that must contradict a log for it to be false.
const LEAST_AGAINST: usize = 2;

/// Stretch of a log that others contradict.
#[derive(Clone, Debug, PartialEq)]
pub struct ContradictedStretch {
    /// Index of the track.
    pub track: usize,
    /// Indices of the depths in the track.
    pub depths: Range<usize>,
    /// Depths that contradict the stretch: the nearest of each other track.
    pub against: Vec<Contradiction>,
}

/// Depth of another track that contradicts a stretch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Contradiction {
    /// Index of the other track.
    #[serde(rename = "log")]
    pub track: usize,
    /// Depth of the stretch and depth of the other track, metres.
    pub depths_m: [f64; 2],
    /// Distance between the two depths, metres.
    pub apart_m: f64,
}

/// Returns the stretches that more logs contradict than contradict any of these logs, in the order
/// of tracks and time. `tracks` are in one plane; `may_be_false` returns true for a part of a track
/// that may be left out.
///
/// # Errors
/// When the work was cancelled.
pub fn contradicted(
    tracks: &[Vec<TrackDepth>],
    may_be_false: &dyn Fn(usize, &[TrackDepth]) -> bool,
    progress: &Progress,
) -> Result<Vec<ContradictedStretch>, Cancelled> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for (track, depths) in tracks.iter().enumerate() {
        progress.check()?;
        stretches.extend(stretches_of(depths).into_iter().map(|range| Stretch {
            track,
            may_be_false: may_be_false(track, &depths[range.clone()]),
            depths: range,
        }));
    }
    if !stretches.iter().any(|stretch| stretch.may_be_false) {
        return Ok(Vec::new());
    }
    let approaches = approaches(tracks, &stretches, progress)?;
    let is_false = false_stretches(&stretches, &approaches);
    let all: Vec<usize> = (0..stretches.len()).filter(|&index| is_false[index]).collect();
    let follows = |stretch: &usize, next: &usize| {
        *next == stretch + 1 && stretches[*stretch].track == stretches[*next].track
    };
    let joined = all.chunk_by(follows).map(|joined| {
        let (first, last) = (joined[0], joined[joined.len() - 1]);
        ContradictedStretch {
            track: stretches[first].track,
            depths: stretches[first].depths.start..stretches[last].depths.end,
            against: against(first..=last, &stretches, &approaches, &is_false),
        }
    });
    Ok(joined.collect())
}

/// Part of a track between two steps.
struct Stretch {
    track: usize,
    depths: Range<usize>,
    may_be_false: bool,
}

/// Returns the parts of a track between steps that no bed makes, and between long gaps; a short gap
/// divides a track only where the depths on both sides differ.
fn stretches_of(depths: &[TrackDepth]) -> Vec<Range<usize>> {
    let gaps = Gaps::of(depths);
    let is_step = |pair: &[TrackDepth]| {
        let depths_m = [pair[0].depth_m as f32, pair[1].depth_m as f32];
        let way_m = way_m(&pair[0], &pair[1]);
        if gaps.is_gap(&pair[0], &pair[1]) {
            way_m > HELD_GAPS * gaps.longest_m || differ_as_no_bed(depths_m)
        } else {
            is_step_of_no_bed(depths_m, way_m)
        }
    };
    let steps = depths.windows(2).enumerate().filter(|(_, pair)| is_step(pair));
    let ends: Vec<usize> = steps.map(|(index, _)| index + 1).chain([depths.len()]).collect();
    let starts = [0].into_iter().chain(ends.iter().copied());
    starts.zip(&ends).map(|(start, &end)| start..end).filter(|range| !range.is_empty()).collect()
}

/// Median depth of a stretch in a square of [`SQUARE_M`].
struct Mean {
    stretch: usize,
    place: [f64; 2],
    depth_m: f64,
}

/// Returns the median place and depth of a stretch in each square, in the order of the squares.
fn means(stretch: usize, depths: &[TrackDepth]) -> impl Iterator<Item = Mean> {
    let mut squares: BTreeMap<[i64; 2], Vec<&TrackDepth>> = BTreeMap::new();
    for depth in depths {
        let square = [depth.east_m, depth.north_m].map(|metres| (metres / SQUARE_M).floor() as i64);
        squares.entry(square).or_default().push(depth);
    }
    squares.into_values().map(move |inside| {
        let of = |value: fn(&TrackDepth) -> f64| median_of(inside.iter().map(|depth| value(depth)));
        let place = [of(|depth| depth.east_m), of(|depth| depth.north_m)];
        Mean { stretch, place, depth_m: of(|depth| depth.depth_m) }
    })
}

/// Closest approach of two stretches of different tracks.
struct Approach {
    /// Indices of the stretches, the smaller first.
    stretches: [usize; 2],
    apart_m: f64,
    depths_m: [f64; 2],
}

impl Approach {
    /// Returns true if the depths differ by more than a bed does over the distance between them.
    fn is_contradiction(&self) -> bool {
        is_step_of_no_bed(self.depths_m.map(|depth_m| depth_m as f32), self.apart_m)
    }

    /// Returns true if both stretches measured the same depth at one place.
    fn agrees(&self) -> bool {
        self.apart_m <= SAME_PLACE_M
            && !differ_as_no_bed(self.depths_m.map(|depth_m| depth_m as f32))
    }
}

/// Returns the closest approach of every two stretches of different tracks within [`REACH_M`].
///
/// # Errors
/// When the work was cancelled.
fn approaches(
    tracks: &[Vec<TrackDepth>],
    stretches: &[Stretch],
    progress: &Progress,
) -> Result<Vec<Approach>, Cancelled> {
    let of_stretch = |(index, stretch): (usize, &Stretch)| {
        means(index, &tracks[stretch.track][stretch.depths.clone()])
    };
    let means: Vec<Mean> = stretches.iter().enumerate().flat_map(of_stretch).collect();
    let square = |place: [f64; 2]| place.map(|metres| (metres / REACH_M).floor() as i64);
    let mut squares: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    for (index, mean) in means.iter().enumerate() {
        squares.entry(square(mean.place)).or_default().push(index);
    }
    let mut nearest: BTreeMap<[usize; 2], Approach> = BTreeMap::new();
    for mean in means.iter().filter(|mean| stretches[mean.stretch].may_be_false) {
        progress.check()?;
        let [east, north] = square(mean.place);
        let around = (east - 1..=east + 1)
            .flat_map(|east| (north - 1..=north + 1).map(move |north| [east, north]));
        for &other in around.filter_map(|square| squares.get(&square)).flatten() {
            let other = &means[other];
            let apart_m = (other.place[0] - mean.place[0]).hypot(other.place[1] - mean.place[1]);
            let is_same_track = stretches[other.stretch].track == stretches[mean.stretch].track;
            if is_same_track || apart_m > REACH_M {
                continue;
            }
            let [first, second] =
                if mean.stretch < other.stretch { [mean, other] } else { [other, mean] };
            let pair = [first.stretch, second.stretch];
            if nearest.get(&pair).is_none_or(|found| apart_m < found.apart_m) {
                let depths_m = [first.depth_m, second.depth_m];
                nearest.insert(pair, Approach { stretches: pair, apart_m, depths_m });
            }
        }
    }
    Ok(nearest.into_values().collect())
}

/// Returns whether each stretch is false. Takes the track that the most other tracks contradict,
/// and marks its contradicted stretches as false, except for stretches that as many other tracks
/// confirm. Repeats this without the stretches marked so far, as long as a track is contradicted by
/// more tracks than each track that contradicts it.
fn false_stretches(stretches: &[Stretch], approaches: &[Approach]) -> Vec<bool> {
    let mut is_false = vec![false; stretches.len()];
    let track = |stretch: usize| stretches[stretch].track;
    let confirmed = confirmations(stretches, approaches);
    loop {
        let open = || {
            let open = approaches.iter().filter(|approach| approach.is_contradiction());
            open.filter(|approach| !approach.stretches.iter().any(|&stretch| is_false[stretch]))
        };
        let mut against: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for [one, other] in open().map(|approach| approach.stretches) {
            against.entry(track(one)).or_default().insert(track(other));
            against.entry(track(other)).or_default().insert(track(one));
        }
        let count = |of: &usize| against.get(of).map_or(0, BTreeSet::len);
        let is_clear = |of: &usize| {
            count(of) >= LEAST_AGAINST && against[of].iter().all(|other| count(other) < count(of))
        };
        let unconfirmed = |of: usize| {
            let both = open().flat_map(|approach| approach.stretches).collect::<BTreeSet<usize>>();
            let own = both.into_iter().filter(|&stretch| track(stretch) == of);
            let contradicted = |stretch: usize| {
                let with = open().filter(|open| open.stretches.contains(&stretch));
                let others = with.flat_map(|open| open.stretches).filter(|&at| at != stretch);
                others.map(track).collect::<BTreeSet<usize>>().len()
            };
            let own = own.filter(|&stretch| stretches[stretch].may_be_false);
            own.filter(|&stretch| confirmed[stretch].len() < contradicted(stretch))
                .collect::<Vec<usize>>()
        };
        let mut clear: Vec<usize> = against.keys().copied().filter(is_clear).collect();
        clear.sort_by_key(|of| std::cmp::Reverse(count(of)));
        let Some(found) = clear.into_iter().map(unconfirmed).find(|found| !found.is_empty()) else {
            return is_false;
        };
        for stretch in found {
            is_false[stretch] = true;
        }
    }
}

/// Returns, for each stretch, the tracks that measured the same depth there.
fn confirmations(stretches: &[Stretch], approaches: &[Approach]) -> Vec<BTreeSet<usize>> {
    let mut confirmed = vec![BTreeSet::new(); stretches.len()];
    for approach in approaches.iter().filter(|approach| approach.agrees()) {
        let [one, other] = approach.stretches;
        confirmed[one].insert(stretches[other].track);
        confirmed[other].insert(stretches[one].track);
    }
    confirmed
}

/// Returns the depths that contradict the stretches `of`, the nearest of each track, without the
/// depths of false stretches.
fn against(
    of: RangeInclusive<usize>,
    stretches: &[Stretch],
    approaches: &[Approach],
    is_false: &[bool],
) -> Vec<Contradiction> {
    let mut nearest: BTreeMap<usize, Contradiction> = BTreeMap::new();
    for approach in approaches.iter().filter(|approach| approach.is_contradiction()) {
        let Some(own) = approach.stretches.iter().position(|stretch| of.contains(stretch)) else {
            continue;
        };
        let other = approach.stretches[1 - own];
        if is_false[other] {
            continue;
        }
        let track = stretches[other].track;
        let depths_m = [own, 1 - own].map(|pass| approach.depths_m[pass]);
        let found = Contradiction { track, depths_m, apart_m: approach.apart_m };
        let known = nearest.entry(track).or_insert(found);
        if found.apart_m < known.apart_m {
            *known = found;
        }
    }
    nearest.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of 100 m with a depth each metre: to the north if `is_crossing`, otherwise to the
    /// east.
    fn line(across_m: f64, is_crossing: bool, depth_m: impl Fn(usize) -> f64) -> Vec<TrackDepth> {
        let depth = |index: usize| {
            let along_m = index as f64;
            let place = if is_crossing { [across_m, along_m] } else { [along_m, across_m] };
            TrackDepth::new(along_m, place, depth_m(index))
        };
        (0..100).map(depth).collect()
    }

    fn found(tracks: &[Vec<TrackDepth>]) -> Vec<(usize, Range<usize>)> {
        let found = contradicted(tracks, &|_, _| true, &Progress::new()).unwrap();
        found.into_iter().map(|stretch| (stretch.track, stretch.depths)).collect()
    }

    #[test]
    fn a_false_stretch_is_the_one_that_two_logs_contradict() {
        let held = |index: usize| if (20..60).contains(&index) { 9.2 } else { 22.0 };
        let tracks = [
            line(50.3, false, held),
            line(30.2, true, |_| 22.3),
            line(40.2, true, |_| 21.8),
            line(80.2, true, |_| 22.1),
        ];
        assert_eq!(found(&tracks), [(0, 20..60)]);
        let stretch = &contradicted(&tracks, &|_, _| true, &Progress::new()).unwrap()[0];
        let against: Vec<usize> =
            stretch.against.iter().map(|contradiction| contradiction.track).collect();
        assert_eq!(against, [1, 2]);
        assert!(stretch.against[0].depths_m == [9.2, 22.3] && stretch.against[0].apart_m < 1.0);
        // Nothing may be left out that first returns judge.
        let none = contradicted(&tracks, &|track, _| track != 0, &Progress::new()).unwrap();
        assert!(none.is_empty());
    }

    #[test]
    fn two_logs_alone_do_not_tell_which_is_false() {
        let held = |index: usize| if (20..60).contains(&index) { 9.2 } else { 22.0 };
        assert!(found(&[line(50.3, false, held), line(30.2, true, |_| 22.0)]).is_empty());
    }

    #[test]
    fn a_shoal_that_others_measured_too_and_steep_banks_stay() {
        let shoal = |index: usize| if (10..80).contains(&index) { 9.2 } else { 22.0 };
        let tracks = [
            line(50.3, false, shoal),
            line(40.2, true, |_| 9.3),
            line(50.2, true, |_| 9.0),
            // These two contradict it at its end.
            line(78.9, true, |_| 22.0),
            line(79.4, true, |_| 22.0),
        ];
        assert!(found(&tracks).is_empty(), "{:?}", found(&tracks));
        // 40 degrees, measured 4 m apart.
        let bank = |index: usize| 5.0 + 0.84 * index as f64;
        let beside = |index: usize| bank(index + 4);
        assert!(found(&[line(0.0, false, bank), line(3.0, false, beside)]).is_empty());
    }

    #[test]
    fn leaps_and_gaps_with_other_depths_divide_a_track() {
        let mut depths = line(0.0, false, |index| if index < 30 { 9.0 } else { 20.0 });
        assert_eq!(stretches_of(&depths), [0..30, 30..100]);
        for depth in &mut depths[60..] {
            depth.east_m += 40.0;
        }
        assert_eq!(stretches_of(&depths), [0..30, 30..100], "as deep on both sides");
        for depth in &mut depths[60..] {
            depth.depth_m = 12.0;
        }
        assert_eq!(stretches_of(&depths), [0..30, 30..60, 60..100]);
        for depth in &mut depths[60..] {
            depth.east_m += 40.0;
            depth.depth_m = 20.0;
        }
        assert_eq!(stretches_of(&depths), [0..30, 30..60, 60..100], "far away");
        assert!(stretches_of(&[]).is_empty());
    }
}
