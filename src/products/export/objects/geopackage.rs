//! Layers of a GeoPackage with boxes: their places, and their outlines on the ground;
//! `objects.gpkg` has these two.

use super::{ObjectLog, ObjectRow, log_name};
use crate::export::ExportError;
use crate::export::geopackage::{FeatureGeometry, Layer, geopackage};
use crate::export::qgis_vector::{target_outline_style, target_style};
use crate::export::sqlite::{Value, count, text};
use bathyscope_log::support::geo::{Crs, LonLat};
use bathyscope_objects::targets::Target;
use std::path::Path;

/// EPSG's number of WGS84.
const WGS84: u16 = 4326;
/// The columns after the geometry, the same in both layers.
const COLUMNS: &str = "log TEXT, box INTEGER, object INTEGER, name TEXT, class TEXT, state TEXT, confidence TEXT, score DOUBLE, remarks TEXT, length_m DOUBLE, width_m DOUBLE, height_m DOUBLE, height_sigma_m DOUBLE, depth_m DOUBLE, sigma_m DOUBLE, side TEXT, ping_from INTEGER, ping_to INTEGER";
const ABOUT: &str = "Targets of a side-scan survey";

/// Writes boxes as two layers, `targets` (points) and `target_outlines` (length along the track by
/// width across it, on the ground), with everything that is known about them. The time of the last
/// change is that of the first recording, so that the same survey gives the same bytes.
pub(crate) fn objects_gpkg(
    path: &Path,
    logs: &[ObjectLog<'_>],
    rows: &[ObjectRow<'_>],
) -> Result<(), ExportError> {
    let degrees = Crs::from_epsg(WGS84)
        .map_err(|error| ExportError::at(path)(std::io::Error::other(error)))?;
    let first = logs.first().and_then(|log| log.survey.start_unix_s);
    let layers = object_layers(logs, rows, |at| [at.lon_deg, at.lat_deg]);
    geopackage(path, &degrees, first.unwrap_or(0.0), &layers).map(|_| ())
}

/// Boxes as two layers; `place` gives where a position lies in the system of the file. Boxes
/// without a place are left out, points and boxes of unknown size from the outlines.
pub(crate) fn object_layers(
    logs: &[ObjectLog<'_>],
    rows: &[ObjectRow<'_>],
    place: impl Fn(LonLat) -> [f64; 2],
) -> [Layer; 2] {
    let placed = || (rows.iter()).filter_map(|row| Some((row, row.of.target.as_ref()?)));
    let values = |row, target| attributes(row, target, log_name(logs, row));
    let points = placed().map(|(row, target)| {
        let at = FeatureGeometry::Point(place(target.position));
        (at, values(row, target))
    });
    let outlines = placed().filter_map(|(row, target)| {
        let corners = row.outline?;
        let around = corners.into_iter().chain([corners[0]]);
        let ring = FeatureGeometry::Polygon(vec![around.map(&place).collect()]);
        Some((ring, values(row, target)))
    });
    let outlines = Layer {
        name: "target_outlines",
        title: "Outlines of targets",
        about: ABOUT,
        geometry: "POLYGON",
        columns: COLUMNS,
        features: outlines.collect(),
        style: target_outline_style(),
    };
    let points = Layer {
        name: "targets",
        title: "Targets",
        about: ABOUT,
        geometry: "POINT",
        columns: COLUMNS,
        features: points.collect(),
        style: target_style(),
    };
    [points, outlines]
}

/// What is known of a box, column by column.
fn attributes(row: &ObjectRow<'_>, target: &Target, log: Option<&str>) -> Vec<Value> {
    let (of, one) = (row.of, &row.of.one);
    let or_nothing = |said: &str| match said.is_empty() {
        true => Value::Null,
        false => text(said),
    };
    vec![
        log.map_or(Value::Null, text),
        Value::Integer(one.id.0.into()),
        of.object.map_or(Value::Null, |number| Value::Integer(number.into())),
        or_nothing(&one.name),
        text(&of.class),
        text(one.state.name()),
        or_nothing(row.confidence()),
        one.score.map_or(Value::Null, |score| {
            // To four decimals, as in the other tables.
            Value::Real((f64::from(score) * 1e4).round() / 1e4)
        }),
        or_nothing(&one.note),
        Value::Real(target.length_m),
        Value::Real(target.width_m),
        Value::Real(target.height_m),
        Value::Real(target.height_sigma_m),
        Value::Real(target.depth_m),
        Value::Real(target.sigma_m),
        text(one.mark.side.name()),
        count(one.mark.pings.start),
        count(one.mark.pings.end),
    ]
}
