//! Which solid, in which size and pose, explains what the passes recorded of an object.
//!
//! What is sought is the least sum of squares of recorded levels minus predicted ones. A level is a logarithm of power here, in standard
//! deviations of single-look speckle, which has one of 1.28 in ln power whatever the recorder: `ln(bottom + strength * object) / 1.28`,
//! no lower than the darkest shadow. Strength and darkness belong to a pass, size and heading to the object, and each pass may place it a
//! little elsewhere, as its receiver did.

use super::levels::BoxLevels;
use super::predict::{PosedSolid, Predicted, predict};
use super::solid::{ShapeKind, Solid};
use crate::detection::targets::Target;
use std::f64::consts::{PI, TAU};

/// What is known of an object before, from one of its boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    /// Its place, metres east and north.
    pub(super) place_m: [f64; 2],
    /// Direction of the track, radians clockwise from north.
    pub(super) heading_rad: f64,
    /// Extents along and across the track, metres.
    pub(super) along_m: f64,
    pub(super) across_m: f64,
    /// Extent of the box across the track on a level bottom, its shadow included, metres.
    pub(super) box_m: f64,
    /// Height, metres; NaN where it is not known.
    pub(super) height_m: f64,
}

impl Start {
    /// Of a box that is placed, and its look.
    pub(super) fn of(target: &Target, look: &BoxLevels) -> Self {
        Self {
            place_m: [target.east_m, target.north_m],
            heading_rad: target.heading_rad,
            along_m: target.length_m,
            across_m: target.width_m,
            box_m: look.across_m(),
            height_m: target.height_m,
        }
    }

    /// The numbers of a look to begin with.
    fn of_look(&self) -> [f64; OF_LOOK] {
        let [east_m, north_m] = self.place_m;
        [east_m, north_m, STRENGTH[0], DARKNESS, 0.0]
    }
}

/// A kind as it fits best.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    kind: ShapeKind,
    /// The numbers of the object.
    of_object: Numbers,
    /// The solid as each of the looks places it.
    pub(super) posed: Vec<PosedSolid>,
    /// Sum of squares that is left.
    pub(super) cost: f64,
}

/// Standard deviation of ln power of single-look speckle.
const SPECKLE_LN: f64 = 1.283;
/// Headings that are tried at first over half a circle.
const HEADINGS: usize = 8;
/// Rounds of the search at most.
const ROUNDS: usize = 40;
/// How many beginnings of each length, those that explain most, are followed over how many rounds, and how many of all to the end.
const FOLLOWED: (usize, usize, usize) = (2, 5, 2);
/// Beyond what is usual of a kind a logarithm of size counts against it as so many standard deviations.
const BEYOND_USUAL: f64 = 0.03;
/// Most that a boat lists ([`Solid::list`]): its keel lies beside it then.
const MOST_LIST: f64 = 0.4;
/// Strength over the bottom in ln power, expected and its standard deviation: 6 dB each. Darkness to begin with: 13 dB.
const STRENGTH: [f64; 2] = [1.38, 1.4];
const DARKNESS: f64 = -3.0;

/// Numbers of an object: heading, ln length, ln slenderness, ln steepness, list; then of each look east, north, strength, darkness, and how
/// much lighter the dark is at the far end of it.
type Numbers = Vec<f64>;
const OF_OBJECT: usize = 5;
const OF_LOOK: usize = 5;
/// How far each is changed at first.
const FIRST_STEPS: [f64; OF_OBJECT + OF_LOOK] = [0.2, 0.2, 0.2, 0.2, 0.1, 0.2, 0.2, 0.7, 0.7, 0.7];
/// Smallest changes of place and of ln length that are worth another round.
const LEAST_STEP: f64 = 0.01;

