//! Finds the offsets and latencies of the positions of each log from crossings of tracks over a
//! bottom that slopes.
//!
//! A log whose positions are off measures at a crossing the depth of another place, and the slope
//! of the bottom shows how far away this place is. With the gradient `G` of the depth, heights `h`,
//! shifts `s` and the boat's velocity `v` times the latency `t`, the depths of two passes differ by
//!
//! `d_1 - d_2 = (h_1 - h_2) + G (s_1 + v_1 t_1 - s_2 - v_2 t_2)`
//!
//! which is linear in the unknowns. A shift that all logs share changes nothing; the shifts found
//! have a mean of about zero. A latency can be found even for a single log that crosses itself in
//! different directions.

use super::crosslines::{Crossing, TrackDepth, velocity_mps};
use super::height_offsets::{difference_sigma_m, groups, robust_shares};
use crate::sparse::{Equations, Factor, Pattern};
use std::collections::BTreeMap;

/// Standard deviations of the unknowns that are assumed before any crossing: of positions of a
/// receiver without corrections, metres, and of the latency of a recorder, seconds. Where crossings
/// determine nothing, the bottom being level, the shift stays zero.
const SD_SHIFT_M: f64 = 2.0;
const SD_LATENCY_S: f64 = 1.0;
/// Assumed standard deviation of heights, metres: so large that it hardly restricts them.
const SD_HEIGHT_M: f64 = 10.0;
/// Least scatter of the residuals, as a share of what is expected from their slopes: few crossings
/// can agree by chance.
const LEAST_SCALE: f64 = 0.5;
/// Least slope that determines positions, metres a metre: a smaller one may be that of noise.
const LEAST_SLOPE: f64 = 0.02;
const ROUNDS: usize = 20;
/// Largest number of rounds in which tracks are corrected and their crossings found anew, and the
/// change below which the rounds end, metres or seconds. Slopes are those over a few metres and so
/// too small on mounds, which makes the first shifts too large.
const MOST_CORRECTIONS: usize = 10;
const CORRECTED: f64 = 0.01;
/// Change of the unknowns below which the iteration ends, metres or seconds.
const SETTLED: f64 = 1e-6;
/// Indices of the unknowns of a log: shift to the east and north, latency, height.
const EAST: usize = 0;
const NORTH: usize = 1;
const LATENCY: usize = 2;
const HEIGHT: usize = 3;
const UNKNOWNS: usize = 4;

/// Unknowns that are to be found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Shifts to the east and north.
    pub shifts: bool,
    /// Latencies.
    pub latencies: bool,
}

impl Wanted {
    /// Returns true if any unknown is wanted.
    pub fn is_anything(self) -> bool {
        self.shifts || self.latencies
    }
}

/// Correction of the positions of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// Shift to the east that is added to the positions, metres.
    pub east_m: f64,
    /// Shift to the north that is added to the positions, metres.
    pub north_m: f64,
    /// Delay of the positions after the depths recorded with them, seconds: at the time of a depth
    /// the boat is at the position that is recorded this much later.
    pub latency_s: f64,
}

impl Shift {
    /// Returns the correction of a place that is passed at some velocity, metres to the east and
    /// north.
    pub fn at(&self, velocity_mps: [f64; 2]) -> [f64; 2] {
        let [east, north] = velocity_mps;
        [self.east_m + self.latency_s * east, self.north_m + self.latency_s * north]
    }

    /// Returns the shift with more added: east, north and latency.
    #[must_use]
    pub fn plus(&self, [east_m, north_m, latency_s]: [f64; 3]) -> Self {
        Self {
            east_m: self.east_m + east_m,
            north_m: self.north_m + north_m,
            latency_s: self.latency_s + latency_s,
        }
    }

    /// Returns east, north and latency, metres and seconds.
    pub fn values(&self) -> [f64; 3] {
        [self.east_m, self.north_m, self.latency_s]
    }
}

/// Shift that was found for a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundShift {
    /// The whole shift, including the part that was known before.
    pub shift: Shift,
    /// Standard error of the shift, metres, the larger of both directions: against the mean of the
    /// logs that crossings connect with this one, or against a pinned one of them. NaN where shifts
    /// were not wanted; about 2 m where crossings determine nothing.
    pub shift_error_m: f64,
    /// Standard error of the latency, seconds; NaN where latencies were not wanted. About 1 s where
    /// crossings determine nothing.
    pub latency_error_s: f64,
}

