//! Writes objects for plotters and map programs: `objects.geojson` (RFC 7946) with a point for each
//! object, `objects.gpx` (GPX 1.1) with a waypoint, `objects.kml` (KML 2.2) with a placemark, and
//! `objects.gpkg` (GeoPackage) with two layers: the places of objects and their outlines on the
//! ground.
//!
//! The text of an object has a name, a line of description, and its columns as elements of XML.

use super::object_places;
use crate::export::geopackage::{FeatureGeometry, Layer, WGS84, geopackage};
use crate::export::qgis_style::{target_outline_style, target_style};
use crate::export::sqlite::{self, count, text};
use crate::export::{ExportError, GPX_HEAD, KML_HEAD, Summary, write_bytes, write_json};
use bathyscope_bottom::presentation::text::plural;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::geo::{Crs, LonLat};
use bathyscope_log::support::printable::xml;
use bathyscope_objects::objects::{
    ColumnValue, ColumnValues, ListedObject, OBJECT_COLUMNS, Object, ObjectColumn,
};
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::path::Path;

/// Returns the description that a plotter shows beside the name of an object, without unknown
/// values.
fn description(object: &Object) -> String {
    let units = Units::default();
    let mut parts = vec![object.class.clone(), object.state.name().to_owned()];
    if let Some(score) = object.score {
        parts.push(format!("score {score:.2}"));
    }
    if let Some(certainty) = object.certainty {
        parts.push(certainty.name().to_owned());
    }
    let (length_m, width_m) = (object.length_m, object.width_m);
    if length_m.is_finite() && width_m.is_finite() {
        parts.push(format!("{length_m:.2} x {width_m:.2} m"));
    }
    let known = [
        ("height", object.height.mean_m, object.height.sigma_m),
        ("depth", object.depth_m, f64::NAN),
        ("position within", object.sigma_m, f64::NAN),
    ];
    let known = known.iter().filter(|(_, metres, _)| metres.is_finite());
    parts.extend(known.map(|(what, metres, sigma_m)| {
        format!("{what} {}", units.with_sigma(*metres, *sigma_m, 2))
    }));
    let passes = plural(object.sightings, "pass", "passes");
    parts.push(format!("seen on {passes}"));
    if !object.remarks.is_empty() {
        parts.push(object.remarks.clone());
    }
    parts.join("; ")
}

/// Returns a different name for each object, because plotters treat places of the same name as one
/// place: `Anna`, `rock 12`. A name that several objects have is followed by their numbers.
fn titles(objects: &[ListedObject<'_>]) -> Vec<String> {
    let mut times: HashMap<&str, usize> = HashMap::new();
    for ListedObject { object, .. } in objects {
        *times.entry(&object.name).or_default() += 1;
    }
    let title = |ListedObject { object, .. }: &ListedObject<'_>| {
        let name = object.name.as_str();
        match (name, times[name]) {
            ("", _) => format!("{} {}", object.class, object.number),
            (name, 1) => name.to_owned(),
            (name, _) => format!("{name} {}", object.number),
        }
    };
    objects.iter().map(title).collect()
}

/// Returns the known columns of an object, each as an element that `element` creates from the name
/// and the value.
fn elements(of: &ListedObject<'_>, element: impl Fn(&str, &str) -> String) -> String {
    let known = OBJECT_COLUMNS.iter().map(|column| (column.name, column.text(of)));
    let known = known.filter(|(_, text)| !text.is_empty());
    known.map(|(name, text)| element(name, &xml(&text))).collect()
}

/// Writes objects as points with all columns of the table of objects; unknown values are `null`.
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

/// Writes objects as waypoints: name, remarks (`cmt`), a line of known values (`desc`), class
/// (`type`), and the columns of the table of objects as extensions.
pub(crate) fn objects_gpx(
    path: &Path,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
    let mut text = format!("{GPX_HEAD} xmlns:bathyscope=\"urn:bathyscope:object\">\n");
    for (of, title) in objects.iter().zip(titles(objects)) {
        let object = of.object;
        let columns =
            elements(of, |name, text| format!("<bathyscope:{name}>{text}</bathyscope:{name}>"));
        let at = object.position;
        let remarks = if object.remarks.is_empty() {
            String::new()
        } else {
            format!("<cmt>{}</cmt>", xml(&object.remarks))
        };
        text += &format!(
            "<wpt lat=\"{:.8}\" lon=\"{:.8}\"><name>{}</name>{remarks}<desc>{}</desc><type>{}</type><extensions>{columns}</extensions></wpt>\n",
            at.lat_deg,
            at.lon_deg,
            xml(&title),
            xml(&description(object)),
            xml(&object.class),
        );
    }
    text.push_str("</gpx>\n");
    write_bytes(path, text)?;
    Ok(object_places(objects))
}

/// Writes objects as placemarks, with the columns of the table of objects as extended data.
pub(crate) fn objects_kml(
    path: &Path,
    name: &str,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
    let mut text = format!("{KML_HEAD}<name>{}</name>\n", xml(name));
    for (of, title) in objects.iter().zip(titles(objects)) {
        let object = of.object;
        let columns = elements(of, |name, text| {
            format!("<Data name=\"{name}\"><value>{text}</value></Data>")
        });
        let at = object.position;
        text += &format!(
            "<Placemark><name>{}</name><description>{}</description><ExtendedData>{columns}</ExtendedData><Point><coordinates>{:.8},{:.8}</coordinates></Point></Placemark>\n",
            xml(&title),
            xml(&description(object)),
            at.lon_deg,
            at.lat_deg,
        );
    }
    text.push_str("</Document>\n</kml>\n");
    write_bytes(path, text)?;
    Ok(object_places(objects))
}

/// Writes objects as two layers, `targets` (points) and `target_outlines` (length along the track
/// by width across it, on the ground), with all columns of the table of objects. The recorded time
/// of the last change is `changed_unix_s`, that of the first recording, so that the same survey
/// gives the same bytes.
pub(crate) fn objects_gpkg(
    path: &Path,
    objects: &[ListedObject<'_>],
    changed_unix_s: f64,
) -> Result<Summary, ExportError> {
    let degrees = Crs::from_epsg(WGS84)
        .map_err(|error| ExportError::at(path)(std::io::Error::other(error)))?;
    let layers = object_layers(objects, |at| [at.lon_deg, at.lat_deg]);
    geopackage(path, &degrees, changed_unix_s, &layers)
}

/// Returns objects as two layers, points and outlines; `place` returns the coordinates of a
/// position in the system of the file. Objects of unknown size have no outline.
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
    let points = Layer {
        name: "targets",
        title: "Targets",
        about: "Targets of a side-scan survey",
        geometry: "POINT",
        columns: columns().into(),
        features: points.collect(),
        style: target_style(),
    };
    let outlines = Layer {
        name: "target_outlines",
        title: "Outlines of targets",
        geometry: "POLYGON",
        columns: points.columns.clone(),
        features: outlines.collect(),
        style: target_outline_style(),
        ..points
    };
    [points, outlines]
}

/// Returns the columns of the table of objects as SQL declares them.
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

fn values(of: &ListedObject<'_>) -> Vec<sqlite::Value> {
    let value = |column: &ObjectColumn| match column.value(of) {
        None => sqlite::Value::Null,
        Some(ColumnValue::Text(words)) => text(&words),
        Some(ColumnValue::Count(number)) => count(number),
        Some(ColumnValue::Number(_, number)) => sqlite::Value::Real(number),
    };
    OBJECT_COLUMNS.iter().map(value).collect()
}
