//! The unknowns of a tile and the equations between them.
//!
//! Unknown are the correction `c` of the depth and the logarithm `a` of the bed's own brightness at the nodes, the gain and the roll of
//! every chunk of pings, a curve `g` over the angle from straight down for each log and side, and a curve `h` over the slant range for each
//! range setting and side. A piece at `x` that looks outward along `o` gives, with the level `m` in natural logarithms of power,
//! `d = (c(x + u o) - c(x - u o)) / 2u` and `F` and `S` of [`AtSlope`] on the surface with the correction `c'` of the round before,
//!
//! `-S d + a(x) + gain + roll s (phi - 45 deg) / 15 deg + g(phi) + h(r) + k c(x) = m - F - S d' + k c'(x)`
//!
//! where `s` is -1 to port and 1 to starboard, and `k` what the level changes because the
//! angle under which a deeper bed is seen is smaller: `k = -g'(phi) / (r sin phi)`.

use super::echo_law::AtSlope;
use super::layout::ChunkId;
use super::level_scale::{GRAIN_SAMPLES, SPECKLE_SD};
use super::nodes::{Nodes, Shares, sum};
use super::pieces::{PIECE_M, Piece};
use crate::sparse::Equations;
use crate::survey::Side;
use std::collections::BTreeMap;

/// Standard deviation of what the model lacks, natural logarithm of power.
const SD_MODEL: f64 = 0.35;
/// How far a piece may lie beside where it is thought to be, metres. Positions are better than that, but what they are off by hangs
/// together over many pieces.
const BESIDE_M: f64 = 0.8;
/// Standard deviation of the correction at a depth that was measured, metres; of several at one node that of their mean.
const SD_ANCHOR_M: f64 = 0.03;
/// Standard deviation of the brightness from one node to the next, and of itself: a tight one would forbid patches of several metres.
const SD_BRIGHTNESS_STEP: f64 = 0.7;
const SD_BRIGHTNESS: f64 = 10.0;
/// Standard deviations of the gain and the roll from one chunk to the next, and of themselves. The roll counts what 15 degrees change.
const SD_GAIN_STEP: f64 = 0.06;
const SD_GAIN: f64 = 20.0;
const SD_ROLL_STEP: f64 = 0.03;
const SD_ROLL: f64 = 0.03;
/// Chunks farther apart than this are not tied.
const FARTHEST_TIE: u32 = 50;
/// Standard deviations of the second differences of a curve, and of its values over the angle and over the range.
const SD_BEND: f64 = 0.05;
const SD_ANGLE_CURVE: f64 = 5.0;
const SD_RANGE_CURVE: f64 = 0.5;
/// Bins of the curves: degrees and metres.
const ANGLE_BIN_DEG: f64 = 2.0;
const RANGE_BIN_M: f64 = 0.5;
const ANGLE_BINS: usize = 46;
/// Reciprocal of the length over which the correction hangs together, a metre.
const KAPPA_PER_M: f64 = 0.6;
/// The middle of the angles that the roll turns about, and what it counts, degrees.
const ROLL_DEG: [f64; 2] = [45.0, 15.0];

/// A piece with what is computed of it once a round.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// The piece.
    pub piece: Piece,
    /// Its level in natural logarithms of power.
    pub ln_level: f64,
    /// The bed's share of the recorded power, 0.1 to 1.
    pub share: f64,
}

/// What a round takes over from the one before.
#[derive(Clone, Debug)]
pub struct Before {
    /// The correction at the nodes of the tile, metres.
    pub correction_m: Vec<f64>,
    /// The curves over the angle by log and side.
    pub angle_curves: BTreeMap<(u32, Side), Vec<f64>>,
}

/// The equations of a tile.
pub struct System {
    /// All of them: those of the readings come first.
    pub equations: Equations,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Standard deviation of every reading.
    pub reading_sd: Vec<f64>,
    /// Where every reading lies, east and north, metres.
    places_m: Vec<[f64; 2]>,
    nodes: Nodes,
    /// The first of the equations that hold the correction together, one a node.
    prior_at: usize,
    angle_curves: BTreeMap<(u32, Side), usize>,
}

