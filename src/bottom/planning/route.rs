//! Finds the order in which lines are sailed, and the direction along each.

use super::turns::{Leg, Turn, TurnPose, apart_m, turns};
use super::water::Water;
use std::collections::HashMap;

/// Largest number of rounds of improvement; each round examines all pairs of lines.
const ROUNDS: usize = 30;
/// Least improvement that counts, metres.
const LEAST_M: f64 = 1e-6;
/// Number of nearest lines that a new line may be sailed before or after.
const NEAREST: usize = 12;

/// Returns the shortest turn between two poses that stays in the water; `None` where none does.
pub(super) fn link(water: &Water, from: TurnPose, to: TurnPose, radius_m: f64) -> Option<Turn> {
    let step_m = 0.5 * water.grid.cell_m;
    let stays = |turn: &Turn| turn.places(step_m).into_iter().all(|place| water.holds(place));
    turns(from, to, radius_m).into_iter().find(stays)
}

/// Index of a line; true if it is sailed from its end to its start.
type Sailed = (usize, bool);

/// Lines in the order of sailing.
#[derive(Clone, Debug)]
pub(super) struct Route<'a> {
    water: &'a Water,
    radius_m: f64,
    lines: Vec<Leg>,
    order: Vec<Sailed>,
    /// Lengths of the turns between lines computed so far, metres; infinite where no turn stays in
    /// the water.
    links: HashMap<(Sailed, Sailed), f64>,
}

impl<'a> Route<'a> {
    /// Creates a route without any line.
    pub(super) fn new(water: &'a Water, radius_m: f64) -> Self {
        Self { water, radius_m, lines: Vec::new(), order: Vec::new(), links: HashMap::new() }
    }

    /// Returns the lines in the order and direction of sailing.
    pub(super) fn legs(&self) -> Vec<Leg> {
        self.order.iter().map(|line| self.leg(*line)).collect()
    }

    /// Returns the length of all lines and the turns between them, metres.
    pub(super) fn length_m(&mut self) -> f64 {
        let lines_m: f64 = self.lines.iter().map(Leg::length_m).sum();
        let order = self.order.clone();
        let links = order.windows(2).map(|pair| self.link_m(pair[0], pair[1]));
        lines_m + links.sum::<f64>()
    }

    /// Returns the growth of the route by a new line at its best place, metres, and that place;
    /// `None` where no turn leads to the line.
    pub(super) fn growth(&mut self, leg: Leg) -> Option<(f64, Insertion)> {
        if self.order.is_empty() {
            return Some((leg.length_m(), Insertion { at: 0, leg }));
        }
        let mut best: Option<(f64, Insertion)> = None;
        for at in self.places_near(&leg) {
            for leg in [leg, leg.turned()] {
                let (before, after) = self.around(at, at);
                let come = before.map(|line| self.between(self.leg(line), leg));
                let go = after.map(|line| self.between(leg, self.leg(line)));
                let was_m = self.joined_m(before, after);
                let growth_m = leg.length_m() + come.unwrap_or(0.0) + go.unwrap_or(0.0) - was_m;
                if growth_m.is_finite() && best.as_ref().is_none_or(|(least, _)| growth_m < *least)
                {
                    best = Some((growth_m, Insertion { at, leg }));
                }
            }
        }
        best
    }

    /// Inserts a line at the place that [`Route::growth`] found.
    pub(super) fn insert(&mut self, insertion: Insertion) {
        let Insertion { at, leg } = insertion;
        self.lines.push(leg);
        self.order.insert(at, (self.lines.len() - 1, false));
    }

    /// Shortens the turns: it reverses stretches of the order (2-opt), and moves or reverses single
    /// lines (or-opt). Returns the saved length, metres.
    pub(super) fn improve(&mut self) -> f64 {
        let before_m = self.length_m();
        for _ in 0..ROUNDS {
            if !(self.reverse_a_stretch() | self.move_a_line()) {
                break;
            }
        }
        before_m - self.length_m()
    }

    /// Reverses each stretch of the order where that shortens the way; returns true if any was. A
    /// turn has the same length in both directions, so that the turns within a stretch stay.
    fn reverse_a_stretch(&mut self) -> bool {
        let count = self.order.len();
        let mut is_better = false;
        for first in 0..count {
            for last in first..count {
                let (before, after) = self.around(first, last + 1);
                let (start, end) = (self.order[first], self.order[last]);
                let old_m = self.joined_m(before, Some(start)) + self.joined_m(Some(end), after);
                let (new_start, new_end) = (Some(other_way(end)), Some(other_way(start)));
                if self.least_m(before, new_start) + self.least_m(new_end, after) >= old_m {
                    continue;
                }
                let new_m = self.joined_m(before, new_start) + self.joined_m(new_end, after);
                if new_m < old_m - LEAST_M {
                    let stretch = &mut self.order[first..=last];
                    stretch.reverse();
                    stretch.iter_mut().for_each(|line| *line = other_way(*line));
                    is_better = true;
                }
            }
        }
        is_better
    }

