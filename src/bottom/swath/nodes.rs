//! Defines the places of the unknowns: nodes at even steps, with bilinear values between them.

use crate::bathymetry::Grid;

/// Number of nodes around its core over which a tile fades into the next.
const BLEND: usize = 6;

/// Nodes in rows from south to north, each from west to east.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nodes {
    /// Origin of the nodes, east and north, metres: parts of a map with the same origin have the
    /// same nodes to the bit.
    pub zero_m: [f64; 2],
    /// Number of steps from the origin to the first node, east and north.
    pub first: [i64; 2],
    /// Distance from one node to the next, metres.
    pub step_m: f64,
    /// Number of nodes in a row, and number of rows; at least two each.
    pub counts: [usize; 2],
}

/// Four nodes around a place: index and share of each.
pub(super) type Shares = [(usize, f64); 4];

/// Part of the nodes that is solved for together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NodeTile {
    /// Column and row of the first node of the tile among all nodes.
    pub first: [usize; 2],
    /// Nodes of the tile.
    pub nodes: Nodes,
    /// Columns and rows of the core, each as the first one and one after the last, counted in the
    /// nodes of the tile. No node is in two cores.
    pub core: [[usize; 2]; 2],
}

/// Joined values of several tiles: where tiles overlap, their mean, weighted towards the nearer
/// core, so that no seam shows. Each node has a weighted sum and the sum of the weights.
#[derive(Clone, Debug)]
pub(super) struct Blend(Vec<[f64; 2]>);

impl Blend {
    /// Creates a blend at some nodes without any tile.
    pub(super) fn none(nodes: &Nodes) -> Self {
        Self(vec![[0.0; 2]; nodes.len()])
    }

    /// Adds the values of a tile.
    pub(super) fn add(&mut self, all: &Nodes, tile: &NodeTile, values: &[f64]) {
        for (node, value) in values.iter().enumerate() {
            let weight = tile.weight(node);
            let [sum, weights] = &mut self.0[tile.index_in(all, node)];
            *sum += weight * value;
            *weights += weight;
        }
    }

    /// Returns the values at all nodes; 0 where no tile was added.
    pub(super) fn values(self) -> Vec<f64> {
        let value = |[sum, weight]: [f64; 2]| if weight > 0.0 { sum / weight } else { 0.0 };
        self.0.into_iter().map(value).collect()
    }
}

impl Nodes {
    /// Creates the nodes over the cells of a grid.
    pub(super) fn over(grid: &Grid, step_m: f64) -> Self {
        let count = |cells: usize| (cells as f64 * grid.cell_m / step_m).ceil() as usize + 1;
        let south_m = grid.north_m - grid.rows as f64 * grid.cell_m;
        Self {
            zero_m: [grid.west_m, south_m],
            first: [0; 2],
            step_m,
            counts: [count(grid.columns).max(2), count(grid.rows).max(2)],
        }
    }

    /// Returns the number of steps from the first node to a place, east or north.
    fn steps(&self, place: [f64; 2], axis: usize) -> f64 {
        (place[axis] - self.zero_m[axis]) / self.step_m - self.first[axis] as f64
    }

