//! Finds lines that could be sailed: over many headings and offsets, the stretch of each line that
//! reduces the uncertainty most for its time.

use super::ground::PlanningGrid;
use super::turns::{Leg, apart_m};
use bathyscope_log::support::outline::bounds;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::ops::Range;

/// Number of headings that are tried, over half a turn.
const HEADINGS: usize = 18;
/// Number of lines of one heading that are returned as candidates.
const BEST_OF_HEADING: usize = 6;
/// Least distance between lines of one heading, metres.
const LEAST_OFFSET_M: f64 = 1.0;
/// Worth of a line past an object that was seen from one side only, as square metres of ground
/// without any known depth.
const OBJECT_M2: f64 = 150.0;
/// Length of a line before and after the place beside an object, metres, so that its shadow and its
/// ends are in the picture.
const BESIDE_M: f64 = 5.0;
/// Largest number of rounds of Dinkelbach's method: three or four are usual.
const ROUNDS: usize = 12;

/// Speed, turn radius and length that limit a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Speed of the boat, metres a second.
    pub speed_mps: f64,
    /// Least radius of a turn, metres.
    pub radius_m: f64,
    /// Greatest length of a line, metres.
    pub most_m: f64,
}

impl Limits {
    /// Returns the length below which a line is not worth a turn, metres.
    pub(super) fn least_m(&self) -> f64 {
        2.0 * self.radius_m
    }
}

/// Line that could be sailed.
#[derive(Clone, Debug)]
pub(super) struct CandidateLine {
    from: [f64; 2],
    /// Unit vector along the line.
    course: [f64; 2],
    step_m: f64,
    /// Reduction of the uncertainty by each step of the line: metres of standard deviation times
    /// square metres.
    gains: Vec<f32>,
    /// Sum of the gains of all steps.
    pub gain: f64,
    /// Estimated gain in a second, including the time of a turn and of the straight way to the
    /// line.
    rate: f64,
}

impl CandidateLine {
    /// Returns the line from its start to its end.
    pub(super) fn leg(&self) -> Leg {
        let length_m = self.step_m * self.gains.len() as f64;
        Leg {
            from: self.from,
            to: [0, 1].map(|axis| self.from[axis] + length_m * self.course[axis]),
        }
    }

    /// Returns the line shortened by some metres at its ends, where this loses least gain; `None`
    /// where less than `least_m` would remain.
    pub(super) fn shortened(&self, by_m: f64, least_m: f64) -> Option<Self> {
        let steps = (by_m / self.step_m).ceil().max(1.0) as usize;
        let left = self.gains.len().checked_sub(steps)?;
        if (left as f64) * self.step_m < least_m {
            return None;
        }
        let sum = |range: Range<usize>| -> f64 {
            self.gains[range].iter().map(|gain| f64::from(*gain)).sum()
        };
        let starts = (0..=steps).max_by(|a, b| sum(*a..a + left).total_cmp(&sum(*b..b + left)));
        let start = starts.unwrap_or(0);
        Some(Self {
            from: [0, 1]
                .map(|axis| self.from[axis] + self.step_m * start as f64 * self.course[axis]),
            gains: self.gains[start..start + left].to_vec(),
            gain: sum(start..start + left),
            ..self.clone()
        })
    }
}

/// Returns the lines with the largest gain for their time, best first. `ends` are the ends of the
/// lines that are already planned: the boat comes from one of them.
///
/// # Errors
/// When the work was cancelled.
pub(super) fn candidates(
    ground: &PlanningGrid,
    ends: &[[f64; 2]],
    limits: &Limits,
    progress: &Progress,
) -> Result<Vec<CandidateLine>, Cancelled> {
    let of_heading = |index: usize| {
        progress.check()?;
        let heading_rad = PI * index as f64 / HEADINGS as f64;
        Ok(ParallelLines::new(ground, heading_rad).best(ground, ends, limits))
    };
    let found: Result<Vec<Vec<CandidateLine>>, Cancelled> =
        (0..HEADINGS).into_par_iter().map(of_heading).collect();
    let mut found: Vec<CandidateLine> = found?.into_iter().flatten().collect();
    found.sort_by(|a, b| b.rate.total_cmp(&a.rate));
    Ok(found)
}

/// Parallel lines over the water, with the gain of each step.
struct ParallelLines {
    /// Unit vectors along the lines and across them.
    along: [f64; 2],
    across: [f64; 2],
    /// Start of the first step of the first line, along and across, metres.
    origin: [f64; 2],
    /// Length of a step, and distance between neighbouring lines, metres.
    step_m: f64,
    offset_m: f64,
    steps: usize,
    lines: usize,
    gains: Vec<f32>,
}

