//! Solves one round by least squares: depth, brightness, gain and, while they are learnt, the
//! curves, from all observations and all measured depths together.
//!
//! The unknowns are depth `d` and logarithm of brightness `a` at the nodes, and the gain of every
//! stretch of a log. An observation at `x` that looks outward along `o` gives the equation `J_s
//! (d(x + u o) - d(x - u o)) / 2u + J_d d(x) + q a(x) + gain + J_c c = over + J d' + q a'` with the
//! values `'` of the round before. The curves `c` occur in every observation, so they are solved
//! for by the Schur complement.

use super::echoes::WeedPlaces;
use super::model::{LawCurves, PARAMETERS};
use super::nodes::{Nodes, Shares};
use super::observations::{Bed, SideChunk, SlopeObservation};
use crate::bathymetry::{Bends, Node};
use crate::sparse::{Equations, Factor, Normal, Pattern, solve_dense};
use bathyscope_log::support::statistics::median_of;
use faer::Mat;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;

/// Standard deviation of the errors of the model, natural logarithm of power, and variance of the
/// logarithm of a single echo's power.
const SD_MODEL: f64 = 0.12;
const SPECKLE_VARIANCE: f64 = 1.7;
/// Least standard deviation of a measured depth, metres.
const SD_MEASURED_M: f64 = 0.025;
/// Reciprocal of the correlation length of the depth about the triangles, a metre.
const KAPPA_PER_M: f64 = 0.6;
/// Standard deviation of the brightness at a node.
const SD_BRIGHTNESS: f64 = 1.0;
/// Standard deviations of the change of the gain from one stretch of a log to the next, and of the
/// gain of a stretch.
const SD_GAIN_STEP: f64 = 0.05;
const SD_GAIN: f64 = 1.0;
/// Misfit above which the weight of observations falls, in their standard deviations.
const ROBUST: f64 = 2.5;
/// Largest change of a parameter of a curve in a round.
const MOST_CURVE_STEP: f64 = 0.7;
/// Number of random draws of the depths, for their standard deviation.
const DRAWS: usize = 8;
/// Damping of the curves in a round, against steps beyond the range where the equations are nearly
/// linear.
const CURVE_DAMPING: f64 = 4.0;
/// Number of rows or columns of nodes that separate two sides.
const BETWEEN: usize = 2;
/// Largest number of rows and columns of a part that is not divided further.
const LEAST_PARTED: usize = 5;

/// Assumed change of the bed's brightness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Brightness {
    /// Slow change: standard deviation of the change over half a metre.
    Slow(f64),
    /// Changes in patches: standard deviation of the brightness.
    Patches(f64),
}

/// Prior knowledge of a bed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Prior {
    /// Change of the bed's brightness.
    pub brightness: Brightness,
    /// Standard deviation of the bed's depth about the triangles between the measured depths,
    /// metres.
    pub relief_m: f64,
}

/// Correlation length of patches, metres.
const PATCH_M: f64 = 3.0;
/// Length that the change in [`Brightness::Slow`] refers to, metres.
const SLOW_M: f64 = 0.5;

/// Input that a tile is solved from.
#[derive(Clone, Copy)]
pub(super) struct TileInput<'a> {
    /// All looks.
    pub looks: &'a [SideChunk],
    /// Curves of each set; `None` where they are unknown.
    pub curves: &'a [Option<LawCurves>],
    /// Ground range of a level cell, metres.
    pub level_cell_m: f64,
    /// Places whose echoes do not come from the bed.
    pub weed: &'a WeedPlaces,
    /// Prior knowledge of the bed.
    pub prior: Prior,
    /// True if observations with large misfits have less weight.
    pub is_robust: bool,
}

/// Results of a round, other than the bed.
pub(super) struct Solved {
    /// True for each node with an observation next to it.
    pub is_seen: Vec<bool>,
    /// Equations of the curves; `None` if the curves are not learnt.
    pub border: Option<Border>,
}

