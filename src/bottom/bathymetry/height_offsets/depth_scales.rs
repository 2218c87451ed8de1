//! Finds logs whose depths differ more, the deeper the water is.
//!
//! A recorder that counts with another sound speed gives all depths larger by the same share. Where
//! two logs cross in shallow and in deep water, their difference grows with the depth by this
//! share. A difference of heights, and one of positions on a slope, are parts of the same equation,
//! so that neither is taken for the share:
//!
//! ```text
//! depth of the other log - depth of the first = height + share depth + shift . gradient
//! ```

use super::{LogOverlap, robust_shares};
use crate::sparse::solve_dense;
use bathyscope_log::support::statistics::ends;
use faer::Mat;
use serde::Serialize;
use std::collections::BTreeMap;

/// Unknowns: height, share, and the shift to the east and to the north.
const UNKNOWNS: usize = 4;
/// Fewest overlaps of two logs that determine a share.
const FEWEST: usize = 10;
/// Rounds in which outliers lose their weight.
const ROUNDS: usize = 12;
/// Largest number of lots, of which one after another is left out to find the error: a lot holds
/// one line, or several where there are more lines.
const MOST_LOTS: usize = 40;
/// Fewest lots from which an error is found.
const LEAST_LOTS: usize = 4;
/// Least share that is reported: as a number of standard errors, as a share, and as the difference
/// that it makes between the shallowest and the deepest overlap, metres.
const SIGMAS: f64 = 4.0;
const LEAST_SHARE: f64 = 0.004;
const LEAST_DIFFERENCE_M: f64 = 0.03;

/// Two logs whose depths differ by a share of the depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthScale {
    /// Index of the log whose depths are greater, and index of the other log.
    pub logs: [usize; 2],
    /// Share of the depth by which its depths are greater: 0.02 is 2 %.
    pub share: f64,
    /// Standard error of the share.
    pub standard_error: f64,
    /// Least and greatest depth at which the logs were compared, metres.
    pub depth_m: [f64; 2],
    /// Number of places where the logs cross or overlap.
    pub n: usize,
}

/// Returns the pairs of logs whose depths differ by a share of the depth that exceeds its error, in
/// order. The error is found by leaving out one line after another, since the errors of the
/// overlaps on one line are alike.
pub(super) fn depth_scales(overlaps: &[LogOverlap]) -> Vec<DepthScale> {
    let mut pairs: BTreeMap<[usize; 2], Vec<&LogOverlap>> = BTreeMap::new();
    for overlap in overlaps {
        let is_known = overlap.depth_m.is_finite() && overlap.difference_m.is_finite();
        if is_known && overlap.gradient.iter().all(|slope| slope.is_finite()) {
            pairs.entry(overlap.logs).or_default().push(overlap);
        }
    }
    pairs.iter().filter_map(|(logs, overlaps)| depth_scale(*logs, overlaps)).collect()
}

fn depth_scale(logs: [usize; 2], overlaps: &[&LogOverlap]) -> Option<DepthScale> {
    if overlaps.len() < FEWEST {
        return None;
    }
    let share = fitted_share(overlaps)?;
    let standard_error = [0, 1]
        .into_iter()
        .map(|pass| jackknife_error(overlaps, pass, share))
        .try_fold(0.0, |most: f64, error| Some(most.max(error?)))?;
    let depth_m = ends(overlaps.iter().map(|overlap| overlap.depth_m));
    let is_told = share.abs() > (SIGMAS * standard_error).max(LEAST_SHARE)
        && share.abs() * (depth_m[1] - depth_m[0]) > LEAST_DIFFERENCE_M;
    let logs = if share > 0.0 { [logs[1], logs[0]] } else { logs };
    is_told.then_some(DepthScale {
        logs,
        share: share.abs(),
        standard_error,
        depth_m,
        n: overlaps.len(),
    })
}

