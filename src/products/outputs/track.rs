//! Writes the track and the insonified ground, for plotters and maps, and all lines, areas and
//! objects of a survey in one file.

use super::content::{FileContent, FileResult, Need};
use super::contours::DrawnContours;
use super::object_files::targets;
use super::order::When;
use super::results::Results;
use crate::Error;
use crate::export::{
    self, LabelledLine, MapGeometry, SideScanCoverage, Summary, TrackPiece, TrackPoint,
};
use bathyscope_bottom::presentation::colours::depth_colour;
use std::path::Path;

/// Red that is legible on a map and on a picture of the earth.
const COLOUR: [u8; 3] = [214, 39, 40];

/// Writes `track.gpx`.
pub(super) fn gpx(results: &Results<'_>, path: &Path) -> FileResult {
    let (name, start_unix_s) = (results.name(), results.start_unix_s());
    let points = export::track_gpx(path, &name, start_unix_s, results.track())?;
    Ok(FileContent::in_degrees(points))
}

/// Writes `track.geojson`.
pub(super) fn geojson(results: &Results<'_>, path: &Path) -> FileResult {
    let lines = export::track_geojson(path, results.track())?;
    Ok(FileContent::in_degrees(lines))
}

/// Writes `track.kmz`.
pub(super) fn kmz(results: &Results<'_>, path: &Path) -> FileResult {
    let name = results.name();
    let lines = export::lines_kmz(path, &name, &lines(results, &name))?;
    Ok(FileContent::in_degrees(lines))
}

/// Writes `track.shp` with its companions, in the coordinate system of the map.
pub(super) fn shapefile(results: &Results<'_>, path: &Path) -> FileResult {
    let crs = &results.map.crs;
    let names = ["ping_from", "ping_to", "length_m"];
    let lines = lines(results, &results.name());
    let lines = export::lines_shapefile(path, crs, &names, &lines)?;
    Ok(FileContent::in_system(crs, lines))
}

fn lines(results: &Results<'_>, name: &str) -> Vec<LabelledLine> {
    let ping = |point: Option<&TrackPoint>| point.map_or(f64::NAN, |point| point.ping as f64);
    let line = |(number, piece): (usize, &TrackPiece)| LabelledLine {
        points: piece.points.iter().map(|point| point.position).collect(),
        label: format!("{name} {number}"),
        numbers: vec![ping(piece.points.first()), ping(piece.points.last()), piece.length_m],
        colour: COLOUR,
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
