//! Robust weighted least squares over the graph of logs.

use super::{Datum, HeightOffsets, LogOffset, Meeting, PairDifference};
use crate::sparse::{Equations, Factor, Pattern};
use crate::statistics::{SIGMA_PER_MAD, median, spread_about};
use std::collections::BTreeMap;

/// Standard deviation of a difference on level ground, metres, and of the place of a meeting: they weigh meetings against each
/// other, so only their ratio matters. What a slope makes of half a metre is more than the noise of a sounding beyond 3 degrees.
const DEPTH_SIGMA_M: f64 = 0.03;
const POSITION_SIGMA_M: f64 = 0.5;
/// Slope that is assumed where none is known.
const USUAL_SLOPE: f64 = 0.05;
/// Tuning of Huber's and of Tukey's weights, in standard deviations: 95 % as efficient as least squares on normal noise.
const HUBER: f64 = 1.345;
const TUKEY: f64 = 4.685;
const ROUNDS: usize = 50;
/// Offsets that change by less than this are found, metres.
const SETTLED_M: f64 = 1e-7;
/// The scale of the residuals is at least this share of what the weights assume: differences may agree to the last digit.
const LEAST_SCALE: f64 = 1e-6;
/// A robust weight below this ties nothing.
const LEAST_SHARE: f64 = 1e-9;
/// Standard error of a median over that of a mean.
const MEDIAN_SHARE: f64 = 1.2533;

/// Heights of `count` logs from their meetings.
///
/// The offsets `h` fulfil `h_first - h_second = difference` as well as they can: least squares weighted by the noise that the slope
/// of the bottom lets expect, first with Huber's weights and from there with Tukey's, so that a meeting over weed or on a lost bottom
/// counts little or nothing. Standard errors are those of the weighted residuals; where pairs of logs disagree as a whole by more than
/// their single meetings scatter (a shifted position, a tide), they are larger by that much.
pub fn adjust(count: usize, meetings: &[Meeting], datum: Datum) -> HeightOffsets {
    let known: Vec<Meeting> = meetings
        .iter()
        .filter(|one| {
            one.difference_m.is_finite() && one.logs[0] != one.logs[1] && one.logs[1] < count
        })
        .copied()
        .collect();
    let groups = groups(count, known.iter().map(|one| one.logs));
    let mut logs: Vec<LogOffset> = (groups.iter())
        .map(|group| LogOffset {
            offset_m: 0.0,
            standard_error_m: f64::NAN,
            group: *group,
            meetings: 0,
        })
        .collect();
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups.iter().max().map_or(0, |l| l + 1)];
    let mut inside: Vec<Vec<Meeting>> = vec![Vec::new(); members.len()];
    for (log, group) in groups.iter().enumerate() {
        members[*group].push(log);
    }
    for one in &known {
        inside[groups[one.logs[0]]].push(*one);
        for log in one.logs {
            logs[log].meetings += 1;
        }
    }
    let mut pairs = Vec::new();
    for (members, inside) in members.iter().zip(&inside) {
        let Some(solved) = Network::new(members, inside, datum).solve() else {
            continue;
        };
        for (index, &log) in members.iter().enumerate() {
            logs[log].offset_m = solved.heights_m[index];
            logs[log].standard_error_m = solved.errors_m[index];
        }
        pairs.extend(pair_differences(inside, &logs));
    }
    pairs.sort_by_key(|pair: &PairDifference| pair.logs);
    HeightOffsets { logs, pairs }
}

/// Standard deviation of the difference between two depths at one place, metres, where the bottom has some slope.
pub fn difference_sigma_m(slope: f64) -> f64 {
    let slope = if slope.is_nan() { USUAL_SLOPE } else { slope };
    DEPTH_SIGMA_M.hypot(slope * POSITION_SIGMA_M)
}

/// Huber's weights of some residuals, and their robust standard deviation.
pub fn robust_shares(residuals: &[f64]) -> (Vec<f64>, f64) {
    weighted_shares(residuals, &huber)
}

fn huber(u: f64) -> f64 {
    (HUBER / u.abs()).min(1.0)
}

