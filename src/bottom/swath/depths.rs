//! Chooses the resolution for a survey, divides its nodes, or those of a part of a larger map, into
//! tiles that are solved one by one, and runs the rounds of the solution: learns the curves on a
//! sample of tiles, then finds the depths of all tiles with these curves.
//!
//! The tiles of a part of a map belong to a lattice that all parts share, so that neighbouring
//! parts find the same depths, to the bit, where they meet.

use super::echoes::WeedPlaces;
use super::layout::{LaidOutLog, PingChunk};
use super::model::{FitPlace, Incidence, LawCurves};
use super::nodes::{Blend, NodeTile, Nodes};
use super::observations::{FARTHEST_M, SideChunk};
use super::solve::{Prior, TileInput, TileSolution, learn};
use crate::bathymetry::{Bends, DepthPoint, Grid, Node, merge_repeated};
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
                    weed: &self.weed,
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
            let given = TileInput {
                looks: &input.looks,
                curves: &self.curves,
                level_cell_m: self.resolution.level_cell_m,
                weed: &input.weed,
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

/// Number of nodes along the side of a tile's core, and in the halo on each side of it.
const CORE: usize = 64;
const HALO: usize = 8;
/// Largest number of nodes that are solved for in a single tile.
const MOST_TOGETHER: usize = 24_000;
/// Largest number of nodes of a survey: at a step of a metre they cover eight square kilometres.
const MOST_NODES: usize = 8_000_000;

/// Resolution of depths and levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Resolution {
    /// Distance from one node to the next, metres.
    pub node_m: f64,
    /// Ground range of a level cell, metres.
    pub level_cell_m: f64,
    /// Length in slant range that levels are averaged over, metres.
    pub range_m: f64,
    /// Number of chunks of pings that are averaged together.
    pub chunks: usize,
    /// Number of rounds in which depths are found once the curves are known.
    pub rounds: usize,
}

impl Resolution {
    /// Resolution of a survey of at most [`MOST_FINE`] nodes at this resolution.
    pub(super) const FINE: Self =
        Self { node_m: 0.5, level_cell_m: 0.5, range_m: 0.06, chunks: 1, rounds: 2 };
    /// Resolution of a larger survey, and of the parts of a map.
    pub(super) const COARSE: Self = Self {
        node_m: 1.0,
        level_cell_m: 1.0,
        range_m: 0.12,
        chunks: 2,
        // On ponds a second round reduces the error by a twentieth, and takes a third more time.
        rounds: 1,
    };

    /// Returns the resolution at which curves are learnt and left-out soundings predicted.
    #[must_use]
    pub(super) fn of_learning(self) -> Self {
        Self { node_m: Self::COARSE.node_m, ..self }
    }
}

/// Largest number of nodes at the fine resolution.
const MOST_FINE: usize = 40_000;
/// Step of the edges of parts, which are multiples of it, metres.
pub const PART_STEP_M: f64 = CORE as f64 * Resolution::COARSE.node_m;
/// Width around a part in which measured depths must be known, metres: a core and the halo.
pub const PART_DEPTHS_M: f64 = (CORE + HALO) as f64 * Resolution::COARSE.node_m;
/// Width around a part in which the pings must be known, metres: the width of the measured depths
/// and the largest ground range from which a ping looks at them.
pub const PART_PINGS_M: f64 = PART_DEPTHS_M + FARTHEST_M;

/// Nodes of a survey or of a part of a map, in tiles.
#[derive(Clone)]
pub(super) struct Tiling {
    /// Resolution of the nodes and levels.
    pub resolution: Resolution,
    /// All nodes.
    pub nodes: Nodes,
    /// Tiles of the nodes.
    pub tiles: Vec<NodeTile>,
}

impl Tiling {
    /// Creates the tiling of a survey whose map has a grid; `None` where it is too large.
    pub(super) fn of_survey(grid: &Grid) -> Option<Self> {
        let resolution = if Nodes::over(grid, Resolution::FINE.node_m).len() <= MOST_FINE {
            Resolution::FINE
        } else {
            Resolution::COARSE
        };
        let nodes = Nodes::over(grid, resolution.node_m);
        (nodes.len() <= MOST_NODES).then(|| Self::at(grid, resolution))
    }

    /// Creates the tiling of a survey at some resolution.
    pub(super) fn at(grid: &Grid, resolution: Resolution) -> Self {
        let nodes = Nodes::over(grid, resolution.node_m);
        Self { resolution, tiles: nodes.tiles(MOST_TOGETHER, CORE, HALO), nodes }
    }

    /// Creates the tiling of a part of a map with the given edges, west, south, east and north,
    /// metres, which are multiples of [`PART_STEP_M`]. The tiling has one further core around the
    /// part on all sides.
    pub(super) fn of_part([west_m, south_m, east_m, north_m]: [f64; 4]) -> Self {
        let resolution = Resolution::COARSE;
        let cores = |metres: f64| (metres / PART_STEP_M).round() as i64;
        let (from, to) = ([west_m, south_m].map(cores), [east_m, north_m].map(cores));
        let count = [0, 1].map(|axis| (to[axis] - from[axis] + 2).max(1) as usize);
        let nodes = Nodes {
            zero_m: [0.0; 2],
            first: from.map(|core| (core - 1) * CORE as i64 - HALO as i64),
            step_m: resolution.node_m,
            counts: count.map(|cores| cores * CORE + 2 * HALO),
        };
        Self { resolution, tiles: nodes.tiles_within(HALO, [CORE; 2], HALO), nodes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tiles_of_two_parts_are_those_of_one_lattice() {
        let [one, other] =
            [0.0, 512.0].map(|east_m| Tiling::of_part([east_m, 1024.0, east_m + 512.0, 1536.0]));
        assert_eq!(one.tiles.len(), 10 * 10);
        let place = |tile: &NodeTile| (tile.nodes.first, tile.nodes.counts, tile.core);
        assert_eq!(place(&one.tiles[0]), ([-72, 952], [80, 80], [[8, 72], [8, 72]]));
        let is_shared = |tile: &&NodeTile| {
            other.tiles.iter().any(|other_tile| place(other_tile) == place(tile))
        };
        // There is a column of tiles on both sides of the edge.
        assert_eq!(one.tiles.iter().filter(is_shared).count(), 20);
    }

    #[test]
    fn a_small_survey_is_fine_and_one_tile_and_a_survey_may_be_too_large() {
        let grid = |side: usize| Grid::at([0.0, 0.0], 1.0, [side, side]);
        let small = Tiling::of_survey(&grid(60)).unwrap();
        assert_eq!((small.tiles.len(), small.resolution), (1, Resolution::FINE));
        assert_eq!(Tiling::of_survey(&grid(900)).unwrap().resolution, Resolution::COARSE);
        assert!(Tiling::of_survey(&grid(4000)).is_none());
    }
}
