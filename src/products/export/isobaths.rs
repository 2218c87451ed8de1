//! Writes `isobaths.geojson`, `depth_areas.geojson`, `spot_soundings.geojson` (RFC 7946) and
//! `storage.csv`.

use super::geojson::{areas as areas_of, collection, feature_at, line_at, position};
use super::{ExportError, Summary, millimetres, write_summed};
use bathyscope_bottom::bathymetry::DepthPoint;
use bathyscope_bottom::bathymetry::isobaths::{DepthArea, Isobath, IsobathSettings, Storage};
use bathyscope_log::support::geo::LonLat;
use serde_json::json;
use std::io::Write as _;
use std::path::Path;

/// Isobaths with the settings of their drawing.
pub(crate) struct DrawnLines<'a> {
    /// The isobaths.
    pub lines: &'a [Isobath],
    /// Settings with the unit in which the depths of the lines are written.
    pub settings: &'a IsobathSettings,
    /// Depths of the lines that are thick and labelled, metres.
    pub index_levels_m: Vec<f64>,
}

impl DrawnLines<'_> {
    /// Returns true if a line is thick and labelled.
    pub(super) fn is_index(&self, line: &Isobath) -> bool {
        self.index_levels_m.contains(&line.depth_m)
    }
}

/// Writes isobaths; `place` returns the position of a point of a line.
pub(crate) fn isobaths_geojson(
    path: &Path,
    drawn: &DrawnLines<'_>,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    let feature = |line: &Isobath, summary: &mut Summary| {
        summary.count += 1;
        summary.value(line.depth_m);
        let depth = drawn.settings.in_unit(line.depth_m);
        let properties = json!({
            "depth_m": line.depth_m,
            "depth": depth,
            "unit": drawn.settings.unit.symbol(),
            "label": depth.to_string(),
            "is_index": drawn.is_index(line),
            "ring": line.is_ring(),
        });
        line_at(line.points.iter().map(|point| place(*point)), properties, summary)
    };
    collection(path, drawn.lines.iter(), feature)
}

/// Writes the areas between depths. A square metre of the polygons is `ground` square metres on the
/// ground; `place` returns the position of a corner.
pub(crate) fn depth_areas_geojson(
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
        let properties = json!({
            "from_m": millimetres(area.from_m),
            "to_m": millimetres(area.to_m),
            "area_m2": millimetres(ground * area.area_m2()),
        });
        feature_at("MultiPolygon", polygons, properties)
    };
    let filled = areas.iter().filter(|area| !area.polygons.is_empty());
    collection(path, filled, feature)
}

/// Writes depths as points with the figures that a chart prints; `place` returns the position of a
/// point.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn spot_soundings_geojson(
    path: &Path,
    soundings: &[DepthPoint],
    settings: &IsobathSettings,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    let feature = |point: &DepthPoint, summary: &mut Summary| {
        let at = position(place([point.east_m, point.north_m]));
        summary.add(at, point.depth_m);
        let properties = json!({
            "depth_m": millimetres(point.depth_m),
            "unit": settings.unit.symbol(),
            "label": settings.charted(point.depth_m),
            "is_sounding": point.is_sounding,
        });
        feature_at("Point", at, properties)
    };
    collection(path, soundings.iter(), feature)
}

/// Writes the area and the volume of the water below each level. A square metre of the table is
/// `ground` square metres on the ground.
pub(crate) fn storage_csv(
    path: &Path,
    table: &[Storage],
    ground: f64,
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        writeln!(out, "depth_m,area_m2,volume_m3")?;
        for row in table {
            summary.add([f64::NAN; 2], row.depth_m);
            let (area_m2, volume_m3) = (ground * row.area_m2, ground * row.volume_m3);
            writeln!(out, "{:.3},{area_m2:.2},{volume_m3:.2}", row.depth_m)?;
        }
        Ok(())
    })
}
