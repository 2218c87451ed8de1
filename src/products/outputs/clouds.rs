//! Writes points and bodies: the tables of pings and points, the cloud for other programs, and the
//! bottom for 3D programs: `bottom.glb`, the depth map as a mesh with the depth colours and the
//! mosaic as pictures over it, and `bottom.copc.laz`, its cells as points.

use super::content::{FileContent, FileResult};
use super::rasters::known_cells;
use super::results::{NO_SURFACE, Results};
use crate::Error;
use crate::export::{
    self, BottomCell, LasPacking, LogPoints, Summary, TexturedMesh, bottom_las, glb,
};
use crate::pipeline::{Bottom, BottomColour};
use bathyscope_bottom::bathymetry::{Grid, Surface};
use bathyscope_bottom::cloud::CloudPoint;
use bathyscope_bottom::presentation::colours::{Rgb, depth_colour, depth_share};
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};
use serde_json::json;
use std::path::Path;

/// Largest number of corners: programs and browsers rotate such a mesh smoothly.
const MOST_CORNERS: usize = 250_000;
/// Longest side of a picture, pixels: every program accepts it.
const MOST_PIXELS: usize = 2048;

/// Writes `first_returns.csv`.
pub(super) fn first_returns(results: &Results<'_>, path: &Path) -> FileResult {
    let pings = export::first_returns_csv(path, &results.log_points())?;
    Ok(FileContent::in_degrees(pings))
}

/// Writes `cloud.csv`.
pub(super) fn table(results: &Results<'_>, path: &Path) -> FileResult {
    let points = export::cloud_csv(path, &results.log_points())?;
    Ok(FileContent::in_degrees(points))
}

/// Writes all points to `cloud.copc.laz`, in the coordinate system of the map.
pub(super) fn copc(results: &Results<'_>, path: &Path) -> FileResult {
    las_file(results, path, LasPacking::Copc)
}

/// Writes all points to `cloud.las`, in the coordinate system of the map.
pub(super) fn las(results: &Results<'_>, path: &Path) -> FileResult {
    las_file(results, path, LasPacking::Plain)
}

fn las_file(results: &Results<'_>, path: &Path, packing: LasPacking) -> FileResult {
    let crs = &results.map.crs;
    let place = |log: &LogPoints<'_>, point: &CloudPoint| place(results, log, point);
    let points = export::cloud_las(path, packing, crs, place, &results.log_points())?;
    Ok(FileContent {
        detail: if results.start_unix_s().is_some() {
            ", time adjusted standard GPS time"
        } else {
            ", time seconds after the log's beginning"
        },
        ..FileContent::in_system(crs, points)
    })
}

/// Writes all points to `cloud.ply`, in the local coordinate frame of the survey.
pub(super) fn ply(results: &Results<'_>, path: &Path) -> FileResult {
    let origin = results.survey.track.frame.origin();
    let points = export::cloud_ply(path, &results.log_points())?;
    Ok(FileContent::in_metres(origin, points))
}

/// Writes the points of the bottom to `cloud.xyz`, in the coordinate system of the map.
pub(super) fn xyz(results: &Results<'_>, path: &Path) -> FileResult {
    let crs = &results.map.crs;
    let decimals = if crs.is_degrees() { 9 } else { 3 };
    let place = |log: &LogPoints<'_>, point: &CloudPoint| place(results, log, point);
    let points = export::cloud_xyz(path, decimals, place, &results.log_points())?;
    Ok(FileContent::in_system(crs, points))
}

/// Returns the x and y of a point of a log in the coordinate system of the map.
fn place(results: &Results<'_>, log: &LogPoints<'_>, point: &CloudPoint) -> [f64; 2] {
    let track = &log.survey.track;
    let at = (log.navigation).to_lon_lat(track, point.east_m, point.north_m);
    results.map.crs.place(at)
}

/// Writes `bottom.glb`.
pub(super) fn bottom_mesh(results: &Results<'_>, path: &Path) -> FileResult {
    let (derived, logs) = (results.order.derived, results.order.logs);
    let bottom = derived.bottom(logs, BottomColour::Depth, MOST_CORNERS, results.progress)?;
    let bottom = bottom.ok_or(NO_SURFACE)?;
    let surface = bottom.surface();
    let middle = surface.grid.centre(surface.grid.rows / 2, surface.grid.columns / 2);
    let mut mesh = mesh(surface, middle);
    mesh.name = results.survey.name();
    mesh.pictures.push(("depth", png(&surface.grid, &bottom.rgb)?));
    if let Some(picture) = mosaic(results, &bottom)? {
        mesh.pictures.push(("mosaic", picture));
    }
    let map = &results.map;
    let crs = &map.crs;
    mesh.extras = json!({
        "what": format!("The bottom in metres from a place of the survey: x east, y up from the depths' own zero, z south. {}", results.products.correction.statement()),
        "origin": {"crs": format!("EPSG:{}", crs.epsg()), "easting": map.in_crs(middle)[0], "northing": map.in_crs(middle)[1]},
        "corner_spacing_m": surface.grid.cell_m,
    });
    glb(path, &mesh)?;
    let mut summary = Summary::default();
    for [east_m, north_m, up_m] in &mesh.places_m {
        let place = [middle[0] + f64::from(*east_m), middle[1] + f64::from(*north_m)];
        summary.add(map.in_crs(place), -f64::from(*up_m));
    }
    Ok(FileContent::in_system(crs, summary))
}

