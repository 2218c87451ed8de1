//! Finds the solid, with size and pose, that explains best what the passes recorded of an object. A
//! look is the picture that one pass recorded ([`BoxLevels`]).
//!
//! The search minimises the sum of squares of recorded levels minus predicted ones. A level here is
//! a logarithm of power, in standard deviations of single-look speckle, which has one of 1.28 in ln
//! power for any recorder: `ln(bottom + strength * object) / 1.28`, no lower than the darkest
//! shadow. Strength and darkness belong to a pass, size and heading to the object, and each pass
//! may place the object a little elsewhere, because of its receiver's error. The parameters with
//! which the search begins are derived from the box of the object.

use super::levels::BoxLevels;
use super::predict::PosedSolid;
use super::problem::{
    DARKNESS, FitState, Numbers, OF_LOOK, OF_OBJECT, OutlineEdge, Problem, STRENGTH,
};
use super::solid::ShapeKind;
use crate::targets::Target;
use std::f64::consts::{PI, TAU};

/// The best fit of one kind of solid.
#[derive(Clone, Debug)]
pub(super) struct ShapeFit {
    pub(super) kind: ShapeKind,
    /// Parameters of the object.
    of_object: Numbers,
    /// The solid as placed in each of the looks.
    pub(super) posed: Vec<PosedSolid>,
    /// Remaining sum of squares.
    pub(super) cost: f64,
}

/// Greatest number of rounds of the search.
const ROUNDS: usize = 40;

/// A search in a picture that is coarser than the look: there, a solid that is a little off still
/// overlaps the object in part, and a trial takes less time.
struct CoarseSearch {
    /// Approximate number of pings and bins of the picture.
    size: [usize; 2],
    /// Number of best states that are followed and number of rounds, for each stage.
    followed: &'static [(usize, usize)],
    /// Number of states that are kept at the end.
    kept: usize,
    /// Least gain of a kind that is kept for a finer picture, as a share of the gain of the best
    /// kind.
    worth_fitting: f64,
}

/// Coarse searches, from coarse to fine. The first needs many states: only few initial guesses lead
/// to a boat that is askew to the track.
const COARSE: [CoarseSearch; 2] = [
    CoarseSearch {
        size: [12, 24],
        followed: &[(80, 1), (20, 3), (6, 5)],
        kept: 4,
        worth_fitting: 0.6,
    },
    CoarseSearch { size: [24, 48], followed: &[(3, 3), (1, 8)], kept: 1, worth_fitting: 0.9 },
];
/// First changes of the parameters in the full picture, as a share of [`FitState::steps`]: the
/// parameters are nearly right.
const FINE_STEPS: f64 = 0.5;

/// Fits the kinds of solids to looks, each with its initial guess, and returns those that may
/// explain enough, the best first. Each kind is fitted first to each of the first two looks alone,
/// which should show the object best, and from there to all looks.
pub(super) fn fits(looks: &[BoxLevels], starts: &[InitialGuess]) -> Vec<ShapeFit> {
    let mut best: Vec<ShapeFit> = Vec::new();
    for first in 0..looks.len().min(2) {
        let kinds = ShapeKind::ALL.into_iter();
        let all = kinds.map(|kind| (kind, beginnings(kind, &starts[first])));
        let fitted =
            COARSE.iter().fold(all.collect(), |kinds, search| search.fits(&looks[first], kinds));
        for (kind, beginnings) in fitted {
            for beginning in beginnings {
                let fitted = fit(kind, looks, starts, first, beginning);
                match best.iter_mut().find(|other| other.kind == kind) {
                    Some(other) if fitted.cost < other.cost => *other = fitted,
                    Some(_) => {}
                    None => best.push(fitted),
                }
            }
        }
    }
    best.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    best
}

/// Fits one kind to one of the looks, from parameters that are nearly right, and from there to all
/// looks.
fn fit(
    kind: ShapeKind,
    looks: &[BoxLevels],
    starts: &[InitialGuess],
    first: usize,
    beginning: Numbers,
) -> ShapeFit {
    let problem = Problem::new(kind, &looks[first..=first]);
    let mut alone = FitState::new(&problem, beginning).with_steps_times(FINE_STEPS);
    search(&problem, &mut alone, ROUNDS);
    let (of_object, of_look) = alone.numbers.split_at(OF_OBJECT);
    let mut numbers = of_object.to_vec();
    for (index, start) in starts.iter().enumerate() {
        if index == first { numbers.extend(of_look) } else { numbers.extend(start.of_look()) }
    }
    let problem = Problem::new(kind, looks);
    let mut best = FitState::new(&problem, numbers);
    if looks.len() > 1 {
        search(&problem, &mut best, ROUNDS);
    }
    ShapeFit {
        kind,
        posed: (0..looks.len())
            .map(|look| problem.posed(&best.numbers, look).with_heading_in_range())
            .collect(),
        cost: best.cost,
        of_object: best.numbers[..OF_OBJECT].to_vec(),
    }
}

