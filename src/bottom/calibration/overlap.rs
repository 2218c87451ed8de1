//! Finds the overlap of the beams: the angle by which the beam of each side reaches past the nadir,
//! to the other side.
//!
//! In drawings the beam of a side ends straight below the boat; the beams of recorders do not. This
//! shows where the bottom slopes across the track: on the side to which it falls, the first return
//! comes from the edge of the beam, over on the rising side, and is nearer than the depth below the
//! boat. With the ranges `n` of the rising and `f` of the falling side, the depth `d`, and `cos(a)
//! = n / f`, a plane gives `f / d = cos(p) - sin(p) tan(a)` for beams that reach past the nadir by
//! `p` (as in `cloud::specular`). On level ground `f / d` shows how ranges and depths are
//! calibrated to each other.
//!
//! Not every block of pings lies on a plane: a bank that ends beside the boat shows no overlap, or
//! one of the other sign. So the overlap is the one that most blocks show, not their median. A
//! sounding that is late is off where the bottom rises or falls along the track: blocks over ground
//! that is level along it count alone where there are enough of them.
//!
//! A sounder whose beam is wider to each side, by `q`, than the overlap of the side-scan takes the
//! nearest ground in its beam, so that `f / d = cos(q) + sin(q) tan(a)`: the same with `p = -q`.

use super::Calibration;
use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::{median_of, quantile, sorted, usual_step};
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;
use std::ops::Range;

/// Number of pings of a block that is compared, at most and at least, and least share of them with
/// all three distances.
const BLOCK: usize = 20;
const SHORTEST_BLOCK: usize = 4;
const LEAST_SHARE: f64 = 0.6;
/// Longest time between the first and the last ping of a block, seconds: the blocks of a slow
/// recorder have fewer pings.
const LONGEST_S: f64 = 4.0;
/// Slopes that count as level, slopes that determine the overlap, and the fewest blocks of each;
/// tangents of the angle. On steeper slopes the echo from the edge of the beam is weak, and comes
/// late: from 0.3 on, blocks of `reach.py` show a third of the overlap, or none.
const LEVEL: Range<f64> = 0.0..0.04;
const TELLING: Range<f64> = 0.05..0.3;
const LEAST_BLOCKS: usize = 8;
/// Largest overlap, degrees: a larger one has another cause, boulders that both sides detect, or
/// depths that are wrong.
const MOST_DEG: f64 = 12.0;
/// Least angle by which a sounder's beam is wider, degrees, and the slopes that are steep enough to
/// show it: on others the sounder takes the nearest ground, as the side-scan does.
const LEAST_WIDER_DEG: f64 = 2.0;
const STEEP: Range<f64> = 0.13..0.45;
/// Largest change of the distances along a block, from its first third to its last, at which the
/// ground is level along the track, as a share of the depth.
const LEVEL_ALONG: f64 = 0.02;
/// Error of the overlap that a block shows, radians: a part divided by the tangent, by errors of
/// the ranges, and a part on any slope.
const BLOCK_ERROR: [f64; 2] = [0.0015, 0.009];
/// Number of these errors within which a block shows no overlap, and within which it agrees with
/// one: how far a beam is seen to reach depends a little on the slope, and surveys along the same
/// lines must find the same.
const SHOWS_NONE: f64 = 2.0;
const AGREES: f64 = 4.0;
/// Step between the overlaps that are tried, and the least overlap that is known, degrees.
const STEP_DEG: f64 = 0.1;
const LEAST_DEG: f64 = 1.0;
/// Least share of the weight of all blocks that must agree with an overlap, and its least ratio to
/// the share that shows none.
const LEAST_AGREEING: f64 = 0.3;
const TIMES_NONE: f64 = 2.0;

/// A block of pings: the tangent of the slope beyond the overlap, the range of the falling side as
/// a share of the depth, and true if the ground is level along the track.
#[derive(Clone, Copy, Debug)]
struct Block {
    tangent: f64,
    share: f64,
    is_level_along: bool,
}

