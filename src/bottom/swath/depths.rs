//! Runs the rounds of the solution: learns the curves on a sample of tiles, then finds the depths
//! of all tiles with these curves.

use super::echoes::WeedPlaces;
use super::layout::{LaidOutLog, PingChunk};
use super::model::{FitPlace, Incidence, LawCurves};
use super::nodes::{Blend, Nodes};
use super::observations::SideChunk;
use super::solve::{Prior, TileInput, TileSolution, learn};
use super::tiling::{Resolution, Tiling};
use crate::bathymetry::{Bends, DepthPoint, Node, merge_repeated};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Side;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Number of rounds in which curves are learnt: the first time, from curves that fit the levels on
/// triangles, and further times, from curves that were learnt before.
pub(super) const LEARNING_ROUNDS: [usize; 2] = [3, 2];
/// Side of the squares in which measured depths are merged, metres.
const MEASURED_M: f64 = 0.5;
/// Bins that the first curves are fitted to: length in range, metres; width in angle, degrees; and
/// least number of independent samples in each.
const FIT_RANGE_M: f64 = 0.25;
const FIT_ANGLE_DEG: f64 = 2.0;
const FIT_LEAST: f64 = 100.0;
/// Least number of bins that determine curves.
const LEAST_BINS: usize = 40;

/// Input that depths are found from.
pub(super) struct SwathInput<'a> {
    /// Looks of all logs.
    pub looks: Vec<SideChunk>,
    /// Recorder and range setting of each set of curves.
    pub sets: Vec<(u32, i32)>,
    /// Measured depths, one for each square.
    pub measured: Vec<Node>,
    /// Bends of the triangles between the measured depths; `None` where the triangles are flat.
    pub bends: Option<Bends>,
    /// The logs that the looks come from.
    pub logs: &'a [LaidOutLog<'a>],
    weed: WeedPlaces,
}

/// Depths found at the nodes, with their uncertainty.
pub(super) struct NodeDepths {
    /// Places of the nodes.
    pub nodes: Nodes,
    /// Depth at each node, metres.
    pub depth_m: Vec<f64>,
    /// Natural logarithm of the bed's own brightness at each node.
    pub ln_brightness: Vec<f64>,
    /// Standard deviation of the depth by the equations, metres.
    pub sd_m: Vec<f64>,
    /// Share of the tiles at each node in which an observation is next to the node, 0 to 1,
    /// weighted as the depths are.
    pub seen: Vec<f64>,
}