impl ShapeFit {
    /// Places the solid, with its size and heading, in a look that it was not fitted to.
    pub(super) fn placed_in(&self, look: &BoxLevels, start: &InitialGuess) -> PosedSolid {
        let problem = Problem::of_known(self.kind, std::slice::from_ref(look));
        let numbers = [&self.of_object[..], &start.of_look()].concat();
        let mut state = FitState::new(&problem, numbers);
        search(&problem, &mut state, ROUNDS);
        problem.posed(&state.numbers, 0).with_heading_in_range()
    }
}

/// Kinds, each with parameters to begin with.
type Beginnings = Vec<(ShapeKind, Vec<Numbers>)>;

impl CoarseSearch {
    /// Returns the kinds that may explain a look, each with its best parameters.
    fn fits(&self, look: &BoxLevels, kinds: Beginnings) -> Beginnings {
        let coarse = [look.coarser(self.size)];
        let mut of_kinds: Vec<(ShapeKind, Vec<FitState>)> = (kinds.into_iter())
            .map(|(kind, beginnings)| {
                let problem = Problem::new(kind, &coarse);
                let states = beginnings.into_iter();
                let mut states: Vec<FitState> =
                    states.map(|numbers| FitState::new(&problem, numbers)).collect();
                for (most, rounds) in self.followed {
                    follow(&problem, &mut states, *most, *rounds);
                }
                states.truncate(self.kept);
                (kind, states)
            })
            .collect();
        let bare = coarse[0].squares() * coarse[0].together as f64;
        let gains = of_kinds.iter().map(|(_, states)| bare - states[0].cost);
        // If no kind gains in so coarse a picture, only the best one is kept.
        let most = gains.fold(f64::NEG_INFINITY, f64::max);
        let least = most.min(self.worth_fitting * most);
        of_kinds.retain(|(_, states)| bare - states[0].cost >= least);
        let numbers =
            |states: Vec<FitState>| states.into_iter().map(|state| state.numbers).collect();
        of_kinds.into_iter().map(|(kind, states)| (kind, numbers(states))).collect()
    }
}

/// Changes one parameter after the other, with a larger step after an improvement and a smaller one
/// otherwise, and then repeats the change of the whole round (Hooke and Jeeves). No derivatives are
/// used, because predictions have kinks.
fn search(problem: &Problem<'_>, state: &mut FitState, rounds: usize) {
    let mut trial = state.clone();
    for _ in 0..rounds {
        let before = state.numbers.clone();
        for number in (0..before.len()).filter(|number| !problem.is_fixed(*number)) {
            let step = state.steps[number];
            let better = try_both_ways(state, &mut trial, step, |trial, by| {
                problem.change(trial, number, by);
            });
            state.steps[number] = step * if better { 1.3 } else { 0.5 };
        }
        for (index, edge) in OutlineEdge::ALL.into_iter().enumerate() {
            let step = state.edge_steps[index];
            let move_edge = |trial: &mut FitState, by: f64| problem.move_edge(trial, edge, by);
            let better = step > 0.0 && try_both_ways(state, &mut trial, step, move_edge);
            state.edge_steps[index] = step * if better { 1.3 } else { 0.5 };
        }
        // If the round changed nothing, there is no direction to continue in.
        if state.numbers != before {
            go_on(problem, state, &mut trial, &before);
        }
        if state.is_settled() {
            break;
        }
    }
}

/// Moves all numbers once more as they have moved since `before`, if that lowers the cost.
fn go_on(problem: &Problem<'_>, state: &mut FitState, trial: &mut FitState, before: &[f64]) {
    trial.copy_from(state);
    for (number, before) in trial.numbers.iter_mut().zip(before) {
        *number += *number - before;
    }
    problem.all(trial);
    if trial.cost < state.cost {
        std::mem::swap(state, trial);
    }
}