/// Equations of the curves from one tile, and the effect of the curves on its bed.
pub(super) struct Border {
    /// Schur complement for the parameters of all sets of curves, one set after the other.
    normal: Mat<f64>,
    /// Right side of these equations.
    right: Vec<f64>,
    /// Parameters that occur, each with the decrease of depth and brightness for a unit step of it.
    columns: Vec<(usize, Vec<f64>)>,
}

/// State of a tile between its rounds.
pub(super) struct TileSolution {
    /// Index of the tile.
    pub tile: usize,
    /// Bed of the tile as it is known so far.
    pub bed: Bed,
    measured: Vec<Node>,
    looks: Vec<usize>,
}

impl TileSolution {
    /// Creates the state of a tile before its first round; `None` where the tile has no measured
    /// depth.
    pub(super) fn new(
        tile: usize,
        nodes: &Nodes,
        (measured, bends): (&[Node], Option<Bends>),
        looks: &[SideChunk],
    ) -> Option<Self> {
        let inside = measured.iter().filter(|depth| nodes.holds(depth.place()));
        let measured: Vec<Node> = inside.copied().collect();
        let bed = Bed::new(*nodes, &measured, bends)?;
        let all = looks.iter().enumerate();
        let touching = all.filter(|(_, look)| look.ranges_within(nodes).is_some());
        Some(Self { tile, looks: touching.map(|(look, _)| look).collect(), measured, bed })
    }

    /// Solves the next round, and moves the bed to its solution. `None` where the tile has no
    /// observation, or the equations have no solution.
    pub(super) fn solve(&mut self, given: &TileInput<'_>, learns: bool) -> Option<Solved> {
        let nodes = self.bed.nodes;
        let mut system = System::new(&nodes);
        for look in self.looks.iter().map(|look| &given.looks[*look]) {
            if let Some(curves) = &given.curves[look.curves] {
                system.gains.insert(look.stretch, 0);
                look.read(&self.bed, &nodes, Some(curves), given.level_cell_m, |observation| {
                    if given.weed.is_far_from(observation.place_m) {
                        system.observations.push((look, observation));
                    }
                });
            }
        }
        if system.observations.is_empty() {
            return None;
        }
        system.add_observations(&self.bed, given.level_cell_m, given.is_robust);
        for depth in &self.measured {
            let sd_m = SD_MEASURED_M.max(0.6 * depth.spread_m);
            let shares = nodes.shares(depth.place());
            system.equations.add(shares, depth.depth_m, sd_m);
        }
        system.add_relief(&self.bed.triangles_m, given.prior.relief_m);
        system.add_brightness(given.prior.brightness);
        system.add_gains();
        let order = order(&nodes, 2, system.unknowns());
        let pattern = Pattern::in_order(&system.equations, order)?;
        let factor = pattern.factorise(&system.equations)?;
        let mut normal = Normal::new(1);
        let mut drawn = factor.solve(&pattern, &system.equations, DRAWS, || normal.draw());
        let values = drawn.swap_remove(0);
        if values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let sd_m = |node: usize| {
            let squares = drawn.iter().map(|draw| draw[node].powi(2));
            (squares.sum::<f64>() / DRAWS as f64).sqrt()
        };
        self.bed.step(&values);
        self.bed.sd_m = (0..nodes.len()).map(sd_m).collect();
        Some(Solved {
            is_seen: system.is_seen(),
            border: learns.then(|| system.border(given.curves.len(), &factor, &values)),
        })
    }

    /// Moves the bed by the effect of a step of the curves.
    pub(super) fn follow(&mut self, border: &Border, steps: &[f64]) {
        for (parameter, column) in &border.columns {
            self.bed.add(column, -steps[*parameter]);
        }
    }
}

