//! The correction of a surface: rounds of pieces on the surface as corrected so far, each solved a few times while weights and the size of
//! the correction settle.

use super::Kept;
use super::elimination;
use super::ground::Ground;
use super::layout::{Chunk, ChunkId, LaidOutLog};
use super::local_sigma::{blurred, local_sigma};
use super::nodes::{Blend, Nodes, Tile};
use super::pieces::pieces;
use super::readings::{gain_steps, readings};
use super::system::{Before, Reading, System};
use super::weed::Weed;
use crate::progress::{Cancelled, Progress};
use crate::sparse::{Normal, Pattern};
use crate::statistics::median;
use crate::survey::Side;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Rounds, each with the pieces where the correction so far puts them, and solutions in each.
const ROUNDS: usize = 2;
const SOLUTIONS: usize = 2;
/// Draws of what is unknown of a solution: where the size of the correction is learnt, which averages them over a window, and at the end,
/// for what is stated of each node.
const SAMPLES: usize = 8;
const LAST_SAMPLES: usize = 16;
/// Standard deviation of the correction to begin with, in usual ones, and at most, metres.
const FIRST_TIMES: f64 = 4.0;
const MOST_FIRST_M: f64 = 0.1;
/// Residuals beyond so many of their own robust standard deviations count less (Huber); that is at least this many of those stated, lest
/// the few that say something count for nothing where the others fit exactly.
const HUBER: f64 = 2.0;
const LEAST_RESIDUAL: f64 = 0.5;
/// A correction of so many of its standard deviations is halved at the end: a small one is more likely none.
const SHRINK: f64 = 0.85;
/// Pieces in a tile that are solved for at most: of more, the chunks are taken evenly. They take a kilobyte each.
const MOST_PIECES: usize = 60_000;
/// Nodes that echoes say something of are at least this share of those around a place that they tell something of.
const LEAST_SEEN: f64 = 1e-3;

/// The correction at the nodes.
#[derive(Clone, Debug)]
pub struct Correction {
    /// Where the nodes are.
    pub nodes: Nodes,
    /// What is added to the depth, metres.
    pub added_m: Vec<f64>,
    /// Natural logarithm of the bed's own brightness at the nodes, over an unknown one.
    pub ln_brightness: Vec<f64>,
    /// Where a piece of echoes lies next to the node.
    pub is_seen: Vec<bool>,
}

impl Correction {
    /// What is added to the depth at a place, metres.
    pub fn at(&self, place: [f64; 2]) -> f64 {
        self.nodes.value_at(&self.added_m, place)
    }

    /// Whether echoes say something of a place.
    pub fn sees(&self, place: [f64; 2]) -> bool {
        self.is_seen[self.nodes.nearest(place)]
    }

    /// Root mean square of the correction over a window of a standard deviation in metres about every node, of the nodes that echoes say something
    /// of; 0 where there are none.
    pub fn size_around_m(&self, window_m: f64) -> Vec<f64> {
        let seen: Vec<f64> = self
            .is_seen
            .iter()
            .map(|seen| f64::from(u8::from(*seen)))
            .collect();
        let squares: Vec<f64> = (self.added_m.iter().zip(&seen))
            .map(|(added_m, seen)| seen * added_m * added_m)
            .collect();
        let window = window_m / self.nodes.step_m;
        let [squares, seen] =
            [squares, seen].map(|values| blurred(self.nodes.counts, &values, window));
        let root = |(square, seen): (&f64, &f64)| (square / seen.max(LEAST_SEEN)).max(0.0).sqrt();
        squares.iter().zip(&seen).map(root).collect()
    }
}

/// What is solved for.
pub struct Tiling {
    /// All nodes.
    pub nodes: Nodes,
    /// The parts of them that are solved for together.
    pub tiles: Vec<Tile>,
    /// Those of which the last round needs a solution, too: what lies around a part of a map only tells it how the bed goes on.
    pub last: Vec<usize>,
    /// Fewer pieces on all nodes tell nothing.
    pub least_pieces: usize,
}

