//! One round: depth, brightness, gain and, where they are to be learnt, the curves, from all readings and all measured depths together, by least
//! squares.
//!
//! Unknown are depth `d` and logarithm of brightness `a` at the nodes and the gain of every chunk. A reading at `x` that looks outward
//! along `o` says `J_s (d(x + u o) - d(x - u o)) / 2u + J_d d(x) + q a(x) + gain + J_c c = over + J d' + q a'` with the values `'` of the round before. The
//! curves `c` occur in every reading, so they are solved for by the Schur complement.

use super::elimination;
use super::layout::ChunkId;
use super::looks::Look;
use super::model::{Curves, PARAMETERS, solve_dense};
use super::nodes::{Nodes, Shares};
use super::readings::{Bed, Reading};
use crate::sparse::{Equations, Factor, Normal, Pattern};
use crate::statistics::median;
use faer::Mat;
use std::collections::BTreeMap;

/// Standard deviation of what the model lacks, natural logarithm of power, and variance of the logarithm of a single echo's power.
const SD_MODEL: f64 = 0.12;
const SPECKLE_VARIANCE: f64 = 1.7;
/// Reciprocal of the length over which the depth about the plate hangs together, a metre.
const KAPPA_PER_M: f64 = 0.6;
/// Standard deviation of the plate's curvature at a square metre, a metre.
const PLATE_BEND_PER_M: f64 = 0.11;
/// Standard deviation of the brightness itself.
const SD_BRIGHTNESS: f64 = 1.0;
/// Standard deviations of the gain from one chunk to the next, and of itself. Chunks farther apart than this are not tied.
const SD_GAIN_STEP: f64 = 0.01;
const SD_GAIN: f64 = 0.3;
const FARTHEST_TIE: u32 = 50;
/// Misfits beyond so many of their standard deviations count less.
const ROBUST: f64 = 2.5;
/// Most that a parameter of a curve changes in a round.
const MOST_CURVE_STEP: f64 = 0.7;
/// Draws of what is unknown of the depths, for their standard deviation.
const DRAWS: usize = 8;
/// What holds the curves in a round, against steps beyond where they are nearly linear.
const CURVE_DAMPING: f64 = 4.0;

/// How the brightness of the bed may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Brightness {
    /// Slowly: standard deviation of its change over half a metre.
    Slow(f64),
    /// In patches: its standard deviation.
    Patches(f64),
}

/// What is known of a bed beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// How its brightness may change.
    pub brightness: Brightness,
    /// Standard deviation of its depth about the plate through the measured depths, metres.
    pub relief_m: f64,
}

/// The length over which patches hang together, metres.
const PATCH_M: f64 = 3.0;
/// The length that [`Brightness::Slow`] counts by, metres.
const SLOW_M: f64 = 0.5;

/// A depth that was measured.
#[derive(Clone, Copy, Debug)]
pub struct Anchor {
    /// East and north, metres.
    pub place_m: [f64; 2],
    /// Depth, metres.
    pub depth_m: f64,
    /// Its standard deviation, metres.
    pub sd_m: f64,
}

/// What a tile is solved from.
#[derive(Clone, Copy)]
pub struct Given<'a> {
    /// All looks.
    pub looks: &'a [Look],
    /// The curves of each, `None` where they are unknown.
    pub curves: &'a [Option<Curves>],
    /// Ground range of a piece, metres.
    pub piece_m: f64,
    /// Whether echoes of a place are those of the bed.
    pub is_bed: &'a (dyn Fn([f64; 2]) -> bool + Sync),
    /// What is known beforehand.
    pub prior: Prior,
    /// Whether misfits count less.
    pub is_robust: bool,
}

/// What a round finds beside the bed.
pub struct Solved {
    /// Whether a reading lies next to each node.
    pub is_seen: Vec<bool>,
    /// Where the curves are to be learnt.
    pub border: Option<Border>,
}