impl ParallelLines {
    fn new(ground: &PlanningGrid, heading_rad: f64) -> Self {
        let (sin, cos) = heading_rad.sin_cos();
        let (along, across) = ([sin, cos], [cos, -sin]);
        let places = ground.cells.iter().map(|cell| turned(cell.place, along, across));
        let [a0, b0, a1, b1] = bounds(places);
        let step_m = ground.water.grid.cell_m;
        let offset_m = step_m.max(LEAST_OFFSET_M);
        let steps = ((a1 - a0) / step_m) as usize + 1;
        let lines = ((b1 - b0) / offset_m) as usize + 1;
        let mut sheet = Self {
            along,
            across,
            origin: [a0 - 0.5 * step_m, b0],
            step_m,
            offset_m,
            steps,
            lines,
            gains: vec![0.0; steps * lines],
        };
        sheet.add_ground(ground);
        sheet.add_objects(ground, heading_rad);
        sheet
    }

    /// Adds the gain of every line at the cells on both sides of it.
    fn add_ground(&mut self, ground: &PlanningGrid) {
        let cell_m2 = ground.cell_m2() as f32;
        for cell in &ground.cells {
            let reach_m = ground.reach_m(cell);
            let sigma_m = ground.sigma_m(cell);
            let [a, b] = turned(cell.place, self.along, self.across);
            let step = self.step_of(a);
            for line in self.lines_within(b, reach_m) {
                let pass_m = (b - self.offset_of(line)).abs() as f32;
                let gain = ground.mended_by(cell, sigma_m, pass_m);
                self.gains[line * self.steps + step] += cell_m2 * gain;
            }
        }
    }

    /// Adds the gain of lines that show objects from another side.
    fn add_objects(&mut self, ground: &PlanningGrid, heading_rad: f64) {
        let [near_m, far_m] = ground.useful_m;
        for object in &ground.objects {
            let better = object.crossing_with(heading_rad) - object.crossing();
            let worth = OBJECT_M2 * f64::from(ground.sigma.limit_m()) * better;
            let [a, b] = turned(object.place, self.along, self.across);
            let beside = self.step_of(a - BESIDE_M)..self.step_of(a + BESIDE_M) + 1;
            let each = (worth / beside.len() as f64) as f32;
            for line in self.lines_within(b, far_m) {
                if (b - self.offset_of(line)).abs() < near_m {
                    continue;
                }
                let first = line * self.steps;
                let gains = &mut self.gains[first + beside.start..first + beside.end];
                gains.iter_mut().for_each(|gain| *gain += each);
            }
        }
    }

    fn step_of(&self, along_m: f64) -> usize {
        let step = ((along_m - self.origin[0]) / self.step_m).max(0.0) as usize;
        step.min(self.steps - 1)
    }

    fn offset_of(&self, line: usize) -> f64 {
        self.origin[1] + self.offset_m * line as f64
    }

    fn lines_within(&self, across_m: f64, reach_m: f64) -> Range<usize> {
        let cells = |metres: f64| ((metres - self.origin[1]) / self.offset_m).max(0.0);
        let first = cells(across_m - reach_m).ceil() as usize;
        let last = cells(across_m + reach_m).floor() as usize;
        first..(last + 1).min(self.lines)
    }

    fn place(&self, line: usize, step: f64) -> [f64; 2] {
        let (a, b) = (self.origin[0] + self.step_m * step, self.offset_of(line));
        [0, 1].map(|axis| a * self.along[axis] + b * self.across[axis])
    }

    /// Returns the best stretches of the lines, best first, at most [`BEST_OF_HEADING`].
    fn best(
        &self,
        ground: &PlanningGrid,
        ends: &[[f64; 2]],
        limits: &Limits,
    ) -> Vec<CandidateLine> {
        let step_s = self.step_m / limits.speed_mps;
        let turn_s = PI * limits.radius_m / limits.speed_mps;
        let least = (limits.least_m() / self.step_m).ceil() as usize;
        let most = (limits.most_m / self.step_m) as usize;
        let mut found: Vec<CandidateLine> = Vec::new();
        for line in 0..self.lines {
            for run in self.runs(ground, line, limits.radius_m) {
                let first = line * self.steps;
                let gains = &self.gains[first + run.start..first + run.end];
                let Some((stretch, gain)) = best_stretch(gains, least, most, step_s, turn_s) else {
                    continue;
                };
                let from = self.place(line, (run.start + stretch.start) as f64);
                let to = self.place(line, (run.start + stretch.end) as f64);
                let away_m = (ends.iter())
                    .flat_map(|end| [from, to].map(|place| apart_m(*end, place)))
                    .fold(f64::INFINITY, f64::min);
                let away_s = if ends.is_empty() { 0.0 } else { away_m / limits.speed_mps };
                let seconds = stretch.len() as f64 * step_s + turn_s + away_s;
                found.push(CandidateLine {
                    from,
                    course: self.along,
                    step_m: self.step_m,
                    gains: gains[stretch].to_vec(),
                    gain,
                    rate: gain / seconds,
                });
            }
        }
        found.sort_by(|a, b| b.rate.total_cmp(&a.rate));
        found.truncate(BEST_OF_HEADING);
        found
    }

