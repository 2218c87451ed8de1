//! `objects.geojson` (RFC 7946): a point for each object.

use super::object_places;
use crate::export::{ExportError, Summary, write_json};
use bathyscope_objects::objects::{ColumnValue, ListedObject, OBJECT_COLUMNS};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes objects as points with all columns of the table of objects; `null` for what is not known.
pub(crate) fn objects_geojson(
    path: &Path,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
    let features: Vec<Value> = objects.iter().map(feature).collect();
    write_json(path, &json!({ "type": "FeatureCollection", "features": features }))?;
    Ok(object_places(objects))
}

fn feature(of: &ListedObject<'_>) -> Value {
    let value = |value: Option<ColumnValue>| match value {
        None => Value::Null,
        Some(ColumnValue::Text(words)) => words.into(),
        Some(ColumnValue::Count(count)) => count.into(),
        Some(ColumnValue::Number(_, number)) => number.into(),
    };
    let properties: Map<String, Value> = (OBJECT_COLUMNS.iter())
        .map(|column| (column.name.to_owned(), value(column.value(of))))
        .collect();
    let at = of.object.position;
    json!({
        "type": "Feature",
        "id": of.object.number,
        "geometry": { "type": "Point", "coordinates": [at.lon_deg, at.lat_deg] },
        "properties": properties,
    })
}