/// Fits one kind to looks, of which each has its start: to each of the first two, which are to show the object best, and from there to all.
pub(super) fn fit(kind: ShapeKind, looks: &[BoxLevels], starts: &[Start]) -> Fit {
    let problem = Problem::new(kind, looks);
    let from = |first: usize| {
        let alone = fit_alone(kind, &looks[first..=first], &starts[first]);
        let (of_object, of_look) = alone.numbers.split_at(OF_OBJECT);
        let mut numbers = of_object.to_vec();
        for (index, start) in starts.iter().enumerate() {
            match index == first {
                true => numbers.extend(of_look),
                false => numbers.extend(start.of_look()),
            }
        }
        let mut state = State::new(&problem, numbers);
        if looks.len() > 1 {
            search(&problem, &mut state, ROUNDS);
        }
        state
    };
    let mut best = from(0);
    if looks.len() > 1 {
        let other = from(1);
        if other.cost < best.cost {
            best = other;
        }
    }
    Fit {
        kind,
        posed: (0..looks.len())
            .map(|look| problem.posed(&best.numbers, look).with_heading_in_range())
            .collect(),
        cost: best.cost,
        of_object: best.numbers[..OF_OBJECT].to_vec(),
    }
}

impl Fit {
    /// The solid as a look places it that it was not fitted to.
    pub(super) fn placed_in(&self, look: &BoxLevels, start: &Start) -> PosedSolid {
        let problem = Problem {
            is_object_known: true,
            ..Problem::new(self.kind, std::slice::from_ref(look))
        };
        let numbers = [&self.of_object[..], &start.of_look()].concat();
        let mut state = State::new(&problem, numbers);
        search(&problem, &mut state, ROUNDS);
        problem.posed(&state.numbers, 0).with_heading_in_range()
    }
}

/// Fits one kind to one look.
fn fit_alone(kind: ShapeKind, look: &[BoxLevels], start: &Start) -> State {
    let problem = Problem::new(kind, look);
    let by_cost = |a: &State, b: &State| a.cost.total_cmp(&b.cost);
    let mut all = Vec::new();
    for beginnings in beginnings(kind, start) {
        let states = beginnings.into_iter();
        let mut states: Vec<State> = states.map(|one| State::new(&problem, one)).collect();
        states.sort_by(by_cost);
        // Of each length some: a small solid in the right place explains more at first than a large one in a wrong heading.
        states.truncate(FOLLOWED.0);
        all.extend(states);
    }
    for (most, rounds) in [(all.len(), FOLLOWED.1), (FOLLOWED.2, ROUNDS)] {
        all.truncate(most);
        for state in &mut all {
            search(&problem, state, rounds);
        }
        all.sort_by(by_cost);
    }
    all.swap_remove(0)
}

/// Sizes and headings to begin with: of a typical slenderness, as long as the extents along the track, across it, or both say; those of one
/// such length together.
fn beginnings(kind: ShapeKind, start: &Start) -> [Vec<Numbers>; 4] {
    let usual = kind.usual();
    let slenderness = usual.typical_slenderness;
    let headings = match kind {
        ShapeKind::Tyre => 1,
        _ if kind.is_boat() => 2 * HEADINGS,
        _ => HEADINGS,
    };
    let turn_rad = if kind.is_boat() { TAU } else { PI };
    let mut all: [Vec<Numbers>; 4] = Default::default();
    for heading in 0..headings {
        let off_rad = turn_rad * heading as f64 / headings as f64;
        let (sin, cos) = (off_rad.sin().abs(), off_rad.cos().abs());
        let by_along_m = start.along_m.max(0.2) / (cos + sin / slenderness);
        let by_across_m = start.across_m.max(0.1) / (sin + cos / slenderness);
        // Of a box half is shadow, more or less.
        let by_box_m = 0.6 * start.box_m / (sin + cos / slenderness);
        let both_m = (by_along_m * by_across_m).sqrt();
        let lengths_m = [by_along_m, by_across_m, both_m, by_box_m];
        for (length_m, into) in lengths_m.into_iter().zip(&mut all) {
            let length_m = length_m.clamp(usual.length_m[0], usual.length_m[1]);
            let [low, high] = usual.steepness;
            let steepness = match start.height_m > 0.0 {
                true => (start.height_m * slenderness / length_m).clamp(low, high),
                false => (low * high).sqrt(),
            };
            let heading_rad = start.heading_rad + off_rad;
            let sizes = [length_m.ln(), slenderness.ln(), steepness.ln()];
            into.push([&[heading_rad], &sizes[..], &[0.0], &start.of_look()].concat());
        }
    }
    all
}

