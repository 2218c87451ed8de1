//! Finds false positions and soundings in a recording before results are computed from them.
//!
//! A position is checked against the positions before and after it and the speed of the boat, a
//! sounding against its neighbours along the track. A value that contradicts these by more than
//! their errors is false: it does not count, and a sentence reports when, how many and why. The
//! rules are in metres of track and in the log's own intervals and speeds, so that they apply to
//! recorders of any rate; times in seconds only limit how far apart compared values may be.
//!
//! `soundings` finds the faults of soundings.

mod soundings;

pub(crate) use soundings::{NEAREST_SOUNDING_S, give_depths, mark_faults_from};
pub use soundings::{differ_as_no_bed, is_step_of_no_bed, mark_faults};

use crate::named;
use crate::support::geo::{distance_m, east_of_deg};
use crate::support::statistics::{quantile, sorted, upper_median};
use crate::survey::{Fix, run_ranges};
use serde::ser::{Serialize, SerializeMap, Serializer};

/// The reason why a sounding does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SoundingFault {
    /// The recorder had lost the bottom: the depths jump up and down.
    LostBottom,
    /// The depth is between a leap far below the bottom and the leap back.
    FarBelow,
    /// The depth differs alone from the depths before and after it.
    Glitch,
    /// The depth is from the echo that went to the bottom twice: it is twice that of the first
    /// returns of both sides.
    SecondEcho,
    /// The recorder repeats its last depth while the first returns of both sides change.
    Held,
}

named! {
    /// All faults, in the order of [`FaultCounts`].
    pub SoundingFault {
        LostBottom: "lost bottom",
        FarBelow: "far below the bottom",
        Glitch: "glitch",
        SecondEcho: "second echo",
        Held: "held depth",
    }
}

impl SoundingFault {
    /// Returns the sign of the fault as the end of a sentence about several soundings.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::LostBottom => "jump up and down (the recorder had lost the bottom)",
            Self::FarBelow => "lie between a leap far below the bottom and the leap back",
            Self::Glitch => "depart from those before and after them",
            Self::SecondEcho => {
                "are twice as deep as the first returns of both sides (the recorder took the second echo of the bottom)"
            }
            Self::Held => {
                "stay the same while the first returns of both sides move (the recorder had lost the bottom and wrote its last depth)"
            }
        }
    }
}

/// Number of soundings with each fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultCounts([usize; SoundingFault::ALL.len()]);

impl FaultCounts {
    /// Counts faults.
    pub fn of(faults: impl IntoIterator<Item = SoundingFault>) -> Self {
        let mut counts = Self::default();
        for fault in faults {
            counts.0[fault as usize] += 1;
        }
        counts
    }

    /// Adds the counts of another log.
    pub fn add(&mut self, other: &Self) {
        for (count, more) in self.0.iter_mut().zip(other.0) {
            *count += more;
        }
    }

    /// Returns the number of soundings with any fault.
    pub fn all(&self) -> usize {
        self.0.iter().sum()
    }

    /// Returns the faults that occur, with their numbers of soundings.
    pub fn found(&self) -> impl Iterator<Item = (SoundingFault, usize)> + '_ {
        let counts = SoundingFault::ALL.into_iter().map(|fault| (fault, self.0[fault as usize]));
        counts.filter(|(_, count)| *count > 0)
    }

    /// Describes the counts in words: "83 lost bottom, 12 glitch".
    pub fn summary(&self) -> String {
        let each = self.found().map(|(fault, count)| format!("{count} {}", fault.name()));
        each.collect::<Vec<_>>().join(", ")
    }
}

/// Writes a map from the name of each fault that occurs to its number of soundings.
impl Serialize for FaultCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (fault, count) in self.found() {
            map.serialize_entry(fault.name(), &count)?;
        }
        map.end()
    }
}

