//! Finds the solid, with size and pose, that explains best what the passes recorded of an object. A
//! look is the picture that one pass recorded ([`BoxLevels`]).
//!
//! The search minimises the sum of squares of recorded levels minus predicted ones. A level here is
//! a logarithm of power, in standard deviations of single-look speckle, which has one of 1.28 in ln
//! power for any recorder: `ln(bottom + strength * object) / 1.28`, no lower than the darkest
//! shadow. Strength and darkness belong to a pass, size and heading to the object, and each pass
//! may place the object a little elsewhere, because of its receiver's error.

use super::initial_guess::{InitialGuess, beginnings};
use super::levels::BoxLevels;
use super::predict::PosedSolid;
use super::problem::{FitState, Numbers, OF_OBJECT, Problem};
use super::search::{follow, search};
use super::solid::ShapeKind;

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