/// Returns the terms of `(kappa^2 - Laplace)` at a node, whose values are independent in a Matern
/// field (Lindgren et al. 2011, doi 10.1111/j.1467-9868.2011.00777.x), and their standard deviation
/// for a field of standard deviation `sd`.
fn innovation(
    nodes: &Nodes,
    node: usize,
    kappa_per_m: f64,
    sd: f64,
) -> (impl Iterator<Item = (usize, f64)>, f64) {
    let per_m2 = 1.0 / nodes.step_m.powi(2);
    let around = nodes.neighbours(node).map(|other| (other, -per_m2));
    let terms = around.into_iter().chain([(node, 4.0 * per_m2 + kappa_per_m.powi(2))]);
    (terms, sd * (4.0 * PI).sqrt() * kappa_per_m / nodes.step_m)
}

struct System<'a> {
    nodes: Nodes,
    equations: Equations,
    observations: Vec<(&'a SideChunk, SlopeObservation)>,
    /// Index of the unknown gain of each stretch of a log.
    gains: BTreeMap<(u32, u32), usize>,
}

impl<'a> System<'a> {
    fn new(nodes: &Nodes) -> Self {
        Self {
            nodes: *nodes,
            equations: Equations::default(),
            observations: Vec::new(),
            gains: BTreeMap::new(),
        }
    }

    fn unknowns(&self) -> usize {
        2 * self.nodes.len() + self.gains.len()
    }

    fn add_observations(&mut self, bed: &Bed, level_cell_m: f64, is_robust: bool) {
        let count = self.nodes.len();
        for (index, gain) in self.gains.values_mut().enumerate() {
            *gain = 2 * count + index;
        }
        let middle = median_of(self.observations.iter().map(|(_, observation)| observation.over));
        for (look, observation) in &self.observations {
            let half_m = 0.5 * level_cell_m;
            let at = |metres: f64| {
                [0, 1].map(|axis| observation.place_m[axis] + metres * look.outward[axis])
            };
            let places = [-half_m, 0.0, half_m].map(at);
            let [inner, here, outer] = places.map(|place| self.nodes.shares(place));
            let [before_inner, before, before_outer] =
                places.map(|place| bed.nodes.value_at(&bed.depth_m, place));
            let per_m = observation.per_slope / level_cell_m;
            let goal = observation.over
                + per_m * (before_outer - before_inner)
                + observation.per_depth * before
                + observation.share * bed.nodes.value_at(&bed.ln_brightness, observation.place_m);
            let times = |shares: Shares, factor: f64, first: usize| {
                shares.into_iter().map(move |(node, share)| (first + node, factor * share))
            };
            let terms = times(outer, per_m, 0)
                .chain(times(inner, -per_m, 0))
                .chain(times(here, observation.per_depth, 0))
                .chain(times(here, observation.share, count))
                .chain([(self.gains[&look.stretch], 1.0)]);
            let mut sd = (SPECKLE_VARIANCE / observation.independent).sqrt().hypot(SD_MODEL);
            let over = (observation.over - middle).abs() / sd;
            if is_robust && over > ROBUST {
                sd *= (over / ROBUST).sqrt();
            }
            self.equations.add(terms, goal, sd);
        }
    }

    /// Adds the equations of the prior of the depth, which varies about the triangles; the bends of
    /// the triangles themselves have no cost.
    fn add_relief(&mut self, triangles_m: &[f64], relief_m: f64) {
        for (node, depth_m) in triangles_m.iter().enumerate() {
            let (terms, sd) = innovation(&self.nodes, node, KAPPA_PER_M, relief_m);
            self.equations.add(terms, KAPPA_PER_M * KAPPA_PER_M * depth_m, sd);
        }
    }

