//! Writes the track and the insonified ground, for plotters and maps.

use super::content::{FileContent, FileResult};
use super::ground::SideScanCoverage;
use super::results::Results;
use crate::export::{self, LabelledLine, Summary, TrackPiece};
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
    let crs = &results.plane.map.crs;
    let names = ["ping_from", "ping_to", "length_m"];
    let lines = lines(results, &results.name());
    let lines = export::lines_shapefile(path, crs, &names, &lines)?;
    Ok(FileContent::in_system(crs, lines))
}

fn lines(results: &Results<'_>, name: &str) -> Vec<LabelledLine> {
    let numbered = (1..).zip(results.track());
    numbered.map(|(n, piece)| line(name, n, piece)).collect()
}

fn line(name: &str, number: usize, piece: &TrackPiece) -> LabelledLine {
    let ping =
        |point: Option<&export::TrackPoint>| point.map_or(f64::NAN, |point| point.ping as f64);
    LabelledLine {
        points: piece.points.iter().map(|point| point.position).collect(),
        label: format!("{name} {number}"),
        numbers: vec![ping(piece.points.first()), ping(piece.points.last()), piece.length_m],
        colour: COLOUR,
    }
}

/// Writes `footprint.geojson`.
pub(super) fn footprint_geojson(results: &Results<'_>, path: &Path) -> FileResult {
    let (ground, name) = (results.ground()?, results.name());
    let place = |at| results.to_lon_lat(at);
    let areas = export::footprint_geojson(path, &name, &ground.shapes, ground.area_m2, place)?;
    Ok(with_area(ground, areas))
}

/// Writes `footprint.kmz`.
pub(super) fn footprint_kmz(results: &Results<'_>, path: &Path) -> FileResult {
    let (ground, name) = (results.ground()?, results.name());
    let place = |at| results.to_lon_lat(at);
    let areas = export::areas_kmz(path, &name, &ground.shapes, place)?;
    Ok(with_area(ground, areas))
}

fn with_area(ground: &SideScanCoverage, areas: Summary) -> FileContent {
    FileContent::in_degrees(Summary { values: Some([ground.area_m2; 2]), ..areas })
}
