//! Finds the solid, with size and pose, that explains best what the passes recorded of an object.
//!
//! What is sought is the least sum of squares of recorded levels minus predicted ones. A level is a
//! logarithm of power here, in standard deviations of single-look speckle, which has one of 1.28 in
//! ln power whatever the recorder: `ln(bottom + strength * object) / 1.28`, no lower than the
//! darkest shadow. Strength and darkness belong to a pass, size and heading to the object, and each
//! pass may place it a little elsewhere, as its receiver did.

use super::initial_guess::{InitialGuess, beginnings};
use super::levels::BoxLevels;
use super::predict::PosedSolid;
use super::problem::{FitState, Numbers, OF_OBJECT, Problem};
use super::search::{follow, search};
use super::solid::ShapeKind;

/// A kind as it fits best.
#[derive(Clone, Debug)]
pub(super) struct ShapeFit {
    pub(super) kind: ShapeKind,
    /// The numbers of the object.
    of_object: Numbers,
    /// The solid as each of the looks places it.
    pub(super) posed: Vec<PosedSolid>,
    /// Sum of squares that is left.
    pub(super) cost: f64,
}

/// Rounds of the search at most.
const ROUNDS: usize = 40;

/// A search in a picture that is coarser than the look: there a solid that lies a little off is
/// right in part, and a trial costs less.
struct CoarseSearch {
    /// Pings and bins of the picture, about.
    size: [usize; 2],
    /// Number of states that are followed (those that explain most), and of rounds, for each stage.
    followed: &'static [(usize, usize)],
    /// Number of them that are kept.
    kept: usize,
    /// A kind that gains less than this share of what the best gains here is no rival in a finer
    /// picture.
    worth_fitting: f64,
}

/// Coarse searches, from coarse to fine. A boat that lies askew to the track is found from few of
/// the beginnings.
const COARSE: [CoarseSearch; 2] = [
    CoarseSearch {
        size: [12, 24],
        followed: &[(80, 1), (20, 3), (6, 5)],
        kept: 4,
        worth_fitting: 0.6,
    },
    CoarseSearch { size: [24, 48], followed: &[(3, 3), (1, 8)], kept: 1, worth_fitting: 0.9 },
];
/// First changes of the numbers in the whole picture, as a share of the first steps: the numbers
/// are nearly right.
const FINE_STEPS: f64 = 0.5;

/// Fits all kinds to looks, of which each has its start, and gives back those that explain enough
/// to be told apart, the best first. Each kind is fitted to each of the first two looks, which are
/// to show the object best, and from there to all.
pub(super) fn fits(looks: &[BoxLevels], starts: &[InitialGuess]) -> Vec<ShapeFit> {
    let mut best: Vec<ShapeFit> = Vec::new();
    for first in 0..looks.len().min(2) {
        let kinds = ShapeKind::ALL.into_iter();
        let all = kinds.map(|kind| (kind, beginnings(kind, &starts[first])));
        let fitted =
            COARSE.iter().fold(all.collect(), |kinds, search| search.fits(&looks[first], kinds));
        let beginnings = fitted.into_iter().flat_map(|(kind, beginnings)| {
            let beginnings = beginnings.into_iter();
            beginnings.map(move |one| (kind, one))
        });
        for (kind, beginning) in beginnings {
            let fitted = fit(kind, looks, starts, first, beginning);
            match best.iter_mut().find(|other| other.kind == kind) {
                Some(other) if fitted.cost < other.cost => *other = fitted,
                Some(_) => {}
                None => best.push(fitted),
            }
        }
    }
    best.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    best
}

/// Fits one kind to one of the looks from a beginning that is nearly right, and from there to all.
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
    /// The solid as a look places it that it was not fitted to.
    pub(super) fn placed_in(&self, look: &BoxLevels, start: &InitialGuess) -> PosedSolid {
        let problem = Problem::of_known(self.kind, std::slice::from_ref(look));
        let numbers = [&self.of_object[..], &start.of_look()].concat();
        let mut state = FitState::new(&problem, numbers);
        search(&problem, &mut state, ROUNDS);
        problem.posed(&state.numbers, 0).with_heading_in_range()
    }
}

/// Kinds, each with numbers to begin with.
type Beginnings = Vec<(ShapeKind, Vec<Numbers>)>;

impl CoarseSearch {
    /// The kinds that may explain a look, each with what explains most.
    fn fits(&self, look: &BoxLevels, kinds: Beginnings) -> Beginnings {
        let coarse = [look.coarser(self.size)];
        let mut of_kinds: Vec<(ShapeKind, Vec<FitState>)> = (kinds.into_iter())
            .map(|(kind, beginnings)| {
                let problem = Problem::new(kind, &coarse);
                let states = beginnings.into_iter();
                let mut states: Vec<FitState> =
                    states.map(|one| FitState::new(&problem, one)).collect();
                for (most, rounds) in self.followed {
                    follow(&problem, &mut states, *most, *rounds);
                }
                states.truncate(self.kept);
                (kind, states)
            })
            .collect();
        let bare = coarse[0].squares() * coarse[0].together as f64;
        let gains = of_kinds.iter().map(|(_, states)| bare - states[0].cost);
        // Where none gains in so coarse a picture, the best goes on.
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

    /// A look to starboard of a boat that sails north, 3 m above the bottom, of nothing but
    /// speckle.
    fn bare() -> BoxLevels {
        let mut state = 1_u32;
        let mut speckle = || {
            // Sums of four even shares between -1 and 1, of which each has a variance of 1/3.
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
        // What the box says: extents along and across the track that hold echo and shadow, and a
        // place between the two.
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
