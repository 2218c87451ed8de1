//! Writes lines and areas for plotters and maps: the track, the insonified ground, isobaths, the
//! areas between them and the volumes below each level, and all lines, areas and objects of a
//! survey in one file.

use super::content::{FileContent, FileResult, Need};
use super::object_files::targets;
use super::order::When;
use super::results::Results;
use crate::Error;
use crate::export::{
    self, DrawnLines, LabelledLine, MapGeometry, SideScanCoverage, Summary, TrackPiece, TrackPoint,
};
use crate::pipeline::Contours;
use bathyscope_bottom::presentation::colours::{Rgb, depth_colour};
use bathyscope_log::support::statistics::ends;
use std::path::Path;

/// Colour of the track: red that is legible on a map and on a picture of the earth.
const TRACK_COLOUR: Rgb = [214, 39, 40];
/// Colours of the shallowest and the deepest isobath: light enough to be visible on a picture of
/// the earth, dark enough for a map.
const ISOBATH_COLOURS: [[f64; 3]; 2] = [[120.0, 200.0, 255.0], [8.0, 48.0, 160.0]];

/// Writes `track.gpx`.
pub(super) fn track_gpx(results: &Results<'_>, path: &Path) -> FileResult {
    let (name, start_unix_s) = (results.name(), results.start_unix_s());
    let points = export::track_gpx(path, &name, start_unix_s, results.track())?;
    Ok(FileContent::in_degrees(points))
}

/// Writes `track.geojson`.
pub(super) fn track_geojson(results: &Results<'_>, path: &Path) -> FileResult {
    let lines = export::track_geojson(path, results.track())?;
    Ok(FileContent::in_degrees(lines))
}

/// Writes `track.kmz`.
pub(super) fn track_kmz(results: &Results<'_>, path: &Path) -> FileResult {
    let name = results.name();
    let lines = export::lines_kmz(path, &name, &track_lines(results, &name))?;
    Ok(FileContent::in_degrees(lines))
}

/// Writes `track.shp` with its companions, in the coordinate system of the map.
pub(super) fn track_shapefile(results: &Results<'_>, path: &Path) -> FileResult {
    let crs = &results.map.crs;
    let names = ["ping_from", "ping_to", "length_m"];
    let lines = track_lines(results, &results.name());
    let lines = export::lines_shapefile(path, crs, &names, &lines)?;
    Ok(FileContent::in_system(crs, lines))
}

/// Returns the pieces of the track, numbered.
fn track_lines(results: &Results<'_>, name: &str) -> Vec<LabelledLine> {
    let ping = |point: Option<&TrackPoint>| point.map_or(f64::NAN, |point| point.ping as f64);
    let line = |(number, piece): (usize, &TrackPiece)| LabelledLine {
        points: piece.points.iter().map(|point| point.position).collect(),
        label: format!("{name} {number}"),
        numbers: vec![ping(piece.points.first()), ping(piece.points.last()), piece.length_m],
        colour: TRACK_COLOUR,
    };
    (1..).zip(results.track()).map(line).collect()
}

/// Writes `footprint.geojson`.
pub(super) fn footprint_geojson(results: &Results<'_>, path: &Path) -> FileResult {
    let (ground, name) = (results.ground()?, results.name());
    let place = |at| results.map.to_lon_lat(at);
    let areas = export::footprint_geojson(path, &name, ground, place)?;
    Ok(with_area(ground, areas))
}

/// Writes `footprint.kmz`.
pub(super) fn footprint_kmz(results: &Results<'_>, path: &Path) -> FileResult {
    let (ground, name) = (results.ground()?, results.name());
    let place = |at| results.map.to_lon_lat(at);
    let areas = export::areas_kmz(path, &name, &ground.shapes, place)?;
    Ok(with_area(ground, areas))
}

fn with_area(ground: &SideScanCoverage, areas: Summary) -> FileContent {
    FileContent::in_degrees(Summary { values: Some([ground.area_m2; 2]), ..areas })
}

/// Isobaths and depth areas with the settings of their drawing.
struct DrawnContours<'a> {
    /// Isobaths and the areas between them.
    contours: &'a Contours,
    /// The isobaths with the settings of their drawing.
    lines: DrawnLines<'a>,
    /// Square metres on the ground in a square metre of the map, which are not exactly the same.
    ground: f64,
}

impl<'a> DrawnContours<'a> {
    /// Returns the contours of a survey.
    ///
    /// # Errors
    /// When the survey has no depth map, or its isobaths cannot be drawn.
    fn of(results: &'a Results<'_>) -> Result<Self, Error> {
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
        let [light, dark] = ISOBATH_COLOURS;
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

/// Writes `survey.gpkg`, in the coordinate system of the map, with those layers of track,
/// footprint, isobaths, depth areas, soundings and objects that exist. Map programs draw the layers
/// in the order in which they are added here, the first at the bottom.
pub(super) fn geopackage(results: &Results<'_>, path: &Path) -> FileResult {
    let map = &results.map;
    let placed = MapGeometry::new(map);
    let has = |need| Ok::<bool, Error>(results.missing(need)?.is_none());
    let mut layers = Vec::new();
    if has(Need::Surface)? && has(Need::Levels)? {
        let drawn = DrawnContours::of(results)?;
        let contours = drawn.contours;
        layers.push(export::depth_area_layer(&placed, &contours.areas, drawn.ground, depth_colour));
        layers.push(export::isobath_layer(&placed, &drawn.lines, drawn.ground.sqrt()));
    }
    if has(Need::Footprint)? {
        layers.push(export::footprint_layer(&placed, &results.name(), results.ground()?));
    }
    if has(Need::Surface)? && has(Need::Area)? {
        let settings = &results.products.settings.isobaths;
        layers.push(export::spot_sounding_layer(&placed, results.spot_soundings()?, settings));
    }
    layers.push(export::track_layer(&placed, results.track()));
    if results.order.asks_for(When::Listed) {
        let position = |at| placed.position(at);
        let [points, outlines] = export::object_layers(&targets(results)?, position);
        layers.extend([outlines, points]);
    }
    let time_s = results.start_unix_s().unwrap_or(0.0);
    let summary = export::geopackage(path, &map.crs, time_s, &layers)?;
    Ok(FileContent::in_system(&map.crs, summary))
}