/// Where the unknowns of each kind begin.
struct Numbering {
    brightness: usize,
    /// Chunk of all logs, to its place among those of the tile.
    chunks: BTreeMap<ChunkId, usize>,
    gain: usize,
    roll: usize,
    angle_curves: BTreeMap<(u32, Side), usize>,
    /// By log, range setting and side.
    range_curves: BTreeMap<(u32, i32, Side), usize>,
    range_bins: usize,
    count: usize,
}

impl Numbering {
    fn new(nodes: &Nodes, readings: &[Reading]) -> Self {
        let mut chunks = BTreeMap::new();
        let mut angle_curves = BTreeMap::new();
        let mut range_curves = BTreeMap::new();
        let mut most_m: f64 = 0.0;
        for Reading { piece, .. } in readings {
            chunks.insert(piece.chunk, 0);
            angle_curves.insert((piece.chunk.log, piece.side), 0);
            range_curves.insert((piece.chunk.log, piece.range_setting, piece.side), 0);
            most_m = most_m.max(piece.range_m);
        }
        for (index, place) in chunks.values_mut().enumerate() {
            *place = index;
        }
        let brightness = nodes.len();
        let gain = 2 * nodes.len();
        let roll = gain + chunks.len();
        let mut count = roll + chunks.len();
        for first in angle_curves.values_mut() {
            *first = count;
            count += ANGLE_BINS;
        }
        let range_bins = (most_m / RANGE_BIN_M) as usize + 2;
        for first in range_curves.values_mut() {
            *first = count;
            count += range_bins;
        }
        Self {
            brightness,
            chunks,
            gain,
            roll,
            angle_curves,
            range_curves,
            range_bins,
            count,
        }
    }
}

impl System {
    /// Of the readings and the places of measured depths within some nodes. `sigma_m` is the standard deviation of the correction at each
    /// node, `is_break` says of a chunk whether the gain steps before it.
    pub fn new(
        nodes: Nodes,
        readings: &[Reading],
        anchors: &[[f64; 2]],
        sigma_m: &[f64],
        before: Option<&Before>,
        is_break: impl Fn(ChunkId) -> bool,
    ) -> Self {
        let numbering = Numbering::new(&nodes, readings);
        let mut equations = Equations::default();
        let reading_sd: Vec<f64> = readings
            .iter()
            .map(|reading| sd_of(&reading.piece) / reading.share)
            .collect();
        for (reading, sd) in readings.iter().zip(&reading_sd) {
            add_reading(&mut equations, &nodes, &numbering, reading, before, *sd);
        }
        add_brightness(&mut equations, &nodes, numbering.brightness);
        let prior_at = equations.len();
        for (node, sigma_m) in sigma_m.iter().enumerate() {
            equations.add(
                innovation_terms(&nodes, node),
                0.0,
                innovation_sd(&nodes, *sigma_m),
            );
        }
        add_anchors(&mut equations, &nodes, anchors);
        add_chunks(&mut equations, &numbering, is_break);
        for first in numbering.angle_curves.values() {
            add_curve(&mut equations, *first, ANGLE_BINS, SD_ANGLE_CURVE);
        }
        for first in numbering.range_curves.values() {
            add_curve(&mut equations, *first, numbering.range_bins, SD_RANGE_CURVE);
        }
        Self {
            equations,
            unknowns: numbering.count,
            reading_sd,
            places_m: readings.iter().map(|one| one.piece.place_m).collect(),
            nodes,
            prior_at,
            angle_curves: numbering.angle_curves,
        }
    }

    /// Gives the correction another standard deviation at every node, metres.
    pub fn set_sigma(&mut self, sigma_m: &[f64]) {
        for (node, sigma_m) in sigma_m.iter().enumerate() {
            let sd = innovation_sd(&self.nodes, *sigma_m);
            self.equations.set_sd(self.prior_at + node, sd);
        }
    }

    /// Trusts readings less where the brightness of a solution changes fast: a piece that lies a little beside where it is thought to be
    /// has another brightness there, which must not count as a slope.
    pub fn doubt_edges(&mut self, solution: &[f64]) {
        let ln_brightness = self.ln_brightness(solution);
        let nodes = &self.nodes;
        let steepness = |place_m: [f64; 2]| {
            let along = [0, 1].map(|axis| {
                let at = |steps: f64| {
                    let mut beside = place_m;
                    beside[axis] += steps * nodes.step_m;
                    nodes.value_at(ln_brightness, beside)
                };
                (at(1.0) - at(-1.0)) / (2.0 * nodes.step_m)
            });
            along[0].hypot(along[1])
        };
        for (sd, place_m) in self.reading_sd.iter_mut().zip(&self.places_m) {
            *sd = sd.hypot(BESIDE_M * steepness(*place_m));
        }
    }

