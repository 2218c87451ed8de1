//! Compares a solid with looks: predicts the looks from the parameters of the solid, and sums the
//! squares of the differences.

use super::levels::{BoxLevels, PingLevels};
use super::predict::{PosedSolid, Predicted, predict};
use super::solid::{LANES, ShapeKind, Solid};
use bathyscope_bottom::vectors::{VectorLoop, ln, vectorised};

/// Standard deviation of the ln power of single-look speckle.
pub(super) const SPECKLE_LN: f64 = 1.283;
/// Standard deviation of the logarithm of a size outside the usual range of a kind.
const BEYOND_USUAL: f64 = 0.03;
/// Greatest list of a boat ([`Solid::list`]), at which its keel is at its side.
const MOST_LIST: f64 = 0.4;
/// Strength of the object over the bottom in ln power: its expected value and its standard
/// deviation, 6 dB each; and the initial darkness of a shadow, 13 dB below the bottom.
pub(super) const STRENGTH: [f64; 2] = [1.38, 1.4];
pub(super) const DARKNESS: f64 = -3.0;

/// Parameters of a fit. For the object: heading, ln length, ln slenderness, ln steepness, list;
/// then for each look: east, north, strength, darkness, and how much lighter a shadow is at the far
/// end of the look. The constants are the number of parameters of the object and of each look.
pub(super) type Numbers = Vec<f64>;
pub(super) const OF_OBJECT: usize = 5;
pub(super) const OF_LOOK: usize = 5;
/// First change of each parameter.
const FIRST_STEPS: [f64; OF_OBJECT + OF_LOOK] = [0.2, 0.2, 0.2, 0.2, 0.1, 0.2, 0.2, 0.7, 0.7, 0.7];
/// First change of length or width when an edge is moved, as its logarithm.
const EDGE_STEP: f64 = 0.2;
/// Change of place (metres) and of ln length below which the search ends.
const LEAST_STEP: f64 = 0.01;
/// Change of ln steepness below which the search ends, as a multiple of [`LEAST_STEP`]: an echo
/// determines the height less well.
const LEAST_OF_HEIGHT: f64 = 2.0;

/// A kind of solid, and the looks that it is fitted to.
pub(super) struct Problem<'a> {
    kind: ShapeKind,
    looks: &'a [BoxLevels],
    /// Sums of the squares of the recorded levels, by look and by ping.
    bare: Vec<Vec<f64>>,
    /// True if size and heading are known: only the parameters of the looks are searched.
    is_object_known: bool,
}

/// Parameters of a fit, with the levels that they predict.
#[derive(Clone)]
pub(super) struct FitState {
    pub(super) numbers: Numbers,
    /// Next change of each parameter.
    pub(super) steps: Vec<f64>,
    /// Next change for each edge in [`OutlineEdge::ALL`], of ln length or ln width.
    pub(super) edge_steps: [f64; 4],
    predicted: Vec<Predicted>,
    /// Sum of the squared differences of each look.
    costs: Vec<f64>,
    pub(super) cost: f64,
}

impl FitState {
    pub(super) fn new(problem: &Problem<'_>, numbers: Numbers) -> Self {
        let first_step = |number: usize| match number.checked_sub(OF_OBJECT) {
            None => FIRST_STEPS[number],
            Some(of_looks) => FIRST_STEPS[OF_OBJECT + of_looks % OF_LOOK],
        };
        let mut state = Self {
            steps: (0..numbers.len())
                .map(|number| if problem.is_fixed(number) { 0.0 } else { first_step(number) })
                .collect(),
            edge_steps: OutlineEdge::ALL
                .map(|edge| if problem.moves(edge) { EDGE_STEP } else { 0.0 }),
            numbers,
            predicted: vec![Predicted::default(); problem.looks.len()],
            costs: vec![0.0; problem.looks.len()],
            cost: 0.0,
        };
        problem.all(&mut state);
        state
    }

