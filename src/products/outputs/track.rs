//! The track and the insonified ground, for plotters and maps.

use super::content::{Coordinates, FileContent};
use super::ground::SideScanCoverage;
use super::results::Results;
use crate::products::export::{self, ExportError, LabelledLine, Summary, TrackPiece};
use crate::products::outputs::OutputError;
use std::path::Path;

/// Red, which stays legible on a map and on a picture of the earth.
const COLOUR: [u8; 3] = [214, 39, 40];

fn in_degrees(summary: Result<Summary, ExportError>) -> Result<FileContent, OutputError> {
    summary
        .map(|summary| FileContent::new(Coordinates::Degrees, summary))
        .map_err(OutputError::from)
}

/// Writes `track.gpx`.
pub(super) fn gpx(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let start_unix_s = results.start_unix_s();
    in_degrees(export::track_gpx(
        path,
        &results.name(),
        start_unix_s,
        results.track(),
    ))
}

/// Writes `track.geojson`.
pub(super) fn geojson(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    in_degrees(export::track_geojson(path, results.track()))
}

/// Writes `track.kmz`.
pub(super) fn kmz(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let name = results.name();
    in_degrees(export::lines_kmz(path, &name, &lines(results, &name)))
}

/// Writes `track.shp` with what belongs to it, in the system of the map.
pub(super) fn shapefile(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let crs = &results.plane.map.crs;
    let names = ["ping_from", "ping_to", "length_m"];
    let lines = lines(results, &results.name());
    export::lines_shapefile(path, crs, &names, &lines)
        .map(|lines| FileContent::new(Coordinates::System(crs.clone()), lines))
        .map_err(OutputError::from)
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
        numbers: vec![
            ping(piece.points.first()),
            ping(piece.points.last()),
            piece.length_m,
        ],
        colour: COLOUR,
    }
}

/// Writes `footprint.geojson`.
pub(super) fn footprint_geojson(
    results: &Results<'_>,
    path: &Path,
) -> Result<FileContent, OutputError> {
    let (ground, name) = (results.ground()?, results.name());
    let place = |at| results.to_lon_lat(at);
    let written = export::footprint_geojson(path, &name, &ground.shapes, ground.area_m2, place);
    with_area(ground, in_degrees(written))
}

/// Writes `footprint.kmz`.
pub(super) fn footprint_kmz(
    results: &Results<'_>,
    path: &Path,
) -> Result<FileContent, OutputError> {
    let (ground, name) = (results.ground()?, results.name());
    let place = |at| results.to_lon_lat(at);
    let written = export::areas_kmz(path, &name, &ground.shapes, place);
    with_area(ground, in_degrees(written))
}

fn with_area(
    ground: &SideScanCoverage,
    written: Result<FileContent, OutputError>,
) -> Result<FileContent, OutputError> {
    let mut content = written?;
    content.summary.values = Some([ground.area_m2; 2]);
    Ok(content)
}
