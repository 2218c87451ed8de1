//! Solves for the heights of logs by robust weighted least squares over the graph of logs.

use super::{Datum, HeightOffsets, LogOffset, LogOverlap, PairDifference};
use crate::sparse::{Equations, Factor, Pattern};
use bathyscope_log::support::statistics::{
    MEDIAN_ERROR, SIGMA_PER_MAD, median, median_of, spread_about,
};
use std::collections::BTreeMap;

/// Standard deviation of a difference on level ground, and of the position of an overlap, metres:
/// they weigh overlaps against each other, so only their ratio matters. On slopes of more than 3
/// degrees, half a metre of position makes more difference than the noise of a sounding.
const DEPTH_SIGMA_M: f64 = 0.03;
const POSITION_SIGMA_M: f64 = 0.5;
/// Slope that is assumed where none is known.
const USUAL_SLOPE: f64 = 0.05;
/// Tuning of Huber's and of Tukey's weights, in standard deviations: 95 % as efficient as least
/// squares on normal noise.
const HUBER: f64 = 1.345;
const TUKEY: f64 = 4.685;
const ROUNDS: usize = 50;
/// Change of the offsets below which the iteration ends, metres.
const SETTLED_M: f64 = 1e-7;
/// Least scale of the residuals, as a share of what the weights assume: differences may agree to
/// the last digit.
const LEAST_SCALE: f64 = 1e-6;
/// Weight of the assumed variance, as a number of differences: it counts where few differences
/// check each other.
const ASSUMED_DIFFERENCES: f64 = 1.0;
/// Least robust weight of an overlap that connects two logs.
const LEAST_SHARE: f64 = 1e-9;
/// Largest standard error of an offset that is determined, metres, and as a share of the offset:
/// overlaps on false depths contradict each other by metres, and the few that then count determine
/// no offset.
const MOST_ERROR_M: f64 = 0.25;
const MOST_ERROR_SHARE: f64 = 1.0 / 3.0;

/// Returns the heights of `count` logs, computed from their overlaps.
///
/// The offsets `h` fulfil `h_first - h_second = difference` as well as they can: least squares
/// weighted by the noise that is expected from the slope of the bottom, first with Huber's weights
/// and then with Tukey's, so that an overlap over weed or on a lost bottom counts little or
/// nothing. Where the direction of the slope is known, the east and north shift of each log's
/// positions, assumed to be about half a metre, is solved for together with the height, so that the
/// standard errors include the effect of such a shift on a slope. The standard errors come from the
/// weighted residuals; where pairs of logs, or the single lines of logs, disagree as a whole by
/// more than their single overlaps scatter (a tide, positions that are off all along a line), they
/// are larger accordingly.
pub fn adjust(count: usize, log_overlaps: &[LogOverlap], datum: Datum) -> HeightOffsets {
    let known: Vec<LogOverlap> = log_overlaps
        .iter()
        .filter(|overlap| {
            overlap.difference_m.is_finite()
                && overlap.logs[0] != overlap.logs[1]
                && overlap.logs[1] < count
        })
        .copied()
        .collect();
    let groups = groups(count, known.iter().map(|overlap| overlap.logs));
    let mut logs: Vec<LogOffset> = (groups.iter())
        .map(|group| LogOffset {
            offset_m: 0.0,
            standard_error_m: f64::NAN,
            group: *group,
            log_overlaps: 0,
        })
        .collect();
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups.iter().max().map_or(0, |l| l + 1)];
    let mut inside: Vec<Vec<LogOverlap>> = vec![Vec::new(); members.len()];
    for (log, group) in groups.iter().enumerate() {
        members[*group].push(log);
    }
    for overlap in &known {
        inside[groups[overlap.logs[0]]].push(*overlap);
        for log in overlap.logs {
            logs[log].log_overlaps += 1;
        }
    }
    let mut pairs = Vec::new();
    for (members, inside) in members.iter().zip(&inside) {
        let Some(solved) = LogNetwork::new(members, inside, datum).solve() else {
            continue;
        };
        for (&log, [height_m, error_m]) in members.iter().zip(solved) {
            if error_m <= MOST_ERROR_M.max(MOST_ERROR_SHARE * height_m.abs()) {
                logs[log].offset_m = height_m;
                logs[log].standard_error_m = error_m;
            }
        }
        pairs.extend(pair_differences(inside, &logs));
    }
    pairs.sort_by_key(|pair: &PairDifference| pair.logs);
    HeightOffsets { logs, pairs, scales: Vec::new() }
}