    /// Moves or reverses each single line where that shortens the way; returns true if any was.
    fn move_a_line(&mut self) -> bool {
        let mut is_better = false;
        for from in 0..self.order.len() {
            let (before, after) = self.around(from, from + 1);
            let line = self.order[from];
            let gap_m = self.joined_m(before, after);
            let here_m = self.joined_m(before, Some(line)) + self.joined_m(Some(line), after);
            let saved_m = here_m - gap_m;
            if saved_m <= LEAST_M || !gap_m.is_finite() {
                continue;
            }
            self.order.remove(from);
            let mut best = (saved_m - LEAST_M, from, line);
            for at in 0..=self.order.len() {
                let (before, after) = self.around(at, at);
                let was_m = self.joined_m(before, after);
                for moved in [line, other_way(line)] {
                    let new = Some(moved);
                    if self.least_m(before, new) + self.least_m(new, after) - was_m >= best.0 {
                        continue;
                    }
                    let cost_m = self.joined_m(before, new) + self.joined_m(new, after) - was_m;
                    if cost_m < best.0 {
                        best = (cost_m, at, moved);
                    }
                }
            }
            let (_, at, moved) = best;
            self.order.insert(at, moved);
            is_better |= (at, moved) != (from, line);
        }
        is_better
    }

    /// Returns the line before `first` and the line at `next` in the order; `None` beyond its ends.
    fn around(&self, first: usize, next: usize) -> (Option<Sailed>, Option<Sailed>) {
        let before = first.checked_sub(1).map(|index| self.order[index]);
        (before, self.order.get(next).copied())
    }

    /// Returns the places in the order before and after the lines whose ends are nearest to those
    /// of a new line.
    fn places_near(&self, leg: &Leg) -> Vec<usize> {
        let away_m = |line: &Leg| {
            let ends = [line.from, line.to];
            let each = ends.iter().flat_map(|end| [apart_m(*end, leg.from), apart_m(*end, leg.to)]);
            each.fold(f64::INFINITY, f64::min)
        };
        let mut nearest: Vec<(f64, usize)> = (self.order.iter().enumerate())
            .map(|(index, (line, _))| (away_m(&self.lines[*line]), index))
            .collect();
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        nearest.truncate(NEAREST);
        let mut places: Vec<usize> =
            nearest.iter().flat_map(|(_, index)| [*index, *index + 1]).collect();
        places.sort_unstable();
        places.dedup();
        places
    }

    fn leg(&self, (line, is_turned): Sailed) -> Leg {
        if is_turned { self.lines[line].turned() } else { self.lines[line] }
    }

    /// Returns the length of the turn between two lines, metres; 0 before the first line and after
    /// the last.
    fn joined_m(&mut self, from: Option<Sailed>, to: Option<Sailed>) -> f64 {
        from.zip(to).map_or(0.0, |(from, to)| self.link_m(from, to))
    }

    /// Returns a lower bound of [`Route::joined_m`]: the straight distance, metres.
    fn least_m(&self, from: Option<Sailed>, to: Option<Sailed>) -> f64 {
        let ends = from.zip(to);
        ends.map_or(0.0, |(from, to)| apart_m(self.leg(from).to, self.leg(to).from))
    }

    fn link_m(&mut self, from: Sailed, to: Sailed) -> f64 {
        // The turn in the opposite direction has the same length.
        let key = std::cmp::min((from, to), (other_way(to), other_way(from)));
        if let Some(length_m) = self.links.get(&key) {
            return *length_m;
        }
        let length_m = self.between(self.leg(key.0), self.leg(key.1));
        self.links.insert(key, length_m);
        length_m
    }

    fn between(&self, from: Leg, to: Leg) -> f64 {
        let turn = link(self.water, from.end(), to.start(), self.radius_m);
        turn.map_or(f64::INFINITY, |turn| turn.length_m())
    }
}

/// Place of a new line in the order, and the line in the direction of sailing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Insertion {
    at: usize,
    leg: Leg,
}

fn other_way((line, is_turned): Sailed) -> Sailed {
    (line, !is_turned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_in_any_order_become_a_round_to_and_fro() {
        let ring = vec![[-50.0, -50.0], [250.0, -50.0], [250.0, 150.0], [-50.0, 150.0]];
        let water = Water::within(&[ring]).unwrap();
        let mut route = Route::new(&water, 5.0);
        // Ten lines 10 m apart in a mixed order, all drawn eastwards, each appended at the end.
        for rank in [3, 9, 0, 6, 1, 8, 4, 2, 7, 5] {
            let north = 10.0 * f64::from(rank);
            let leg = Leg { from: [0.0, north], to: [200.0, north] };
            let at = route.order.len();
            route.insert(Insertion { at, leg });
        }
        let saved_m = route.improve();
        // A half circle of 5 m radius between neighbouring lines.
        let best_m = 10.0 * 200.0 + 9.0 * std::f64::consts::PI * 5.0;
        let length_m = route.length_m();
        assert!(saved_m > 0.0 && length_m < 1.03 * best_m, "{length_m} {best_m}");
        let (growth_m, _) = route.growth(Leg { from: [0.0, 100.0], to: [200.0, 100.0] }).unwrap();
        assert!((growth_m - 215.7).abs() < 0.1, "{growth_m}");
    }

    #[test]
    fn a_turn_that_leaves_the_water_is_none() {
        let ring = vec![[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]];
        let water = Water::within(&[ring]).unwrap();
        let pose =
            |east: f64, north: f64, course_rad: f64| TurnPose { place: [east, north], course_rad };
        // A half circle to the neighbouring line, with room for it and without.
        let beside = |north: f64| {
            let up = std::f64::consts::FRAC_PI_2;
            link(&water, pose(0.0, north, up), pose(10.0, north, -up), 5.0)
        };
        let half_m = std::f64::consts::PI * 5.0;
        assert!((beside(10.0).unwrap().length_m() - half_m).abs() < 1e-6);
        assert!(beside(17.0).is_none_or(|turn| turn.length_m() > half_m + 1.0));
    }
}