impl<'a> SwathInput<'a> {
    /// Creates the input from the logs whose law is known; `recorders` holds for each log the index
    /// of the log whose curves it shares.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(super) fn new(
        logs: &'a [LaidOutLog<'a>],
        recorders: &[u32],
        (measured, bends): (&[DepthPoint], Option<Bends>),
        resolution: Resolution,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let settings = |(log, recorder): (&'a LaidOutLog<'a>, &u32)| {
            let recorder = *recorder;
            let chunks = log.chunks.iter();
            chunks.map(move |chunk| (recorder, chunk.range_setting))
        };
        let mut sets: Vec<(u32, i32)> = logs.iter().zip(recorders).flat_map(settings).collect();
        sets.sort_unstable();
        sets.dedup();
        let mut looks = Vec::new();
        for (number, (log, recorder)) in logs.iter().zip(recorders).enumerate() {
            progress.check()?;
            let Some(law) = logs[*recorder as usize].law else {
                continue;
            };
            let table = law.table();
            let of_chunk = |chunk: &PingChunk| {
                let set = (*recorder, chunk.range_setting);
                let curves = sets.partition_point(|other| *other < set);
                Side::BOTH.map(|side| {
                    SideChunk::new(log, number, chunk, curves, side, &table, resolution.range_m)
                })
            };
            let chunks = PingChunk::joined(&log.chunks, resolution.chunks);
            let found: Vec<[Option<SideChunk>; 2]> = chunks.par_iter().map(of_chunk).collect();
            looks.extend(found.into_iter().flatten().flatten());
        }
        Ok(Self {
            looks,
            sets,
            measured: merged(measured),
            bends,
            weed: WeedPlaces::of(logs.iter().map(|log| (&log.echoes, &log.is_weed[..]))),
            logs,
        })
    }

    /// Returns the tiles in which most looks begin, those with most looks first; at most `most` of
    /// them.
    pub(super) fn busiest(&self, tiling: &Tiling, most: usize) -> Vec<usize> {
        let begin = |tile: &usize| {
            let nodes = &tiling.tiles[*tile].nodes;
            self.looks.iter().filter(|look| nodes.holds(look.place_m)).count()
        };
        let mut counted: Vec<(usize, usize)> =
            (0..tiling.tiles.len()).map(|tile| (begin(&tile), tile)).collect();
        counted.retain(|(count, _)| *count > 0);
        counted.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        counted.truncate(most);
        counted.into_iter().map(|(_, tile)| tile).collect()
    }

    /// Finds the depths of all tiles with known curves; `None` where no tile can be solved.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(super) fn find(
        &self,
        tiling: &Tiling,
        curves: &[Option<LawCurves>],
        prior: Prior,
        progress: &Progress,
    ) -> Result<Option<NodeDepths>, Cancelled> {
        let is_bed = |place: [f64; 2]| self.weed.is_far_from(place);
        progress.start(tiling.tiles.len() as u64);
        let of_tile = |tile: usize| {
            progress.check()?;
            progress.advance(1);
            let nodes = &tiling.tiles[tile].nodes;
            let measured = (&self.measured[..], self.bends);
            let state = TileSolution::new(tile, nodes, measured, &self.looks);
            let Some(mut state) = state else {
                return Ok(None);
            };
            let mut last = None;
            for round in 0..tiling.resolution.rounds {
                let given = TileInput {
                    looks: &self.looks,
                    curves,
                    level_cell_m: tiling.resolution.level_cell_m,
                    is_bed: &is_bed,
                    prior,
                    is_robust: round > 0,
                };
                let Some(solved) = state.solve(&given, false) else {
                    return Ok(None);
                };
                last = Some(solved);
            }
            Ok(last.map(|solved| (tile, state.bed, solved)))
        };
        let solved: Vec<_> = (0..tiling.tiles.len())
            .into_par_iter()
            .map(of_tile)
            .collect::<Result<_, Cancelled>>()?;
        let nodes = tiling.nodes;
        let [mut depth_m, mut brightness, mut sd_m, mut seen] = [0; 4].map(|_| Blend::none(&nodes));
        let mut is_any = false;
        for (tile, bed, of_tile) in solved.into_iter().flatten() {
            is_any = true;
            let tile = &tiling.tiles[tile];
            let is_seen: Vec<f64> =
                of_tile.is_seen.into_iter().map(|seen| f64::from(u8::from(seen))).collect();
            depth_m.add(&nodes, tile, &bed.depth_m);
            brightness.add(&nodes, tile, &bed.ln_brightness);
            sd_m.add(&nodes, tile, &bed.sd_m);
            seen.add(&nodes, tile, &is_seen);
        }
        Ok(is_any.then(|| NodeDepths {
            nodes,
            depth_m: depth_m.values(),
            ln_brightness: brightness.values(),
            sd_m: sd_m.values(),
            seen: seen.values(),
        }))
    }
}

/// Returns the measured depths, merged to one for each square.
pub(super) fn merged(measured: &[DepthPoint]) -> Vec<Node> {
    merge_repeated(measured, MEASURED_M)
}

/// Tiles on which curves are learnt, together with their depths.
pub(super) struct Sample {
    /// State of each tile.
    pub states: Vec<TileSolution>,
    /// Curves of each set; `None` where they are unknown.
    pub curves: Vec<Option<LawCurves>>,
    resolution: Resolution,
    is_learnt: bool,
}

