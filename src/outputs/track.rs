//! The track and the ground that was heard, for plotters and maps.

use super::record::{Coordinates, Made};
use crate::export::{self, ExportError, Line, Summary, TrackPiece};
use crate::geo::MapPlane;
use crate::mosaic::footprint;
use crate::pipeline::{Products, mosaic_layout};
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::Path;

/// Red, which stays legible on a map and on a picture of the earth.
const COLOUR: [u8; 3] = [214, 39, 40];
/// What a track does not depend on.
const REGARDLESS_OF: [&str; 13] = [
    "calibration",
    "cloud",
    "detector",
    "draft_m",
    "height_offset_m",
    "first_return",
    "image",
    "isobaths",
    "mosaic",
    "outliers",
    "sound_speed",
    "surface",
    "water_level",
];

/// Writes the track as GPX, GeoJSON, KMZ and shapefile, and the footprint as GeoJSON and KMZ, with why something is missing.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled.
pub fn write_track(
    survey: &Survey,
    products: &Products,
    map: &MapPlane,
    folder: &Path,
    progress: &Progress,
) -> Result<(Vec<Made>, Vec<String>), String> {
    let pieces = export::track(survey, &products.navigation);
    if pieces.is_empty() {
        let why = "no track: the log has no position, or the boat lay still";
        return Ok((Vec::new(), vec![why.to_owned()]));
    }
    let mut made = write_lines(survey, &pieces, map, folder)?;
    let mut warnings = Vec::new();
    match write_footprint(survey, products, map, folder, progress)? {
        Some(footprint) => made.extend(footprint),
        None if survey.has_side_scan() => warnings.push(
            "no footprint: no ping has side-scan, a place, a heading and an altitude".to_owned(),
        ),
        None => {}
    }
    Ok((made, warnings))
}

fn write_lines(
    survey: &Survey,
    pieces: &[TrackPiece],
    map: &MapPlane,
    folder: &Path,
) -> Result<Vec<Made>, String> {
    let fail = |error: ExportError| error.to_string();
    let made = |name, coordinates, counted, summary| Made {
        name,
        what: "The boat's track, thinned to half a metre, broken where the log paused",
        coordinates,
        counted,
        measured: "",
        summary,
        regardless_of: &REGARDLESS_OF,
    };
    let name = survey.name();
    let lines: Vec<Line> = (1..)
        .zip(pieces)
        .map(|(n, piece)| line(&name, n, piece))
        .collect();
    let names = ["ping_from", "ping_to", "length_m"];
    let start_unix_s = survey.start_unix_s;
    let gpx = export::track_gpx(&folder.join("track.gpx"), &name, start_unix_s, pieces);
    let geojson = export::track_geojson(&folder.join("track.geojson"), pieces);
    let kmz = export::lines_kmz(&folder.join("track.kmz"), &name, &lines);
    let shapes = export::lines_shapefile(&folder.join("track.shp"), &map.crs, &names, &lines);
    let system = Coordinates::System(map.crs.clone());
    Ok(vec![
        made(
            "track.gpx",
            Coordinates::Degrees,
            "points",
            gpx.map_err(fail)?,
        ),
        made(
            "track.geojson",
            Coordinates::Degrees,
            "lines",
            geojson.map_err(fail)?,
        ),
        made(
            "track.kmz",
            Coordinates::Degrees,
            "lines",
            kmz.map_err(fail)?,
        ),
        made("track.shp", system, "lines", shapes.map_err(fail)?),
    ])
}

fn line(name: &str, number: usize, piece: &TrackPiece) -> Line {
    let ping =
        |point: Option<&export::TrackPoint>| point.map_or(f64::NAN, |point| point.ping as f64);
    Line {
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

/// `None` where there is no ground that was heard.
fn write_footprint(
    survey: &Survey,
    products: &Products,
    map: &MapPlane,
    folder: &Path,
    progress: &Progress,
) -> Result<Option<Vec<Made>>, String> {
    let layout = mosaic_layout(survey, products, map);
    let shapes = footprint(&layout, progress).map_err(|error| error.to_string())?;
    let Some(first) = shapes.first().and_then(|shape| shape.outline.first()) else {
        return Ok(None);
    };
    let on_map_m2: f64 = shapes.iter().map(|shape| shape.area_m2()).sum();
    let area_m2 = on_map_m2 / map.area_scale_at(*first);
    let place = |at| map.to_lon_lat(at);
    let fail = |error: ExportError| error.to_string();
    let made = |name, summary| Made {
        name,
        what: "The ground that the side-scan heard, without turns",
        coordinates: Coordinates::Degrees,
        counted: "areas",
        measured: "area_m2",
        summary: Summary {
            values: Some([area_m2; 2]),
            ..summary
        },
        regardless_of: &["cloud", "detector", "isobaths", "outliers", "surface"],
    };
    let log = survey.name();
    let (geojson, kmz) = ("footprint.geojson", "footprint.kmz");
    let in_geojson =
        export::footprint_geojson(&folder.join(geojson), &log, &shapes, area_m2, place);
    let in_kmz = export::areas_kmz(&folder.join(kmz), &log, &shapes, place);
    Ok(Some(vec![
        made(geojson, in_geojson.map_err(fail)?),
        made(kmz, in_kmz.map_err(fail)?),
    ]))
}