    /// Copies another state of the same problem into the memory of this one, because the search
    /// does little else than such copies.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.numbers.clone_from(&other.numbers);
        self.steps.clone_from(&other.steps);
        self.edge_steps = other.edge_steps;
        self.costs.clone_from(&other.costs);
        self.cost = other.cost;
        for (own, other) in self.predicted.iter_mut().zip(&other.predicted) {
            own.bottom.clone_from(&other.bottom);
            own.object.clone_from(&other.object);
            own.changed.clone_from(&other.changed);
        }
    }

    /// Multiplies the next changes of parameters and edges by a factor.
    pub(super) fn with_steps_times(mut self, share: f64) -> Self {
        let steps = self.steps.iter_mut().chain(&mut self.edge_steps);
        steps.for_each(|step| *step *= share);
        self
    }

    /// Returns true if the next changes of places, length and height are so small that another
    /// round is not worth it.
    pub(super) fn is_settled(&self) -> bool {
        let looks = self.steps[OF_OBJECT..].chunks_exact(OF_LOOK);
        let farthest = looks.map(|look| look[0].max(look[1]));
        let size = self.steps[1].max(self.steps[3] / LEAST_OF_HEIGHT);
        farthest.fold(size, f64::max) < LEAST_STEP
    }
}

impl<'a> Problem<'a> {
    pub(super) fn new(kind: ShapeKind, looks: &'a [BoxLevels]) -> Self {
        Self {
            kind,
            looks,
            bare: looks
                .iter()
                .map(|look| look.pings.iter().map(PingLevels::squares).collect())
                .collect(),
            is_object_known: false,
        }
    }

    /// Creates the problem for an object whose size and heading are known.
    pub(super) fn of_known(kind: ShapeKind, looks: &'a [BoxLevels]) -> Self {
        Self { is_object_known: true, ..Self::new(kind, looks) }
    }

    /// Returns the solid as placed in a look.
    pub(super) fn posed(&self, numbers: &[f64], look: usize) -> PosedSolid {
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

    /// Predicts all looks, and updates the cost.
    pub(super) fn all(&self, state: &mut FitState) {
        for look in 0..self.looks.len() {
            self.place(state, look);
        }
        self.sum(state);
    }

    /// Predicts one look, and compares it with the recorded levels.
    fn place(&self, state: &mut FitState, look: usize) {
        let posed = self.posed(&state.numbers, look);
        predict(&self.looks[look], &posed, &mut state.predicted[look]);
        self.weigh(state, look);
    }

    /// Compares one look with its prediction.
    fn weigh(&self, state: &mut FitState, look: usize) {
        let of_look = &state.numbers[OF_OBJECT + look * OF_LOOK..];
        let strength = of_look[2].exp() as f32;
        let all = vectorised(Squares {
            look: &self.looks[look],
            bare: &self.bare[look],
            predicted: &state.predicted[look],
            strength,
            darkest: [of_look[3], of_look[4]],
        });
        state.costs[look] = all * self.looks[look].together as f64;
    }

    fn sum(&self, state: &mut FitState) {
        state.cost = state.costs.iter().sum::<f64>() + self.unusual(&state.numbers);
    }

    /// Returns the penalty for unusual parameters, in squared standard deviations.
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
        let strengths = looks.clone().map(|look| ((look[2] - STRENGTH[0]) / STRENGTH[1]).powi(2));
        let lighter = looks.map(|look| look[4].powi(2));
        sizes.sum::<f64>() + strengths.sum::<f64>() + lighter.sum::<f64>()
    }

    /// Returns true if a parameter is not searched: it belongs to a known object, or the kind does
    /// not have it (a list, a heading, or a width that follows from its length or height).
    pub(super) fn is_fixed(&self, number: usize) -> bool {
        match self.kind {
            _ if self.is_object_known && number < OF_OBJECT => true,
            ShapeKind::Hull | ShapeKind::UpturnedHull => false,
            _ if number == 4 => true,
            ShapeKind::Tyre => number == 0 || number == 2,
            ShapeKind::Cylinder => number == 3,
            ShapeKind::Block | ShapeKind::Boulder => false,
        }
    }

