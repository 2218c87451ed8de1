//! Finds where left-out soundings are missed by more than usual at the same distance, and where by
//! less.

use super::{LeftOutMiss, SigmaByDistance};
use std::collections::HashMap;

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