    /// Returns the runs of steps of a line in open water, with room to turn at both ends.
    fn runs(&self, ground: &PlanningGrid, line: usize, radius_m: f64) -> Vec<Range<usize>> {
        let room = (radius_m / self.step_m).ceil() as usize + 1;
        let mut runs = Vec::new();
        let mut start = 0;
        for step in 0..=self.steps {
            let is_open = step < self.steps && {
                let [before, after] = [0.05, 0.95].map(|part| self.place(line, step as f64 + part));
                ground.water.holds(before) && ground.water.holds(after)
            };
            if !is_open {
                if step > start + 2 * room {
                    runs.push(start + room..step - room);
                }
                start = step + 1;
            }
        }
        runs
    }
}

/// Returns the coordinates of a place along and across the lines.
fn turned(place: [f64; 2], along: [f64; 2], across: [f64; 2]) -> [f64; 2] {
    [along, across].map(|axis| place[0] * axis[0] + place[1] * axis[1])
}

/// Returns the stretch of `gains`, `least` to `most` steps long, with the largest gain for its
/// time, and that gain. Each step takes `step_s`, and the whole stretch `extra_s` more. `None`
/// where there is no gain, or no such stretch.
///
/// The method is that of W. Dinkelbach (On nonlinear fractional programming, 1967): at a given
/// rate, the best stretch is found as a largest sum; this stretch gives a better rate, until the
/// rate no longer grows.
fn best_stretch(
    gains: &[f32],
    least: usize,
    most: usize,
    step_s: f64,
    extra_s: f64,
) -> Option<(Range<usize>, f64)> {
    if least == 0 || least > most || gains.len() < least {
        return None;
    }
    let mut sums = Vec::with_capacity(gains.len() + 1);
    sums.push(0.0);
    for gain in gains {
        sums.push(sums[sums.len() - 1] + f64::from(*gain));
    }
    let mut best: Option<(Range<usize>, f64)> = None;
    let mut rate = 0.0;
    for _ in 0..ROUNDS {
        let stretch = largest(&sums, least, most, rate * step_s)?;
        let gain = sums[stretch.end] - sums[stretch.start];
        let found = gain / (stretch.len() as f64 * step_s + extra_s);
        if found <= rate * (1.0 + 1e-9) {
            break;
        }
        rate = found;
        best = Some((stretch, gain));
    }
    best
}

/// Returns the stretch with the largest sum less `cost` for each step.
fn largest(sums: &[f64], least: usize, most: usize, cost: f64) -> Option<Range<usize>> {
    let at = |index: usize| sums[index] - cost * index as f64;
    // Starts that may still be the best one, in order of their place; their values rise in this
    // order too.
    let mut starts: VecDeque<usize> = VecDeque::new();
    let mut best: Option<(f64, Range<usize>)> = None;
    for end in least..sums.len() {
        let start = end - least;
        while starts.back().is_some_and(|last| at(*last) >= at(start)) {
            starts.pop_back();
        }
        starts.push_back(start);
        while starts.front().is_some_and(|first| end - first > most) {
            starts.pop_front();
        }
        let Some(&start) = starts.front() else {
            continue;
        };
        let sum = at(end) - at(start);
        if best.as_ref().is_none_or(|(most, _)| sum > *most) {
            best = Some((sum, start..end));
        }
    }
    best.map(|(_, stretch)| stretch)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_best_of_all_stretches() {
        for case in 0..60_u64 {
            let draw = |index: u64| ((case * 131 + index * 7919) % 101) as f32 / 20.0;
            let gains: Vec<f32> = (0..40).map(|index| (draw(index) - 3.0).max(0.0)).collect();
            let (least, most, extra_s) = (3, 6 + case as usize % 30, 0.5 * case as f64);
            let rate = |stretch: &Range<usize>| {
                let gain: f64 = gains[stretch.clone()].iter().map(|g| f64::from(*g)).sum();
                gain / (2.0 * stretch.len() as f64 + extra_s)
            };
            let all = (0..40).flat_map(|start| {
                (start + least..=(start + most).min(40)).map(move |end| start..end)
            });
            let expected = all.map(|stretch| rate(&stretch)).fold(0.0, f64::max);
            let (found, gain) = best_stretch(&gains, least, most, 2.0, extra_s).unwrap();
            assert!((rate(&found) - expected).abs() < 1e-9, "{case}: {found:?}");
            assert!((gain / (2.0 * found.len() as f64 + extra_s) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn nothing_to_gain_is_no_stretch() {
        assert_eq!(best_stretch(&[0.0; 9], 2, 9, 1.0, 1.0), None);
        assert_eq!(best_stretch(&[1.0; 3], 4, 9, 1.0, 1.0), None);
        assert_eq!(best_stretch(&[1.0; 9], 4, 3, 1.0, 1.0), None);
    }
}