    /// Changes one parameter, and predicts the looks that depend on it.
    pub(super) fn change(&self, state: &mut FitState, number: usize, by: f64) {
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

bathyscope_log::listed! {
    /// All edges.
    const ALL;

    /// A side of the outline that is moved while the opposite side stays: if one end of a boat fits
    /// and the other does not, a change of the length alone or of the place alone does not improve
    /// the fit.
    #[derive(Clone, Copy)]
    pub(super) enum OutlineEdge {
        Bow,
        Stern,
        Starboard,
        Port,
    }
}

impl OutlineEdge {
    fn is_end(self) -> bool {
        matches!(self, OutlineEdge::Bow | OutlineEdge::Stern)
    }
}

impl Problem<'_> {
    /// Returns true if the kind has an edge that can be moved alone.
    fn moves(&self, edge: OutlineEdge) -> bool {
        !self.is_fixed(2) && (edge.is_end() || !self.is_fixed(3))
    }

    /// Moves an edge so that length or width grow by a factor, given as its logarithm, and predicts
    /// all looks.
    pub(super) fn move_edge(&self, state: &mut FitState, edge: OutlineEdge, by: f64) {
        let numbers = &mut state.numbers;
        let (sin, cos) = numbers[0].sin_cos();
        let (length_m, width_m) = (numbers[1].exp(), (numbers[1] - numbers[2]).exp());
        let size_m = if edge.is_end() {
            numbers[1] += by;
            numbers[2] += by;
            length_m
        } else {
            // The height does not change.
            numbers[2] -= by;
            numbers[3] -= by;
            width_m
        };
        let half_m = 0.5 * size_m * (by.exp() - 1.0);
        let [east, north] = match edge {
            OutlineEdge::Bow => [sin, cos],
            OutlineEdge::Stern => [-sin, -cos],
            OutlineEdge::Starboard => [cos, -sin],
            OutlineEdge::Port => [-cos, sin],
        };
        for of_look in numbers[OF_OBJECT..].chunks_exact_mut(OF_LOOK) {
            of_look[0] += half_m * east;
            of_look[1] += half_m * north;
        }
        self.all(state);
    }
}

/// Computes the sum of the squares of recorded minus predicted levels of a look; `bare` holds the
/// sums of the squares of the recorded levels of each ping.
struct Squares<'a> {
    look: &'a BoxLevels,
    bare: &'a [f64],
    predicted: &'a Predicted,
    strength: f32,
    /// Darkness of a shadow in ln power at the near end of the look, and how much lighter it is at
    /// the far end: the noise that fills a shadow does not fade with the bottom.
    darkest: [f64; 2],
}

impl VectorLoop for Squares<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let bins = self.look.bins;
        let bottom = self.predicted.bottom.chunks_exact(bins);
        let both = bottom.zip(self.predicted.object.chunks_exact(bins));
        let pings = self.look.pings.iter().zip(both);
        let mut sum = 0.0;
        for (((ping, (bottom, object)), changed), bare) in
            pings.zip(&self.predicted.changed).zip(self.bare)
        {
            let (from, to) = (changed.start, changed.end);
            let levels = [&ping.levels[from..to], &bottom[from..to], &object[from..to]];
            sum += bare + f64::from(self.more(levels, from));
        }
        sum
    }
}