/// Distance from the track's median position beyond which a position is damaged data, degrees (some
/// 200 km). Such positions are removed first, because they would distort the speeds of the boat.
const STRAY_DEG: f64 = 2.0;
/// Shortest time over which a speed is computed, seconds: over shorter times the noise and the
/// rounding of the positions dominate.
const SPEED_OVER_S: f64 = 4.0;
/// Share of the track's speeds that are real speeds of the boat even where some positions are
/// false.
const BOATS_SHARE: f64 = 0.9;
/// Largest speed of the boat: this many times the speed that it stays below for [`BOATS_SHARE`] of
/// the track, plus this many metres a second.
const FASTER: (f64, f64) = (2.0, 2.0);
/// Distance between two positions that noise and rounding can explain, metres: receivers without
/// corrections scatter by a few metres.
const NOISE_M: f64 = 8.0;
/// Fewest fixes that can be checked against each other.
const FEWEST: usize = 8;
/// Largest share of the fixes that is left out: where more seem false, it is not known which of
/// them are.
const MOST_FALSE: f64 = 0.2;
/// Longest time for which positions can be false, seconds. Positions that stay away for longer are
/// no fault of the receiver: the clock or the log has a gap there, and both sides of the gap are
/// kept.
const LONGEST_S: f64 = 60.0;

/// A run of fixes without an impossible step between them.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Indices of the first and the last fix.
    first: usize,
    last: usize,
    is_false: bool,
}

impl Piece {
    fn len(&self) -> usize {
        self.last + 1 - self.first
    }
}

/// Removes false fixes from `fixes`, which are in time order, and returns sentences about them,
/// without a capital letter and a full stop. Where the times of the fixes are assumed (`has_times`
/// is false) there are no speeds, and only positions hundreds of kilometres away are removed.
pub(crate) fn drop_false_fixes(fixes: &mut Vec<Fix>, has_times: bool) -> Vec<String> {
    let mut sentences = Vec::new();
    sentences.extend(drop_stray(fixes));
    if fixes.len() < FEWEST || !has_times {
        return sentences;
    }
    let fastest_mps = fastest_mps(fixes);
    let mut pieces = pieces(fixes, fastest_mps);
    mark_false(&mut pieces, fixes, fastest_mps);
    let count: usize = pieces.iter().filter(|piece| piece.is_false).map(Piece::len).sum();
    if count == 0 {
        return sentences;
    }
    if count as f64 > MOST_FALSE * fixes.len() as f64 {
        let jumps = match pieces.len() - 1 {
            1 => "once".to_owned(),
            jumps => format!("{jumps} times"),
        };
        sentences.push(format!(
            "the positions jump {jumps} farther than the boat can go (at most {fastest_mps:.0} m/s), and it is not known which of them are false: all are kept"
        ));
        return sentences;
    }
    sentences.extend(sentence(&pieces, count, fixes, fastest_mps));
    let is_false = |index: usize| {
        let piece = pieces.partition_point(|piece| piece.last < index);
        pieces.get(piece).is_some_and(|piece| piece.is_false)
    };
    let mut index = 0;
    fixes.retain(|_| {
        index += 1;
        !is_false(index - 1)
    });
    sentences
}

/// Removes fixes that are far away from all others because of a damaged record; returns a sentence
/// about them, if any.
fn drop_stray(fixes: &mut Vec<Fix>) -> Option<String> {
    let median = |pick: fn(&Fix) -> f64| {
        let mut values: Vec<f64> = fixes.iter().map(pick).collect();
        upper_median(&mut values, f64::total_cmp)
    };
    let lon_deg = median(|fix| fix.position.lon_deg)?;
    let lat_deg = median(|fix| fix.position.lat_deg)?;
    let before = fixes.len();
    let mut first_s = f64::NAN;
    fixes.retain(|fix| {
        let east_deg = east_of_deg(lon_deg, fix.position.lon_deg);
        let near = (fix.position.lat_deg - lat_deg).abs() < STRAY_DEG
            && east_deg.abs() * lat_deg.to_radians().cos() < STRAY_DEG;
        if !near {
            first_s = first_s.min(fix.time_s);
        }
        near
    });
    let dropped = before - fixes.len();
    (dropped > 0).then(|| match dropped {
        1 => format!(
            "the position at {first_s:.1} s lies hundreds of kilometres from all others and was dropped"
        ),
        _ => format!(
            "{dropped} positions, the first at {first_s:.1} s, lie hundreds of kilometres from all others and were dropped"
        ),
    })
}

