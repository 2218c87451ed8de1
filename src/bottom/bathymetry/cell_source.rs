//! The source of the depth in each cell.

use super::{DepthPoint, Grid};
use crate::presentation::colours::{Rgb, SOURCES};

/// The source of the depth in a cell. The numbers are those of `depth/source.tif`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum CellSource {
    /// No depth is known.
    #[default]
    None = 0,
    /// No depth was measured in it: it lies between depths that were.
    Interpolated = 1,
    /// No depth was measured in it, but the levels of its echoes determine its slope: inferred, not
    /// measured.
    FromLevels = 2,
    /// A first return of the side-scan lies in it, and no sounding.
    FirstReturn = 3,
    /// A depth of the recorder, under the boat or across the track, or of a reference lies in it.
    Sounding = 4,
}

impl CellSource {
    /// The sources that a depth can have.
    pub const KNOWN: [Self; 4] =
        [Self::Sounding, Self::FirstReturn, Self::FromLevels, Self::Interpolated];

    /// A word or two for legends and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "unknown",
            Self::Interpolated => "interpolated",
            Self::FromLevels => "from levels",
            Self::FirstReturn => "first return",
            Self::Sounding => "sounding",
        }
    }

    /// Number, name and colour of those that a depth can have, as rasters of sources show them.
    pub fn classes() -> [(u8, &'static str, Rgb); 4] {
        let class = |index: usize| {
            let source = Self::KNOWN[index];
            (source as u8, source.name(), SOURCES[index])
        };
        std::array::from_fn(class)
    }
}

/// Returns the best source measured in each cell of a grid; points without weight do not count.
pub(super) fn measured_cells(points: &[DepthPoint], grid: &Grid) -> Vec<CellSource> {
    let mut cells = vec![CellSource::None; grid.len()];
    for point in points.iter().filter(|point| point.weight > 0.0) {
        let index = grid.index_at(point.east_m, point.north_m);
        if let Some(cell) = index.and_then(|index| cells.get_mut(index)) {
            *cell = (*cell).max(if point.is_sounding {
                CellSource::Sounding
            } else {
                CellSource::FirstReturn
            });
        }
    }
    cells
}

/// Says of every cell with a depth that holds no measured one that it is interpolated, and of those
/// without any that none is known.
pub(super) fn settle(sources: &mut [CellSource], depth_m: &[f32]) {
    for (source, depth_m) in sources.iter_mut().zip(depth_m) {
        *source = match (depth_m.is_nan(), *source) {
            (true, _) => CellSource::None,
            (false, CellSource::None) => CellSource::Interpolated,
            (false, measured) => measured,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_says_the_best_that_lies_in_it() {
        let grid = Grid::at([0.0, 1.0], 1.0, [5, 1]);
        let point = |east_m, is_sounding, weight| DepthPoint {
            east_m,
            north_m: 0.5,
            depth_m: 2.0,
            weight,
            is_sounding,
        };
        let points = [
            point(0.2, false, 1.0),
            point(0.7, true, 0.5),
            point(1.5, false, 1.0),
            point(2.5, true, 0.0),
            point(3.5, true, 1.0),
        ];
        let mut sources = measured_cells(&points, &grid);
        settle(&mut sources, &[2.0, 2.0, 2.0, f32::NAN, f32::NAN]);
        let expected = [
            CellSource::Sounding,
            CellSource::FirstReturn,
            CellSource::Interpolated,
            CellSource::None,
            CellSource::None,
        ];
        assert_eq!(sources, expected);
    }
}