/// Returns the standard deviation of the difference between two depths at one place, metres, for a
/// slope of the bottom.
pub(crate) fn difference_sigma_m(slope: f64) -> f64 {
    let slope = if slope.is_nan() { USUAL_SLOPE } else { slope };
    DEPTH_SIGMA_M.hypot(slope * POSITION_SIGMA_M)
}

/// Returns Huber's weights of some residuals, and the robust standard deviation of the residuals.
pub(crate) fn robust_shares(residuals: &[f64]) -> (Vec<f64>, f64) {
    weighted_shares(residuals, &huber)
}

fn huber(u: f64) -> f64 {
    (HUBER / u.abs()).min(1.0)
}

fn weighted_shares(residuals: &[f64], weight: &dyn Fn(f64) -> f64) -> (Vec<f64>, f64) {
    let usual = median_of(residuals.iter().map(|u| u.abs()));
    let scale = (SIGMA_PER_MAD * usual).max(LEAST_SCALE);
    let shares = residuals.iter().map(|u| weight(u / scale)).collect();
    (shares, scale)
}

/// Returns the group of every log: logs that cross or overlap, directly or through others, share a
/// group. Groups are numbered in the order of their first logs.
pub(crate) fn groups(count: usize, log_overlaps: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    // Each log points to a log before it, or to itself if it is the first of its group.
    let mut first: Vec<usize> = (0..count).collect();
    fn first_of(first: &mut [usize], mut log: usize) -> usize {
        while first[log] != log {
            first[log] = first[first[log]];
            log = first[log];
        }
        log
    }
    for logs in log_overlaps {
        let [a, b] = logs.map(|log| first_of(&mut first, log));
        first[a.max(b)] = a.min(b);
    }
    let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
    let number = |log: usize| {
        let next = numbers.len();
        *numbers.entry(first_of(&mut first, log)).or_insert(next)
    };
    (0..count).map(number).collect()
}

/// Connected logs and their overlaps.
struct LogNetwork<'a> {
    log_overlaps: &'a [LogOverlap],
    /// The two logs of each overlap, as indices in the group.
    ends: Vec<[usize; 2]>,
    /// Expected standard deviation of each difference, metres.
    sigmas_m: Vec<f64>,
    size: usize,
    /// True if the shifts of positions are unknowns, too: east and north of each log, after the
    /// heights.
    has_shifts: bool,
    /// Index of the member whose offset is zero; `None` if the mean of the offsets is zero.
    fixed: Option<usize>,
}

/// Solution for given weights of the overlaps.
struct Weighted {
    heights_m: Vec<f64>,
    /// Shift of each log to the east and north, metres; empty where no slope has a direction.
    shifts_m: Vec<f64>,
    shares: Vec<f64>,
    scale: f64,
    factor: Factor,
}

impl<'a> LogNetwork<'a> {
    fn new(members: &[usize], log_overlaps: &'a [LogOverlap], datum: Datum) -> Self {
        let place = |log: usize| members.partition_point(|member| *member < log);
        let fixed = match datum {
            Datum::Mean => None,
            Datum::Log(log) => members.contains(&log).then(|| place(log)),
        };
        Self {
            ends: log_overlaps.iter().map(|overlap| overlap.logs.map(place)).collect(),
            sigmas_m: log_overlaps
                .iter()
                .map(|overlap| difference_sigma_m(overlap.slope))
                .collect(),
            has_shifts: log_overlaps.iter().any(LogOverlap::has_gradient),
            log_overlaps,
            size: members.len(),
            fixed,
        }
    }