impl Block {
    /// Creates the block of some pings; `None` where fewer than `least` of them have all distances,
    /// or they are too far apart in time.
    fn of(pings: &[PingRanges], least: usize) -> Option<Self> {
        let [first, last] = [pings.first()?, pings.last()?];
        let is_whole = |ping: &&PingRanges| {
            ping.sides_m.iter().chain([&ping.depth_m]).all(|distance_m| *distance_m > 0.0)
        };
        let all: Vec<&PingRanges> = pings.iter().filter(is_whole).collect();
        if all.len() < least || last.time_s - first.time_s > LONGEST_S {
            return None;
        }
        let middle = |pings: &[&PingRanges], of: &dyn Fn(&PingRanges) -> f64| {
            median_of(pings.iter().map(|ping| of(ping)))
        };
        let [port_m, starboard_m] = [0, 1].map(|side| middle(&all, &|ping| ping.sides_m[side]));
        let depth_m = middle(&all, &|ping| ping.depth_m);
        let (near_m, far_m) = (port_m.min(starboard_m), port_m.max(starboard_m));
        let third = all.len() / 3;
        let change_m = |of: &dyn Fn(&PingRanges) -> f64| {
            (middle(&all[..third], of) - middle(&all[all.len() - third..], of)).abs()
        };
        let sides_m = change_m(&|ping| 0.5 * (ping.sides_m[0] + ping.sides_m[1]));
        Some(Self {
            tangent: (near_m / far_m).acos().tan(),
            share: far_m / depth_m,
            is_level_along: change_m(&|ping| ping.depth_m).max(sides_m) < LEVEL_ALONG * depth_m,
        })
    }

    /// Returns the overlap that gives the share of the block, radians: `cos(p) - p tan(a)` to the
    /// second order. `level` is the share on level ground. The overlap is less than 0 where the
    /// sounder's beam is wider.
    fn overlap_rad(&self, level: f64) -> f64 {
        let nearer = 1.0 - self.share / level;
        (self.tangent * self.tangent + 2.0 * nearer).max(0.0).sqrt() - self.tangent
    }
}

/// Distances of a ping by the calibration in force, metres; NaN where a distance is not known.
#[derive(Clone, Copy, Debug)]
struct PingRanges {
    time_s: f64,
    /// Slant ranges of the first returns, port and starboard.
    sides_m: [f64; 2],
    /// Recorded depth.
    depth_m: f64,
}

/// Widths of beams, found on slopes across the track, radians; 0 where these show nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeamWidths {
    /// Angle by which the beam of each side reaches past the nadir to the other side.
    pub overlap_rad: f64,
    /// Least angle to each side by which the sounder's beam is wider than the overlap.
    pub wider_rad: f64,
}

impl BeamWidths {
    /// Returns a sentence about the wide beam of the sounder; `None` where it is not wide.
    pub(super) fn warning(self) -> Option<String> {
        (self.wider_rad > 0.0).then(|| {
            "On slopes across the track soundings are nearer than the first returns of the lower side: the sounder has a wide beam and takes the nearest ground in it, so that soundings over slopes are too shallow.".to_owned()
        })
    }
}

/// Returns the widths of the beams that a log shows.
pub(super) fn beam_widths(
    survey: &Survey,
    returns: &FirstReturns,
    calibration: &Calibration,
) -> BeamWidths {
    let interval_s = usual_step(survey.side_scan.iter().map(|ping| ping.time_s));
    let length = block_length(interval_s);
    let starts: Vec<usize> = (0..survey.side_scan.len()).step_by(length).collect();
    let block_from = |start: usize| {
        let pings = start..(start + length).min(survey.side_scan.len());
        let pings = pings.map(|ping| PingRanges {
            time_s: survey.side_scan[ping].time_s,
            sides_m: Side::BOTH.map(|side| calibration.first_return_m(survey, returns, ping, side)),
            depth_m: f64::from(survey.good_depth_m(ping)),
        });
        Block::of(&pings.collect::<Vec<_>>(), least_of(length))
    };
    let blocks: Vec<Block> = starts.into_par_iter().filter_map(block_from).collect();
    let level = blocks.iter().filter(|block| block.is_level_along).copied();
    let widths = widths_of(&level.collect::<Vec<_>>());
    match widths {
        None if !calibration.are_soundings_late(survey) => widths_of(&blocks),
        widths => widths,
    }
    .unwrap_or_default()
}

/// Returns the number of pings of a block at a usual time between pings.
fn block_length(interval_s: f64) -> usize {
    ((LONGEST_S / interval_s) as usize).clamp(SHORTEST_BLOCK, BLOCK)
}