/// What a tile says of the curves, and what they change in it.
pub struct Border {
    /// The curves that occur in it.
    pub curves: Vec<usize>,
    /// The Schur complement, of all parameters of these, and the right side.
    pub normal: Mat<f64>,
    /// See `normal`.
    pub right: Vec<f64>,
    /// What depth and brightness lose for a step of each parameter.
    columns: Vec<Vec<f64>>,
}

/// The depths of a plate that bends least through the measured depths, at the nodes of a tile; `None` without any.
pub fn plate(nodes: &Nodes, anchors: &[Anchor]) -> Option<Vec<f64>> {
    let mut equations = Equations::default();
    add_anchors(&mut equations, nodes, anchors);
    if equations.len() == 0 {
        return None;
    }
    for node in 0..nodes.len() {
        equations.add(laplacian(nodes, node), 0.0, PLATE_BEND_PER_M / nodes.step_m);
    }
    // Far from all depths a plate is as good as any.
    for node in 0..nodes.len() {
        let middle_m =
            anchors.iter().map(|anchor| anchor.depth_m).sum::<f64>() / anchors.len() as f64;
        equations.add([(node, 1.0)], middle_m, FAR_SD_M);
    }
    let pattern = Pattern::in_order(&equations, nodes.len(), |neighbours| {
        elimination::order(nodes, 1, neighbours)
    })?;
    let factor = pattern.factorise(&equations)?;
    Some(factor.solve(&pattern, &equations, 0, || 0.0).swap_remove(0))
}

/// Standard deviation of a plate about the mean depth, metres: it only keeps the equations solvable.
const FAR_SD_M: f64 = 100.0;

/// A tile between its rounds.
pub struct TileState {
    /// Which tile.
    pub tile: usize,
    /// Its bed as it is known so far.
    pub bed: Bed,
    anchors: Vec<Anchor>,
    plate_m: Vec<f64>,
    looks: Vec<usize>,
    solver: Option<Solver>,
}

/// What a round leaves to the next.
struct Solver {
    factor: Factor,
    values: Vec<f64>,
    /// Standard deviation of the depth at every node by what is unknown of it, metres; empty without draws.
    sd_m: Vec<f64>,
}

impl TileState {
    /// Of a tile before its first round; `None` where no depth was measured in it.
    pub fn new(tile: usize, nodes: &Nodes, anchors: &[Anchor], looks: &[Look]) -> Option<Self> {
        let anchors: Vec<Anchor> = anchors
            .iter()
            .filter(|anchor| nodes.holds(anchor.place_m))
            .copied()
            .collect();
        let plate_m = plate(nodes, &anchors)?;
        let touching = looks
            .iter()
            .enumerate()
            .filter(|(_, look)| look.within(nodes).is_some());
        Some(Self {
            tile,
            bed: Bed::new(
                *nodes,
                plate_m.clone(),
                anchors.iter().map(|anchor| anchor.place_m).collect(),
            ),
            looks: touching.map(|(look, _)| look).collect(),
            anchors,
            plate_m,
            solver: None,
        })
    }

    /// The next round; `None` where no reading lies in the tile, or where the equations have no solution. From the second on the factor of the first
    /// serves, unless the curves are learnt.
    pub fn solve(&mut self, given: &Given<'_>, learns: bool) -> Option<Solved> {
        let nodes = self.bed.nodes;
        let mut system = System::new(&nodes);
        for look in self.looks.iter().map(|look| &given.looks[*look]) {
            if let Some(curves) = &given.curves[look.curves] {
                system.gains.insert((look.chunk, look.segment), 0);
                look.read(&self.bed, &nodes, Some(curves), given.piece_m, |reading| {
                    if (given.is_bed)(reading.place_m) {
                        system.readings.push((look, reading));
                    }
                });
            }
        }
        if system.readings.is_empty() {
            return None;
        }
        system.add_readings(&self.bed, given.piece_m, given.is_robust);
        add_anchors(&mut system.equations, &nodes, &self.anchors);
        system.add_relief(&self.plate_m, given.prior.relief_m);
        system.add_brightness(given.prior.brightness);
        system.add_gains();
        let solver = match self.solver.take() {
            Some(before) if !learns && before.values.len() == system.unknowns() => Solver {
                values: before.factor.better(&system.equations, before.values),
                ..before
            },
            _ => system.solver(if learns { 0 } else { DRAWS })?,
        };
        if solver.values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let solved = Solved {
            is_seen: system.is_seen(),
            border: learns.then(|| system.border(&solver)),
        };
        self.bed.step(&solver.values);
        self.solver = Some(solver);
        Some(solved)
    }