impl Sample {
    /// Creates the sample of some tiles with the given curves, or with the curves that fit the
    /// levels on the triangles between the measured depths.
    pub(super) fn new(
        input: &SwathInput<'_>,
        tiling: &Tiling,
        tiles: &[usize],
        measured: &[Node],
        curves: Option<Vec<Option<LawCurves>>>,
    ) -> Self {
        let state = |tile: &usize| {
            let measured = (measured, input.bends);
            TileSolution::new(*tile, &tiling.tiles[*tile].nodes, measured, &input.looks)
        };
        let states: Vec<TileSolution> = tiles.par_iter().filter_map(state).collect();
        Self {
            curves: curves.unwrap_or_else(|| first_curves(input, &states, tiling.resolution)),
            states,
            resolution: tiling.resolution,
            is_learnt: false,
        }
    }

    /// Learns curves and depths, starting from the present ones; returns false where they cannot be
    /// learnt.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(super) fn learn(
        &mut self,
        input: &SwathInput<'_>,
        prior: Prior,
        progress: &Progress,
    ) -> Result<bool, Cancelled> {
        let recorders: Vec<u32> = input.sets.iter().map(|(recorder, _)| *recorder).collect();
        for _ in 0..LEARNING_ROUNDS[usize::from(self.is_learnt)] {
            let is_bed = |place: [f64; 2]| input.weed.is_far_from(place);
            let given = TileInput {
                looks: &input.looks,
                curves: &self.curves,
                level_cell_m: self.resolution.level_cell_m,
                is_bed: &is_bed,
                prior,
                is_robust: self.is_learnt,
            };
            let solve = |state: &mut TileSolution| {
                progress.check()?;
                progress.advance(1);
                Ok(state.solve(&given, true).and_then(|solved| solved.border))
            };
            let states = self.states.par_iter_mut();
            let borders: Vec<_> = states.map(solve).collect::<Result<_, Cancelled>>()?;
            let known: Vec<_> = borders.iter().flatten().collect();
            let Some(steps) = learn(&mut self.curves, &recorders, &known) else {
                return Ok(false);
            };
            for (state, border) in self.states.iter_mut().zip(borders) {
                border.iter().for_each(|border| state.follow(border, &steps));
            }
            self.is_learnt = true;
        }
        Ok(true)
    }
}

/// Returns the curves that fit the levels on the beds of some tiles; `None` for a set with too few
/// bins.
fn first_curves(
    input: &SwathInput<'_>,
    states: &[TileSolution],
    resolution: Resolution,
) -> Vec<Option<LawCurves>> {
    let mut bins: Vec<BTreeMap<(i32, i32, bool), [f64; 5]>> =
        vec![BTreeMap::new(); input.sets.len()];
    for bed in states.iter().map(|state| &state.bed) {
        for look in &input.looks {
            look.read(bed, &bed.nodes, None, resolution.level_cell_m, |observation| {
                if !input.weed.is_far_from(observation.place_m) {
                    return;
                }
                let at = observation.at;
                let key = (
                    (at.range_m / FIT_RANGE_M) as i32,
                    (at.phi_rad.to_degrees() / FIT_ANGLE_DEG) as i32,
                    at.side > 0.0,
                );
                let sums = bins[look.curves].entry(key).or_default();
                let values = [1.0, at.range_m, at.phi_rad, at.slope, observation.ln_power];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += observation.independent * value;
                }
            });
        }
    }
    let fit = |bins: BTreeMap<(i32, i32, bool), [f64; 5]>| {
        let bins = bins.into_iter().filter(|(_, sums)| sums[0] >= FIT_LEAST);
        let places: Vec<FitPlace> = bins
            .map(|((_, _, is_starboard), [count, range_m, phi_rad, slope, ln_power])| FitPlace {
                at: Incidence {
                    range_m: range_m / count,
                    phi_rad: phi_rad / count,
                    slope: slope / count,
                    side: if is_starboard { 1.0 } else { -1.0 },
                },
                ln_power: ln_power / count,
                sd: (1.7 / count).sqrt().hypot(0.1),
            })
            .collect();
        (places.len() >= LEAST_BINS).then(|| LawCurves::fit(&places))?
    };
    bins.into_par_iter().map(fit).collect()
}