/// Looks, and the kind that is fitted to them.
struct Problem<'a> {
    kind: ShapeKind,
    looks: &'a [BoxLevels],
    /// Size and heading are what they are: only the numbers of the looks are sought.
    is_object_known: bool,
}

/// Numbers with what they predict.
struct State {
    numbers: Numbers,
    /// How far each is changed next.
    steps: Vec<f64>,
    predicted: Vec<Predicted>,
    /// Sum of squares of each look.
    costs: Vec<f64>,
    cost: f64,
}

impl Clone for State {
    fn clone(&self) -> Self {
        Self {
            numbers: self.numbers.clone(),
            steps: self.steps.clone(),
            predicted: self.predicted.clone(),
            costs: self.costs.clone(),
            cost: self.cost,
        }
    }

    /// Into the memory that is there: the search does little else.
    fn clone_from(&mut self, other: &Self) {
        self.numbers.clone_from(&other.numbers);
        self.steps.clone_from(&other.steps);
        self.costs.clone_from(&other.costs);
        self.cost = other.cost;
        for (own, other) in self.predicted.iter_mut().zip(&other.predicted) {
            own.bottom.clone_from(&other.bottom);
            own.object.clone_from(&other.object);
        }
    }
}

impl State {
    fn new(problem: &Problem<'_>, numbers: Numbers) -> Self {
        let first_step = |number: usize| match number.checked_sub(OF_OBJECT) {
            None => FIRST_STEPS[number],
            Some(of_looks) => FIRST_STEPS[OF_OBJECT + of_looks % OF_LOOK],
        };
        let mut state = Self {
            steps: (0..numbers.len())
                .map(|number| match problem.is_fixed(number) {
                    true => 0.0,
                    false => first_step(number),
                })
                .collect(),
            numbers,
            predicted: vec![Predicted::default(); problem.looks.len()],
            costs: vec![0.0; problem.looks.len()],
            cost: 0.0,
        };
        problem.all(&mut state);
        state
    }

    /// Whether places and length change by so little that another round is not worth it.
    fn is_settled(&self) -> bool {
        let looks = self.steps[OF_OBJECT..].chunks_exact(OF_LOOK);
        let farthest = looks.map(|look| look[0].max(look[1]));
        farthest.fold(self.steps[1], f64::max) < LEAST_STEP
    }
}

impl<'a> Problem<'a> {
    fn new(kind: ShapeKind, looks: &'a [BoxLevels]) -> Self {
        Self {
            kind,
            looks,
            is_object_known: false,
        }
    }

    /// The solid as a look places it.
    fn posed(&self, numbers: &[f64], look: usize) -> PosedSolid {
        let length_m = numbers[1].exp();
        let width_m = length_m / numbers[2].exp();
        let of_look = &numbers[OF_OBJECT + look * OF_LOOK..];
        PosedSolid {
            solid: Solid {
                kind: self.kind,
                length_m,
                width_m,
                height_m: width_m * numbers[3].exp(),
                list: numbers[4].clamp(-MOST_LIST, MOST_LIST),
            },
            east_m: of_look[0],
            north_m: of_look[1],
            heading_rad: numbers[0],
        }
    }

    /// Predicts all looks.
    fn all(&self, state: &mut State) {
        for look in 0..self.looks.len() {
            self.place(state, look);
        }
        self.sum(state);
    }

    /// Predicts one look.
    fn place(&self, state: &mut State, look: usize) {
        let posed = self.posed(&state.numbers, look);
        predict(&self.looks[look], &posed, &mut state.predicted[look]);
        self.weigh(state, look);
    }

    /// Holds one look against what is predicted.
    fn weigh(&self, state: &mut State, look: usize) {
        let of_look = &state.numbers[OF_OBJECT + look * OF_LOOK..];
        let strength = of_look[2].exp() as f32;
        let darkest = [of_look[3], of_look[4]];
        state.costs[look] = squares(&self.looks[look], &state.predicted[look], strength, darkest);
    }

    fn sum(&self, state: &mut State) {
        state.cost = state.costs.iter().sum::<f64>() + self.unusual(&state.numbers);
    }