    /// Returns the number of nodes.
    pub(super) fn len(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Returns west, south, east and north of the outermost nodes, metres.
    pub(super) fn bounds_m(&self) -> [f64; 4] {
        let at = |axis: usize, step: usize| {
            self.zero_m[axis] + (self.first[axis] + step as i64) as f64 * self.step_m
        };
        let last = |axis: usize| at(axis, self.counts[axis] - 1);
        [at(0, 0), at(1, 0), last(0), last(1)]
    }

    /// Returns the place of a node, east and north, metres.
    pub(super) fn place_m(&self, node: usize) -> [f64; 2] {
        let steps = [node % self.counts[0], node / self.counts[0]];
        [0, 1].map(|axis| {
            self.zero_m[axis] + (self.first[axis] + steps[axis] as i64) as f64 * self.step_m
        })
    }

    /// Returns true if a place, east and north, is between the outermost nodes.
    pub(super) fn holds(&self, place: [f64; 2]) -> bool {
        (0..2).all(|axis| {
            let steps = self.steps(place, axis);
            steps > 0.0 && steps < (self.counts[axis] - 1) as f64
        })
    }

    /// Returns the four nodes around a place and their shares, which sum to 1; places beyond the
    /// outermost nodes count as on them.
    pub(super) fn shares(&self, place: [f64; 2]) -> Shares {
        let [(column, right), (row, up)] = [0, 1].map(|axis| {
            let steps = self.steps(place, axis);
            let most = (self.counts[axis] - 1) as f64 - 1e-3;
            let steps = steps.clamp(0.0, most);
            (steps as usize, steps.fract())
        });
        let first = row * self.counts[0] + column;
        let next = first + self.counts[0];
        [
            (first, (1.0 - right) * (1.0 - up)),
            (first + 1, right * (1.0 - up)),
            (next, (1.0 - right) * up),
            (next + 1, right * up),
        ]
    }

    /// Interpolates values at the nodes to a place.
    pub(super) fn value_at(&self, values: &[f64], place: [f64; 2]) -> f64 {
        sum(values, &self.shares(place))
    }

    /// Returns the node nearest to a place.
    pub(super) fn nearest(&self, place: [f64; 2]) -> usize {
        let [column, row] = [0, 1].map(|axis| {
            let steps = self.steps(place, axis).round();
            (steps.max(0.0) as usize).min(self.counts[axis] - 1)
        });
        row * self.counts[0] + column
    }

    /// Returns the nodes west, east, south and north of a node; the node itself where there is
    /// none.
    pub(super) fn neighbours(&self, node: usize) -> [usize; 4] {
        let [columns, rows] = self.counts;
        let (row, column) = (node / columns, node % columns);
        let or = |there: bool, other: usize| if there { other } else { node };
        [
            or(column > 0, node.wrapping_sub(1)),
            or(column + 1 < columns, node + 1),
            or(row > 0, node.wrapping_sub(columns)),
            or(row + 1 < rows, node + columns),
        ]
    }

    /// Divides the nodes into tiles with cores of about the same size, at most `core` nodes a side,
    /// and a halo of `halo` nodes around each core; one tile if there are at most `most` nodes.
    pub(super) fn tiles(&self, most: usize, core: usize, halo: usize) -> Vec<NodeTile> {
        let cores = self.counts.map(|count| {
            if self.len() <= most { count } else { count.div_ceil(count.div_ceil(core)) }
        });
        self.tiles_within(0, cores, halo)
    }

    /// Divides the nodes into tiles with cores of `cores` nodes in a row and rows, and a halo of
    /// `halo` nodes around each core; the outermost `margin` nodes are in no core.
    pub(super) fn tiles_within(
        &self,
        margin: usize,
        cores: [usize; 2],
        halo: usize,
    ) -> Vec<NodeTile> {
        let spans = |axis: usize| -> Vec<[usize; 4]> {
            let count = self.counts[axis];
            let end = count.saturating_sub(margin);
            let of_core = |from: usize| {
                let to = (from + cores[axis]).min(end);
                [from.saturating_sub(halo), from, to, (to + halo).min(count)]
            };
            (margin..end).step_by(cores[axis]).map(of_core).collect()
        };
        let [across, along] = [0, 1].map(spans);
        let both = along.iter().flat_map(|rows| across.iter().map(move |columns| [columns, rows]));
        both.map(|spans| {
            let first = spans.map(|span| span[0]);
            let nodes = Self {
                first: [0, 1].map(|axis| self.first[axis] + first[axis] as i64),
                counts: spans.map(|span| span[3] - span[0]),
                ..*self
            };
            NodeTile {
                first,
                nodes,
                core: spans.map(|span| [span[1] - span[0], span[2] - span[0]]),
            }
        })
        .filter(|tile| tile.nodes.counts.iter().all(|count| *count >= 2))
        .collect()
    }
}

impl NodeTile {
    /// Returns the nodes of the core.
    pub(super) fn core_nodes(&self) -> Nodes {
        let [columns, rows] = self.core;
        Nodes {
            first: [self.nodes.first[0] + columns[0] as i64, self.nodes.first[1] + rows[0] as i64],
            counts: [columns[1] - columns[0], rows[1] - rows[0]],
            ..self.nodes
        }
    }

