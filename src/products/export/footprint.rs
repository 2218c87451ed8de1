//! `footprint.geojson`: the ground that the side-scan insonified.

use super::geojson::{areas, collection, feature_at};
use super::{ExportError, Summary};
use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_log::support::geo::LonLat;
use serde_json::json;
use std::path::Path;

/// Writes the ground of one log as one feature of `area_m2`.
pub(crate) fn footprint_geojson(
    path: &Path,
    name: &str,
    shapes: &[Polygon],
    area_m2: f64,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    let feature = |_: (), summary: &mut Summary| {
        let polygons = areas(shapes, &place);
        summary.count += 1;
        let corners = polygons.iter().flatten().flatten();
        corners.for_each(|corner| summary.reach(*corner));
        let properties = json!({ "log": name, "area_m2": (area_m2 * 10.0).round() / 10.0 });
        feature_at("MultiPolygon", polygons, properties)
    };
    collection(path, std::iter::once(()), feature)
}
