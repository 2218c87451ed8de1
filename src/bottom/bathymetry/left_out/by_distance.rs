//! Computes the error of a depth from the distance to the nearest sounding, and finds where
//! left-out soundings are missed by more than usual at the same distance, and where by less.

use super::LeftOutMiss;
use bathyscope_log::support::statistics::{sigma_of_sizes, sorted};
use std::collections::HashMap;

/// Number of bins by distance for the misses of large squares; those of small squares are one bin.
const BINS: usize = 8;

/// Standard deviation of a depth's error by the distance to the nearest sounding.
#[derive(Clone, Debug, PartialEq)]
pub struct SigmaByDistance {
    /// Pairs of distance and standard deviation, metres, both rising.
    steps: Vec<[f64; 2]>,
}

impl SigmaByDistance {
    /// Computes the standard deviations from left-out soundings, `near` ones of small squares and
    /// `far` ones of large squares. A miss contains the error of the prediction and that of the
    /// left-out sounding. The neighbours predict a sounding about as well as it was measured, so
    /// that half of the square of the least miss is the noise of a depth.
    pub(super) fn of(near: &[LeftOutMiss], far: &[LeftOutMiss]) -> Self {
        // Small squares are predicted along the lines, whatever their distance: across the lines
        // the error grows from there on.
        let along = bins(near, 1).into_iter().map(|[_, miss_m]| [0.0, miss_m]);
        let mut steps: Vec<[f64; 2]> = along.chain(bins(far, BINS)).collect();
        steps.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut steps = rising(steps);
        let noise = 0.5 * steps.first().map_or(0.0, |[_, miss_m]| miss_m * miss_m);
        for [_, sigma_m] in &mut steps {
            *sigma_m = (*sigma_m * *sigma_m - noise).sqrt();
        }
        Self { steps }
    }

    /// Returns the larger of two standard deviations at every distance that either was measured at.
    pub(super) fn larger(&self, other: &Self) -> Self {
        let both = [self, other];
        let steps = both.iter().flat_map(|sigma| &sigma.steps);
        let mut distances_m = sorted(steps.map(|[distance_m, _]| *distance_m));
        distances_m.dedup();
        // Neither grows beyond the last distance that it was measured at.
        let measured = |sigma: &Self, distance_m: f64| {
            let last_m = sigma.steps.last().map_or(0.0, |[last_m, _]| *last_m);
            sigma.at(distance_m.min(last_m))
        };
        let at = |distance_m: f64| {
            let sigmas = both.map(|sigma| measured(sigma, distance_m));
            [distance_m, sigmas[0].max(sigmas[1])]
        };
        Self { steps: distances_m.into_iter().map(at).collect() }
    }

    /// Returns the standard deviation at a distance from the nearest sounding, metres; beyond the
    /// distances of all left-out soundings it grows as between the last two. Its square grows with
    /// the square of the distance, as where a slope is not known.
    pub fn at(&self, away_m: f64) -> f64 {
        let after = self.steps.partition_point(|[distance_m, _]| *distance_m <= away_m);
        let pair = match (after, self.steps.len()) {
            (0, _) | (_, 1) => return self.steps.first().map_or(f64::NAN, |[_, sigma_m]| *sigma_m),
            (after, count) => after.min(count - 1),
        };
        let ([from_m, low_m], [to_m, high_m]) = (self.steps[pair - 1], self.steps[pair]);
        let square = |value: f64| value * value;
        let share = (square(away_m) - square(from_m))
            / (square(to_m) - square(from_m)).max(f64::MIN_POSITIVE);
        (square(low_m) + (square(high_m) - square(low_m)) * share).sqrt()
    }
}

/// Returns the middle distance and the spread of the misses, in `count` bins of equal counts.
fn bins(misses: &[LeftOutMiss], count: usize) -> Vec<[f64; 2]> {
    let mut misses = misses.to_vec();
    misses.sort_by(|a, b| a.away_m.total_cmp(&b.away_m));
    let bins = misses.chunks(misses.len().div_ceil(count).max(1));
    let bins = bins.map(|bin| {
        let sizes = sorted(bin.iter().map(|miss| miss.error_m.abs()));
        [bin[bin.len() / 2].away_m, sigma_of_sizes(&sizes)]
    });
    bins.collect()
}

/// Makes the second numbers rise by replacing neighbours that do not rise by their mean (pool
/// adjacent violators).
fn rising(steps: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for [_, value] in &steps {
        pools.push((*value, 1));
        while let [.., (before, many), (last, more)] = pools[..]
            && before > last
        {
            let mean = (before * many as f64 + last * more as f64) / (many + more) as f64;
            pools.truncate(pools.len() - 2);
            pools.push((mean, many + more));
        }
    }
    let values = pools.into_iter().flat_map(|(value, count)| std::iter::repeat_n(value, count));
    let places = steps.iter().map(|[place, _]| *place);
    let mut made: Vec<[f64; 2]> = places.zip(values).map(|(place, value)| [place, value]).collect();
    made.dedup_by_key(|[place, _]| *place);
    made
}