    /// Returns the weight of a node of the tile in a [`Blend`]: 1 in the core, down to 0 at
    /// [`BLEND`] nodes from it.
    fn weight(&self, node: usize) -> f64 {
        let columns = self.nodes.counts[0];
        let along = |at: usize, [from, to]: [usize; 2]| {
            let beside = from.saturating_sub(at).max((at + 1).saturating_sub(to));
            (1.0 - beside as f64 / BLEND as f64).max(0.0)
        };
        along(node % columns, self.core[0]) * along(node / columns, self.core[1])
    }

    /// Returns the index among all nodes of a node of the tile.
    pub(super) fn index_in(&self, all: &Nodes, node: usize) -> usize {
        let columns = self.nodes.counts[0];
        let (row, column) = (node / columns, node % columns);
        (row + self.first[1]) * all.counts[0] + column + self.first[0]
    }
}

/// Returns the sum of values, each multiplied by its share.
pub(super) fn sum(values: &[f64], shares: &Shares) -> f64 {
    shares.iter().map(|&(node, share)| share * values[node]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: Nodes =
        Nodes { zero_m: [1.0, -3.0], first: [4, 2], step_m: 0.5, counts: [41, 23] };

    /// Returns the values at the nodes of a tile from the values at all nodes.
    fn cut(tile: &NodeTile, values: &[f64]) -> Vec<f64> {
        let value = |node| values[tile.index_in(&NODES, node)];
        (0..tile.nodes.len()).map(value).collect()
    }

    #[test]
    fn values_are_bilinear_between_nodes() {
        let value = |[east, north]: [f64; 2]| 1.0 + 0.3 * east - 0.2 * north;
        let values: Vec<f64> = (0..NODES.len())
            .map(|node| value([3.0 + 0.5 * (node % 41) as f64, -2.0 + 0.5 * (node / 41) as f64]))
            .collect();
        let place = [7.21, 3.37];
        assert!((NODES.value_at(&values, place) - value(place)).abs() < 1e-12);
        assert!(NODES.holds(place) && !NODES.holds([2.9, 0.0]));
    }

    #[test]
    fn tiles_put_together_are_what_they_were_cut_from() {
        let values: Vec<f64> = (0..NODES.len()).map(|node| (node as f64).sin()).collect();
        for most in [100, 10_000] {
            let mut blend = Blend::none(&NODES);
            for tile in NODES.tiles(most, 10, 14) {
                blend.add(&NODES, &tile, &cut(&tile, &values));
            }
            let back = blend.values();
            let differs = |(one, other): (&f64, &f64)| (one - other).abs() > 1e-12;
            assert!(!back.iter().zip(&values).any(differs));
        }
        assert_eq!(NODES.tiles(10_000, 10, 14).len(), 1);
    }

    #[test]
    fn a_part_has_the_same_nodes_as_the_whole() {
        let parts = NODES.tiles_within(3, [5; 2], 2);
        assert_eq!(parts.len(), 7 * 4);
        let place = [7.21, 3.37];
        let values: Vec<f64> = (0..NODES.len()).map(|node| (node as f64).cos()).collect();
        let expected = NODES.value_at(&values, place);
        for part in parts.iter().filter(|part| part.nodes.holds(place)) {
            let found = part.nodes.value_at(&cut(part, &values), place);
            assert_eq!(found.to_bits(), expected.to_bits());
        }
        // The margin makes the last core of a row shorter.
        assert_eq!(parts[6].core[0], [2, 7]);
        assert_eq!(parts[21].core[1], [2, 4]);
    }
}