    /// How far it is from what is usual, in squared standard deviations.
    fn unusual(&self, numbers: &[f64]) -> f64 {
        let usual = self.kind.usual();
        let limits = [
            (numbers[1], usual.length_m),
            (numbers[1] - numbers[2], usual.width_m),
            (numbers[2], usual.slenderness),
            (numbers[3], usual.steepness),
        ];
        let sizes = limits.iter().map(|(number, [low, high])| {
            let beyond = (low.ln() - number).max(number - high.ln()).max(0.0);
            (beyond / BEYOND_USUAL).powi(2)
        });
        let looks = numbers[OF_OBJECT..].chunks_exact(OF_LOOK);
        let strengths = looks
            .clone()
            .map(|look| ((look[2] - STRENGTH[0]) / STRENGTH[1]).powi(2));
        let lighter = looks.map(|look| look[4].powi(2));
        sizes.sum::<f64>() + strengths.sum::<f64>() + lighter.sum::<f64>()
    }

    /// Whether a number is not sought: one of what is known, or none of this kind, which has no heading, or whose width follows from its
    /// length or height.
    fn is_fixed(&self, number: usize) -> bool {
        match self.kind {
            _ if self.is_object_known && number < OF_OBJECT => true,
            ShapeKind::Hull | ShapeKind::UpturnedHull => false,
            _ if number == 4 => true,
            ShapeKind::Tyre => number == 0 || number == 2,
            ShapeKind::Cylinder => number == 3,
            ShapeKind::Block | ShapeKind::Boulder => false,
        }
    }

    /// Changes one number and predicts what depends on it.
    fn change(&self, state: &mut State, number: usize, by: f64) {
        state.numbers[number] += by;
        match number.checked_sub(OF_OBJECT) {
            None => self.all(state),
            Some(of_looks) => {
                let look = of_looks / OF_LOOK;
                match of_looks % OF_LOOK {
                    0 | 1 => self.place(state, look),
                    _ => self.weigh(state, look),
                }
                self.sum(state);
            }
        }
    }
}

/// Changes one number after the other, farther where that helped and less far where it did not, and goes on in the direction in which a
/// round has gone (Hooke and Jeeves): predictions have kinks, so nothing is differentiated.
fn search(problem: &Problem<'_>, state: &mut State, rounds: usize) {
    let mut trial = state.clone();
    for _ in 0..rounds {
        let before = state.numbers.clone();
        for number in (0..before.len()).filter(|number| !problem.is_fixed(*number)) {
            let step = state.steps[number];
            let better = [step, -step].into_iter().any(|by| {
                trial.clone_from(state);
                problem.change(&mut trial, number, by);
                trial.cost < state.cost
            });
            if better {
                std::mem::swap(state, &mut trial);
            }
            state.steps[number] = step * if better { 1.3 } else { 0.5 };
        }
        trial.clone_from(state);
        for (number, before) in trial.numbers.iter_mut().zip(&before) {
            *number += *number - before;
        }
        problem.all(&mut trial);
        if trial.cost < state.cost {
            std::mem::swap(state, &mut trial);
        }
        if state.is_settled() {
            break;
        }
    }
}

/// Sum of the squares of what is recorded minus what is predicted.
fn squares(look: &BoxLevels, predicted: &Predicted, strength: f32, darkest: [f64; 2]) -> f64 {
    let [dark_ln, lighter_ln] = darkest;
    // The noise that fills a shadow does not fade with the bottom.
    let darkest: Vec<f32> = (0..look.bins)
        .map(|bin| (dark_ln + lighter_ln * bin as f64 / look.bins as f64).exp() as f32)
        .collect();
    let scale = SPECKLE_LN.recip() as f32;
    let bottom = predicted.bottom.chunks_exact(look.bins);
    let both = bottom.zip(predicted.object.chunks_exact(look.bins));
    let pings = look.pings.iter().zip(both).map(|(ping, (bottom, object))| {
        let all = ping.levels.iter().zip(bottom).zip(object).zip(&darkest);
        let squares = all.map(|(((level, bottom), object), darkest)| {
            // Most of a look is bare bottom, and a logarithm is what costs time here.
            let expected = match *bottom == 1.0 && *object == 0.0 {
                true => 0.0,
                false => scale * (bottom + strength * object).max(*darkest).ln(),
            };
            (level - expected) * (level - expected)
        });
        f64::from(squares.sum::<f32>())
    });
    pings.sum()
}