/// Writes `bottom.copc.laz`: the cells that have a depth as points, each with the source of its
/// depth, so that inferred depths are not mistaken for measured ones.
pub(super) fn bottom_points(results: &Results<'_>, path: &Path) -> FileResult {
    let depth_map = results.needed_depth_map()?;
    let (surface, map) = (&depth_map.surface, &results.map);
    let cell = |(index, place, depth_m): (usize, [f64; 2], f32)| BottomCell {
        place,
        depth_m,
        sigma_m: surface.spread_m[index],
        distance_m: surface.distance_m[index],
        source: surface.source[index],
        rgb: depth_colour(depth_share(depth_m, depth_map.colour_range_m)),
    };
    let cells: Vec<BottomCell> = known_cells(surface, map).map(cell).collect();
    results.progress.check()?;
    let origin = results.survey.track.frame.origin();
    let cells = bottom_las(path, &map.crs, origin, &cells)?;
    Ok(FileContent::in_system(&map.crs, cells))
}

/// Returns the mesh of the known corners and the triangles between them, relative to a place.
fn mesh(surface: &Surface, [middle_east_m, middle_north_m]: [f64; 2]) -> TexturedMesh {
    let grid = &surface.grid;
    let mut mesh = TexturedMesh::default();
    let mut numbers = vec![None; grid.len()];
    for (cell, depth_m) in surface.depth_m.iter().enumerate() {
        if depth_m.is_nan() {
            continue;
        }
        let (row, column) = (cell / grid.columns, cell % grid.columns);
        let [east_m, north_m] = grid.centre(row, column);
        numbers[cell] = Some(mesh.places_m.len() as u32);
        mesh.places_m.push([
            (east_m - middle_east_m) as f32,
            (north_m - middle_north_m) as f32,
            -depth_m,
        ]);
        mesh.normals.push(surface.normal(row, column));
        mesh.in_pictures.push([
            (column as f32 + 0.5) / grid.columns as f32,
            (row as f32 + 0.5) / grid.rows as f32,
        ]);
    }
    for row in 1..grid.rows {
        for column in 1..grid.columns {
            let here = row * grid.columns + column;
            let [north_west, north_east, south_west, south_east] =
                [here - grid.columns - 1, here - grid.columns, here - 1, here]
                    .map(|cell| numbers[cell]);
            mesh.triangles.extend(square([north_west, north_east, south_east, south_west]));
        }
    }
    mesh
}

/// Returns the triangles between the known ones of four corners, which are given clockwise from the
/// north-west.
fn square(corners: [Option<u32>; 4]) -> Vec<[u32; 3]> {
    match corners {
        [Some(a), Some(b), Some(c), Some(d)] => vec![[a, d, b], [b, d, c]],
        _ => match corners.into_iter().flatten().collect::<Vec<u32>>()[..] {
            [a, b, c] => vec![[c, b, a]],
            _ => Vec::new(),
        },
    }
}

/// Returns the mosaic over the area of the bottom as PNG, with cells as fine as those of the mosaic
/// if the picture does not become too large; `None` without side-scan.
fn mosaic(results: &Results<'_>, bottom: &Bottom) -> Result<Option<Vec<u8>>, Error> {
    let Some(mosaic) = results.mosaic()? else {
        return Ok(None);
    };
    let coarse = &bottom.surface().grid;
    let finest = (coarse.cell_m / mosaic.settings.cell_m).round().max(1.0) as usize;
    let times = (MOST_PIXELS / coarse.columns.max(coarse.rows).max(1)).clamp(1, finest);
    let grid = coarse.finer(times);
    let levels = mosaic.levels(&grid, results.progress)?;
    let colours: Vec<Rgb> =
        (levels.iter()).map(|level| Bottom::echo_colour(mosaic.settings.colours, *level)).collect();
    png(&grid, &colours).map(Some)
}

fn png(grid: &Grid, rgb: &[Rgb]) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let (columns, rows) = (grid.columns as u32, grid.rows as u32);
    PngEncoder::new(&mut bytes)
        .write_image(rgb.as_flattened(), columns, rows, ExtendedColorType::Rgb8)
        .map_err(|error| format!("cannot make the picture of the bottom: {error}"))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_face_up_and_a_hole_takes_only_what_touches_it() {
        let grid = Grid { west_m: 0.0, north_m: 3.0, cell_m: 1.0, columns: 4, rows: 3 };
        let mut depth_m = vec![2.0; grid.len()];
        depth_m[5] = f32::NAN;
        let surface = Surface::of_depths(grid, depth_m);
        let mesh = mesh(&surface, [0.0, 0.0]);
        assert_eq!(mesh.places_m.len(), 11);
        // There are six squares; the four squares at the hole have one triangle each.
        assert_eq!(mesh.triangles.len(), 2 * 2 + 4);
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| {
                let [east, north, _] = mesh.places_m[corner as usize];
                [east, north]
            });
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
        };
        assert!(mesh.triangles.iter().all(|triangle| (area(triangle) - 0.5).abs() < 1e-6));
        let [least, most] = [0, mesh.in_pictures.len() - 1].map(|corner| mesh.in_pictures[corner]);
        assert_eq!((least, most), ([0.125, 0.5 / 3.0], [0.875, 2.5 / 3.0]));
    }
}