/// Estimates the speed that the boat does not exceed, metres a second, from the track and from the
/// speeds that the receiver recorded.
fn fastest_mps(fixes: &[Fix]) -> f64 {
    let mut speeds: Vec<f64> = Vec::new();
    let mut from = 0;
    for (index, fix) in fixes.iter().enumerate() {
        let took_s = fix.time_s - fixes[from].time_s;
        if took_s < SPEED_OVER_S {
            continue;
        }
        speeds.push(distance_m(fixes[from].position, fix.position) / took_s);
        from = index;
    }
    let recorded = fixes.iter().map(|fix| f64::from(fix.speed_mps));
    let recorded = recorded.filter(|speed| speed.is_finite());
    let usual = [sorted(speeds), sorted(recorded)]
        .into_iter()
        .filter(|some| !some.is_empty())
        .map(|some| quantile(&some, BOATS_SHARE))
        .fold(0.0, f64::max);
    FASTER.0 * usual + FASTER.1
}

/// Returns true if the boat can have gone from one fix to the other in the time between.
fn can_follow(from: &Fix, to: &Fix, fastest_mps: f64) -> bool {
    let far_m = distance_m(from.position, to.position);
    far_m <= NOISE_M + fastest_mps * (to.time_s - from.time_s).max(0.0)
}

fn pieces(fixes: &[Fix], fastest_mps: f64) -> Vec<Piece> {
    let together = run_ranges(fixes, |before, after| can_follow(before, after, fastest_mps));
    together.map(|run| Piece { first: run.start, last: run.end - 1, is_false: false }).collect()
}

/// Marks as false the short pieces that the boat cannot have reached from the pieces that are kept,
/// going outward from the longest piece in both directions.
fn mark_false(pieces: &mut [Piece], fixes: &[Fix], fastest_mps: f64) {
    let length_s = |piece: &Piece| fixes[piece.last].time_s - fixes[piece.first].time_s;
    let longest = (0..pieces.len()).max_by(|&a, &b| {
        let [a, b] = [&pieces[a], &pieces[b]];
        length_s(a).total_cmp(&length_s(b)).then(a.len().cmp(&b.len()))
    });
    let Some(longest) = longest else {
        return;
    };
    let later: Vec<usize> = (longest + 1..pieces.len()).collect();
    let earlier: Vec<usize> = (0..longest).rev().collect();
    for outward in [later, earlier] {
        let mut kept = longest;
        for index in outward {
            let [before, after] = [kept.min(index), kept.max(index)].map(|index| pieces[index]);
            let follows = can_follow(&fixes[before.last], &fixes[after.first], fastest_mps);
            if follows || length_s(&pieces[index]) > LONGEST_S {
                kept = index
            } else {
                pieces[index].is_false = true
            }
        }
    }
}