    fn add_brightness(&mut self, brightness: Brightness) {
        let count = self.nodes.len();
        for node in 0..count {
            match brightness {
                Brightness::Slow(sd) => {
                    let [_, east, _, north] = self.nodes.neighbours(node);
                    // Over such a short step the change is in proportion to its length.
                    let sd = sd * self.nodes.step_m / SLOW_M;
                    for other in [east, north].into_iter().filter(|other| *other != node) {
                        self.equations.add([(count + node, 1.0), (count + other, -1.0)], 0.0, sd);
                    }
                }
                Brightness::Patches(sd) => {
                    let (terms, sd) = innovation(&self.nodes, node, 1.0 / PATCH_M, sd);
                    let terms = terms.map(|(node, factor)| (count + node, factor));
                    self.equations.add(terms, 0.0, sd);
                }
            }
            self.equations.add([(count + node, 1.0)], 0.0, SD_BRIGHTNESS);
        }
    }

    fn add_gains(&mut self) {
        for (&(log, stretch), gain) in &self.gains {
            self.equations.add([(*gain, 1.0)], 0.0, SD_GAIN);
            if let Some(next) = self.gains.get(&(log, stretch + 1)) {
                let terms = [(*gain, 1.0), (*next, -1.0)];
                self.equations.add(terms, 0.0, SD_GAIN_STEP);
            }
        }
    }

    fn is_seen(&self) -> Vec<bool> {
        let mut is_seen = vec![false; self.nodes.len()];
        for (_, observation) in &self.observations {
            is_seen[self.nodes.nearest(observation.place_m)] = true;
        }
        is_seen
    }