/// What does not change from round to round.
struct Given<'a> {
    logs: &'a [LaidOutLog<'a>],
    ground: &'a Ground,
    anchors: &'a [[f64; 2]],
    usual_m: f64,
    weed: Weed,
    nodes: Nodes,
}

/// What the rounds find.
struct State {
    correction_m: Vec<f64>,
    sd_m: Vec<f64>,
    sigma_m: Vec<f64>,
    ln_brightness: Vec<f64>,
    /// Of each tile, once it was solved.
    curves: Vec<Option<AngleCurves>>,
}

type AngleCurves = BTreeMap<(u32, Side), Vec<f64>>;

/// The solution of a tile.
struct Solved {
    correction_m: Vec<f64>,
    sd_m: Vec<f64>,
    sigma_m: Vec<f64>,
    ln_brightness: Vec<f64>,
    /// `None` of a tile without readings.
    curves: Option<AngleCurves>,
}

impl Solved {
    /// No correction where nothing was read.
    fn of_nothing(sigma_m: Vec<f64>) -> Self {
        Self {
            correction_m: vec![0.0; sigma_m.len()],
            sd_m: vec![0.0; sigma_m.len()],
            ln_brightness: vec![0.0; sigma_m.len()],
            sigma_m,
            curves: None,
        }
    }
}

/// The correction of a ground by the echoes of some logs. `anchors` are the places of measured depths, `usual_m` is the size of a correction
/// that is drawn to where little is known.
///
/// # Errors
/// When the work was cancelled.
pub fn correction(
    logs: &[LaidOutLog<'_>],
    ground: &Ground,
    tiling: &Tiling,
    anchors: &[[f64; 2]],
    usual_m: f64,
    progress: &Progress,
) -> Result<Result<Correction, Kept>, Cancelled> {
    if logs.iter().all(|log| log.ln_per_level.is_none()) {
        return Ok(Err(Kept::NoDecibels));
    }
    let Tiling { nodes, tiles, .. } = tiling;
    let given = Given {
        logs,
        ground,
        anchors,
        usual_m,
        weed: Weed::of(logs),
        nodes: *nodes,
    };
    let mut state = State::new(nodes, tiles.len(), usual_m);
    let all: Vec<usize> = (0..tiles.len()).collect();
    progress.start((SOLUTIONS * ((ROUNDS - 1) * all.len() + tiling.last.len())) as u64);
    let mut is_seen = vec![false; nodes.len()];
    for round in 0..ROUNDS {
        let (found, steps) = given.readings(round, &state, progress)?;
        if found.len() < tiling.least_pieces {
            return Ok(Err(Kept::TooFewEchoes));
        }
        let (solved, last_samples) = match round + 1 == ROUNDS {
            true => (&tiling.last, LAST_SAMPLES),
            false => (&all, 0),
        };
        let due = Due { tiles, solved };
        if !state.solve(&given, &due, &found, &steps, last_samples, progress)? {
            return Ok(Err(Kept::NotSolved));
        }
        is_seen.fill(false);
        for reading in &found {
            is_seen[nodes.nearest(reading.piece.place_m)] = true;
        }
    }
    let shrunk = |(correction_m, sd_m): (&f64, &f64)| {
        let squared = correction_m * correction_m;
        correction_m * squared / (squared + (SHRINK * sd_m).powi(2)).max(1e-12)
    };
    Ok(Ok(Correction {
        nodes: *nodes,
        added_m: state
            .correction_m
            .iter()
            .zip(&state.sd_m)
            .map(shrunk)
            .collect(),
        ln_brightness: state.ln_brightness,
        is_seen,
    }))
}

impl Given<'_> {
    /// The pieces on the ground as corrected so far, and the chunks before which the gain steps.
    fn readings(
        &self,
        round: usize,
        state: &State,
        progress: &Progress,
    ) -> Result<(Vec<Reading>, BTreeSet<ChunkId>), Cancelled> {
        let corrected;
        let ground = match round {
            0 => self.ground,
            _ => {
                corrected = self
                    .ground
                    .with(|place| self.nodes.value_at(&state.correction_m, place));
                &corrected
            }
        };
        let of_chunk = |(log, chunk): (usize, &Chunk)| {
            progress.check()?;
            let LaidOutLog {
                echoes,
                ln_per_level,
                ..
            } = &self.logs[log];
            let pieces = pieces(echoes, log as u32, chunk, ground);
            Ok(readings(&pieces, *ln_per_level))
        };
        let chunks = self.logs.iter().enumerate();
        let chunks: Vec<(usize, &Chunk)> = chunks
            .flat_map(|(log, of)| of.chunks.iter().map(move |chunk| (log, chunk)))
            .collect();
        let each: Result<Vec<Vec<Reading>>, Cancelled> =
            chunks.into_par_iter().map(of_chunk).collect();
        let each = each?;
        // The readings are the largest that is held of a survey: those of each chunk go as they are taken over.
        let mut found = Vec::with_capacity(each.iter().map(Vec::len).sum());
        each.into_iter().for_each(|one| found.extend(one));
        // Gains step where they do, whether over weed or not.
        let steps = gain_steps(&found);
        found.retain(|Reading { piece, .. }| {
            self.nodes.holds(piece.place_m) && self.weed.is_far_from(piece.place_m)
        });
        Ok((found, steps))
    }
}

