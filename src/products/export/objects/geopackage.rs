//! Layers of a GeoPackage with objects: their places, and their outlines on the ground;
//! `objects.gpkg` has these two.

use crate::export::ExportError;
use crate::export::geopackage::{FeatureGeometry, Layer, geopackage};
use crate::export::qgis_vector::{target_outline_style, target_style};
use crate::export::sqlite::{Value, count, text};
use bathyscope_log::support::geo::{Crs, LonLat};
use bathyscope_objects::objects::{
    ColumnValue, ColumnValues, ListedObject, OBJECT_COLUMNS, ObjectColumn,
};
use std::path::Path;

/// EPSG's number of WGS84.
const WGS84: u16 = 4326;
const ABOUT: &str = "Targets of a side-scan survey";

/// Writes objects as two layers, `targets` (points) and `target_outlines` (length along the track
/// by width across it, on the ground), with all columns of the table of objects. The time of the
/// last change is `changed_unix_s`, that of the first recording, so that the same survey gives the
/// same bytes.
pub(crate) fn objects_gpkg(
    path: &Path,
    objects: &[ListedObject<'_>],
    changed_unix_s: f64,
) -> Result<(), ExportError> {
    let degrees = Crs::from_epsg(WGS84)
        .map_err(|error| ExportError::at(path)(std::io::Error::other(error)))?;
    let layers = object_layers(objects, |at| [at.lon_deg, at.lat_deg]);
    geopackage(path, &degrees, changed_unix_s, &layers).map(|_| ())
}

/// Objects as two layers; `place` gives where a position lies in the system of the file. Objects of
/// unknown size have no outline.
pub(crate) fn object_layers(
    objects: &[ListedObject<'_>],
    place: impl Fn(LonLat) -> [f64; 2],
) -> [Layer; 2] {
    let points = objects.iter().map(|of| {
        let at = FeatureGeometry::Point(place(of.object.position));
        (at, values(of))
    });
    let outlines = objects.iter().filter_map(|of| {
        let corners = of.outline?;
        let around = corners.into_iter().chain([corners[0]]);
        let ring = FeatureGeometry::Polygon(vec![around.map(&place).collect()]);
        Some((ring, values(of)))
    });
    let outlines = Layer {
        name: "target_outlines",
        title: "Outlines of targets",
        about: ABOUT,
        geometry: "POLYGON",
        columns: columns().into(),
        features: outlines.collect(),
        style: target_outline_style(),
    };
    let points = Layer {
        name: "targets",
        title: "Targets",
        about: ABOUT,
        geometry: "POINT",
        columns: columns().into(),
        features: points.collect(),
        style: target_style(),
    };
    [points, outlines]
}

/// The columns as SQL declares them.
fn columns() -> String {
    let declared = |column: &ObjectColumn| {
        let kind = match column.values {
            ColumnValues::Text(_) | ColumnValues::State(_) => "TEXT",
            ColumnValues::Count(_) => "INTEGER",
            ColumnValues::Number(..)
            | ColumnValues::Length(_)
            | ColumnValues::Measured(_)
            | ColumnValues::Position(_) => "DOUBLE",
        };
        format!("{} {kind}", column.name)
    };
    let columns: Vec<String> = OBJECT_COLUMNS.iter().map(declared).collect();
    columns.join(", ")
}

fn values(of: &ListedObject<'_>) -> Vec<Value> {
    let value = |column: &ObjectColumn| match column.value(of) {
        None => Value::Null,
        Some(ColumnValue::Text(words)) => text(&words),
        Some(ColumnValue::Count(number)) => count(number),
        Some(ColumnValue::Number(_, number)) => Value::Real(number),
    };
    OBJECT_COLUMNS.iter().map(value).collect()
}