/// Returns the share by which the depths of the second log are greater; `None` where the overlaps
/// do not separate it from the other unknowns.
fn fitted_share(overlaps: &[&LogOverlap]) -> Option<f64> {
    let mean_m =
        overlaps.iter().map(|overlap| overlap.depth_m).sum::<f64>() / overlaps.len() as f64;
    let row = |overlap: &LogOverlap| {
        [1.0, overlap.depth_m - mean_m, overlap.gradient[0], overlap.gradient[1]]
    };
    let mut weights = vec![1.0; overlaps.len()];
    let mut solution = Vec::new();
    for _ in 0..ROUNDS {
        let mut normal = Mat::<f64>::zeros(UNKNOWNS, UNKNOWNS);
        let mut right = [0.0; UNKNOWNS];
        for (overlap, weight) in overlaps.iter().zip(&weights) {
            let row = row(overlap);
            for (at, a) in row.iter().enumerate() {
                // Elevations differ the other way round than depths.
                right[at] -= weight * a * overlap.difference_m;
                for (other, b) in row.iter().enumerate() {
                    normal[(at, other)] += weight * a * b;
                }
            }
        }
        // A level bed does not determine a shift: this term counts as a slope of a millimetre a
        // metre.
        for at in 2..UNKNOWNS {
            normal[(at, at)] += 1e-6;
        }
        solution = solve_dense(&normal, &right)?;
        let left_m = overlaps.iter().map(|overlap| {
            let fitted_m: f64 = row(overlap).iter().zip(&solution).map(|(a, x)| a * x).sum();
            -overlap.difference_m - fitted_m
        });
        weights = robust_shares(&left_m.collect::<Vec<_>>()).0;
    }
    solution.get(1).copied()
}

/// Returns the standard error of the share, by leaving out the overlaps of the lines of one log
/// (`pass`) in turn; `None` where there are too few lines.
fn jackknife_error(overlaps: &[&LogOverlap], pass: usize, share: f64) -> Option<f64> {
    let mut lots: BTreeMap<i64, usize> = BTreeMap::new();
    let line = |index: usize| overlaps[index].lines.map_or(index as i64, |lines| lines[pass]);
    for index in 0..overlaps.len() {
        let next = lots.len() % MOST_LOTS;
        lots.entry(line(index)).or_insert(next);
    }
    let count = lots.len().min(MOST_LOTS);
    if count < LEAST_LOTS {
        return None;
    }
    let without = |lot: usize| {
        let rest = (0..overlaps.len()).filter(|&index| lots.get(&line(index)) != Some(&lot));
        fitted_share(&rest.map(|index| overlaps[index]).collect::<Vec<_>>())
    };
    let mut squares = 0.0;
    for lot in 0..count {
        squares += (without(lot)? - share).powi(2);
    }
    Some((squares * (count - 1) as f64 / count as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::height_offsets::OverlapKind;

    /// Crossings of five lines of one log and six of another between 2 and 9 m of water; depths of
    /// the second are greater by a share, and it lies higher and to the east.
    fn crossings(share: f64, shift_m: f64) -> Vec<LogOverlap> {
        let mut overlaps = Vec::new();
        for (index, line) in (0..30).map(|index| (index, [index % 5, 10 + index / 5])) {
            let depth_m = 2.0 + f64::from((index * 7) % 30) * 0.24;
            let gradient = [0.3 * (f64::from(index) * 1.7).sin(), 0.2 * f64::from(index).cos()];
            let noise_m = 0.02 * (f64::from(index) * 5.3).sin();
            let deeper_m = 0.1 + share * depth_m + shift_m * gradient[0] + noise_m;
            let slope = gradient[0].hypot(gradient[1]);
            overlaps.push(LogOverlap {
                gradient,
                depth_m,
                lines: Some(line.map(i64::from)),
                ..LogOverlap::new([0, 1], OverlapKind::Crossing, [0.0; 2], -deeper_m, slope)
            });
        }
        overlaps
    }

    #[test]
    fn a_share_is_found_beside_a_height_and_a_shift() {
        for (share, logs) in [(0.02, [1, 0]), (-0.02, [0, 1])] {
            let found = depth_scales(&crossings(share, 1.5));
            let [found] = found[..] else { panic!("{found:?}") };
            assert_eq!(found.logs, logs);
            assert!((found.share - 0.02).abs() < 3.0 * found.standard_error, "{found:?}");
            assert!(found.standard_error < 0.004, "{found:?}");
        }
    }

    #[test]
    fn heights_shifts_and_noise_are_no_share() {
        assert_eq!(depth_scales(&crossings(0.0, 0.0)), []);
        assert_eq!(depth_scales(&crossings(0.0, 2.0)), []);
        assert_eq!(depth_scales(&crossings(0.02, 0.0)[..9]), [], "too few");
    }
}