    /// Returns the height of each log and its standard error, metres; `None` for a log alone, or
    /// where the equations have no solution.
    fn solve(&self) -> Option<Vec<[f64; 2]>> {
        if self.size < 2 {
            return None;
        }
        let mut equations = self.equations();
        let pattern = Pattern::of(&equations, self.unknowns())?;
        let ones = vec![1.0; self.log_overlaps.len()];
        let mut at = self.weighted(&pattern, &mut equations, ones, 1.0)?;
        let tukey = |u: f64| (1.0 - (u / TUKEY).powi(2)).max(0.0).powi(2);
        for weight in [&huber as &dyn Fn(f64) -> f64, &tukey] {
            for _ in 0..ROUNDS {
                let (shares, scale) = weighted_shares(&self.residuals(&at), weight);
                // Where the weights would disconnect a log, the last solution is kept.
                let Some(next) = self.weighted(&pattern, &mut equations, shares, scale) else {
                    break;
                };
                let moved = next.heights_m.iter().zip(&at.heights_m);
                let moved_m = moved.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                at = next;
                if moved_m < SETTLED_M {
                    break;
                }
            }
        }
        let of_unknowns = at.factor.variances(self.unknowns());
        let own = self.variances(&at.factor, &of_unknowns).into_iter();
        let variance = self.variance(&at, &of_unknowns);
        let heights_m = at.heights_m.into_iter().zip(own);
        Some(heights_m.map(|(height_m, own)| [height_m, (variance * own).sqrt()]).collect())
    }

    /// Returns the number of unknowns: the heights of all logs but the first, and the shifts, if
    /// any.
    fn unknowns(&self) -> usize {
        self.size - 1 + if self.has_shifts { 2 * self.size } else { 0 }
    }

    /// Returns the index of a log's shift to the east among the unknowns; its shift to the north
    /// follows.
    fn shift(&self, log: usize) -> usize {
        self.size - 1 + 2 * log
    }

    /// Returns the variance of a residual, in units of its expected variance.
    fn variance(&self, at: &Weighted, of_unknowns: &[f64]) -> f64 {
        let residuals = self.residuals(at);
        let squares: f64 = residuals.iter().zip(&at.shares).map(|(u, w)| w * u * u).sum();
        // A shift takes away a degree of freedom as far as the overlaps determine it better than
        // assumed.
        let assumed = (POSITION_SIGMA_M / at.scale).powi(2);
        let shifts = &of_unknowns[self.size - 1..];
        let shifts: f64 = shifts.iter().map(|own| (1.0 - own / assumed).max(0.0)).sum();
        let parameters = (self.size - 1) as f64 + shifts;
        let freedom = (at.shares.iter().sum::<f64>() - parameters).max(0.0);
        // Where no difference checks another, the assumed variance counts.
        let single = (squares + ASSUMED_DIFFERENCES) / (freedom + ASSUMED_DIFFERENCES);
        let of_pairs = self.variance_of_pairs(&residuals, &at.shares);
        let of_lines = self.variance_of_lines(&residuals, &at.shares, parameters, single);
        single.max(of_pairs).max(of_lines)
    }

    /// Returns what the heights and the shifts leave of each difference, in standard deviations.
    fn residuals(&self, at: &Weighted) -> Vec<f64> {
        let all = self.log_overlaps.iter().zip(&self.ends).zip(&self.sigmas_m);
        all.map(|((overlap, [a, b]), sigma_m)| {
            let mut left_m = overlap.difference_m - (at.heights_m[*a] - at.heights_m[*b]);
            if overlap.has_gradient() {
                let apart_m =
                    [0, 1].map(|axis| at.shifts_m[2 * a + axis] - at.shifts_m[2 * b + axis]);
                left_m -= overlap.gradient[0] * apart_m[0] + overlap.gradient[1] * apart_m[1];
            }
            left_m / sigma_m
        })
        .collect()
    }