fn weighted_shares(residuals: &[f64], weight: &dyn Fn(f64) -> f64) -> (Vec<f64>, f64) {
    let mut sizes: Vec<f64> = residuals.iter().map(|u| u.abs()).collect();
    let scale = (SIGMA_PER_MAD * median(&mut sizes)).max(LEAST_SCALE);
    let shares = residuals.iter().map(|u| weight(u / scale)).collect();
    (shares, scale)
}

/// The group of every log, numbered in the order of their first logs: those that meet, directly or through others, share one.
pub fn groups(count: usize, meetings: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    // Each log leads to one before it, or to itself where it is the first of its group.
    let mut first: Vec<usize> = (0..count).collect();
    fn first_of(first: &mut [usize], mut log: usize) -> usize {
        while first[log] != log {
            first[log] = first[first[log]];
            log = first[log];
        }
        log
    }
    for logs in meetings {
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

/// Connected logs and their meetings.
struct Network<'a> {
    meetings: &'a [Meeting],
    /// The two logs of each meeting as places in the group.
    ends: Vec<[usize; 2]>,
    /// Standard deviation that each difference is expected to have.
    sigmas_m: Vec<f64>,
    size: usize,
    /// The member whose offset is zero; without one their mean is.
    fixed: Option<usize>,
}

struct Solved {
    heights_m: Vec<f64>,
    errors_m: Vec<f64>,
}

impl<'a> Network<'a> {
    fn new(members: &[usize], meetings: &'a [Meeting], datum: Datum) -> Self {
        let place = |log: usize| members.partition_point(|member| *member < log);
        let fixed = match datum {
            Datum::Mean => None,
            Datum::Log(log) => members.contains(&log).then(|| place(log)),
        };
        Self {
            ends: meetings.iter().map(|one| one.logs.map(place)).collect(),
            sigmas_m: meetings
                .iter()
                .map(|one| difference_sigma_m(one.slope))
                .collect(),
            meetings,
            size: members.len(),
            fixed,
        }
    }

    /// `None` for a log alone.
    fn solve(&self) -> Option<Solved> {
        if self.size < 2 {
            return None;
        }
        let mut equations = self.equations();
        let pattern = Pattern::of(&equations, self.size - 1)?;
        let ones = vec![1.0; self.meetings.len()];
        let (mut heights_m, mut factor) = self.weighted(&pattern, &mut equations, &ones)?;
        let tukey = |u: f64| (1.0 - (u / TUKEY).powi(2)).max(0.0).powi(2);
        let mut shares = ones;
        for weight in [&huber as &dyn Fn(f64) -> f64, &tukey] {
            for _ in 0..ROUNDS {
                let (next_shares, _) = weighted_shares(&self.residuals(&heights_m), weight);
                // Where Tukey's weights would cut a log off, Huber's stand.
                let next = self.weighted(&pattern, &mut equations, &next_shares);
                let Some((next_m, next_factor)) = next else {
                    break;
                };
                let moved = next_m.iter().zip(&heights_m).map(|(a, b)| (a - b).abs());
                let moved_m = moved.fold(0.0, f64::max);
                (heights_m, shares, factor) = (next_m, next_shares, next_factor);
                if moved_m < SETTLED_M {
                    break;
                }
            }
        }
        let residuals = self.residuals(&heights_m);
        let squares: f64 = residuals.iter().zip(&shares).map(|(u, w)| w * u * u).sum();
        let freedom = shares.iter().sum::<f64>() - (self.size - 1) as f64;
        // A tree of single differences checks nothing: what was assumed of them counts then.
        let variance = if freedom > 0.5 {
            squares / freedom
        } else {
            1.0
        };
        let variance = variance.max(self.variance_of_pairs(&residuals, &shares));
        let own = self.variances(&factor).into_iter();
        Some(Solved {
            errors_m: own.map(|own| (variance * own).sqrt()).collect(),
            heights_m,
        })
    }

    /// Differences less what the heights make of them, in standard deviations.
    fn residuals(&self, heights_m: &[f64]) -> Vec<f64> {
        let all = self.meetings.iter().zip(&self.ends).zip(&self.sigmas_m);
        all.map(|((one, [a, b]), sigma_m)| {
            (one.difference_m - (heights_m[*a] - heights_m[*b])) / sigma_m
        })
        .collect()
    }

    /// What the mean residuals of the pairs of logs say of the variance of a single one: larger than that of the single ones where
    /// a pair disagrees with others as a whole. 0 where the pairs do not check each other.
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
        match pairs.len() >= self.size {
            false => 0.0,
            true => squares / (pairs.len() + 1 - self.size) as f64,
        }
    }

    /// What the meetings say of the heights of all logs but the first, which is taken for zero.
    fn equations(&self) -> Equations {
        let mut equations = Equations::default();
        let all = self.meetings.iter().zip(&self.ends).zip(&self.sigmas_m);
        for ((one, [a, b]), sigma_m) in all {
            let ends = [(*a, 1.0), (*b, -1.0)].into_iter();
            let terms = ends.filter_map(|(log, sign)| Some((log.checked_sub(1)?, sign)));
            equations.add(terms, one.difference_m, *sigma_m);
        }
        equations
    }

    /// Heights by least squares with some weights, from the datum, and the matrix that they come from; `None` where the weights cut the logs
    /// into several groups.
    fn weighted(
        &self,
        pattern: &Pattern,
        equations: &mut Equations,
        shares: &[f64],
    ) -> Option<(Vec<f64>, Factor)> {
        let ties = self.ends.iter().zip(shares);
        let ties = ties.filter_map(|(ends, share)| (*share > LEAST_SHARE).then_some(*ends));
        if groups(self.size, ties).iter().any(|group| *group > 0) {
            return None;
        }
        for (meeting, (share, sigma_m)) in shares.iter().zip(&self.sigmas_m).enumerate() {
            equations.set_sd(meeting, sigma_m / share.sqrt());
        }
        let factor = pattern.factorise(equations)?;
        let mut heights_m = vec![0.0];
        heights_m.append(&mut factor.solve(pattern, equations, 0, || 0.0).swap_remove(0));
        let datum_m = match self.fixed {
            Some(fixed) => heights_m[fixed],
            None => heights_m.iter().sum::<f64>() / self.size as f64,
        };
        heights_m
            .iter_mut()
            .for_each(|height_m| *height_m -= datum_m);
        let is_known = heights_m.iter().all(|height_m| height_m.is_finite());
        is_known.then_some((heights_m, factor))
    }

    /// Variances of the heights from the datum, before they are scaled by that of the residuals: with the covariance `C` against the first log
    /// and weights `w` that make the datum, `C_ii - 2 (C w)_i + w C w`.
    fn variances(&self, factor: &Factor) -> Vec<f64> {
        let weight = |log: usize| match self.fixed {
            Some(fixed) => f64::from(u8::from(log == fixed)),
            None => 1.0 / self.size as f64,
        };
        let of_others = |values: Vec<f64>| [0.0].into_iter().chain(values);
        let mut with_datum = [(1..self.size).map(weight).collect()];
        factor.solve_for(&mut with_datum);
        let [with_datum] = with_datum;
        let with_datum: Vec<f64> = of_others(with_datum).collect();
        let datum: f64 = (0..self.size)
            .map(|log| weight(log) * with_datum[log])
            .sum();
        let own = of_others(factor.variances(self.size - 1)).zip(&with_datum);
        own.map(|(own, with)| (own - 2.0 * with + datum).max(0.0))
            .collect()
    }
}

/// What the meetings of each pair say, and what the offsets leave of it.
fn pair_differences(meetings: &[Meeting], logs: &[LogOffset]) -> Vec<PairDifference> {
    let mut by_pair: BTreeMap<[usize; 2], Vec<&Meeting>> = BTreeMap::new();
    for meeting in meetings {
        by_pair.entry(meeting.logs).or_default().push(meeting);
    }
    by_pair
        .into_iter()
        .map(|([a, b], met)| {
            let mut differences: Vec<f64> = met.iter().map(|one| one.difference_m).collect();
            let difference_m = median(&mut differences);
            let spread_m = match differences.len() {
                1 => f64::NAN,
                _ => spread_about(&mut differences, difference_m),
            };
            let n = met.len();
            // Few differences may agree by chance.
            let sigma_m = spread_m.max(DEPTH_SIGMA_M / (n as f64).sqrt());
            PairDifference {
                logs: [a, b],
                kind: met[0].kind,
                n,
                difference_m,
                spread_m,
                standard_error_m: MEDIAN_SHARE * sigma_m / (n as f64).sqrt(),
                residual_m: difference_m - (logs[a].offset_m - logs[b].offset_m),
            }
        })
        .collect()
}