/// Returns the fewest pings with all distances that a block of `length` pings needs.
fn least_of(length: usize) -> usize {
    (LEAST_SHARE * length as f64).ceil() as usize
}

/// Returns the widths of the beams that some blocks show; `None` with too few blocks.
fn widths_of(blocks: &[Block]) -> Option<BeamWidths> {
    let of = |slopes: Range<f64>| -> Vec<Block> {
        blocks.iter().filter(|block| slopes.contains(&block.tangent)).copied().collect()
    };
    let (level, telling, steep) = (of(LEVEL), of(TELLING), of(STEEP));
    if level.len().min(telling.len()) < LEAST_BLOCKS {
        return None;
    }
    // Ground that slopes by less than the overlap looks level, but its ranges are shorter.
    let level = quantile(&sorted(level.iter().map(|block| block.share)), 0.75);
    let overlap_rad = known_overlap_rad(&telling, level).filter(|angle_rad| *angle_rad > 0.0);
    let wider_rad = known_overlap_rad(&steep, level)
        .map(|angle_rad| -angle_rad)
        .filter(|angle_rad| *angle_rad >= LEAST_WIDER_DEG.to_radians());
    Some(BeamWidths {
        overlap_rad: overlap_rad.unwrap_or(0.0),
        wider_rad: wider_rad.unwrap_or(0.0),
    })
}