    /// Returns the variance of a single residual by the mean residuals of the lines, as
    /// [`Self::variance_of_pairs`] does for pairs. A line has the weight of its overlaps, which is
    /// its weight in a height. Each overlap lies on a line of either log, so that the excess of the
    /// lines counts twice. 0 where too few lines cross.
    fn variance_of_lines(
        &self,
        residuals: &[f64],
        shares: &[f64],
        parameters: f64,
        single: f64,
    ) -> f64 {
        let mut lines: BTreeMap<(usize, i64), [f64; 2]> = BTreeMap::new();
        let all = self.log_overlaps.iter().zip(&self.ends).zip(&self.sigmas_m);
        for (((overlap, ends), sigma_m), (u, share)) in all.zip(residuals.iter().zip(shares)) {
            let weight = share / (sigma_m * sigma_m);
            for (end, line) in overlap.lines.into_iter().flatten().enumerate() {
                // The residual is that of the first log less that of the second log.
                let sign = if end == 0 { 1.0 } else { -1.0 };
                let [sum, weights] = lines.entry((ends[end], line)).or_default();
                (*sum, *weights) = (*sum + sign * weight * u * sigma_m, *weights + weight);
            }
        }
        let total = |of: fn(&[f64; 2]) -> f64| lines.values().map(of).sum::<f64>();
        let weights = total(|[_, weight]| *weight);
        // Effective number of lines: the number of lines of equal weight that would count the same.
        let count = weights * weights / total(|[_, weight]| weight * weight);
        let freedom = count - parameters - 1.0;
        // NaN without any line.
        if freedom.is_nan() || freedom < 0.5 {
            return 0.0;
        }
        let squares = count * total(|[sum, _]| sum * sum) / weights;
        let assumed = ASSUMED_DIFFERENCES * single;
        2.0 * (squares + assumed) / (freedom + ASSUMED_DIFFERENCES) - single
    }

    /// Returns the variance of a single residual by the mean residuals of the pairs of logs: larger
    /// than the variance by single residuals where a pair disagrees with others as a whole. 0 where
    /// the pairs do not check each other.
    fn variance_of_pairs(&self, residuals: &[f64], shares: &[f64]) -> f64 {
        let mut pairs: BTreeMap<[usize; 2], [f64; 2]> = BTreeMap::new();
        let all = self.ends.iter().zip(&self.sigmas_m);
        for ((ends, sigma_m), (u, share)) in all.zip(residuals.iter().zip(shares)) {
            let weight = share / (sigma_m * sigma_m);
            let [sum, weights] = pairs.entry(*ends).or_default();
            (*sum, *weights) = (*sum + weight * u * sigma_m, *weights + weight);
        }
        let observed = pairs.values().filter(|[_, weights]| *weights > 0.0);
        let squares: f64 = observed.map(|[sum, weights]| sum * sum / weights).sum();
        if pairs.len() < self.size { 0.0 } else { squares / (pairs.len() + 1 - self.size) as f64 }
    }

    /// Returns the equations of the overlaps for the heights of all logs but the first, which is
    /// set to zero, and for the shifts; after them, the assumptions about the shifts.
    fn equations(&self) -> Equations {
        let mut equations = Equations::default();
        let all = self.log_overlaps.iter().zip(&self.ends).zip(&self.sigmas_m);
        for ((overlap, ends), sigma_m) in all {
            let mut terms = Vec::with_capacity(6);
            for (log, sign) in ends.iter().zip([1.0, -1.0]) {
                terms.extend(log.checked_sub(1).map(|height| (height, sign)));
                if overlap.has_gradient() {
                    let of_axis = |axis| (self.shift(*log) + axis, sign * overlap.gradient[axis]);
                    terms.extend([0, 1].map(of_axis));
                }
            }
            equations.add(terms, overlap.difference_m, *sigma_m);
        }
        for shift in self.size - 1..self.unknowns() {
            equations.add([(shift, 1.0)], 0.0, POSITION_SIGMA_M);
        }
        equations
    }