impl FoundShift {
    /// Zero shift without errors, where no unknown was wanted.
    pub const NONE: Self = Self {
        shift: Shift { east_m: 0.0, north_m: 0.0, latency_s: 0.0 },
        shift_error_m: f64::NAN,
        latency_error_s: f64::NAN,
    };

    /// Keeps the standard errors of `before` for unknowns that were not wanted now.
    pub fn keep_errors_of(&mut self, before: &Self) {
        let kept = |now: f64, before: f64| if now.is_nan() { before } else { now };
        self.shift_error_m = kept(self.shift_error_m, before.shift_error_m);
        self.latency_error_s = kept(self.latency_error_s, before.latency_error_s);
    }
}

/// Returns a track with its positions corrected.
pub fn shifted(track: &[TrackDepth], shift: &Shift) -> Vec<TrackDepth> {
    let moved = |(index, depth): (usize, &TrackDepth)| {
        let [east_m, north_m] = shift.at(velocity_mps(track, index));
        TrackDepth { east_m: depth.east_m + east_m, north_m: depth.north_m + north_m, ..*depth }
    };
    track.iter().enumerate().map(moved).collect()
}

/// A log in the adjustment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CorrectedLog {
    /// Correction applied to the positions before the depths were compared.
    pub shift: Shift,
    /// Height offset of a pinned log, metres: a person has fixed its height and shift. `None` for
    /// others.
    pub pinned_m: Option<f64>,
}

/// Returns the shifts of logs, found in rounds: `crossings` returns the crossings of the tracks as
/// corrected so far, whose places and slopes move with the tracks. `None` where the equations have
/// no solution in numbers.
///
/// # Errors
/// Those of `crossings`.
pub fn settled_offsets<E>(
    logs: &[CorrectedLog],
    wanted: Wanted,
    mut crossings: impl FnMut(&[CorrectedLog]) -> Result<Vec<Crossing>, E>,
) -> Result<Option<Vec<FoundShift>>, E> {
    let mut placed = logs.to_vec();
    let mut result = Vec::new();
    for _ in 0..MOST_CORRECTIONS {
        let met = crossings(&placed)?;
        let Some(found) = position_offsets(&placed, &met, wanted) else {
            return Ok(None);
        };
        let mut moved: f64 = 0.0;
        for (placed, found) in placed.iter_mut().zip(&found) {
            let pairs = placed.shift.values().into_iter().zip(found.shift.values());
            moved = pairs.map(|(a, b)| (a - b).abs()).fold(moved, f64::max);
            placed.shift = found.shift;
        }
        result = found;
        if moved < CORRECTED {
            break;
        }
    }
    Ok(Some(result))
}

/// Returns the shifts of logs from crossings with each other and with themselves, by least squares
/// with robust weights; the track of a pass is the index of its log. `None` where the equations
/// have no solution in numbers.
fn position_offsets(
    logs: &[CorrectedLog],
    crossings: &[Crossing],
    wanted: Wanted,
) -> Option<Vec<FoundShift>> {
    let adjustment = Adjustment::new(logs, crossings, wanted);
    let (values, factor) = adjustment.solve()?;
    let errors = adjustment.errors(&factor);
    let found: Vec<FoundShift> =
        (0..logs.len()).map(|log| adjustment.found(log, &values, &errors)).collect();
    let is_number =
        |found_shift: &FoundShift| found_shift.shift.values().iter().all(|value| value.is_finite());
    found.iter().all(is_number).then_some(found)
}

/// The adjustment of logs to each other.
struct Adjustment<'a> {
    logs: &'a [CorrectedLog],
    /// Crossings of these logs whose depths and gradients are finite.
    crossings: Vec<&'a Crossing>,
    /// Expected standard deviation of the difference of the depths at each crossing, metres.
    sigmas_m: Vec<f64>,
    wanted: Wanted,
}