/// The tiles, and those of them that are solved.
struct Due<'a> {
    tiles: &'a [Tile],
    solved: &'a [usize],
}

impl State {
    fn new(nodes: &Nodes, tiles: usize, usual_m: f64) -> Self {
        Self {
            correction_m: vec![0.0; nodes.len()],
            sd_m: vec![0.0; nodes.len()],
            ln_brightness: vec![0.0; nodes.len()],
            sigma_m: vec![(FIRST_TIMES * usual_m).min(MOST_FIRST_M); nodes.len()],
            curves: vec![None; tiles],
        }
    }

    /// Solves the tiles that are due. One without a solution has no correction; false where none has one.
    fn solve(
        &mut self,
        given: &Given<'_>,
        due: &Due<'_>,
        found: &[Reading],
        steps: &BTreeSet<ChunkId>,
        last_samples: usize,
        progress: &Progress,
    ) -> Result<bool, Cancelled> {
        let solve = |index: &usize| {
            let tile = &due.tiles[*index];
            let own = within(tile, found);
            let sigma_m = tile.cut(&given.nodes, &self.sigma_m);
            if own.is_empty() {
                progress.advance(SOLUTIONS as u64);
                return Ok(Some(Solved::of_nothing(sigma_m)));
            }
            let curves = self.curves.get(*index).and_then(Option::as_ref);
            let before = curves.map(|curves| Before {
                correction_m: tile.cut(&given.nodes, &self.correction_m),
                angle_curves: curves.clone(),
            });
            let holds = |place: &&[f64; 2]| due.tiles.len() == 1 || tile.nodes.holds(**place);
            let anchors: Vec<[f64; 2]> = given.anchors.iter().filter(holds).copied().collect();
            let is_break = |chunk: ChunkId| steps.contains(&chunk);
            let system = System::new(
                tile.nodes,
                &own,
                &anchors,
                &sigma_m,
                before.as_ref(),
                is_break,
            );
            solve_tile(
                system,
                tile.nodes,
                sigma_m,
                given.usual_m,
                last_samples,
                progress,
            )
        };
        let solved: Result<Vec<Option<Solved>>, Cancelled> =
            due.solved.par_iter().map(solve).collect();
        let solved = solved?;
        if solved.iter().all(Option::is_none) {
            return Ok(false);
        }
        let [mut correction_m, mut sd_m, mut sigma_m, mut brightness] =
            [0; 4].map(|_| Blend::none(&given.nodes));
        for (index, solved) in due.solved.iter().zip(solved) {
            let tile = &due.tiles[*index];
            let solved =
                solved.unwrap_or_else(|| Solved::of_nothing(tile.cut(&given.nodes, &self.sigma_m)));
            correction_m.add(&given.nodes, tile, &solved.correction_m);
            sd_m.add(&given.nodes, tile, &solved.sd_m);
            sigma_m.add(&given.nodes, tile, &solved.sigma_m);
            // Gain and brightness are known but for a constant, which each tile finds for itself.
            if solved.curves.is_some() {
                brightness.add_level(&given.nodes, tile, &solved.ln_brightness);
            }
            self.curves[*index] = solved.curves;
        }
        [
            self.correction_m,
            self.sd_m,
            self.sigma_m,
            self.ln_brightness,
        ] = [correction_m, sd_m, sigma_m, brightness].map(Blend::values);
        Ok(true)
    }
}