    /// The brightness at the nodes out of a solution, natural logarithms.
    pub fn ln_brightness<'a>(&self, solution: &'a [f64]) -> &'a [f64] {
        &solution[self.nodes.len()..2 * self.nodes.len()]
    }

    /// The curves over the angle out of a solution.
    pub fn angle_curves(&self, solution: &[f64]) -> BTreeMap<(u32, Side), Vec<f64>> {
        let curve = |first: usize| solution[first..first + ANGLE_BINS].to_vec();
        self.angle_curves
            .iter()
            .map(|(of, first)| (*of, curve(*first)))
            .collect()
    }
}

/// Standard deviation of a piece's level: of its speckle, and of what the model lacks.
fn sd_of(piece: &Piece) -> f64 {
    let independent = f64::from(piece.samples) / GRAIN_SAMPLES;
    (SPECKLE_SD.powi(2) / independent).sqrt().hypot(SD_MODEL)
}

fn add_reading(
    equations: &mut Equations,
    nodes: &Nodes,
    numbering: &Numbering,
    reading: &Reading,
    before: Option<&Before>,
    sd: f64,
) {
    let piece = &reading.piece;
    let AtSlope {
        ln_over_level,
        per_slope,
    } = AtSlope::new(piece.phi_rad, piece.slope);
    let half_m = 0.5 * PIECE_M;
    let at = |metres: f64| -> Shares {
        nodes.shares([0, 1].map(|axis| piece.place_m[axis] + metres * piece.outward[axis]))
    };
    let [inner, here, outer] = [-half_m, 0.0, half_m].map(at);
    let mut goal = reading.ln_level - ln_over_level;
    let mut per_depth = 0.0;
    if let Some(Before {
        correction_m,
        angle_curves,
    }) = before
    {
        goal -=
            per_slope * (sum(correction_m, &outer) - sum(correction_m, &inner)) / (2.0 * half_m);
        if let Some(curve) = angle_curves.get(&(piece.chunk.log, piece.side)) {
            per_depth = -steepness(curve, piece.phi_rad) / (piece.range_m * piece.phi_rad.sin());
            goal += per_depth * sum(correction_m, &here);
        }
    }
    let times = |shares: Shares, factor: f64, first: usize| {
        shares
            .into_iter()
            .map(move |(node, share)| (first + node, factor * share))
    };
    let slope = per_slope / (2.0 * half_m);
    let sign = if piece.side == Side::Port { -1.0 } else { 1.0 };
    let roll = sign * (piece.phi_rad.to_degrees() - ROLL_DEG[0]) / ROLL_DEG[1];
    let angle = (piece.chunk.log, piece.side);
    let range = (piece.chunk.log, piece.range_setting, piece.side);
    let places = (
        numbering.chunks.get(&piece.chunk),
        numbering.angle_curves.get(&angle),
        numbering.range_curves.get(&range),
    );
    let (Some(chunk), Some(angle_curve), Some(range_curve)) = places else {
        return;
    };
    let on_curve = |first: usize, bins: f64| {
        let below = first + bins as usize;
        [(below, 1.0 - bins.fract()), (below + 1, bins.fract())]
    };
    let terms = times(outer, -slope, 0)
        .chain(times(inner, slope, 0))
        .chain(times(here, 1.0, numbering.brightness))
        .chain([
            (numbering.gain + chunk, 1.0),
            (numbering.roll + chunk, roll),
        ])
        .chain(on_curve(
            *angle_curve,
            piece.phi_rad.to_degrees() / ANGLE_BIN_DEG,
        ))
        .chain(on_curve(*range_curve, piece.range_m / RANGE_BIN_M));
    match per_depth {
        0.0 => equations.add(terms, goal, sd),
        _ => equations.add(terms.chain(times(here, per_depth, 0)), goal, sd),
    }
}