impl<'a> Adjustment<'a> {
    fn new(logs: &'a [CorrectedLog], crossings: &'a [Crossing], wanted: Wanted) -> Self {
        let used = |crossing: &&Crossing| {
            let numbers = crossing
                .gradient
                .iter()
                .chain([&crossing.passes[0].depth_m, &crossing.passes[1].depth_m]);
            let is_known = |pass: usize| crossing.passes[pass].track < logs.len();
            is_known(0) && is_known(1) && numbers.into_iter().all(|number| number.is_finite())
        };
        let crossings: Vec<&Crossing> = crossings.iter().filter(used).collect();
        let sigmas_m =
            crossings.iter().map(|crossing| difference_sigma_m(crossing.slope())).collect();
        Self { logs, crossings, sigmas_m, wanted }
    }

    /// Returns an equation for each crossing, in their order, and one for each unknown that holds
    /// it near zero.
    fn equations(&self) -> Equations {
        let mut equations = Equations::default();
        for (crossing, sigma_m) in self.crossings.iter().zip(&self.sigmas_m) {
            let (terms, known_m) = self.sides(crossing);
            equations.add(terms, crossing.difference_m() - known_m, *sigma_m);
        }
        for (log, placed) in self.logs.iter().enumerate() {
            let sds = [SD_SHIFT_M, SD_SHIFT_M, SD_LATENCY_S];
            for ((unknown, value), sd) in placed.shift.values().into_iter().enumerate().zip(sds) {
                // The whole shift is held near zero, and a part of it is known.
                equations.add([(UNKNOWNS * log + unknown, 1.0)], -value, sd);
            }
            equations.add([(UNKNOWNS * log + HEIGHT, 1.0)], 0.0, SD_HEIGHT_M);
        }
        equations
    }

    /// Returns the unknowns, and the factor of the equations that they solve; crossings that do not
    /// fit the others lose weight round by round. `None` where the equations have no solution.
    fn solve(&self) -> Option<(Vec<f64>, Factor)> {
        let mut equations = self.equations();
        let count = UNKNOWNS * self.logs.len();
        let pattern = Pattern::of(&equations, count)?;
        let (mut values, mut factor) = (vec![0.0; count], None);
        for round in 0..ROUNDS {
            if round > 0 {
                self.weigh(&mut equations, &values);
            }
            let found = pattern.factorise(&equations)?;
            let next = found.solve(&pattern, &equations, 0, || 0.0).swap_remove(0);
            let moved = next.iter().zip(&values).map(|(a, b)| (a - b).abs());
            let moved = moved.fold(0.0, f64::max);
            (values, factor) = (next, Some(found));
            if round > 0 && moved < SETTLED {
                break;
            }
        }
        Some((values, factor?))
    }

    /// Weighs the crossings by how well some values explain them.
    fn weigh(&self, equations: &mut Equations, values: &[f64]) {
        let residuals: Vec<f64> = (self.crossings.iter().zip(&self.sigmas_m))
            .map(|(crossing, sigma_m)| self.left_m(crossing, values) / sigma_m)
            .collect();
        let (shares, scale) = robust_shares(&residuals);
        let scale = scale.max(LEAST_SCALE);
        for (crossing, (share, sigma_m)) in shares.iter().zip(&self.sigmas_m).enumerate() {
            equations.set_sd(crossing, scale * sigma_m / share.sqrt());
        }
    }

    /// Returns the shift of a log and its errors, from all unknowns and their errors.
    fn found(&self, log: usize, values: &[f64], errors: &[f64]) -> FoundShift {
        let placed = &self.logs[log];
        let of = |unknown: usize| UNKNOWNS * log + unknown;
        let is_open = placed.pinned_m.is_none();
        let asked = |is_wanted: bool, unknown: usize| {
            if is_wanted && is_open { values[of(unknown)] } else { 0.0 }
        };
        let error = |is_wanted: bool, value: f64| match (is_wanted, is_open) {
            (false, _) => f64::NAN,
            (true, true) => value,
            (true, false) => 0.0,
        };
        let Wanted { shifts, latencies } = self.wanted;
        FoundShift {
            shift: placed.shift.plus([
                asked(shifts, EAST),
                asked(shifts, NORTH),
                asked(latencies, LATENCY),
            ]),
            shift_error_m: error(shifts, errors[of(EAST)].max(errors[of(NORTH)])),
            latency_error_s: error(latencies, errors[of(LATENCY)]),
        }
    }

