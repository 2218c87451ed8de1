//! Functions that all writers of GeoJSON files (RFC 7946) share.

use super::antimeridian::{cut_areas, cut_line};
use super::rings::rounded;
use super::{ExportError, Summary, write_summed};
use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_log::support::geo::LonLat;
use serde::Serialize;
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::Path;

/// Steps of longitude and latitude in a degree: 1e-8 of one is a millimetre.
const STEPS: f64 = 1e8;

/// Writes one feature a line, so that no more than one is in memory as text.
pub(super) fn collection<T>(
    path: &Path,
    things: impl Iterator<Item = T>,
    feature: impl Fn(T, &mut Summary) -> Value,
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        out.write_all(b"{ \"type\": \"FeatureCollection\", \"features\": [")?;
        for (index, thing) in things.enumerate() {
            out.write_all(if index == 0 { b"\n" } else { b",\n" })?;
            serde_json::to_writer(&mut *out, &feature(thing, summary))?;
        }
        out.write_all(b"\n] }\n")
    })
}

/// A feature of a collection.
pub(super) fn feature_at(kind: &str, coordinates: impl Serialize, properties: Value) -> Value {
    let geometry = json!({ "type": kind, "coordinates": coordinates });
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}

/// Longitude and latitude to a millimetre.
pub(super) fn position(at: LonLat) -> [f64; 2] {
    [at.lon_deg, at.lat_deg].map(|degrees| (degrees * STEPS).round() as i64 as f64 / STEPS)
}

/// A line's positions, none twice in a row.
pub(super) fn positions(places: impl Iterator<Item = LonLat>) -> Vec<[f64; 2]> {
    let mut positions: Vec<[f64; 2]> = places.map(position).collect();
    positions.dedup();
    positions
}

/// The coordinates of a `MultiPolygon`: polygons, each an outline and its holes, valid after
/// rounding.
pub(super) fn areas(
    shapes: &[Polygon],
    place: &impl Fn([f64; 2]) -> LonLat,
) -> Vec<Vec<Vec<[f64; 2]>>> {
    rounded(&cut_areas(shapes, place), STEPS, |at| at)
}

/// A line as a feature: a `LineString`, or a `MultiLineString` where it crosses the 180th meridian.
pub(super) fn line_at(
    places: impl Iterator<Item = LonLat>,
    properties: Value,
    summary: &mut Summary,
) -> Value {
    let mut parts: Vec<Vec<[f64; 2]>> = cut_line(places)
        .into_iter()
        .map(|part| positions(part.into_iter().map(|[lon, lat]| LonLat::new(lon, lat))))
        .collect();
    parts.iter().flatten().for_each(|at| summary.reach(*at));
    match parts.len() {
        0 | 1 => feature_at("LineString", parts.pop().unwrap_or_default(), properties),
        _ => feature_at("MultiLineString", parts, properties),
    }
}