/// Largest square of a single miss, as a multiple of its usual square: a larger miss is one wrong
/// depth, not a rough bottom.
const MOST_SQUARE: f64 = 9.0;
/// Weight of the usual roughness, in squares: it makes a few misses count little.
const USUAL_SQUARES: f64 = 1.0;
/// Number of squares to each side that count, weighted by a bell curve with a standard deviation of
/// one square.
const REACH: i64 = 2;

/// Mean square of misses as a share of what is usual at their distance, by place.
pub(super) struct Roughness {
    square_m: f64,
    shares: HashMap<[i64; 2], f64>,
}

impl Roughness {
    pub(super) fn of(misses: &[LeftOutMiss], usual: &SigmaByDistance, square_m: f64) -> Self {
        let mut squares: HashMap<[i64; 2], (f64, f64)> = HashMap::new();
        let noise = usual.at(0.0).powi(2);
        for miss in misses {
            // A miss contains the noise of the left-out sounding, too.
            let expected = usual.at(miss.away_m).powi(2) + noise;
            let share = (miss.error_m.powi(2) / expected).min(MOST_SQUARE);
            let square = miss.place.map(|metres| (metres / square_m).floor() as i64);
            let (sum, count) = squares.entry(square).or_default();
            *sum += share;
            *count += 1.0;
        }
        let around = |[column, row]: [i64; 2]| {
            let cells = (-REACH..=REACH).flat_map(|c| (-REACH..=REACH).map(move |r| [c, r]));
            let start = (USUAL_SQUARES, USUAL_SQUARES);
            let (sum, weights) = cells.fold(start, |(sum, weights), [c, r]| {
                let weight = (-0.5 * (c * c + r * r) as f64).exp();
                match squares.get(&[column + c, row + r]) {
                    Some((shares, count)) => (sum + weight * shares / count, weights + weight),
                    None => (sum, weights),
                }
            });
            sum / weights
        };
        Self { square_m, shares: squares.keys().map(|square| (*square, around(*square))).collect() }
    }

    /// Returns a sampler for many places, of which most are near the place before.
    pub(super) fn sampler(&self) -> RoughnessSampler<'_> {
        RoughnessSampler { roughness: self, last: None }
    }

    /// Returns the shares of the squares whose middles are the corners around a place; 1 for a
    /// square where nothing was left out.
    fn around(&self, corner: [i64; 2]) -> [f64; 4] {
        CORNERS.map(|step| {
            let square = [0, 1].map(|axis| corner[axis] + step[axis] as i64);
            self.shares.get(&square).copied().unwrap_or(1.0)
        })
    }
}

/// Steps from the south-western one of the four middles of squares around a place to each of the
/// four.
const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];

/// Sampler that keeps the shares around the last place.
pub(super) struct RoughnessSampler<'a> {
    roughness: &'a Roughness,
    last: Option<([i64; 2], [f64; 4])>,
}

impl RoughnessSampler<'_> {
    /// Returns the share at a place, interpolated between the middles of squares.
    pub(super) fn at(&mut self, place: [f64; 2]) -> f64 {
        let [x, y] = place.map(|metres| metres / self.roughness.square_m - 0.5);
        let first = [x.floor(), y.floor()];
        let corner = first.map(|index| index as i64);
        let shares = match self.last {
            Some((last, shares)) if last == corner => shares,
            _ => self.roughness.around(corner),
        };
        self.last = Some((corner, shares));
        let share = |([right, up], share): ([f64; 2], f64)| {
            let corner = [first[0] + right, first[1] + up];
            (1.0 - (x - corner[0]).abs()) * (1.0 - (y - corner[1]).abs()) * share
        };
        CORNERS.into_iter().zip(shares).map(share).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_falls_is_made_to_rise_by_means() {
        let steps = [[0.0, 1.0], [1.0, 3.0], [2.0, 2.0], [3.0, 1.0], [4.0, 5.0]];
        let expected = [[0.0, 1.0], [1.0, 2.0], [2.0, 2.0], [3.0, 2.0], [4.0, 5.0]];
        assert_eq!(rising(steps.to_vec()), expected);
    }

    #[test]
    fn a_stated_error_is_read_between_its_steps_and_beyond_them() {
        let sigma = SigmaByDistance { steps: vec![[1.0, 0.1], [3.0, 0.2]] };
        // 0.01 + 0.03 (d² - 1) / 8
        let squares = [(0.0, 0.01), (1.0, 0.01), (2.0, 0.02125), (3.0, 0.04), (5.0, 0.1)];
        for (away_m, square) in squares {
            assert!((sigma.at(away_m).powi(2) - square).abs() < 1e-12, "{away_m}");
        }
    }
}