    /// Takes over a step of the curves.
    pub fn follow(&mut self, border: &Border, steps: &BTreeMap<usize, Vec<f64>>) {
        for (at, curves) in border.curves.iter().enumerate() {
            for (parameter, step) in steps.get(curves).into_iter().flatten().enumerate() {
                self.bed
                    .add(&border.columns[at * PARAMETERS + parameter], -step);
            }
        }
    }

    /// Standard deviation of the depth at every node by what is unknown of it, metres; empty where the curves were learnt.
    pub fn sd_m(&self) -> &[f64] {
        self.solver.as_ref().map_or(&[], |solver| &solver.sd_m)
    }
}

/// The terms of the Laplacian at a node, a square metre.
fn laplacian(nodes: &Nodes, node: usize) -> impl Iterator<Item = (usize, f64)> {
    let per_m2 = 1.0 / nodes.step_m.powi(2);
    let own = [(node, -4.0 * per_m2)];
    own.into_iter()
        .chain(nodes.neighbours(node).map(move |other| (other, per_m2)))
}

/// The terms of `(kappa^2 - Laplace)` at a node, whose values are independent in a Matern field (Lindgren et al. 2011, doi
/// 10.1111/j.1467-9868.2011.00777.x), and their standard deviation for a field of standard deviation `sd`.
fn innovation(
    nodes: &Nodes,
    node: usize,
    kappa_per_m: f64,
    sd: f64,
) -> (impl Iterator<Item = (usize, f64)>, f64) {
    let terms = laplacian(nodes, node).map(|(other, factor)| (other, -factor));
    let terms = terms.chain([(node, kappa_per_m * kappa_per_m)]);
    (
        terms,
        sd * (4.0 * std::f64::consts::PI).sqrt() * kappa_per_m / nodes.step_m,
    )
}

fn add_anchors(equations: &mut Equations, nodes: &Nodes, anchors: &[Anchor]) {
    for anchor in anchors {
        equations.add(nodes.shares(anchor.place_m), anchor.depth_m, anchor.sd_m);
    }
}

struct System<'a> {
    nodes: Nodes,
    equations: Equations,
    readings: Vec<(&'a Look, Reading)>,
    /// The unknown of the gain of each chunk.
    gains: BTreeMap<(ChunkId, u32), usize>,
}

impl<'a> System<'a> {
    fn new(nodes: &Nodes) -> Self {
        Self {
            nodes: *nodes,
            equations: Equations::default(),
            readings: Vec::new(),
            gains: BTreeMap::new(),
        }
    }

    fn unknowns(&self) -> usize {
        2 * self.nodes.len() + self.gains.len()
    }

    fn add_readings(&mut self, bed: &Bed, piece_m: f64, is_robust: bool) {
        let count = self.nodes.len();
        for (index, gain) in self.gains.values_mut().enumerate() {
            *gain = 2 * count + index;
        }
        let mut overs: Vec<f64> = self
            .readings
            .iter()
            .map(|(_, reading)| reading.over)
            .collect();
        let middle = median(&mut overs);
        for (look, reading) in &self.readings {
            let half_m = 0.5 * piece_m;
            let at = |metres: f64| {
                [0, 1].map(|axis| reading.place_m[axis] + metres * look.outward[axis])
            };
            let places = [-half_m, 0.0, half_m].map(at);
            let [inner, here, outer] = places.map(|place| self.nodes.shares(place));
            let [before_inner, before, before_outer] =
                places.map(|place| bed.nodes.value_at(&bed.depth_m, place));
            let per_m = reading.per_slope / piece_m;
            let goal = reading.over
                + per_m * (before_outer - before_inner)
                + reading.per_depth * before
                + reading.share * bed.nodes.value_at(&bed.ln_brightness, reading.place_m);
            let times = |shares: Shares, factor: f64, first: usize| {
                shares
                    .into_iter()
                    .map(move |(node, share)| (first + node, factor * share))
            };
            let terms = times(outer, per_m, 0)
                .chain(times(inner, -per_m, 0))
                .chain(times(here, reading.per_depth, 0))
                .chain(times(here, reading.share, count))
                .chain([(self.gains[&(look.chunk, look.segment)], 1.0)]);
            let mut sd = (SPECKLE_VARIANCE / reading.independent)
                .sqrt()
                .hypot(SD_MODEL);
            let over = (reading.over - middle).abs() / sd;
            if is_robust && over > ROBUST {
                sd *= (over / ROBUST).sqrt();
            }
            self.equations.add(terms, goal, sd);
        }
    }

