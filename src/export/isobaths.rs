//! `isobaths.geojson`, `depth_areas.geojson` (RFC 7946) and `storage.csv`.

use super::geojson::{areas as areas_of, collection, positions};
use super::{ExportError, Summary, write_aside};
use crate::bathymetry::isobaths::{DepthArea, Isobath, Storage, smoothed};
use crate::geo::LonLat;
use serde_json::json;
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Writes lines of equal depth, their corners cut `smooth` times; `place` gives where a point of them lies.
pub fn isobaths_geojson(
    path: &Path,
    lines: &[Isobath],
    smooth: u32,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    let feature = |line: &Isobath, summary: &mut Summary| {
        let points = smoothed(&line.points, smooth);
        let points = positions(points.iter().map(|point| place(*point)));
        summary.count += 1;
        summary.value(line.depth_m);
        points.iter().for_each(|point| summary.reach(*point));
        json!({
            "type": "Feature",
            "geometry": { "type": "LineString", "coordinates": points },
            "properties": { "depth_m": line.depth_m, "label": format!("{}", line.depth_m), "ring": line.is_ring() },
        })
    };
    write_aside(path, |file| collection(file, lines.iter(), feature))
}

/// Writes the areas between depths. A square metre of the polygons is `ground` square metres on the ground.
pub fn depth_areas_geojson(
    path: &Path,
    areas: &[DepthArea],
    ground: f64,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    let feature = |area: &DepthArea, summary: &mut Summary| {
        let polygons = areas_of(&area.polygons, &place);
        summary.count += 1;
        summary.value(area.from_m);
        summary.value(area.to_m);
        let corners = polygons.iter().flatten().flatten();
        corners.for_each(|corner| summary.reach(*corner));
        json!({
            "type": "Feature",
            "geometry": { "type": "MultiPolygon", "coordinates": polygons },
            "properties": {
                "from_m": millimetres(area.from_m),
                "to_m": millimetres(area.to_m),
                "area_m2": millimetres(ground * area.area_m2()),
            },
        })
    };
    let filled = areas.iter().filter(|area| !area.polygons.is_empty());
    write_aside(path, |file| collection(file, filled, feature))
}

/// Writes what lies below each level: depth, area, volume. A square metre of the table is `ground` square metres on the ground.
///
/// # Errors
/// When the file cannot be written.
pub fn storage_csv(path: &Path, table: &[Storage], ground: f64) -> Result<Summary, ExportError> {
    write_aside(path, |file| {
        let (mut out, mut summary) = (BufWriter::new(file), Summary::default());
        writeln!(out, "depth_m,area_m2,volume_m3")?;
        for row in table {
            summary.add([f64::NAN; 2], row.depth_m);
            let (area_m2, volume_m3) = (ground * row.area_m2, ground * row.volume_m3);
            writeln!(out, "{:.3},{area_m2:.2},{volume_m3:.2}", row.depth_m)?;
        }
        out.flush()?;
        Ok(summary)
    })
}

fn millimetres(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}
