//! Cell numbers along one axis.

/// Cells along one axis. Long empty stretches can be left out, so that a far outlier costs one
/// cell, not a grid.
#[derive(Debug)]
pub(super) struct CellAxis {
    /// Begin of each occupied stretch, ascending, with its first cell number.
    stretches: Vec<(f64, u32)>,
    cells_per_m: f64,
    /// Number of cells.
    pub(super) len: u64,
}

impl CellAxis {
    /// More cells than this along an axis make their numbers inexact: empty stretches must be left
    /// out.
    const MAX_DIRECT: f64 = 1e9;

    /// One cell for everything.
    pub(super) fn single() -> Self {
        Self { stretches: vec![(0.0, 0)], cells_per_m: 0.0, len: 1 }
    }

    /// Numbers cells evenly from the smallest to the largest of the values; `None` when there would
    /// be too many cells to number.
    pub(super) fn even(values: impl Iterator<Item = f64>, cell_m: f64) -> Option<Self> {
        let (min, max) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| {
            (min.min(value), max.max(value))
        });
        let last = (max - min) / cell_m;
        (last < Self::MAX_DIRECT).then(|| Self {
            stretches: vec![(min, 0)],
            cells_per_m: 1.0 / cell_m,
            len: last as u64 + 1,
        })
    }

    /// Numbers cells as [`CellAxis::even`] does, but a gap of more than a cell between two values
    /// starts a new stretch, which is numbered on with one empty cell between. Values on the two
    /// sides of a gap are no neighbours.
    pub(super) fn compact(values: impl Iterator<Item = f64>, cell_m: f64) -> Self {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let cells_per_m = 1.0 / cell_m;
        let mut stretches = vec![(sorted[0], 0)];
        for pair in sorted.windows(2) {
            if pair[1] - pair[0] > cell_m {
                let (start, first) = stretches[stretches.len() - 1];
                let last = first + ((pair[0] - start) * cells_per_m) as u32;
                stretches.push((pair[1], last + 2));
            }
        }
        let mut axis = Self { stretches, cells_per_m, len: 0 };
        axis.len = u64::from(axis.cell(sorted[sorted.len() - 1])) + 1;
        axis
    }

    /// The cell of a value that the axis was made from.
    pub(super) fn cell(&self, value: f64) -> u32 {
        let (start, first) = match self.stretches.as_slice() {
            [only] => *only,
            many => many[many.partition_point(|&(start, _)| start <= value).max(1) - 1],
        };
        first + ((value - start) * self.cells_per_m) as u32
    }
}
