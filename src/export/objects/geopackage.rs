//! `objects.gpkg` (GeoPackage 1.3, OGC 12-128r17): a layer of the places of boxes, and one of their outlines on the ground.

use super::{ObjectLog, ObjectRow, log_name};
use crate::calendar;
use crate::detection::targets::Target;
use crate::export::sqlite::{Table, Value, database};
use crate::export::{ExportError, write_aside};
use crate::geo::LonLat;
use std::io::Write as _;
use std::path::Path;

/// `GPKG`, as the number that says what kind of database it is, and version 1.3.0.
const APPLICATION: u32 = 0x4750_4b47;
const VERSION: u32 = 10_300;
/// WGS84 in EPSG's register.
const WGS84: i32 = 4326;
const WGS84_WKT: &str = "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563,AUTHORITY[\"EPSG\",\"7030\"]],AUTHORITY[\"EPSG\",\"6326\"]],PRIMEM[\"Greenwich\",0,AUTHORITY[\"EPSG\",\"8901\"]],UNIT[\"degree\",0.0174532925199433,AUTHORITY[\"EPSG\",\"9122\"]],AUTHORITY[\"EPSG\",\"4326\"]]";

const SYSTEMS_SQL: &str = "CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT)";
const CONTENTS_SQL: &str = "CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '', last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')), min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER, CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id))";
const COLUMNS_SQL: &str = "CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL, CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name), CONSTRAINT uk_gc_table_name UNIQUE (table_name), CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name), CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id))";

/// The columns after the geometry, the same in both layers.
macro_rules! layer_sql {
    ($name:literal, $geometry:literal) => {
        concat!(
            "CREATE TABLE ",
            $name,
            " (fid INTEGER PRIMARY KEY NOT NULL, geom ",
            $geometry,
            ", log TEXT, box INTEGER, object INTEGER, name TEXT, class TEXT, state TEXT, confidence TEXT, score DOUBLE, remarks TEXT, \
             length_m DOUBLE, width_m DOUBLE, height_m DOUBLE, height_sigma_m DOUBLE, depth_m DOUBLE, sigma_m DOUBLE, \
             side TEXT, ping_from INTEGER, ping_to INTEGER)"
        )
    };
}

/// A layer: its table, its kind of geometry, and what it is called in a map program.
struct Layer {
    name: &'static str,
    sql: &'static str,
    geometry: &'static str,
    title: &'static str,
}

const POINTS: Layer = Layer {
    name: "targets",
    sql: layer_sql!("targets", "POINT"),
    geometry: "POINT",
    title: "Targets",
};
const OUTLINES: Layer = Layer {
    name: "target_outlines",
    sql: layer_sql!("target_outlines", "POLYGON"),
    geometry: "POLYGON",
    title: "Outlines of targets",
};

