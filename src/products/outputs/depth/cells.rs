//! The cells of the surface as text and as points.

use crate::export::{self, BottomCell};
use crate::outputs::content::{FileContent, FileResult};
use crate::outputs::results::Results;
use bathyscope_bottom::bathymetry::CellSource;
use bathyscope_bottom::presentation::colours::{depth_colour, depth_share};
use std::path::Path;

/// Writes `depth.xyz`: the middles of the cells that have a depth.
pub(crate) fn write(results: &Results<'_>, path: &Path) -> FileResult {
    let surface = results.surface()?.ok_or(super::NO_SURFACE)?;
    let (grid, map) = (&surface.grid, &results.plane.map);
    let known = surface.depth_m.iter().enumerate();
    let known = known.filter(|(_, depth_m)| !depth_m.is_nan());
    let cells = known.map(|(index, &depth_m)| {
        let centre = grid.centre(index / grid.columns, index % grid.columns);
        (map.in_crs(centre), depth_m)
    });
    let decimals = if map.crs.is_degrees() { 9 } else { 3 };
    let cells = export::depth_xyz(path, decimals, cells, results.progress)?;
    Ok(FileContent::in_system(&map.crs, cells))
}

/// Writes `bottom.copc.laz`: the same cells as points, each with the source of its depth, so that
/// what was inferred is not taken for measured.
pub(crate) fn points(results: &Results<'_>, path: &Path) -> FileResult {
    let depth_map = results.depth_map()?.ok_or(super::NO_SURFACE)?;
    let (surface, map) = (&depth_map.surface, &results.plane.map);
    let grid = &surface.grid;
    let cell = |(index, depth_m): (usize, &f32)| BottomCell {
        place: map.in_crs(grid.centre(index / grid.columns, index % grid.columns)),
        depth_m: *depth_m,
        sigma_m: surface.spread_m[index],
        distance_m: surface.distance_m[index],
        source: surface.source[index] as u8,
        is_measured: matches!(
            surface.source[index],
            CellSource::Sounding | CellSource::FirstReturn
        ),
        rgb: depth_colour(depth_share(*depth_m, depth_map.colour_range_m)),
    };
    let known = surface.depth_m.iter().enumerate();
    let known = known.filter(|(_, depth_m)| !depth_m.is_nan());
    let cells: Vec<BottomCell> = known.map(cell).collect();
    results.progress.check()?;
    let origin = results.survey.track.frame.origin();
    let cells = export::bottom_las(path, &map.crs, origin, &cells)?;
    Ok(FileContent::in_system(&map.crs, cells))
}
