//! `isobaths.geojson`, `depth_areas.geojson` (RFC 7946) and `storage.csv`.

use super::{ExportError, write_aside};
use crate::bathymetry::isobaths::{DepthArea, Isobath, Storage, smoothed};
use crate::geo::LonLat;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Writes lines of equal depth, their corners cut `smooth` times; `place` tells where a point of them lies.
pub fn isobaths_geojson(
    path: &Path,
    lines: &[Isobath],
    smooth: u32,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<(), ExportError> {
    let feature = |line: &Isobath| {
        let points = smoothed(&line.points, smooth);
        json!({
            "type": "Feature",
            "geometry": { "type": "LineString", "coordinates": positions(&points, &place) },
            "properties": { "depth_m": line.depth_m, "label": format!("{}", line.depth_m), "ring": line.is_ring() },
        })
    };
    write_aside(path, |file| collection(file, lines.iter().map(feature)))
}

/// Writes the areas between depths. A square metre of the polygons is `ground` square metres on the ground.
pub fn depth_areas_geojson(
    path: &Path,
    areas: &[DepthArea],
    ground: f64,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<(), ExportError> {
    let feature = |area: &DepthArea| {
        let polygons = area.polygons.iter().map(|polygon| {
            let rings = std::iter::once(&polygon.outline).chain(&polygon.holes);
            without_slivers(rings.map(|ring| positions(ring, &place)).collect())
        });
        json!({
            "type": "Feature",
            "geometry": { "type": "MultiPolygon", "coordinates": polygons.flatten().collect::<Vec<_>>() },
            "properties": {
                "from_m": millimetres(area.from_m),
                "to_m": millimetres(area.to_m),
                "area_m2": millimetres(ground * area.area_m2()),
            },
        })
    };
    let filled = areas.iter().filter(|area| !area.polygons.is_empty());
    write_aside(path, |file| collection(file, filled.map(feature)))
}

/// Writes what lies below each level: depth, area, volume. A square metre of the table is `ground` square metres on the ground.
pub fn storage_csv(path: &Path, table: &[Storage], ground: f64) -> Result<(), ExportError> {
    write_aside(path, |file| {
        let mut out = BufWriter::new(file);
        writeln!(out, "depth_m,area_m2,volume_m3")?;
        for row in table {
            let (area_m2, volume_m3) = (ground * row.area_m2, ground * row.volume_m3);
            writeln!(out, "{:.3},{area_m2:.2},{volume_m3:.2}", row.depth_m)?;
        }
        out.flush()
    })
}

/// One feature a line, so that no more than one is in memory as text.
fn collection(file: File, features: impl Iterator<Item = Value>) -> io::Result<()> {
    let mut out = BufWriter::new(file);
    out.write_all(b"{ \"type\": \"FeatureCollection\", \"features\": [")?;
    for (index, feature) in features.enumerate() {
        out.write_all(if index == 0 { b"\n" } else { b",\n" })?;
        serde_json::to_writer(&mut out, &feature)?;
    }
    out.write_all(b"\n] }\n")?;
    out.flush()
}

/// Longitude and latitude to 1e-8 degrees, a millimetre.
fn positions(points: &[[f64; 2]], place: &impl Fn([f64; 2]) -> LonLat) -> Vec<[f64; 2]> {
    let rounded = |degrees: f64| (degrees * 1e8).round() / 1e8;
    let position = |point: &[f64; 2]| {
        let at = place(*point);
        [rounded(at.lon_deg), rounded(at.lat_deg)]
    };
    let mut positions: Vec<[f64; 2]> = points.iter().map(position).collect();
    positions.dedup();
    positions
}

/// The outline and the holes that are still rings after rounding; `None` where the outline is none.
fn without_slivers(rings: Vec<Vec<[f64; 2]>>) -> Option<Vec<Vec<[f64; 2]>>> {
    // A closed ring of a triangle has four positions.
    let is_ring = |ring: &Vec<[f64; 2]>| ring.len() > 3;
    rings.first().filter(|outline| is_ring(outline))?;
    Some(rings.into_iter().filter(is_ring).collect())
}

fn millimetres(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}
