//! How the nodes of a survey, or of a part of a larger map, are parted into tiles that are solved for one by one.
//!
//! The tiles of a part of a map are those of a lattice that all parts share, and as many are solved around the part as it depends on: so
//! each part finds, to the bit, what its neighbours find where they meet.

use super::correction::Tiling;
use super::ground::HELD_M;
use super::nodes::Nodes;
use super::pieces::FARTHEST_M;
use crate::bathymetry::Grid;

/// From one node to the next, metres. On simulated ponds 0.5 m find nothing more, in four times the time.
pub(super) const NODE_M: f64 = 0.8;
/// Nodes that are solved for together at most: some 20 000 unknowns.
pub(super) const MOST_NODES: usize = 8_000;
/// Nodes along the side of a tile's core, and around it: 58 m and 6.4 m, so that a tile has at most [`MOST_NODES`]. Wider halos change
/// nothing: the correction hangs together over two metres.
pub(super) const CORE: usize = 72;
pub(super) const HALO: usize = 8;
/// Tiles of 58 by 58 m that a survey may have: 300 are a square kilometre.
const MOST_TILES: usize = 300;
/// Fewer pieces of echoes on a survey tell nothing.
const LEAST_PIECES: usize = 500;
/// Nodes along the side of a core of the lattice, 64 m, and cores around a part that are solved in the first round; in the last one less.
const LATTICE_CORE: usize = 80;
const AROUND: usize = 2;

/// Edges of parts are multiples of this, metres.
pub const PART_STEP_M: f64 = LATTICE_CORE as f64 * NODE_M;
/// How far around a part its ground must be known, metres: two cores, the halo, as far as pieces of echoes lie from their pings, and as far as
/// the ground is held beyond depths.
pub const PART_GROUND_M: f64 = 192.0;
const _: () =
    assert!((AROUND * LATTICE_CORE + HALO) as f64 * NODE_M + FARTHEST_M + HELD_M <= PART_GROUND_M);
/// How far around a part the pings must be known, metres: a little farther, for the gain steps of those that count.
pub const PART_PINGS_M: f64 = 224.0;
/// Largest cells of a part, metres: with larger ones the slope of the ground reaches farther.
pub const PART_MOST_CELL_M: f64 = 2.0;

impl Tiling {
    /// Of a survey whose surface has a grid; `None` where it is too large.
    pub fn of_survey(grid: &Grid) -> Option<Self> {
        let nodes = Nodes::over(grid, NODE_M);
        // Before the tiles are made: a surface of coarse cells may be of any size.
        if nodes.len() > MOST_TILES * CORE * CORE {
            return None;
        }
        let tiles = nodes.tiles(MOST_NODES, CORE, HALO);
        (tiles.len() <= MOST_TILES).then(|| Self {
            nodes,
            last: (0..tiles.len()).collect(),
            tiles,
            least_pieces: LEAST_PIECES,
        })
    }

    /// Of a part with some edges west, south, east and north, metres: multiples of [`PART_STEP_M`].
    pub fn of_part([west_m, south_m, east_m, north_m]: [f64; 4]) -> Self {
        let cores = |metres: f64| (metres / PART_STEP_M).round() as i64;
        let (from, to) = ([west_m, south_m].map(cores), [east_m, north_m].map(cores));
        let around = AROUND as i64;
        let count = [0, 1].map(|axis| (to[axis] - from[axis] + 2 * around).max(1) as usize);
        let nodes = Nodes {
            zero_m: [0.0; 2],
            first: from.map(|core| (core - around) * LATTICE_CORE as i64 - HALO as i64),
            step_m: NODE_M,
            counts: count.map(|cores| cores * LATTICE_CORE + 2 * HALO),
        };
        let tiles = nodes.tiles_within(HALO, LATTICE_CORE, HALO);
        let is_near = |tile: &usize| {
            let [column, row] = [tile % count[0], tile / count[0]];
            let inner = |at: usize, count: usize| (1..count - 1).contains(&at);
            inner(column, count[0]) && inner(row, count[1])
        };
        Self {
            nodes,
            last: (0..tiles.len()).filter(is_near).collect(),
            tiles,
            least_pieces: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tiles_of_two_parts_are_those_of_one_lattice() {
        let [one, other] =
            [0.0, 512.0].map(|east_m| Tiling::of_part([east_m, 1024.0, east_m + 512.0, 1536.0]));
        assert_eq!((one.tiles.len(), one.last.len()), (144, 100));
        let place = |tiling: &Tiling, tile: usize| {
            let nodes = tiling.tiles[tile].nodes;
            (nodes.first, nodes.counts, tiling.tiles[tile].core)
        };
        assert_eq!(place(&one, 0), ([-168, 1112], [96, 96], [[8, 88], [8, 88]]));
        let shared = one.last.iter().filter(|tile| {
            let here = place(&one, **tile);
            other.last.iter().any(|tile| place(&other, *tile) == here)
        });
        // A column of tiles on both sides of the edge.
        assert_eq!(shared.count(), 20);
    }

    #[test]
    fn a_survey_may_be_too_large() {
        let grid = |side: usize| Grid {
            west_m: 0.0,
            north_m: 0.0,
            cell_m: 1.0,
            columns: side,
            rows: side,
        };
        assert_eq!(Tiling::of_survey(&grid(60)).unwrap().tiles.len(), 1);
        assert!(Tiling::of_survey(&grid(900)).is_some());
        assert!(Tiling::of_survey(&grid(1200)).is_none());
    }
}