/// Changes a state by a step, or by the same step in the other direction, if that lowers the cost.
/// Returns true if the state was changed.
fn try_both_ways(
    state: &mut FitState,
    trial: &mut FitState,
    step: f64,
    change: impl Fn(&mut FitState, f64),
) -> bool {
    let better = [step, -step].into_iter().any(|by| {
        trial.copy_from(state);
        change(trial, by);
        trial.cost < state.cost
    });
    if better {
        std::mem::swap(state, trial);
    }
    better
}

/// Searches on from the `most` best states for some rounds, and drops the others. The states are
/// then sorted, the best first.
fn follow(problem: &Problem<'_>, states: &mut Vec<FitState>, most: usize, rounds: usize) {
    let by_cost = |a: &FitState, b: &FitState| a.cost.total_cmp(&b.cost);
    states.sort_by(by_cost);
    states.truncate(most);
    for state in &mut *states {
        search(problem, state, rounds);
    }
    states.sort_by(by_cost);
}

/// Number of initial headings over half a circle.
const HEADINGS: usize = 8;
/// Offsets outward from the box's place at which a search begins, as shares of the box.
const OUTWARD: [f64; 3] = [-0.15, 0.0, 0.15];

/// Logarithm of the ratio of two steepnesses above which a search begins with both.
const STEEPNESS_APART: f64 = 0.3;

/// Initial guess of an object from one of its boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct InitialGuess {
    /// Place of the object, metres east and north.
    place_m: [f64; 2],
    /// Direction of the track, radians clockwise from north.
    heading_rad: f64,
    /// Extents along and across the track, metres.
    along_m: f64,
    across_m: f64,
    /// Extent of the box across the track on a level bottom, its shadow included, metres.
    box_m: f64,
    /// Unit vector (east, north) across the track, to the side of the look.
    outward: [f64; 2],
    /// Height, metres; NaN without a visible shadow.
    height_m: f64,
}

impl InitialGuess {
    /// Creates the guess from a placed box and its look.
    pub(super) fn of(target: &Target, look: &BoxLevels) -> Self {
        Self {
            place_m: [target.east_m, target.north_m],
            heading_rad: target.heading_rad,
            along_m: target.length_m,
            across_m: target.width_m,
            box_m: look.across_m(),
            outward: look.pings.first().map_or([0.0; 2], |ping| ping.outward),
            height_m: height_m(target),
        }
    }

    /// Returns the initial parameters of a look.
    fn of_look(&self) -> [f64; OF_LOOK] {
        let [east_m, north_m] = self.place_m;
        [east_m, north_m, STRENGTH[0], DARKNESS, 0.0]
    }
}

/// Returns the initial height: that of the box, or, if its shadow is not whole enough for a height,
/// that of the shadow in the middle of the box.
fn height_m(target: &Target) -> f64 {
    let in_middle_m = || {
        let [start_m, end_m] = target.parts?.shadow_m?;
        Some(target.altitude_m * (end_m - start_m) / end_m)
    };
    if target.height_m.is_finite() { target.height_m } else { in_middle_m().unwrap_or(f64::NAN) }
}

/// Returns initial parameters: the solid has a typical slenderness, its length follows from the
/// extents along the track, across it, or both, and it is in the middle of the picture or a little
/// nearer or farther.
fn beginnings(kind: ShapeKind, start: &InitialGuess) -> Vec<Numbers> {
    let usual = kind.usual();
    let slenderness = usual.typical_slenderness;
    let headings = match kind {
        ShapeKind::Tyre => 1,
        _ if kind.is_boat() => 2 * HEADINGS,
        _ => HEADINGS,
    };
    let turn_rad = if kind.is_boat() { TAU } else { PI };
    let mut all = Vec::new();
    for heading in 0..headings {
        let off_rad = turn_rad * heading as f64 / headings as f64;
        let (sin, cos) = (off_rad.sin().abs(), off_rad.cos().abs());
        let by_along_m = start.along_m.max(0.2) / (cos + sin / slenderness);
        let by_across_m = start.across_m.max(0.1) / (sin + cos / slenderness);
        // About half of a box is shadow.
        let by_box_m = 0.6 * start.box_m / (sin + cos / slenderness);
        let both_m = (by_along_m * by_across_m).sqrt();
        for length_m in [by_along_m, by_across_m, both_m, by_box_m] {
            let length_m = length_m.clamp(usual.length_m[0], usual.length_m[1]);
            let heading_rad = start.heading_rad + off_rad;
            let steepnesses = steepnesses(kind, start.height_m * slenderness / length_m);
            for (steepness, out) in
                steepnesses.flat_map(|steepness| OUTWARD.map(|out| (steepness, out)))
            {
                let sizes = [length_m.ln(), slenderness.ln(), steepness.ln()];
                let mut of_look = start.of_look();
                let out_m = out * start.box_m;
                of_look[0] += out_m * start.outward[0];
                of_look[1] += out_m * start.outward[1];
                all.push([&[heading_rad], &sizes[..], &[0.0], &of_look].concat());
            }
        }
    }
    all
}