    /// Returns the least-squares solution for some weights of the overlaps, with heights from the
    /// datum, and the factor of its matrix; `None` where the weights cut the logs into several
    /// groups. `scale` is that of the residuals, by which the assumptions about shifts are weighed
    /// against them.
    fn weighted(
        &self,
        pattern: &Pattern,
        equations: &mut Equations,
        shares: Vec<f64>,
        scale: f64,
    ) -> Option<Weighted> {
        let ties = self.ends.iter().zip(&shares);
        let ties = ties.filter_map(|(ends, share)| (*share > LEAST_SHARE).then_some(*ends));
        if groups(self.size, ties).iter().any(|group| *group > 0) {
            return None;
        }
        for (log_overlap, (share, sigma_m)) in shares.iter().zip(&self.sigmas_m).enumerate() {
            equations.set_sd(log_overlap, sigma_m / share.sqrt());
        }
        for assumed in self.log_overlaps.len()..equations.len() {
            equations.set_sd(assumed, POSITION_SIGMA_M / scale);
        }
        let factor = pattern.factorise(equations)?;
        let mut found = factor.solve(pattern, equations, 0, || 0.0).swap_remove(0);
        let shifts_m = found.split_off(self.size - 1);
        let mut heights_m = vec![0.0];
        heights_m.append(&mut found);
        let datum_m = match self.fixed {
            Some(fixed) => heights_m[fixed],
            None => heights_m.iter().sum::<f64>() / self.size as f64,
        };
        heights_m.iter_mut().for_each(|height_m| *height_m -= datum_m);
        let is_known = heights_m.iter().all(|height_m| height_m.is_finite());
        is_known.then_some(Weighted { heights_m, shifts_m, shares, scale, factor })
    }

    /// Returns the variances of the heights from the datum, before they are scaled by the variance
    /// of the residuals: with the covariance `C` against the first log and the weights `w` of the
    /// logs in the datum, `C_ii - 2 (C w)_i + w C w`.
    fn variances(&self, factor: &Factor, of_unknowns: &[f64]) -> Vec<f64> {
        let weight = |log: usize| match self.fixed {
            Some(fixed) => f64::from(u8::from(log == fixed)),
            None => 1.0 / self.size as f64,
        };
        let of_others = |values: &[f64]| -> Vec<f64> {
            let others = values[..self.size - 1].iter().copied();
            [0.0].into_iter().chain(others).collect()
        };
        let mut with_datum = vec![0.0; self.unknowns()];
        for (log, entry) in (1..self.size).zip(&mut with_datum) {
            *entry = weight(log);
        }
        let mut with_datum = [with_datum];
        factor.solve_for(&mut with_datum);
        let with_datum = of_others(&with_datum[0]);
        let datum: f64 = (0..self.size).map(|log| weight(log) * with_datum[log]).sum();
        let own = of_others(of_unknowns).into_iter().zip(&with_datum);
        own.map(|(own, with)| (own - 2.0 * with + datum).max(0.0)).collect()
    }
}

/// Returns the difference of each pair of logs by its overlaps, and what the offsets leave of it.
fn pair_differences(log_overlaps: &[LogOverlap], logs: &[LogOffset]) -> Vec<PairDifference> {
    let mut by_pair: BTreeMap<[usize; 2], Vec<&LogOverlap>> = BTreeMap::new();
    for log_overlap in log_overlaps {
        by_pair.entry(log_overlap.logs).or_default().push(log_overlap);
    }
    by_pair
        .into_iter()
        .map(|([a, b], found)| {
            let mut differences: Vec<f64> =
                found.iter().map(|overlap| overlap.difference_m).collect();
            let difference_m = median(&mut differences);
            let spread_m = match differences.len() {
                1 => f64::NAN,
                _ => spread_about(&mut differences, difference_m),
            };
            let n = found.len();
            let sigmas_m = found.iter().map(|overlap| difference_sigma_m(overlap.slope));
            let sigma_m = median_of(sigmas_m);
            // Few differences may agree by chance, so that the expected error counts, too.
            let sigma_m = spread_m.max(sigma_m / (n as f64).sqrt());
            PairDifference {
                logs: [a, b],
                kind: found[0].kind,
                n,
                difference_m,
                spread_m,
                standard_error_m: MEDIAN_ERROR * sigma_m / (n as f64).sqrt(),
                residual_m: difference_m - (logs[a].offset_m - logs[b].offset_m),
            }
        })
        .collect()
}