    fn add_relief(&mut self, plate_m: &[f64], relief_m: f64) {
        for node in 0..self.nodes.len() {
            let (terms, sd) = innovation(&self.nodes, node, KAPPA_PER_M, relief_m);
            let terms: Vec<(usize, f64)> = terms.collect();
            let goal = terms
                .iter()
                .map(|(node, factor)| factor * plate_m[*node])
                .sum();
            self.equations.add(terms, goal, sd);
        }
    }

    fn add_brightness(&mut self, brightness: Brightness) {
        let count = self.nodes.len();
        for node in 0..count {
            match brightness {
                Brightness::Slow(sd) => {
                    let [_, east, _, north] = self.nodes.neighbours(node);
                    // Over so short a step the change is in proportion to it.
                    let sd = sd * self.nodes.step_m / SLOW_M;
                    for other in [east, north].into_iter().filter(|other| *other != node) {
                        self.equations
                            .add([(count + node, 1.0), (count + other, -1.0)], 0.0, sd);
                    }
                }
                Brightness::Patches(sd) => {
                    let (terms, sd) = innovation(&self.nodes, node, 1.0 / PATCH_M, sd);
                    let terms = terms.map(|(node, factor)| (count + node, factor));
                    self.equations.add(terms, 0.0, sd);
                }
            }
            self.equations
                .add([(count + node, 1.0)], 0.0, SD_BRIGHTNESS);
        }
    }

    /// Ties every chunk to the one before, unless the gain steps between them.
    fn add_gains(&mut self) {
        let mut last: Option<(ChunkId, u32, usize)> = None;
        for (&(chunk, segment), &gain) in &self.gains {
            self.equations.add([(gain, 1.0)], 0.0, SD_GAIN);
            if let Some((before, before_segment, before_gain)) = last {
                let apart = chunk.number.saturating_sub(before.number);
                if (before.log, before_segment) == (chunk.log, segment)
                    && (1..=FARTHEST_TIE).contains(&apart)
                {
                    let sd = SD_GAIN_STEP * f64::from(apart).sqrt();
                    self.equations
                        .add([(gain, 1.0), (before_gain, -1.0)], 0.0, sd);
                }
            }
            last = Some((chunk, segment, gain));
        }
    }

    fn solver(&self, draws: usize) -> Option<Solver> {
        let pattern = Pattern::in_order(&self.equations, self.unknowns(), |neighbours| {
            elimination::order(&self.nodes, 2, neighbours)
        })?;
        let factor = pattern.factorise(&self.equations)?;
        let mut normal = Normal::new(1);
        let mut columns = factor.solve(&pattern, &self.equations, draws, || normal.draw());
        let values = columns.swap_remove(0);
        let sd = |node: usize| {
            let squares = columns.iter().map(|draw| draw[node].powi(2));
            (squares.sum::<f64>() / draws as f64).sqrt()
        };
        Some(Solver {
            sd_m: if draws > 0 {
                (0..self.nodes.len()).map(sd).collect()
            } else {
                Vec::new()
            },
            factor,
            values,
        })
    }

    fn is_seen(&self) -> Vec<bool> {
        let mut is_seen = vec![false; self.nodes.len()];
        for (_, reading) in &self.readings {
            is_seen[self.nodes.nearest(reading.place_m)] = true;
        }
        is_seen
    }