/// Returns initial steepnesses: that of the shadow, if it is known. The shadow of a boat may be
/// that of a thwart or of one end, so the search for a boat begins with a usual steepness as well.
fn steepnesses(kind: ShapeKind, by_shadow: f64) -> impl Iterator<Item = f64> {
    let [low, high] = kind.usual().steepness;
    let usual = (low * high).sqrt();
    let known = (by_shadow > 0.0).then(|| by_shadow.clamp(low, high));
    let is_far = |known: f64| (known / usual).ln().abs() > STEEPNESS_APART;
    let is_other = known.is_none_or(|known| kind.is_boat() && is_far(known));
    known.into_iter().chain(is_other.then_some(usual))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::targets::shape::levels::PingLevels;
    use crate::targets::shape::predict::{Predicted, predict};
    use crate::targets::shape::problem::SPECKLE_LN;
    use crate::targets::shape::solid::Solid;

    const BINS: usize = 96;

    /// Creates a look to starboard of a boat that sails north, 3 m above the bottom, with nothing
    /// but speckle.
    fn bare() -> BoxLevels {
        let mut state = 1_u32;
        let mut speckle = || {
            // Each number is the sum of four uniform numbers between -1 and 1, each of variance
            // 1/3.
            let sum: f32 = (0..4)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 8) as f32 / (1 << 23) as f32 - 1.0
                })
                .sum();
            sum * (3.0_f32 / 4.0).sqrt()
        };
        let mut ping = |index: usize| PingLevels {
            ping: index,
            boat_m: [0.0, 0.14 * (index as f64 - 20.0)],
            outward: [1.0, 0.0],
            levels: (0..BINS).map(|_| speckle()).collect(),
        };
        BoxLevels::of_pings((0..41).map(&mut ping).collect(), 0.14, [4.0, 0.06])
    }

    #[test]
    fn a_boat_that_lies_askew_to_the_track_is_found_in_its_speckle() {
        let truth = PosedSolid {
            solid: Solid {
                kind: ShapeKind::Hull,
                length_m: 5.0,
                width_m: 1.6,
                height_m: 0.6,
                list: 0.0,
            },
            east_m: 5.4,
            north_m: 0.2,
            heading_rad: 2.3,
        };
        let mut look = bare();
        let mut predicted = Predicted::default();
        predict(&look, &truth, &mut predicted);
        let both = predicted.bottom.iter().zip(&predicted.object);
        let levels = look.pings.iter_mut().flat_map(|ping| &mut ping.levels);
        for (level, (bottom, object)) in levels.zip(both) {
            *level += (bottom + 4.0 * object).max(0.1).ln() / SPECKLE_LN as f32;
        }
        // The guess from the box: extents along and across the track that include echo and shadow,
        // and a place between the two.
        let start = InitialGuess {
            place_m: [5.8, 0.0],
            heading_rad: 0.0,
            along_m: 4.6,
            across_m: 3.0,
            box_m: look.across_m(),
            outward: [1.0, 0.0],
            height_m: f64::NAN,
        };
        let fits = fits(&[look], &[start]);
        let best = &fits[0];
        assert_eq!(best.kind, ShapeKind::Hull);
        let found = best.posed[0];
        let off = |value: f64, truth: f64| (value / truth - 1.0).abs();
        assert!(off(found.solid.length_m, 5.0) < 0.05, "{found:?}");
        assert!(off(found.solid.width_m, 1.6) < 0.1, "{found:?}");
        assert!(off(found.solid.height_m, 0.6) < 0.15, "{found:?}");
        assert!((found.heading_rad - 2.3).abs() < 0.05, "{found:?}");
        assert!(f64::hypot(found.east_m - 5.4, found.north_m - 0.2) < 0.15);
        assert!(fits.windows(2).all(|pair| pair[0].cost <= pair[1].cost));
    }
}