/// The readings within a tile; of every so many chunks alone where they are too many.
fn within(tile: &Tile, found: &[Reading]) -> Vec<Reading> {
    let inside = |reading: &&Reading| tile.nodes.holds(reading.piece.place_m);
    let count = found.iter().filter(inside).count();
    let every = count.div_ceil(MOST_PIECES).max(1) as u32;
    let counts =
        |reading: &&Reading| inside(reading) && reading.piece.chunk.number.is_multiple_of(every);
    found.iter().filter(counts).copied().collect()
}

/// Solves a tile a few times: each solution says which readings do not fit, and how large the correction is where. What is unknown of the
/// last is told from `last_samples` draws. `None` where it has no solution.
fn solve_tile(
    mut system: System,
    nodes: Nodes,
    mut sigma_m: Vec<f64>,
    usual_m: f64,
    last_samples: usize,
    progress: &Progress,
) -> Result<Option<Solved>, Cancelled> {
    let pattern = Pattern::in_order(&system.equations, system.unknowns, |neighbours| {
        elimination::order(&nodes, neighbours)
    });
    let Some(pattern) = pattern else {
        return Ok(None);
    };
    let mut found = None;
    for solution in 0..SOLUTIONS {
        progress.check()?;
        let Some(factor) = pattern.factorise(&system.equations) else {
            return Ok(None);
        };
        progress.check()?;
        let mut normal = Normal::new(solution as u64);
        let is_last = solution + 1 == SOLUTIONS;
        let samples = if is_last { last_samples } else { SAMPLES };
        let columns = factor.solve(&pattern, &system.equations, samples, || normal.draw());
        let Some((values, samples)) = columns.split_first() else {
            return Ok(None);
        };
        if values.iter().any(|value| !value.is_finite()) {
            return Ok(None);
        }
        if !is_last {
            system.doubt_edges(values);
            weigh_anew(&mut system, values);
            let samples: Vec<&[f64]> = samples
                .iter()
                .map(|sample| &sample[..nodes.len()])
                .collect();
            sigma_m = local_sigma(&nodes, &values[..nodes.len()], &samples, usual_m);
            system.set_sigma(&sigma_m);
        } else {
            let sd = |node: usize| {
                let squares = samples.iter().map(|sample| sample[node].powi(2));
                (squares.sum::<f64>() / samples.len().max(1) as f64).sqrt()
            };
            found = Some(Solved {
                correction_m: values[..nodes.len()].to_vec(),
                sd_m: (0..nodes.len()).map(sd).collect(),
                sigma_m: sigma_m.clone(),
                ln_brightness: system.ln_brightness(values).to_vec(),
                curves: Some(system.angle_curves(values)),
            });
        }
        progress.advance(1);
    }
    Ok(found)
}

/// Gives the readings weights by how well the solution fits them.
fn weigh_anew(system: &mut System, solution: &[f64]) {
    let residual = |reading: usize| system.equations.residual(reading, solution).abs();
    let residuals: Vec<f64> = (0..system.reading_sd.len()).map(residual).collect();
    let usual = (1.48 * median(&mut residuals.clone())).max(LEAST_RESIDUAL);
    for (reading, residual) in residuals.into_iter().enumerate() {
        let times = residual / usual;
        let robust = if times > HUBER {
            (HUBER / times).sqrt()
        } else {
            1.0
        };
        let sd = system.reading_sd[reading] / robust;
        system.equations.set_sd(reading, sd);
    }
}

#[cfg(test)]
mod tests;