/// How steep a curve over the angle is at an angle, a radian: linear between differences over two bins.
fn steepness(curve: &[f64], phi_rad: f64) -> f64 {
    let last = curve.len() - 1;
    let at_bin = |bin: usize| {
        let [from, to] = [bin.saturating_sub(1), (bin + 1).min(last)];
        (curve[to] - curve[from]) / (to - from) as f64
    };
    let bins = phi_rad.to_degrees() / ANGLE_BIN_DEG;
    let below = (bins as usize).min(last);
    let share = bins - below as f64;
    let per_bin = at_bin(below) * (1.0 - share) + at_bin((below + 1).min(last)) * share;
    per_bin / ANGLE_BIN_DEG.to_radians()
}

fn add_brightness(equations: &mut Equations, nodes: &Nodes, first: usize) {
    for node in 0..nodes.len() {
        let [_, east, _, north] = nodes.neighbours(node);
        for other in [east, north].into_iter().filter(|other| *other != node) {
            equations.add(
                [(first + node, 1.0), (first + other, -1.0)],
                0.0,
                SD_BRIGHTNESS_STEP,
            );
        }
        equations.add([(first + node, 1.0)], 0.0, SD_BRIGHTNESS);
    }
}

/// The terms of `(kappa^2 - Laplace) c` at a node, whose values are independent where the correction is a Matern field (Lindgren et al.
/// 2011, doi 10.1111/j.1467-9868.2011.00777.x).
fn innovation_terms(nodes: &Nodes, node: usize) -> impl Iterator<Item = (usize, f64)> {
    let per_m2 = 1.0 / nodes.step_m.powi(2);
    let own = [(node, KAPPA_PER_M.powi(2) + 4.0 * per_m2)];
    own.into_iter()
        .chain(nodes.neighbours(node).map(|other| (other, -per_m2)))
}

/// Standard deviation of those values for that of the correction, metres: `sigma sqrt(4 pi) kappa / step`.
pub fn innovation_sd(nodes: &Nodes, sigma_m: f64) -> f64 {
    sigma_m * (4.0 * std::f64::consts::PI).sqrt() * KAPPA_PER_M / nodes.step_m
}

/// Those values at every node.
pub fn innovations(nodes: &Nodes, correction_m: &[f64]) -> Vec<f64> {
    let at = |node| {
        innovation_terms(nodes, node)
            .map(|(other, factor)| factor * correction_m[other])
            .sum()
    };
    (0..nodes.len()).map(at).collect()
}

/// No correction where a depth was measured.
fn add_anchors(equations: &mut Equations, nodes: &Nodes, anchors: &[[f64; 2]]) {
    let mut counts = vec![0_u32; nodes.len()];
    for place in anchors {
        counts[nodes.nearest(*place)] += 1;
    }
    for place in anchors {
        let several = f64::from(counts[nodes.nearest(*place)]).sqrt();
        equations.add(nodes.shares(*place), 0.0, SD_ANCHOR_M * several);
    }
}

/// Ties every chunk to the one before, unless the gain steps between them.
fn add_chunks(
    equations: &mut Equations,
    numbering: &Numbering,
    is_break: impl Fn(ChunkId) -> bool,
) {
    let Numbering {
        chunks, gain, roll, ..
    } = numbering;
    let mut last: Option<(ChunkId, usize)> = None;
    for (&chunk, &place) in chunks {
        equations.add([(gain + place, 1.0)], 0.0, SD_GAIN);
        equations.add([(roll + place, 1.0)], 0.0, SD_ROLL);
        if let Some((before, place_before)) = last.filter(|(before, _)| before.log == chunk.log) {
            let apart = chunk.number - before.number;
            let between =
                (before.number + 1..=chunk.number).map(|number| ChunkId { number, ..chunk });
            if apart <= FARTHEST_TIE && !between.into_iter().any(&is_break) {
                for (first, sd) in [(gain, SD_GAIN_STEP), (roll, SD_ROLL_STEP)] {
                    let terms = [(first + place, 1.0), (first + place_before, -1.0)];
                    equations.add(terms, 0.0, sd * f64::from(apart).sqrt());
                }
            }
        }
        last = Some((chunk, place));
    }
}

fn add_curve(equations: &mut Equations, first: usize, bins: usize, sd: f64) {
    for bin in first..first + bins {
        equations.add([(bin, 1.0)], 0.0, sd);
        if bin > first && bin + 1 < first + bins {
            equations.add([(bin - 1, 1.0), (bin, -2.0), (bin + 1, 1.0)], 0.0, SD_BEND);
        }
    }
}