impl Squares<'_> {
    /// Returns the excess of the squared differences of some bins of a ping, from bin `first` on,
    /// over the squares of the recorded levels: most of a look is bare bottom, where the predicted
    /// level is 0. In: levels, visible share of the bottom, echo of the object.
    #[inline(always)]
    fn more(&self, [levels, bottom, object]: [&[f32]; 3], first: usize) -> f32 {
        let dark = self.darkest[0] as f32;
        let lighter = (self.darkest[1] / self.look.bins as f64) as f32;
        let scale = SPECKLE_LN.recip() as f32;
        let mut sums = [0.0; LANES];
        for start in (0..levels.len()).step_by(LANES) {
            let count = levels.len() - start;
            let (bottom, object) = (lanes(&bottom[start..]), lanes(&object[start..]));
            let levels = lanes(&levels[start..]);
            for lane in 0..LANES {
                let power = bottom[lane] + self.strength * object[lane];
                let darkest = dark + lighter * (first + start + lane) as f32;
                let expected = scale * ln(power.max(f32::MIN_POSITIVE)).max(darkest);
                // (level - expected)^2 - level^2.
                let more = expected * (expected - 2.0 * levels[lane]);
                sums[lane] += if lane < count { more } else { 0.0 };
            }
        }
        sums.iter().sum()
    }
}

/// Returns the first numbers of a row, filled up with zeros if it has too few.
#[inline(always)]
fn lanes(row: &[f32]) -> [f32; LANES] {
    match row.first_chunk() {
        Some(lanes) => *lanes,
        None => {
            let mut lanes = [0.0; LANES];
            lanes[..row.len()].copy_from_slice(row);
            lanes
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_test_support::Random;

    /// Computes the sum by its definition, bin by bin in double precision.
    fn plain_squares(squares: &Squares<'_>) -> f64 {
        let bins = squares.look.bins;
        let [dark, lighter] = squares.darkest;
        let of_bin = |ping: usize, bin: usize| {
            let at = ping * bins + bin;
            let echo = f64::from(squares.strength) * f64::from(squares.predicted.object[at]);
            let power = f64::from(squares.predicted.bottom[at]) + echo;
            let darkest = dark + lighter * bin as f64 / bins as f64;
            let expected = if squares.predicted.changed[ping].contains(&bin) {
                power.ln().max(darkest) / SPECKLE_LN
            } else {
                0.0
            };
            let level = f64::from(squares.look.pings[ping].levels[bin]);
            (level - expected).powi(2)
        };
        let pings = 0..squares.look.pings.len();
        pings
            .flat_map(|ping| (0..bins).map(move |bin| (ping, bin)))
            .map(|(ping, bin)| of_bin(ping, bin))
            .sum()
    }

    fn positive(numbers: Vec<f32>) -> Vec<f32> {
        numbers.into_iter().map(|number| number.max(0.0)).collect()
    }

    #[test]
    fn squares_are_those_of_the_definition_for_any_count_of_bins() {
        for bins in [1, 7, 8, 9, 16, 23, 96] {
            let mut random = Random(7);
            let mut numbers = |count: usize, from: f32, to: f32| -> Vec<f32> {
                let share = (0..count).map(|_| random.below(1000) as f32 / 1000.0);
                share.map(|share| from + share * (to - from)).collect()
            };
            let ping = |ping: usize| PingLevels {
                ping,
                boat_m: [0.0; 2],
                outward: [1.0, 0.0],
                levels: numbers(bins, -3.0, 3.0),
            };
            let look = BoxLevels::of_pings((0..3).map(ping).collect(), 0.2, [0.0, 0.1]);
            // A quarter of the bins are in the shadow, where only noise is expected.
            let predicted = Predicted {
                bottom: positive(numbers(3 * bins, -1.0, 1.0)),
                object: positive(numbers(3 * bins, -1.0, 1.0)),
                changed: vec![0..bins, bins / 3..bins, 0..bins / 2],
            };
            let bare: Vec<f64> = look.pings.iter().map(PingLevels::squares).collect();
            let squares = Squares {
                look: &look,
                bare: &bare,
                predicted: &predicted,
                strength: 1.7,
                darkest: [-3.0, 0.8],
            };
            let expected = plain_squares(&squares);
            let found = vectorised(squares);
            assert!(
                (found - expected).abs() < 1e-5 * (1.0 + expected),
                "{bins} bins: {found}, not {expected}"
            );
        }
    }
}
