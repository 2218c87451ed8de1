//! Writes isobaths, the areas between them and the volumes below each level, in the formats of
//! other programs.

use super::content::{FileContent, FileResult};
use super::results::Results;
use crate::Error;
use crate::export::{self, DrawnLines, LabelledLine};
use crate::pipeline::Contours;
use bathyscope_log::support::statistics::ends;
use std::path::Path;

/// Colours of the shallowest and the deepest line: light enough to be visible on a picture of the
/// earth, dark enough for a map.
const COLOURS: [[f64; 3]; 2] = [[120.0, 200.0, 255.0], [8.0, 48.0, 160.0]];

/// Isobaths and depth areas with the settings of their drawing.
pub(super) struct DrawnContours<'a> {
    /// Isobaths and the areas between them.
    pub contours: &'a Contours,
    /// The isobaths with the settings of their drawing.
    pub lines: DrawnLines<'a>,
    /// Square metres on the ground in a square metre of the map, which are not exactly the same.
    pub ground: f64,
}

impl<'a> DrawnContours<'a> {
    /// Returns the contours of a survey.
    ///
    /// # Errors
    /// When the survey has no depth map, or its isobaths cannot be drawn.
    pub(super) fn of(results: &'a Results<'_>) -> Result<Self, Error> {
        let grid = &results.surface()?.grid;
        let middle = grid.centre(grid.rows / 2, grid.columns / 2);
        let settings = &results.products.settings.isobaths;
        let contours = results.contours()?.as_ref().map_err(Clone::clone)?;
        Ok(Self {
            contours,
            lines: DrawnLines {
                lines: &contours.isobaths.lines,
                settings,
                index_levels_m: settings.index_levels_m(&contours.isobaths.levels_m),
            },
            ground: results.map.area_scale_at(middle).recip(),
        })
    }
}

/// Writes `isobaths.geojson`.
pub(super) fn isobaths_geojson(results: &Results<'_>, path: &Path) -> FileResult {
    let drawn = DrawnContours::of(results)?;
    let place = |at| results.map.to_lon_lat(at);
    let lines = export::isobaths_geojson(path, &drawn.lines, place)?;
    Ok(FileContent::in_degrees(lines))
}

/// Writes `isobaths.kmz`.
pub(super) fn isobaths_kmz(results: &Results<'_>, path: &Path) -> FileResult {
    let lines = named_lines(&DrawnContours::of(results)?, results);
    let lines = export::lines_kmz(path, &results.survey.name(), &lines)?;
    Ok(FileContent::in_degrees(lines))
}

/// Writes `isobaths.shp` with its companions, in the coordinate system of the map.
pub(super) fn isobaths_shapefile(results: &Results<'_>, path: &Path) -> FileResult {
    let lines = named_lines(&DrawnContours::of(results)?, results);
    let crs = &results.map.crs;
    let lines = export::lines_shapefile(path, crs, &["depth_m", "length_m"], &lines)?;
    Ok(FileContent::in_system(crs, lines))
}

/// Writes `depth_areas.geojson`.
pub(super) fn depth_areas(results: &Results<'_>, path: &Path) -> FileResult {
    let drawn = DrawnContours::of(results)?;
    let place = |at| results.map.to_lon_lat(at);
    let areas = export::depth_areas_geojson(path, &drawn.contours.areas, drawn.ground, place)?;
    Ok(FileContent::in_degrees(areas))
}

/// Writes `spot_soundings.geojson`.
pub(super) fn spot_soundings(results: &Results<'_>, path: &Path) -> FileResult {
    let place = |at| results.map.to_lon_lat(at);
    let settings = &results.products.settings.isobaths;
    let soundings = results.spot_soundings()?;
    let points = export::spot_soundings_geojson(path, soundings, settings, place)?;
    Ok(FileContent::in_degrees(points))
}

/// Writes `storage.csv`.
pub(super) fn storage(results: &Results<'_>, path: &Path) -> FileResult {
    let drawn = DrawnContours::of(results)?;
    let levels = export::storage_csv(path, &drawn.contours.table, drawn.ground)?;
    Ok(FileContent::of_table(levels))
}

/// Returns the isobaths with their depths as labels; deeper lines are darker.
fn named_lines(drawn: &DrawnContours<'_>, results: &Results<'_>) -> Vec<LabelledLine> {
    let DrawnLines { lines, settings, .. } = &drawn.lines;
    let ground = drawn.ground.sqrt();
    let [least_m, most_m] = ends(lines.iter().map(|line| line.depth_m));
    let named = lines.iter().map(|line| {
        let share = (line.depth_m - least_m) / (most_m - least_m).max(f64::MIN_POSITIVE);
        let [light, dark] = COLOURS;
        let depth = settings.in_unit(line.depth_m);
        LabelledLine {
            points: line.points.iter().map(|at| results.map.to_lon_lat(*at)).collect(),
            label: format!("{depth} {}", settings.unit.symbol()),
            numbers: vec![line.depth_m, ground * line.length_m()],
            colour: [0, 1, 2].map(|part| (light[part] + share * (dark[part] - light[part])) as u8),
        }
    });
    named.collect()
}
