//! Isobaths, the areas between them and what lies below each, in the formats of other programs.

use super::DepthWritten;
use crate::bathymetry::Surface;
use crate::bathymetry::isobaths::{
    DepthArea, Isobath, Storage, depth_areas, isobaths, smoothed, storage,
};
use crate::export::{self, ExportError, Line};
use crate::outputs::record::{Coordinates, Made};
use crate::pipeline::{Plane, Products};
use crate::progress::{Cancelled, Progress};
use std::path::Path;

/// Colours of the shallowest and the deepest line: light enough for a picture of the earth, dark enough for a map.
const COLOURS: [[f64; 3]; 2] = [[120.0, 200.0, 255.0], [8.0, 48.0, 160.0]];
/// Lines shorter than this, metres, are left out: rounded to the millimetre of the files, they are no lines any more.
const LEAST_LENGTH_M: f64 = 0.01;
/// What isobaths do not depend on.
const REGARDLESS_OF: [&str; 2] = ["detector", "mosaic"];

/// What is drawn of a surface.
struct Contours {
    lines: Vec<Isobath>,
    areas: Vec<DepthArea>,
    table: Vec<Storage>,
}

/// Writes all of them, or tells why there are none.
pub(super) fn write(
    surface: &Surface,
    plane: &Plane<'_>,
    products: &Products,
    folder: &Path,
    progress: &Progress,
    written: &mut DepthWritten,
) -> Result<(), String> {
    let settings = &products.settings.isobaths;
    let range_m = surface.range_m();
    let levels_m = match settings.levels_m(range_m) {
        Ok(levels_m) => levels_m,
        Err(error) => {
            written.warnings.push(error.to_string());
            return Ok(());
        }
    };
    let drawn = draw(surface, &levels_m, range_m, progress).map_err(|error| error.to_string())?;
    let made = write_drawn(&drawn, surface, plane, settings.smooth, folder);
    written
        .made
        .extend(made.map_err(|error| error.to_string())?);
    Ok(())
}

fn draw(
    surface: &Surface,
    levels_m: &[f64],
    range_m: [f64; 2],
    progress: &Progress,
) -> Result<Contours, Cancelled> {
    let with_ends = with_ends(levels_m, range_m);
    let mut lines = isobaths(surface, levels_m, progress)?;
    lines.retain(|line| line.length_m() > LEAST_LENGTH_M);
    Ok(Contours {
        lines,
        areas: depth_areas(surface, &with_ends, progress)?,
        table: storage(surface, &with_ends),
    })
}

fn write_drawn(
    drawn: &Contours,
    surface: &Surface,
    plane: &Plane<'_>,
    smooth: u32,
    folder: &Path,
) -> Result<Vec<Made>, ExportError> {
    let Contours {
        lines,
        areas,
        table,
    } = drawn;
    let place = |at| plane.to_lon_lat(at);
    // A map's square metres are not quite those of the ground.
    let middle = [surface.grid.rows / 2, surface.grid.columns / 2];
    let middle = surface.grid.centre(middle[0], middle[1]);
    let ground = plane.map.area_scale_at(middle).recip();
    let made = |name, what, counted, summary| Made {
        name,
        what,
        coordinates: Coordinates::Degrees,
        counted,
        measured: "depth_m",
        summary,
        regardless_of: &REGARDLESS_OF,
    };
    let of_lines = "Lines of equal depth";
    let at = |name: &str| folder.join(name);
    let geojson = export::isobaths_geojson(&at("isobaths.geojson"), lines, smooth, place)?;
    let mut written = vec![made("isobaths.geojson", of_lines, "lines", geojson)];
    if !lines.is_empty() {
        let named = named_lines(lines, smooth, plane, ground.sqrt());
        let kmz = export::lines_kmz(&at("isobaths.kmz"), &plane.survey.name(), &named)?;
        written.push(made("isobaths.kmz", of_lines, "lines", kmz));
        let (name, names) = ("isobaths.shp", ["depth_m", "length_m"]);
        let shapes = export::lines_shapefile(&at(name), &plane.map.crs, &names, &named)?;
        written.push(Made {
            coordinates: Coordinates::System(plane.map.crs.clone()),
            ..made(name, of_lines, "lines", shapes)
        });
    }
    let name = "depth_areas.geojson";
    let areas = export::depth_areas_geojson(&at(name), areas, ground, place)?;
    written.push(made(name, "Areas between depths", "areas", areas));
    let name = "storage.csv";
    let levels = export::storage_csv(&at(name), table, ground)?;
    written.push(Made {
        coordinates: Coordinates::None,
        ..made(name, "Area and volume below each depth", "levels", levels)
    });
    Ok(written)
}

/// The lines with their depth beside them, the deeper the darker; `ground` metres on the ground are one on the map.
fn named_lines(lines: &[Isobath], smooth: u32, plane: &Plane<'_>, ground: f64) -> Vec<Line> {
    let depths = lines.iter().map(|line| line.depth_m);
    let [least_m, most_m] = depths.fold([f64::MAX, f64::MIN], |[least, most], depth| {
        [least.min(depth), most.max(depth)]
    });
    let named = lines.iter().map(|line| {
        let share = (line.depth_m - least_m) / (most_m - least_m).max(f64::MIN_POSITIVE);
        let [light, dark] = COLOURS;
        let points = smoothed(&line.points, smooth);
        Line {
            points: points.iter().map(|at| plane.to_lon_lat(*at)).collect(),
            label: format!("{} m", line.depth_m),
            numbers: vec![line.depth_m, ground * line.length_m()],
            colour: [0, 1, 2].map(|part| (light[part] + share * (dark[part] - light[part])) as u8),
        }
    });
    named.collect()
}

/// The levels, with the shallowest and what is just beyond the deepest depth around them, so that the areas cover all.
fn with_ends(levels_m: &[f64], [least_m, most_m]: [f64; 2]) -> Vec<f64> {
    let within = levels_m
        .iter()
        .copied()
        .filter(|level| *level > least_m && *level <= most_m);
    let beyond_m = most_m.next_up();
    std::iter::once(least_m)
        .chain(within)
        .chain([beyond_m])
        .collect()
}
