//! The surface as text: one line a cell.

use super::DepthWritten;
use crate::bathymetry::Surface;
use crate::export;
use crate::outputs::record::{Coordinates, Made};
use crate::pipeline::Plane;
use crate::progress::Progress;
use std::path::Path;

/// Writes `depth.xyz`: the middles of the cells that have a depth.
pub(super) fn write(
    surface: &Surface,
    plane: &Plane<'_>,
    folder: &Path,
    progress: &Progress,
    written: &mut DepthWritten,
) -> Result<(), String> {
    let (grid, map) = (&surface.grid, &plane.map);
    let known = surface.depth_m.iter().enumerate();
    let known = known.filter(|(_, depth_m)| !depth_m.is_nan());
    let cells = known.map(|(index, &depth_m)| {
        let centre = grid.centre(index / grid.columns, index % grid.columns);
        (map.in_crs(centre), depth_m)
    });
    let name = "depth.xyz";
    let decimals = if map.crs.is_degrees() { 9 } else { 3 };
    let summary = export::depth_xyz(&folder.join(name), decimals, cells, progress);
    written.made.push(Made {
        name,
        what: "East, north and depth in metres, positive down, of every cell of the depth map that has one",
        coordinates: Coordinates::System(map.crs.clone()),
        counted: "cells",
        measured: "depth_m",
        summary: summary.map_err(|error| error.to_string())?,
        regardless_of: &["detector", "isobaths", "mosaic"],
    });
    Ok(())
}
