//! Chooses the resolution for a survey, and divides its nodes, or those of a part of a larger map,
//! into tiles that are solved one by one.
//!
//! The tiles of a part of a map belong to a lattice that all parts share, so that neighbouring
//! parts find the same depths, to the bit, where they meet.

use super::nodes::{NodeTile, Nodes};
use super::observations::FARTHEST_M;
use crate::bathymetry::Grid;

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
