//! `objects.geojson` (RFC 7946): one point a box that has a place.

use super::{ObjectLog, ObjectRow, log_name};
use crate::export::{ExportError, write_json};
use serde_json::{Value, json};
use std::path::Path;

/// Writes boxes as points with everything that is known about them; `log` says which of several
/// logs they are of. Boxes without a place are left out.
pub(crate) fn objects_geojson(
    path: &Path,
    logs: &[ObjectLog<'_>],
    rows: &[ObjectRow<'_>],
) -> Result<(), ExportError> {
    let features = rows.iter().filter_map(|row| feature(row, log_name(logs, row)));
    let features: Vec<Value> = features.collect();
    let collection = json!({ "type": "FeatureCollection", "features": features });
    write_json(path, &collection)
}

fn feature(row: &ObjectRow<'_>, log: Option<&str>) -> Option<Value> {
    let (of, one) = (row.of, &row.of.one);
    let target = of.target.as_ref()?;
    let solid = row.shape.map(|shape| shape.posed.solid);
    let mut feature = json!({
        "type": "Feature",
        "id": one.id.0,
        "geometry": {
            "type": "Point",
            "coordinates": [target.position.lon_deg, target.position.lat_deg],
        },
        "properties": {
            "class": &of.class,
            "score": one.score.map(round),
            "state": one.state.name(),
            "side": one.mark.side.name(),
            "ping_from": one.mark.pings.start,
            "ping_to": one.mark.pings.end,
            "length_m": metres(target.length_m),
            "width_m": metres(target.width_m),
            "height_m": metres(target.height_m),
            "depth_m": metres(target.depth_m),
            "sigma_m": metres(target.sigma_m),
            "height_sigma_m": metres(target.height_sigma_m),
            "object": of.object,
            "name": &one.name,
            "confidence": row.confidence(),
            "note": &one.note,
            "shape": solid.map(|solid| solid.kind.name()),
            "shape_length_m": solid.and_then(|solid| metres(solid.length_m)),
            "shape_width_m": solid.and_then(|solid| metres(solid.width_m)),
            "shape_height_m": solid.and_then(|solid| metres(solid.height_m)),
        },
    });
    if let Some(log) = log {
        // Each log numbers its own boxes.
        feature["id"] = json!(format!("{log} {}", one.id.0));
        feature["properties"]["log"] = json!(log);
    }
    Some(feature)
}

/// To the millimetre; `null` for what is not known.
fn metres(value: f64) -> Option<f64> {
    value.is_finite().then(|| (value * 1e3).round() / 1e3)
}

fn round(score: f32) -> f64 {
    (f64::from(score) * 1e4).round() / 1e4
}