/// Returns the sentence about the `dropped` fixes that are left out; `None` where there are none.
fn sentence(pieces: &[Piece], dropped: usize, fixes: &[Fix], fastest_mps: f64) -> Option<String> {
    let index = pieces.iter().position(|piece| piece.is_false)?;
    let first = &fixes[pieces[index].first];
    let beside = |index: usize| pieces.get(index).filter(|piece| !piece.is_false);
    let before = beside(index.wrapping_sub(1)).map(|piece| &fixes[piece.last]);
    let after = pieces[index..].iter().find(|piece| !piece.is_false);
    let other = before.or(after.map(|piece| &fixes[piece.first]))?;
    let far_m = distance_m(first.position, other.position);
    let apart_s = (first.time_s - other.time_s).abs();
    let which = match dropped {
        1 => format!("the position at {:.1} s", first.time_s),
        _ => format!("{dropped} positions, the first at {:.1} s,", first.time_s),
    };
    let (verb, were) = if dropped == 1 { ("lies", "was") } else { ("lie", "were") };
    Some(format!(
        "{which} {verb} {far_m:.0} m from another {apart_s:.1} s away, farther than the boat can go (this one at most {fastest_mps:.0} m/s), and {were} left out"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::geo::{LonLat, metres_per_degree};

    /// Creates fixes at these times and metres east and north of a place.
    fn fixes(places: impl IntoIterator<Item = (f64, [f64; 2])>) -> Vec<Fix> {
        let at = LonLat::new(8.5, 47.5);
        let [lon_m, lat_m] = metres_per_degree(at);
        let place = |[x, y]: [f64; 2]| LonLat::new(at.lon_deg + x / lon_m, at.lat_deg + y / lat_m);
        places.into_iter().map(|(time_s, xy)| Fix::at(time_s, place(xy))).collect()
    }

    #[test]
    fn far_positions_go_and_those_across_the_antimeridian_stay() {
        let at = |places: &[[f64; 2]]| -> Vec<Fix> {
            let fix = |(index, &[lon, lat]): (usize, &[f64; 2])| {
                Fix::at(1e5 * index as f64, LonLat::new(lon, lat))
            };
            places.iter().enumerate().map(fix).collect()
        };
        let mut some = at(&[[10.0, 50.0], [10.0, 50.1], [-120.0, -40.0], [10.1, 50.0]]);
        let sentences = drop_false_fixes(&mut some, true);
        assert!(sentences[0].starts_with("the position at 200000.0 s"), "{sentences:?}");
        assert_eq!(some.len(), 3);
        let mut pacific = at(&[[179.9, -18.0], [-179.9, -18.0], [179.95, -18.0], [-179.95, -18.0]]);
        assert!(drop_false_fixes(&mut pacific, true).is_empty());
        assert_eq!(pacific.len(), 4);
        assert!(drop_false_fixes(&mut Vec::new(), true).is_empty());
    }

    #[test]
    fn a_jump_away_and_back_is_left_out_at_any_rate_of_fixes() {
        for step_s in [0.1, 1.0, 5.0] {
            let path = |index: usize| match index {
                50..53 => [143.0, 2.0 * step_s * index as f64],
                _ => [0.0, 2.0 * step_s * index as f64],
            };
            let mut some = fixes((0..120).map(|index| (step_s * index as f64, path(index))));
            let sentences = drop_false_fixes(&mut some, true);
            assert_eq!(some.len(), 117, "{step_s} s: {sentences:?}");
            assert!(sentences[0].starts_with("3 positions, the first at"), "{sentences:?}");
        }
    }

    #[test]
    fn false_positions_at_either_end_are_left_out() {
        for far in [0..3, 117..120] {
            let path = |index: usize| [if far.contains(&index) { 5e3 } else { 0.0 }, index as f64];
            let mut some = fixes((0..120).map(|index| (index as f64, path(index))));
            assert_eq!(drop_false_fixes(&mut some, true).len(), 1);
            assert_eq!(some.len(), 117);
        }
    }

    #[test]
    fn turns_noise_stops_and_a_log_that_goes_on_elsewhere_stay() {
        // A boat that speeds up to 12 m/s for a tenth of the time, with noise of 2 m.
        let mut north_m = 0.0;
        let mut path = Vec::new();
        for index in 0..400 {
            north_m += if (200..250).contains(&index) { 12.0 } else { 1.5 };
            let noise_m = [2.0, -1.0, 0.5, -2.0, 1.0][index % 5];
            path.push((index as f64, [noise_m, north_m]));
        }
        let mut some = fixes(path.clone());
        assert!(drop_false_fixes(&mut some, true).is_empty());
        // The recorder was switched off, carried 2 km and switched on again.
        let elsewhere = path.iter().map(|&(time_s, [x, y])| (time_s + 401.0, [x + 2e3, y]));
        let mut both = fixes(path.iter().copied().chain(elsewhere));
        drop_false_fixes(&mut both, true);
        assert_eq!(both.len(), 800);
    }

    #[test]
    fn faults_are_counted_by_their_names() {
        use SoundingFault::{Glitch, Held, LostBottom};
        let mut counts = FaultCounts::of([Glitch, Held, Glitch]);
        counts.add(&FaultCounts::of([LostBottom]));
        assert_eq!(counts.all(), 4);
        assert_eq!(counts.summary(), "1 lost bottom, 2 glitch, 1 held depth");
        assert_eq!(FaultCounts::default().summary(), "");
    }
}