/// Returns the overlap that most of some blocks show, radians; `None` with too few blocks, where
/// they do not agree, and where as many show none. Blocks count by the squares of their tangents.
fn known_overlap_rad(blocks: &[Block], level: f64) -> Option<f64> {
    if blocks.len() < LEAST_BLOCKS {
        return None;
    }
    let shown: Vec<[f64; 3]> = blocks
        .iter()
        .map(|block| {
            let error_rad = BLOCK_ERROR[0] / block.tangent + BLOCK_ERROR[1];
            [block.overlap_rad(level), error_rad, block.tangent * block.tangent]
        })
        .collect();
    let density = |overlap_rad: f64| -> f64 {
        let part = |&[shown_rad, error_rad, weight]: &[f64; 3]| {
            let errors = (shown_rad - overlap_rad) / (0.5 * AGREES * error_rad);
            weight / error_rad * (-0.5 * errors * errors).exp()
        };
        shown.iter().map(part).sum()
    };
    let steps = (MOST_DEG / STEP_DEG).round() as i32;
    let (_, overlap_rad) = (-steps..=steps)
        .into_par_iter()
        .map(|step| (f64::from(step) * STEP_DEG).to_radians())
        .map(|overlap_rad| (density(overlap_rad), overlap_rad))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    // Weights of the blocks within so many errors of an overlap, and the mean of their overlaps.
    let within = |errors: f64, overlap_rad: f64| {
        let is_within = |[shown_rad, error_rad, _]: &&[f64; 3]| {
            (shown_rad - overlap_rad).abs() < errors * error_rad
        };
        let sums = shown.iter().filter(is_within).fold([0.0; 2], |sums, [shown_rad, _, weight]| {
            [sums[0] + weight, sums[1] + weight * shown_rad]
        });
        (sums[0], sums[1] / sums[0])
    };
    let all: f64 = shown.iter().map(|[_, _, weight]| weight).sum();
    let (none, _) = within(SHOWS_NONE, 0.0);
    let (most, overlap_rad) = within(AGREES, overlap_rad);
    let is_known = overlap_rad.abs() >= LEAST_DEG.to_radians()
        && most > (LEAST_AGREEING * all).max(TIMES_NONE * none);
    is_known.then_some(overlap_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pings over planes of slopes from level to 30 degrees, with ranges 1 % too long and noise.
    fn banks(overlap_deg: f64) -> Vec<PingRanges> {
        let overlap_rad = overlap_deg.to_radians();
        let ping = |ping: u32| {
            let slope_rad = f64::from(ping / 20 % 31).to_radians();
            let noise = 1.0 + 0.004 * [0.0, 1.0, -1.0, 0.5, -0.5, 0.2, -0.2][ping as usize % 7];
            let past_rad = overlap_rad.min(slope_rad);
            let near_m = 6.06 * slope_rad.cos() * noise;
            let far_m = 6.06 * slope_rad.cos() / (slope_rad - past_rad).cos() / noise;
            let is_port = (ping / 300).is_multiple_of(2);
            PingRanges {
                time_s: 0.1 * f64::from(ping),
                sides_m: if is_port { [near_m, far_m] } else { [far_m, near_m] },
                depth_m: 6.0,
            }
        };
        (0..2000).map(ping).collect()
    }

    fn found(pings: &[PingRanges]) -> BeamWidths {
        let length = block_length(usual_step(pings.iter().map(|ping| ping.time_s)));
        let blocks = pings.chunks(length).filter_map(|pings| Block::of(pings, least_of(length)));
        let blocks: Vec<Block> = blocks.collect();
        widths_of(&blocks).unwrap_or_default()
    }

    fn found_deg(pings: &[PingRanges]) -> f64 {
        found(pings).overlap_rad.to_degrees()
    }

    #[test]
    fn a_sounder_with_a_wider_beam_is_found_and_said() {
        let half_rad = 10f64.to_radians();
        let widened = |ping: PingRanges| {
            let slope_rad = (f64::from((10.0 * ping.time_s).round() as u32 / 20 % 31)).to_radians();
            let inside_rad = (slope_rad - half_rad).max(0.0);
            PingRanges { depth_m: 6.0 * slope_rad.cos() / inside_rad.cos(), ..ping }
        };
        let pings: Vec<PingRanges> = banks(3.0).into_iter().map(widened).collect();
        let widths = found(&pings);
        assert!((widths.wider_rad.to_degrees() - 7.0).abs() < 1.0, "{widths:?}");
        assert_eq!(widths.overlap_rad, 0.0);
        let warning = widths.warning().unwrap();
        assert!(warning.contains("wide beam"));
        assert_eq!(found(&banks(3.0)).warning(), None);
        assert_eq!(found(&banks(0.0)).warning(), None);
    }

    #[test]
    fn the_overlap_comes_back_from_banks_whatever_the_calibration() {
        for overlap_deg in [2.0, 5.0, 9.0] {
            let found_deg = found_deg(&banks(overlap_deg));
            assert!((found_deg - overlap_deg).abs() < 0.8, "{overlap_deg}: {found_deg}");
        }
        assert!(found_deg(&banks(0.0)) < 0.3);
        // Two pings a second.
        let slow = |ping: PingRanges| PingRanges { time_s: 5.0 * ping.time_s, ..ping };
        let slow_deg = found_deg(&banks(5.0).into_iter().map(slow).collect::<Vec<_>>());
        assert!((slow_deg - 5.0).abs() < 0.8, "{slow_deg}");
    }

    /// A bank that ends beside the boat is seen by the falling side straight below.
    #[test]
    fn banks_that_end_beside_the_boat_do_not_hide_the_overlap() {
        let ended = |(index, ping): (usize, PingRanges)| {
            let [port_m, starboard_m] = ping.sides_m;
            let is_ended = (index / BLOCK) % 5 < 2 && (port_m - starboard_m).abs() > 0.1;
            let farther = usize::from(starboard_m > port_m);
            let mut sides_m = ping.sides_m;
            if is_ended {
                sides_m[farther] = 6.06;
            }
            PingRanges { sides_m, ..ping }
        };
        let pings: Vec<PingRanges> = banks(5.0).into_iter().enumerate().map(ended).collect();
        let overlap_deg = found_deg(&pings);
        assert!((overlap_deg - 5.0).abs() < 0.8, "{overlap_deg}");
    }

    #[test]
    fn ground_that_falls_along_the_track_is_not_level() {
        let falling = |per_s_m: f64| {
            let pings = banks(5.0)[..BLOCK].to_vec().into_iter();
            let pings = pings
                .map(|ping| PingRanges { depth_m: ping.depth_m + per_s_m * ping.time_s, ..ping });
            Block::of(&pings.collect::<Vec<_>>(), least_of(BLOCK)).map(|block| block.is_level_along)
        };
        assert_eq!(falling(0.0), Some(true));
        assert_eq!(falling(0.2), Some(false));
    }

    #[test]
    fn level_ground_and_too_few_pings_show_none() {
        let level = |ping: PingRanges| PingRanges { sides_m: [6.0; 2], ..ping };
        let pings: Vec<PingRanges> = banks(5.0).into_iter().map(level).collect();
        assert_eq!(found_deg(&pings), 0.0);
        assert_eq!(found_deg(&banks(5.0)[..100]), 0.0);
    }
}