    /// What the readings, which are the first of the equations, say of the curves.
    fn border(&self, Solver { factor, values, .. }: &Solver) -> Border {
        let mut curves: Vec<usize> = self.readings.iter().map(|(look, _)| look.curves).collect();
        curves.sort_unstable();
        curves.dedup();
        let parameters = curves.len() * PARAMETERS;
        let mut normal = Mat::<f64>::zeros(parameters, parameters);
        let mut right = vec![0.0; parameters];
        let mut columns = vec![vec![0.0; self.unknowns()]; parameters];
        for (equation, (look, reading)) in self.readings.iter().enumerate() {
            let mut by = [0.0; PARAMETERS];
            Curves::add_derivatives(&reading.at, reading.share, &mut by);
            let weight = self.equations.weight(equation).powi(2);
            let first = PARAMETERS * curves.partition_point(|one| *one < look.curves);
            // What the solution without a step of the curves leaves.
            let left = -self.equations.residual(equation, values) / self.equations.weight(equation);
            for (row, of_row) in by.iter().enumerate().filter(|(_, by)| **by != 0.0) {
                right[first + row] += weight * of_row * left;
                for (column, of_column) in by.iter().enumerate() {
                    normal[(first + row, first + column)] += weight * of_row * of_column;
                }
                self.equations
                    .add_times(equation, weight * of_row, &mut columns[first + row]);
            }
        }
        let ties = columns.clone();
        factor.solve_for(&mut columns);
        for row in 0..parameters {
            for column in 0..parameters {
                let product: f64 = ties[row]
                    .iter()
                    .zip(&columns[column])
                    .map(|(a, b)| a * b)
                    .sum();
                normal[(row, column)] -= product;
            }
        }
        for column in &mut columns {
            column.truncate(2 * self.nodes.len());
        }
        Border {
            curves,
            normal,
            right,
            columns,
        }
    }
}

/// The step of all curves that the tiles of a sample say together, by curves; the curves a step on are put in their place. `logs` are the logs of
/// the curves.
pub fn learn(
    curves: &mut [Option<Curves>],
    logs: &[u32],
    borders: &[&Border],
) -> Option<BTreeMap<usize, Vec<f64>>> {
    let mut occurring: Vec<usize> = borders
        .iter()
        .flat_map(|border| border.curves.iter().copied())
        .collect();
    occurring.sort_unstable();
    occurring.dedup();
    let place = |one: usize| PARAMETERS * occurring.partition_point(|other| *other < one);
    let count = occurring.len() * PARAMETERS;
    let mut normal = Mat::<f64>::zeros(count, count);
    let mut right = vec![0.0; count];
    for border in borders {
        let to = |at: usize| place(border.curves[at / PARAMETERS]) + at % PARAMETERS;
        for row in 0..border.right.len() {
            right[to(row)] += border.right[row];
            for column in 0..border.right.len() {
                normal[(to(row), to(column))] += border.normal[(row, column)];
            }
        }
    }
    for one in &occurring {
        let before = curves[*one].as_ref()?;
        before.add_prior(&mut normal, &mut right, place(*one), 1.0);
    }
    for pair in occurring
        .windows(2)
        .filter(|pair| logs[pair[0]] == logs[pair[1]])
    {
        let set = |one: usize| Some((curves[one].as_ref()?, place(one)));
        Curves::add_tie(set(pair[0])?, set(pair[1])?, &mut normal, &mut right);
    }
    for at in 0..count {
        normal[(at, at)] += CURVE_DAMPING;
    }
    let step = solve_dense(&normal, &right)?;
    let mut steps = BTreeMap::new();
    for one in &occurring {
        let own: Vec<f64> = step[place(*one)..place(*one) + PARAMETERS]
            .iter()
            .map(|step| step.clamp(-MOST_CURVE_STEP, MOST_CURVE_STEP))
            .collect();
        let before = curves[*one].take()?;
        curves[*one] = Some(before.stepped(&own, MOST_CURVE_STEP));
        steps.insert(*one, own);
    }
    Some(steps)
}
