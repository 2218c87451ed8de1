//! Robust weighted least squares over the graph of logs.

use super::cholesky::inverse;
use super::{Datum, HeightOffsets, LogOffset, Meeting, PairDifference};
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
    let groups = groups(count, &known);
    let mut logs: Vec<LogOffset> = (0..count)
        .map(|log| LogOffset {
            offset_m: 0.0,
            standard_error_m: f64::NAN,
            group: groups[log],
            meetings: known.iter().filter(|one| one.logs.contains(&log)).count(),
        })
        .collect();
    let mut pairs = Vec::new();
    for group in 0..groups.iter().max().map_or(0, |last| last + 1) {
        let members: Vec<usize> = (0..count).filter(|log| groups[*log] == group).collect();
        let inside: Vec<Meeting> = (known.iter())
            .filter(|one| groups[one.logs[0]] == group)
            .copied()
            .collect();
        let Some(solved) = Network::new(&members, &inside, datum).solve() else {
            continue;
        };
        for (index, &log) in members.iter().enumerate() {
            logs[log].offset_m = solved.heights_m[index];
            logs[log].standard_error_m = solved.errors_m[index];
        }
        pairs.extend(pair_differences(&inside, &logs));
    }
    pairs.sort_by_key(|pair: &PairDifference| pair.logs);
    HeightOffsets { logs, pairs }
}

/// The group of every log: those that meet, directly or through others, share one.
fn groups(count: usize, meetings: &[Meeting]) -> Vec<usize> {
    let mut label: Vec<usize> = (0..count).collect();
    let mut changed = true;
    while changed {
        changed = false;
        for meeting in meetings {
            let [a, b] = meeting.logs;
            let least = label[a].min(label[b]);
            changed |= label[a] != least || label[b] != least;
            (label[a], label[b]) = (least, least);
        }
    }
    let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
    for first in &label {
        let next = numbers.len();
        numbers.entry(*first).or_insert(next);
    }
    label.iter().map(|first| numbers[first]).collect()
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
        let sigma_m = |one: &Meeting| {
            let slope = if one.slope.is_nan() {
                USUAL_SLOPE
            } else {
                one.slope
            };
            DEPTH_SIGMA_M.hypot(slope * POSITION_SIGMA_M)
        };
        let fixed = match datum {
            Datum::Mean => None,
            Datum::Log(log) => members.contains(&log).then(|| place(log)),
        };
        Self {
            ends: meetings.iter().map(|one| one.logs.map(place)).collect(),
            sigmas_m: meetings.iter().map(sigma_m).collect(),
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
        let ones = vec![1.0; self.meetings.len()];
        let mut heights_m = self.weighted(&ones)?.0;
        let huber = |u: f64| (HUBER / u.abs()).min(1.0);
        let tukey = |u: f64| (1.0 - (u / TUKEY).powi(2)).max(0.0).powi(2);
        let mut shares = ones;
        for weight in [&huber as &dyn Fn(f64) -> f64, &tukey] {
            for _ in 0..ROUNDS {
                let next_shares = self.shares(&heights_m, weight);
                // Where Tukey's weights would cut a log off, Huber's stand.
                let Some((next_m, _)) = self.weighted(&next_shares) else {
                    break;
                };
                let moved = next_m.iter().zip(&heights_m).map(|(a, b)| (a - b).abs());
                let moved_m = moved.fold(0.0, f64::max);
                (heights_m, shares) = (next_m, next_shares);
                if moved_m < SETTLED_M {
                    break;
                }
            }
        }
        let (_, covariance) = self.weighted(&shares)?;
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
        Some(Solved {
            errors_m: covariance
                .iter()
                .map(|own| (variance * own).sqrt())
                .collect(),
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

    /// Robust weight of every meeting.
    fn shares(&self, heights_m: &[f64], weight: &dyn Fn(f64) -> f64) -> Vec<f64> {
        let residuals = self.residuals(heights_m);
        let mut sizes: Vec<f64> = residuals.iter().map(|u| u.abs()).collect();
        let scale = (SIGMA_PER_MAD * median(&mut sizes)).max(LEAST_SCALE);
        residuals.iter().map(|u| weight(u / scale)).collect()
    }

    /// Heights by least squares with some weights, and their variances before they are scaled by that of the residuals; `None` where
    /// the weights leave a log alone.
    fn weighted(&self, shares: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let n = self.size;
        // The first height is taken for zero, and the datum put in afterwards.
        let mut normal = vec![vec![0.0; n - 1]; n - 1];
        let mut right = vec![0.0; n - 1];
        let all = self.meetings.iter().zip(&self.ends).zip(&self.sigmas_m);
        for (((one, &[a, b]), sigma_m), share) in all.zip(shares) {
            let weight = share / (sigma_m * sigma_m);
            for (end, sign) in [(a, 1.0), (b, -1.0)] {
                if end > 0 {
                    normal[end - 1][end - 1] += weight;
                    right[end - 1] += sign * weight * one.difference_m;
                }
            }
            if a > 0 && b > 0 {
                normal[a - 1][b - 1] -= weight;
                normal[b - 1][a - 1] -= weight;
            }
        }
        let covariance = inverse(&normal)?;
        let of_first = |row: usize, column: usize| match (row, column) {
            (0, _) | (_, 0) => 0.0,
            (row, column) => covariance[row - 1][column - 1],
        };
        let height = |row: usize| -> f64 {
            (1..n)
                .map(|column| of_first(row, column) * right[column - 1])
                .sum()
        };
        let heights_m: Vec<f64> = (0..n).map(height).collect();
        let (datum_m, variances) = match self.fixed {
            Some(fixed) => {
                let variance = |row: usize| {
                    of_first(row, row) - 2.0 * of_first(row, fixed) + of_first(fixed, fixed)
                };
                (heights_m[fixed], (0..n).map(variance).collect())
            }
            None => {
                let mean_with: Vec<f64> = (0..n)
                    .map(|row| (0..n).map(|other| of_first(row, other)).sum::<f64>() / n as f64)
                    .collect();
                let mean_own = mean_with.iter().sum::<f64>() / n as f64;
                let variance = |row: usize| of_first(row, row) - 2.0 * mean_with[row] + mean_own;
                let mean_m = heights_m.iter().sum::<f64>() / n as f64;
                (mean_m, (0..n).map(variance).collect::<Vec<f64>>())
            }
        };
        let heights_m = heights_m.iter().map(|height_m| height_m - datum_m);
        let variances = variances.iter().map(|own| own.max(0.0));
        Some((heights_m.collect(), variances.collect()))
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
