//! Estimates how far the bottom moves from row to row where the boat runs up or down a bank.
//!
//! The cost of a line grows with its movement, and rows are averaged with their neighbours. Both
//! are right while the bottom moves by a few centimetres a ping. On a bank of 33 degrees, at 1.8 m
//! a second and eight pings a second, it moves by 15 cm a ping, and for a slow recorder by as much
//! on a gentle slope: the line would stay for some pings, leap, and stay again. Along a trend, rows
//! are compared and averaged at cells that move with the bottom. On banks of `reach.py` the share
//! of first returns that are off by over 10 cm falls from 50 to 1 % at eight pings a second, and
//! from 60 to 5 % at two.

use std::ops::Range;

/// Movement from row to row from which the bottom has a trend: metres, and cells. Up to it the line
/// follows by itself.
const STEEP_M: f64 = 0.05;
const STEEP_CELLS: f64 = 2.0;

/// Rows that the movement at a row is estimated from.
struct Window {
    /// Number of rows between two rows that are compared.
    apart: usize,
    /// Largest distance from the row to those that are compared.
    reach: usize,
}

/// Window for a loose line: a leap at the edge of a boulder or a wall is in less than a quarter of
/// the comparisons.
const OF_LINE: Window = Window { apart: 8, reach: 20 };
/// Time before and after a ping over which recorded depths must move the same way, seconds: over
/// boulders they do not. Numbers of pings that this is, at least and at most: at one ping a second
/// a bank takes a few pings.
const OF_DEPTHS_S: f64 = 0.5;
const OF_DEPTHS: [usize; 2] = [1, 10];

/// Movement of the bottom along a chunk.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Trend {
    /// Place of each row relative to the first, cells; empty where the bottom is nowhere steep.
    places: Vec<i32>,
}

impl Trend {
    /// Returns the trends of a loose line and of the recorded depths, where these are steep
    /// anywhere. Both are cells of range by row; NaN where a row has none. `interval_s` is the
    /// usual time from row to row.
    pub(super) fn candidates(
        line: &[f64],
        depths: &[f64],
        interval_s: f64,
        cell_m: f64,
    ) -> impl Iterator<Item = Self> {
        let of_line = Self::of(line, &OF_LINE, cell_m);
        let [least, most] = OF_DEPTHS;
        let reach = ((OF_DEPTHS_S / interval_s) as usize).clamp(least, most);
        let of_depths = Self::of(depths, &Window { apart: 1, reach }, cell_m);
        [of_line, of_depths].into_iter().flatten()
    }

    fn of(line: &[f64], window: &Window, cell_m: f64) -> Option<Self> {
        let least = (STEEP_M / cell_m).max(STEEP_CELLS);
        let mut moves = Vec::new();
        let mut is_steep = false;
        let mut place = 0.0;
        let places = (0..line.len()).map(|row| {
            let movement = movement(line, row, window, &mut moves);
            if movement.abs() >= least {
                is_steep = true;
                place += movement;
            }
            place as i32
        });
        let places = places.collect();
        is_steep.then_some(Self { places })
    }

    /// Returns the number of cells that the bottom moves from one row to another; rows beyond the
    /// ends count as the first or the last.
    pub(super) fn between(&self, from: usize, to: isize) -> isize {
        let Some(last) = self.places.len().checked_sub(1) else {
            return 0;
        };
        let to = to.clamp(0, last as isize) as usize;
        self.places[to] as isize - self.places[from] as isize
    }

    /// Returns true if the bottom moves between some rows, of which those beyond the end do not
    /// count.
    pub(super) fn moves_over(&self, rows: &Range<usize>) -> bool {
        let places = self.places.get(rows.start..self.places.len().min(rows.end));
        places.is_some_and(|places| places.windows(2).any(|pair| pair[0] != pair[1]))
    }

    /// Returns the number of cells that the bottom moves from the row before to a row.
    pub(super) fn step(&self, row: usize) -> isize {
        -self.between(row, row as isize - 1)
    }
}

/// Returns the mean movement around a row, cells a row, without the quarters of the comparisons
/// that moved most and least; 0 where the others do not all move the same way, and where rows have
/// no place.
fn movement(line: &[f64], row: usize, window: &Window, moves: &mut Vec<f64>) -> f64 {
    let Window { apart, reach } = *window;
    let rows = row.saturating_sub(reach)..line.len().min(row + reach + 1);
    let compared = line[rows].windows(apart + 1).map(|rows| rows[apart] - rows[0]);
    moves.clear();
    moves.extend(compared.filter(|moved| moved.is_finite()));
    moves.sort_unstable_by(f64::total_cmp);
    let quarter = moves.len() / 4;
    let middle = &moves[quarter..moves.len() - quarter];
    match middle {
        [least, .., most] if least * most > 0.0 => {
            middle.iter().sum::<f64>() / (middle.len() * apart) as f64
        }
        _ => 0.0,
    }
}

/// Returns the parts of two rows of `width` cells that lie beside each other when the second row is
/// read `by` cells farther: the first cell of each part, and their length.
pub(super) fn overlap(width: usize, by: isize) -> (usize, usize, usize) {
    let away = by.unsigned_abs().min(width);
    let (here, there) = if by < 0 { (away, 0) } else { (0, away) };
    (here, there, width - away)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stairs_up_a_bank_are_a_trend_and_a_single_leap_is_none() {
        // 60 cells in four rows, as a line that stays and leaps.
        let bank = |row: usize| 15.0 * (row.clamp(100, 160) - 100) as f64;
        let stairs: Vec<f64> = (0..300).map(|row| bank(row / 4 * 4)).collect();
        let trend = Trend::of(&stairs, &OF_LINE, 0.01).unwrap();
        for row in [115, 130, 145] {
            let moved = trend.between(row - 8, row as isize + 8);
            assert!((moved - 240).abs() < 40, "{row}: {moved}");
        }
        assert_eq!(trend.between(0, 60), 0);
        let leap: Vec<f64> = (0..300).map(|row| if row < 150 { 500.0 } else { 100.0 }).collect();
        assert_eq!(Trend::of(&leap, &OF_LINE, 0.01), None);
        // A depth with a noise of 6 cells.
        let noisy = |row: usize| 300.0 + 6.0 * [0.0, 1.0, -1.0, 0.5, -0.5][row * row % 5];
        let noisy: Vec<f64> = (0..300).map(noisy).collect();
        assert_eq!(Trend::of(&noisy, &Window { apart: 1, reach: 1 }, 0.01), None);
        assert_eq!(Trend::default().step(7), 0);
    }
}