/// Writes boxes as two layers, `targets` (points) and `target_outlines` (length along the track by width across it, on the ground), with
/// everything that is known about them. Boxes without a place are left out, points and boxes of unknown size from the outlines. The time
/// of the last change is that of the first recording, so that the same survey gives the same bytes.
///
/// # Errors
/// When the file cannot be written.
pub fn objects_gpkg(
    path: &Path,
    logs: &[ObjectLog<'_>],
    rows: &[ObjectRow<'_>],
) -> Result<(), ExportError> {
    let time_s = logs
        .first()
        .and_then(|log| log.survey.start_unix_s)
        .unwrap_or(0.0);
    let changed = calendar::moment(time_s)
        .format("%Y-%m-%dT%H:%M:%S%.3fZ")
        .to_string();
    let placed = || (rows.iter()).filter_map(|row| Some((row, row.target.as_ref()?)));
    let points: Vec<Feature> = placed()
        .map(|(row, target)| {
            let at = Shape(vec![target.position]);
            (at, attributes(row, target, log_name(logs, row)))
        })
        .collect();
    let outlines: Vec<Feature> = placed()
        .filter_map(|(row, target)| {
            let corners = row.outline?;
            let around = corners.into_iter().chain([corners[0]]);
            let values = attributes(row, target, log_name(logs, row));
            Some((Shape(around.collect()), values))
        })
        .collect();
    let layers = [(&POINTS, points), (&OUTLINES, outlines)];
    let bytes = database(APPLICATION, VERSION, &tables(&layers, &changed));
    write_aside(path, |mut file| match &bytes {
        Some(bytes) => file.write_all(bytes),
        // The keys of the tables are of a few letters each.
        None => Err(std::io::Error::other("a key does not fit into a page")),
    })
}

fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

fn whole(number: usize) -> Value {
    Value::Integer(i64::try_from(number).unwrap_or(i64::MAX))
}

/// The tables that every GeoPackage has, and the layers.
fn tables(layers: &[(&Layer, Vec<Feature>)], changed: &str) -> Vec<Table> {
    let system = |name: &str, id: i64, by: &str, definition: &str| {
        let values = vec![
            text(name),
            Value::Null,
            text(by),
            Value::Integer(id),
            text(definition),
            Value::Null,
        ];
        (id, values)
    };
    let mut tables = vec![
        Table {
            name: "gpkg_spatial_ref_sys",
            sql: SYSTEMS_SQL,
            rows: vec![
                system("Undefined Cartesian SRS", -1, "NONE", "undefined"),
                system("Undefined geographic SRS", 0, "NONE", "undefined"),
                system("WGS 84 geodetic", WGS84.into(), "EPSG", WGS84_WKT),
            ],
            keys: &[],
        },
        Table {
            name: "gpkg_contents",
            sql: CONTENTS_SQL,
            rows: (1..)
                .zip(layers)
                .map(|(id, (layer, features))| (id, contents(layer, features, changed)))
                .collect(),
            keys: &[&[0], &[2]],
        },
        Table {
            name: "gpkg_geometry_columns",
            sql: COLUMNS_SQL,
            rows: (1..)
                .zip(layers)
                .map(|(id, (layer, _))| {
                    let values = vec![
                        text(layer.name),
                        text("geom"),
                        text(layer.geometry),
                        Value::Integer(WGS84.into()),
                        Value::Integer(0),
                        Value::Integer(0),
                    ];
                    (id, values)
                })
                .collect(),
            keys: &[&[0, 1], &[0]],
        },
    ];
    tables.extend(layers.iter().map(|(layer, features)| {
        Table {
            name: layer.name,
            sql: layer.sql,
            rows: (1..)
                .zip(features)
                .map(|(id, (shape, attributes))| {
                    let values = [Value::Null, Value::Blob(shape.bytes())];
                    (
                        id,
                        values
                            .into_iter()
                            .chain(attributes.iter().cloned())
                            .collect(),
                    )
                })
                .collect(),
            keys: &[],
        }
    }));
    tables
}

/// A layer in the table of contents, with its extent.
fn contents(layer: &Layer, features: &[Feature], changed: &str) -> Vec<Value> {
    let all = || features.iter().flat_map(|(shape, _)| &shape.0);
    let [west, south, east, north] = bounds(all());
    vec![
        text(layer.name),
        text("features"),
        text(layer.title),
        text("Targets of a side-scan survey"),
        text(changed),
        // Without features the bounds are NaN, which is written as nothing.
        Value::Real(west),
        Value::Real(south),
        Value::Real(east),
        Value::Real(north),
        Value::Integer(WGS84.into()),
    ]
}

/// West, south, east and north end; NaN of nothing.
fn bounds<'a>(places: impl Iterator<Item = &'a LonLat> + Clone) -> [f64; 4] {
    let lon = places.clone().map(|at| at.lon_deg);
    let lat = places.map(|at| at.lat_deg);
    [
        lon.clone().fold(f64::NAN, f64::min),
        lat.clone().fold(f64::NAN, f64::min),
        lon.fold(f64::NAN, f64::max),
        lat.fold(f64::NAN, f64::max),
    ]
}

/// What is known of a box, column by column.
fn attributes(row: &ObjectRow<'_>, target: &Target, log: Option<&str>) -> Vec<Value> {
    let or_nothing = |said: &str| match said.is_empty() {
        true => Value::Null,
        false => text(said),
    };
    vec![
        log.map_or(Value::Null, text),
        Value::Integer(row.id.into()),
        row.object.map_or(Value::Null, whole),
        or_nothing(row.name),
        text(row.class),
        text(row.state),
        or_nothing(row.confidence),
        row.score.map_or(Value::Null, |score| {
            // To four decimals, as in the other tables.
            Value::Real((f64::from(score) * 1e4).round() / 1e4)
        }),
        or_nothing(row.note),
        Value::Real(target.length_m),
        Value::Real(target.width_m),
        Value::Real(target.height_m),
        Value::Real(target.height_sigma_m),
        Value::Real(target.depth_m),
        Value::Real(target.sigma_m),
        text(row.mark.side.name()),
        whole(row.mark.pings.start),
        whole(row.mark.pings.end),
    ]
}

/// A shape with the columns of its row.
type Feature = (Shape, Vec<Value>);

/// A point, or a ring that ends where it begins.
struct Shape(Vec<LonLat>);

impl Shape {
    /// The geometry: the header of a GeoPackage's, and behind it well-known binary (OGC 06-103r4), all of it with the lowest byte first.
    fn bytes(&self) -> Vec<u8> {
        let is_point = self.0.len() == 1;
        // Lowest byte first; an envelope of two dimensions where it is no point.
        let flags = if is_point { 0b001 } else { 0b011 };
        let mut bytes = vec![b'G', b'P', 0, flags];
        bytes.extend(WGS84.to_le_bytes());
        if !is_point {
            let [west, south, east, north] = bounds(self.0.iter());
            for end in [west, east, south, north] {
                bytes.extend(end.to_le_bytes());
            }
        }
        bytes.push(1);
        let kind: u32 = if is_point { 1 } else { 3 };
        bytes.extend(kind.to_le_bytes());
        if !is_point {
            bytes.extend(1_u32.to_le_bytes());
            bytes.extend((self.0.len() as u32).to_le_bytes());
        }
        for at in &self.0 {
            bytes.extend(at.lon_deg.to_le_bytes());
            bytes.extend(at.lat_deg.to_le_bytes());
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_is_well_known_binary_behind_a_header() {
        let at = |lon_deg, lat_deg| LonLat { lon_deg, lat_deg };
        let point = Shape(vec![at(1.5, -2.0)]).bytes();
        assert_eq!(point[..8], [b'G', b'P', 0, 1, 0xe6, 0x10, 0, 0]);
        assert_eq!(point[8..13], [1, 1, 0, 0, 0]);
        assert_eq!(point[13..21], 1.5_f64.to_le_bytes());
        assert_eq!(point.len(), 29);
        let ring = [at(0.0, 0.0), at(2.0, 0.0), at(1.0, 3.0), at(0.0, 0.0)];
        let polygon = Shape(ring.to_vec()).bytes();
        assert_eq!(polygon[3], 3);
        // West, east, south, north.
        assert_eq!(polygon[16..24], 2.0_f64.to_le_bytes());
        assert_eq!(polygon[32..40], 3.0_f64.to_le_bytes());
        assert_eq!(polygon[40..49], [1, 3, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(polygon.len(), 8 + 32 + 5 + 8 + 4 * 16);
    }
}