    /// Returns the equations of `sets` sets of curves from the observations, which are the first
    /// equations of the system.
    fn border(&self, sets: usize, factor: &Factor, values: &[f64]) -> Border {
        let parameters = sets * PARAMETERS;
        let mut normal = Mat::<f64>::zeros(parameters, parameters);
        let mut right = vec![0.0; parameters];
        // Sets without an observation in the tile have no column to solve for.
        let mut occurring: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (equation, (look, observation)) in self.observations.iter().enumerate() {
            let mut by = [0.0; PARAMETERS];
            LawCurves::add_derivatives(&observation.at, observation.share, &mut by);
            let weight = self.equations.weight(equation).powi(2);
            let first = PARAMETERS * look.curves;
            // The residual of the solution without a step of the curves.
            let left = -self.equations.residual(equation, values) / self.equations.weight(equation);
            for (row, of_row) in by.iter().enumerate().filter(|(_, by)| **by != 0.0) {
                right[first + row] += weight * of_row * left;
                for (column, of_column) in by.iter().enumerate() {
                    normal[(first + row, first + column)] += weight * of_row * of_column;
                }
                let column = occurring.entry(first + row);
                let column = column.or_insert_with(|| vec![0.0; self.unknowns()]);
                self.equations.add_times(equation, weight * of_row, column);
            }
        }
        let (places, mut columns): (Vec<usize>, Vec<Vec<f64>>) = occurring.into_iter().unzip();
        let ties = columns.clone();
        factor.solve_for(&mut columns);
        for (row, tie) in places.iter().zip(&ties) {
            for (column, solved) in places.iter().zip(&columns) {
                normal[(*row, *column)] -= tie.iter().zip(solved).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        for column in &mut columns {
            column.truncate(2 * self.nodes.len());
        }
        Border { normal, right, columns: places.into_iter().zip(columns).collect() }
    }
}

/// Moves the curves by the step of the parameters of all sets that the tiles of a sample determine
/// together, and returns the step; `None` where there is no solution. `recorders` holds the
/// recorder of each set.
pub(super) fn learn(
    curves: &mut [Option<LawCurves>],
    recorders: &[u32],
    borders: &[&Border],
) -> Option<Vec<f64>> {
    let count = curves.len() * PARAMETERS;
    let mut normal = Mat::<f64>::zeros(count, count);
    let mut right = vec![0.0; count];
    for border in borders {
        normal += &border.normal;
        right.iter_mut().zip(&border.right).for_each(|(sum, value)| *sum += value);
    }
    let known = (0..curves.len()).filter_map(|set| Some((set, curves[set].as_ref()?)));
    let known: Vec<(usize, &LawCurves)> = known.collect();
    for (set, curves) in &known {
        curves.add_prior(&mut normal, &mut right, PARAMETERS * set, 1.0);
    }
    let ends = known.iter().zip(known.iter().skip(1));
    for ((one, before), (other, after)) in ends.filter(|(a, b)| recorders[a.0] == recorders[b.0]) {
        let (one, other) = ((*before, PARAMETERS * one), (*after, PARAMETERS * other));
        LawCurves::add_tie(one, other, &mut normal, &mut right);
    }
    for at in 0..count {
        normal[(at, at)] += CURVE_DAMPING;
    }
    let mut steps = solve_dense(&normal, &right)?;
    for step in &mut steps {
        *step = step.clamp(-MOST_CURVE_STEP, MOST_CURVE_STEP);
    }
    for (curves, step) in curves.iter_mut().zip(steps.chunks(PARAMETERS)) {
        *curves = curves.take().map(|curves| curves.stepped(step));
    }
    Some(steps)
}

/// Returns the order in which `unknowns` unknowns are eliminated: first `each` unknowns of every
/// node, numbered by kind and then by node; then the others.
///
/// The order is that of nested dissection (George 1973). Equations connect nodes that are at most
/// two steps apart, so two rows or columns of nodes separate the others into two sides that share
/// no equation. Each side is eliminated first, in the same way, and the two rows after both.
/// Unknowns that belong to no node, which are connected to many, come last.
fn order(nodes: &Nodes, each: usize, unknowns: usize) -> Vec<u32> {
    let mut of_nodes = Vec::with_capacity(nodes.len());
    part(nodes, nodes.counts.map(|count| 0..count), &mut of_nodes);
    let of_node = |node: usize| (0..each).map(move |kind| kind * nodes.len() + node);
    let all = of_nodes.into_iter().flat_map(of_node);
    all.chain(each * nodes.len()..unknowns).map(|unknown| unknown as u32).collect()
}

/// Adds the nodes of some columns and rows to the order, in nested dissection.
fn part(nodes: &Nodes, spans: [Range<usize>; 2], order: &mut Vec<usize>) {
    let axis = usize::from(spans[1].len() > spans[0].len());
    let Range { start, end } = spans[axis];
    let with = |span: Range<usize>| {
        let mut spans = spans.clone();
        spans[axis] = span;
        spans
    };
    let mut last = start..end;
    if end - start > LEAST_PARTED {
        let from = start + (end - start - BETWEEN) / 2;
        last = from..from + BETWEEN;
        part(nodes, with(start..last.start), order);
        part(nodes, with(last.end..end), order);
    }
    let [columns, rows] = with(last);
    for row in rows {
        order.extend(columns.clone().map(|column| row * nodes.counts[0] + column));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::{Equations, Pattern};

    const NODES: Nodes = Nodes { zero_m: [0.0; 2], first: [0; 2], step_m: 0.8, counts: [64, 50] };

    #[test]
    fn all_unknowns_are_eliminated_and_little_is_filled_in() {
        let (each, gains) = (2 * NODES.len(), 10);
        let mut equations = Equations::default();
        for node in 0..NODES.len() {
            let around = NODES.neighbours(node).map(|other| (other, -1.0));
            equations.add([(node, 4.6)].into_iter().chain(around), 0.0, 1.0);
            let echo = [(node, 1.0), (NODES.len() + node, 1.0)];
            let gain = (each + node % gains, 1.0);
            equations.add(echo.into_iter().chain([gain]), 0.0, 1.0);
        }
        let found = order(&NODES, 2, each + gains);
        let mut sorted = found.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..(each + gains) as u32));
        let in_rows: Vec<u32> = (0..NODES.len())
            .flat_map(|node| [node, NODES.len() + node])
            .chain(each..each + gains)
            .map(|unknown| unknown as u32)
            .collect();
        let [found, in_rows] = [found, in_rows]
            .map(|order| Pattern::in_order(&equations, order).unwrap().factor_len());
        assert!(3 * found < 2 * in_rows, "{found} {in_rows}");
    }
}