    /// Returns the standard errors of all unknowns. Shifts are against the mean of the logs that
    /// crossings connect, unless one of these is pinned, since a shift that all share cannot be
    /// found.
    fn errors(&self, factor: &Factor) -> Vec<f64> {
        let logs = self.logs;
        let count = UNKNOWNS * logs.len();
        let mut variances = factor.variances(count);
        let ties = self.crossings.iter().map(|crossing| crossing.passes.map(|pass| pass.track));
        let group_of = groups(logs.len(), ties);
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (log, group) in group_of.into_iter().enumerate() {
            members.entry(group).or_default().push(log);
        }
        let is_free = |group: &&Vec<usize>| {
            group.len() > 1 && group.iter().all(|log| logs[*log].pinned_m.is_none())
        };
        for group in members.values().filter(is_free) {
            let weight = 1.0 / group.len() as f64;
            for axis in [EAST, NORTH] {
                // With the covariance C and the weights w of the mean: C_ii - 2 (C w)_i + w C w.
                let mut with_mean = [vec![0.0; count]];
                for log in group {
                    with_mean[0][UNKNOWNS * log + axis] = weight;
                }
                factor.solve_for(&mut with_mean);
                let of = |log: &usize| UNKNOWNS * log + axis;
                let mean: f64 = group.iter().map(|log| weight * with_mean[0][of(log)]).sum();
                for log in group {
                    variances[of(log)] += mean - 2.0 * with_mean[0][of(log)];
                }
            }
        }
        variances.into_iter().map(|variance| variance.max(0.0).sqrt()).collect()
    }

    /// Returns the terms that the unknowns add to the difference of a crossing, and its known part,
    /// metres.
    fn sides(&self, crossing: &Crossing) -> (Vec<(usize, f64)>, f64) {
        let mut terms = Vec::with_capacity(2 * UNKNOWNS);
        let mut known_m = 0.0;
        let [east, north] = crossing.gradient;
        let is_sloping = crossing.slope() >= LEAST_SLOPE;
        for (pass, sign) in crossing.passes.iter().zip([1.0, -1.0]) {
            if let Some(pinned_m) = self.logs[pass.track].pinned_m {
                known_m += sign * pinned_m;
                continue;
            }
            let of = |unknown: usize| UNKNOWNS * pass.track + unknown;
            let [v_east, v_north] = pass.velocity_mps;
            terms.push((of(HEIGHT), sign));
            if self.wanted.shifts && is_sloping {
                terms.extend([(of(EAST), sign * east), (of(NORTH), sign * north)]);
            }
            if self.wanted.latencies && is_sloping {
                terms.push((of(LATENCY), sign * (east * v_east + north * v_north)));
            }
        }
        (terms, known_m)
    }

