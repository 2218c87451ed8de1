//! The surface as text: one line a cell.

use crate::export;
use crate::outputs::OutputError;
use crate::outputs::manifest::{Coordinates, FileContent};
use crate::outputs::results::Results;
use std::path::Path;

/// Writes `depth.xyz`: the middles of the cells that have a depth.
pub fn write(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let surface = results.surface()?.ok_or(super::NO_SURFACE)?;
    let (grid, map) = (&surface.grid, &results.plane.map);
    let known = surface.depth_m.iter().enumerate();
    let known = known.filter(|(_, depth_m)| !depth_m.is_nan());
    let cells = known.map(|(index, &depth_m)| {
        let centre = grid.centre(index / grid.columns, index % grid.columns);
        (map.in_crs(centre), depth_m)
    });
    let decimals = if map.crs.is_degrees() { 9 } else { 3 };
    export::depth_xyz(path, decimals, cells, results.progress)
        .map(|cells| FileContent::new(Coordinates::System(map.crs.clone()), cells))
        .map_err(OutputError::from)
}