    /// Returns the part of the difference of a crossing that some values of the unknowns do not
    /// explain, metres.
    fn left_m(&self, crossing: &Crossing, values: &[f64]) -> f64 {
        let (terms, known_m) = self.sides(crossing);
        let explained: f64 = terms.iter().map(|(unknown, factor)| factor * values[*unknown]).sum();
        crossing.difference_m() - known_m - explained
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::crosslines::crossings;
    use bathyscope_log::support::progress::Progress;

    /// Depth of a bed of hills some 25 m wide with slopes of up to 8 degrees, metres.
    fn bed_m([east, north]: [f64; 2]) -> f64 {
        6.0 + 0.6 * (east / 4.5).sin() * (north / 5.5).cos() + 0.02 * east - 0.01 * north
    }

    /// Noise between -1 and 1 that looks like chance.
    fn noise(number: usize) -> f64 {
        let fraction = (number as f64 * 12.9898).sin() * 43_758.545_3;
        2.0 * (fraction - fraction.floor()) - 1.0
    }

    /// Lines up and down an area of 100 by 100 m, along east or north, with depths of where the
    /// boat truly was: `shift` and the latency are missing in the positions, the height in the
    /// depths.
    fn track(log: usize, along_east: bool, shift: Shift, height_m: f64) -> Vec<TrackDepth> {
        let mut track: Vec<TrackDepth> = Vec::new();
        let speed_mps = 1.5 + 0.4 * log as f64;
        let mut time_s = 0.0;
        for line in 0..9 {
            let across_m = 4.0 + 11.0 * f64::from(line) + log as f64;
            let way = if line % 2 == 0 { 1.0 } else { -1.0 };
            for step in 0..500 {
                let along_m = 0.2 * f64::from(step);
                let along_m = if way > 0.0 { along_m } else { 100.0 - along_m };
                let turn = |along: f64, across: f64| {
                    if along_east { [along, across] } else { [across, along] }
                };
                let at = turn(along_m, across_m);
                let moved = shift.at(turn(way * speed_mps, 0.0));
                let depth_m = bed_m(at) + height_m + 0.03 * noise(track.len() + 7919 * log);
                track.push(TrackDepth {
                    time_s,
                    east_m: at[0] - moved[0],
                    north_m: at[1] - moved[1],
                    depth_m,
                });
                time_s += 0.2 / speed_mps;
            }
            // A gap in time, so that the way from line to line is no part of the track.
            time_s += 60.0;
        }
        track
    }

    fn found(
        tracks: &[Vec<TrackDepth>],
        pinned_m: &[Option<f64>],
        wanted: Wanted,
    ) -> Vec<FoundShift> {
        let logs: Vec<CorrectedLog> = pinned_m
            .iter()
            .map(|pinned_m| CorrectedLog { shift: Shift::default(), pinned_m: *pinned_m })
            .collect();
        let found = settled_offsets(&logs, wanted, |logs| {
            let moved = tracks.iter().zip(logs);
            let moved: Vec<Vec<TrackDepth>> =
                moved.map(|(track, log)| shifted(track, &log.shift)).collect();
            crossings(&moved, &Progress::new())
        });
        found.expect("not cancelled").expect("a solution")
    }

    const BOTH: Wanted = Wanted { shifts: true, latencies: true };

    #[test]
    fn shifts_and_latencies_are_found_from_crossings_over_a_hilly_bed() {
        let shift = |east_m, north_m, latency_s| Shift { east_m, north_m, latency_s };
        // The shifts have a mean of zero; the latencies are known by themselves.
        let truth = [shift(1.2, -0.8, 0.8), shift(-0.9, 0.2, 0.0), shift(-0.3, 0.6, 0.3)];
        let heights_m = [0.2, -0.3, 0.5];
        let tracks: Vec<Vec<TrackDepth>> =
            (0..3).map(|log| track(log, log != 1, truth[log], heights_m[log])).collect();
        let found = found(&tracks, &[None; 3], BOTH);
        for (log, (found, truth)) in found.iter().zip(&truth).enumerate() {
            let off_m =
                (found.shift.east_m - truth.east_m).hypot(found.shift.north_m - truth.north_m);
            assert!(off_m < 0.3 && off_m < 4.0 * found.shift_error_m, "{log} {off_m} {found:?}");
            let off_s = (found.shift.latency_s - truth.latency_s).abs();
            assert!(off_s < 0.15 && off_s < 4.0 * found.latency_error_s, "{log} {off_s} {found:?}");
        }
    }

    #[test]
    fn a_pinned_log_stays_and_holds_the_others() {
        let off = Shift { east_m: 1.5, north_m: -1.0, latency_s: 0.0 };
        let tracks = [track(0, true, Shift::default(), 0.1), track(1, false, off, 0.4)];
        let wanted = Wanted { shifts: true, latencies: false };
        let found = found(&tracks, &[Some(0.1), None], wanted);
        assert_eq!(found[0].shift, Shift::default());
        assert_eq!(found[0].shift_error_m, 0.0);
        let off_m = (found[1].shift.east_m - 1.5).hypot(found[1].shift.north_m + 1.0);
        assert!(off_m < 0.3, "{found:?}");
        assert!(found[1].latency_error_s.is_nan());
    }

    #[test]
    fn a_level_bottom_says_nothing_about_positions() {
        let level = |log: usize| -> Vec<TrackDepth> {
            let off = Shift { east_m: 2.0 * log as f64, ..Shift::default() };
            let track = track(log, log == 0, off, 0.0).into_iter().enumerate();
            track
                .map(|(index, depth)| TrackDepth { depth_m: 5.0 + 0.03 * noise(index), ..depth })
                .collect()
        };
        let found = found(&[level(0), level(1)], &[None; 2], BOTH);
        for found_shift in found {
            let shift = found_shift.shift;
            let is_small = shift.east_m.hypot(shift.north_m) < 0.5 && shift.latency_s.abs() < 0.2;
            assert!(
                is_small && found_shift.shift_error_m > 1.0 && found_shift.latency_error_s > 0.5,
                "{found_shift:?}"
            );
        }
        assert_eq!(position_offsets(&[], &[], BOTH), Some(Vec::new()));
    }
}
