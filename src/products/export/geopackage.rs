//! Writes GeoPackages (version 1.3, OGC 12-128r17): layers of features in one file, each with its
//! R-tree and the style in which QGIS draws it.
//!
//! In: layers of features. Out: a GeoPackage.
//!
//! A geometry is stored as a header with its bounding box, followed by well-known binary (OGC
//! 06-103r4), all with the lowest byte first. With the R-tree of a layer (extension
//! `gpkg_rtree_index`) a map program finds the features in its window without reading all of them.

use super::sqlite::{DatabaseKind, Value, database, insert, run, text};
use super::{ExportError, Summary};
use bathyscope_log::support::calendar;
use bathyscope_log::support::geo::Crs;
use bathyscope_log::support::outline::box_around;
use rusqlite::Connection;
use std::borrow::Cow;
use std::io;
use std::path::Path;

/// `GPKG` as a number, and version 1.3.0.
const KIND: DatabaseKind = DatabaseKind { application: 0x4750_4b47, version: 10_300 };
/// Number of WGS84 in EPSG's register.
pub(super) const WGS84: u16 = 4326;
const WGS84_WKT: &str = "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563,AUTHORITY[\"EPSG\",\"7030\"]],AUTHORITY[\"EPSG\",\"6326\"]],PRIMEM[\"Greenwich\",0,AUTHORITY[\"EPSG\",\"8901\"]],UNIT[\"degree\",0.0174532925199433,AUTHORITY[\"EPSG\",\"9122\"]],AUTHORITY[\"EPSG\",\"4326\"]]";

const SYSTEMS_SQL: &str = "CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT)";
const CONTENTS_SQL: &str = "CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '', last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')), min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER, CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id))";
const COLUMNS_SQL: &str = "CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL, CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name), CONSTRAINT uk_gc_table_name UNIQUE (table_name), CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name), CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id))";
const EXTENSIONS_SQL: &str = "CREATE TABLE gpkg_extensions (table_name TEXT, column_name TEXT, extension_name TEXT NOT NULL, definition TEXT NOT NULL, scope TEXT NOT NULL, CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name))";
/// Name of the table in which QGIS stores styles.
const STYLES: &str = "layer_styles";
const STYLES_SQL: &str = "CREATE TABLE layer_styles (id INTEGER PRIMARY KEY NOT NULL, f_table_catalog TEXT(256), f_table_schema TEXT(256), f_table_name TEXT(256), f_geometry_column TEXT(256), styleName TEXT(30), styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN, description TEXT, owner TEXT(30), ui TEXT(30), update_time DATETIME DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')))";
/// Kinds of geometry in well-known binary.
const POINT: u32 = 1;
const LINE: u32 = 2;
const POLYGON: u32 = 3;
const POLYGONS: u32 = 6;

/// Corners of a closed ring: the last corner equals the first.
pub(crate) type Ring = Vec<[f64; 2]>;

/// Geometry of a feature, in the system of its file: east or longitude first.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FeatureGeometry {
    /// A place.
    Point([f64; 2]),
    /// A line.
    Line(Vec<[f64; 2]>),
    /// An outline and its holes.
    Polygon(Vec<Ring>),
    /// Several polygons, each an outline and its holes.
    Polygons(Vec<Vec<Ring>>),
}

impl FeatureGeometry {
    /// Returns the least x and y and the greatest x and y; NaN without any place.
    fn bounds(&self) -> [f64; 4] {
        match self {
            FeatureGeometry::Point(place) => bounds_of([place]),
            FeatureGeometry::Line(line) => bounds_of(line),
            FeatureGeometry::Polygon(rings) => bounds_of(rings.iter().flatten()),
            FeatureGeometry::Polygons(polygons) => bounds_of(polygons.iter().flatten().flatten()),
        }
    }

    /// Returns the bytes of the geometry in the system of an EPSG number.
    fn bytes(&self, system: i32) -> Vec<u8> {
        let is_point = matches!(self, FeatureGeometry::Point(_));
        // Lowest byte first; with an envelope of two dimensions unless the geometry is a point.
        let flags = if is_point { 0b001 } else { 0b011 };
        let mut bytes = vec![b'G', b'P', 0, flags];
        bytes.extend(system.to_le_bytes());
        if !is_point {
            let [west, south, east, north] = self.bounds();
            for end in [west, east, south, north] {
                bytes.extend(end.to_le_bytes());
            }
        }
        match self {
            FeatureGeometry::Point(place) => {
                begin(&mut bytes, POINT);
                put_places(&mut bytes, &[*place]);
            }
            FeatureGeometry::Line(line) => {
                begin(&mut bytes, LINE);
                put_line(&mut bytes, line);
            }
            FeatureGeometry::Polygon(rings) => put_polygon(&mut bytes, rings),
            FeatureGeometry::Polygons(polygons) => {
                begin(&mut bytes, POLYGONS);
                put_count(&mut bytes, polygons.len());
                for rings in polygons {
                    put_polygon(&mut bytes, rings);
                }
            }
        }
        bytes
    }
}

fn bounds_of<'a>(places: impl IntoIterator<Item = &'a [f64; 2]>) -> [f64; 4] {
    let boxes = places.into_iter().map(|&[x, y]| [x, y, x, y]);
    boxes.fold([f64::NAN; 4], box_around)
}

/// A layer: a table of features of one kind of geometry.
pub(crate) struct Layer {
    /// Name of the layer in the file.
    pub name: &'static str,
    /// Title of the layer in a map program.
    pub title: &'static str,
    /// Description of the content, in a few words.
    pub about: &'static str,
    /// Kind of all geometries of the layer: `POINT`, `LINESTRING`, `POLYGON` or `MULTIPOLYGON`.
    pub geometry: &'static str,
    /// Columns after the geometry, as SQL declares them: `depth_m DOUBLE, label TEXT`.
    pub columns: Cow<'static, str>,
    /// Features, each a geometry and a value for each column.
    pub features: Vec<(FeatureGeometry, Vec<Value>)>,
    /// Style in which QGIS draws the layer (QML).
    pub style: String,
}

impl Layer {
    /// Returns the box around the features; NaN without any.
    fn bounds(&self) -> [f64; 4] {
        let features = self.features.iter();
        features.fold([f64::NAN; 4], |bounds, (geometry, _)| box_around(bounds, geometry.bounds()))
    }
}

/// Writes layers in a coordinate system. The recorded time of the last change is that of the first
/// recording (Unix seconds), so that the same survey gives the same bytes. Returns the number and
/// the extent of the features.
pub(crate) fn geopackage(
    path: &Path,
    crs: &Crs,
    changed_unix_s: f64,
    layers: &[Layer],
) -> Result<Summary, ExportError> {
    let changed = calendar::moment(changed_unix_s);
    let changed = changed.format("%Y-%m-%dT%H:%M:%S%.3fZ").to_string();
    database(path, KIND, |file| {
        add_register(file, layers, crs, &changed)?;
        let mut summary = Summary::default();
        for layer in layers {
            add_layer(file, layer, crs)?;
            summary.count += layer.features.len();
            let [west, south, east, north] = layer.bounds();
            summary.reach([west, south]);
            summary.reach([east, north]);
        }
        run(file, STYLES_SQL)?;
        let styles = layers.iter().map(|layer| Ok(style(layer, &changed)));
        insert(file, STYLES, styles)?;
        Ok(summary)
    })
}

/// Adds the tables that every GeoPackage has.
fn add_register(file: &Connection, layers: &[Layer], crs: &Crs, changed: &str) -> io::Result<()> {
    for sql in [SYSTEMS_SQL, CONTENTS_SQL, COLUMNS_SQL, EXTENSIONS_SQL] {
        run(file, sql)?;
    }
    insert(file, "gpkg_spatial_ref_sys", systems(crs).into_iter().map(Ok))?;
    let contents = layers.iter().map(|layer| contents(layer, crs, changed));
    let contents = contents.chain([styles_contents(changed)]);
    insert(file, "gpkg_contents", contents.map(Ok))?;
    let columns = layers.iter().map(|layer| {
        let named = [layer.name, "geom", layer.geometry].map(text);
        let numbers = [crs.epsg().into(), 0, 0].map(Value::Integer);
        Ok(named.into_iter().chain(numbers).collect())
    });
    insert(file, "gpkg_geometry_columns", columns)?;
    let extensions = layers.iter().map(|layer| Ok(index_extension(layer)));
    insert(file, "gpkg_extensions", extensions)
}

/// Adds a layer with its features and their index.
fn add_layer(file: &Connection, layer: &Layer, crs: &Crs) -> io::Result<()> {
    let sql = format!(
        "CREATE TABLE {} (fid INTEGER PRIMARY KEY NOT NULL, geom {}, {})",
        layer.name, layer.geometry, layer.columns
    );
    run(file, &sql)?;
    let rows = (1..).zip(&layer.features).map(|(fid, (geometry, values))| {
        let geometry = Value::Blob(geometry.bytes(crs.epsg().into()));
        let first = [Value::Integer(fid), geometry].into_iter();
        Ok(first.chain(values.iter().cloned()).collect())
    });
    insert(file, layer.name, rows)?;
    add_index(file, layer)
}

/// Returns the rows of the systems that every GeoPackage names, and of the system of the layers.
fn systems(crs: &Crs) -> Vec<Vec<Value>> {
    let system = |name: &str, id: i64, by: &str, definition: &str| {
        vec![
            text(name),
            Value::Integer(id),
            text(by),
            Value::Integer(id),
            text(definition),
            Value::Null,
        ]
    };
    let mut rows = vec![
        system("Undefined Cartesian SRS", -1, "NONE", "undefined"),
        system("Undefined geographic SRS", 0, "NONE", "undefined"),
        system("WGS 84 geodetic", WGS84.into(), "EPSG", WGS84_WKT),
    ];
    if crs.epsg() != WGS84 {
        rows.push(system(crs.name(), crs.epsg().into(), "EPSG", crs.wkt()));
    }
    rows
}

/// Returns the row of a layer in the table of contents, with its extent.
fn contents(layer: &Layer, crs: &Crs, changed: &str) -> Vec<Value> {
    let named = [layer.name, "features", layer.title, layer.about, changed].map(text);
    // Without features the bounds are NaN, which is stored as NULL.
    let bounds = layer.bounds().map(Value::Real);
    let system = Value::Integer(crs.epsg().into());
    named.into_iter().chain(bounds).chain([system]).collect()
}

fn styles_contents(changed: &str) -> Vec<Value> {
    let named = [STYLES, "attributes", STYLES, "Styles for QGIS", changed].map(text);
    let nothing = [Value::Null, Value::Null, Value::Null, Value::Null, Value::Null];
    named.into_iter().chain(nothing).collect()
}

/// Returns the row of a layer in the table of styles: catalogue and schema, which QGIS expects as
/// empty texts, table, column, name, style, and a flag for QGIS to use the style as the default.
fn style(layer: &Layer, changed: &str) -> Vec<Value> {
    let place = ["", "", layer.name, "geom", layer.name].map(text);
    let rest = [
        text(&layer.style),
        Value::Null,
        Value::Integer(1),
        text(layer.about),
        Value::Null,
        Value::Null,
        text(changed),
    ];
    // The first column is the number of the row.
    let first = [Value::Null].into_iter();
    first.chain(place).chain(rest).collect()
}

fn begin(bytes: &mut Vec<u8>, kind: u32) {
    bytes.push(1);
    bytes.extend(kind.to_le_bytes());
}

fn put_count(bytes: &mut Vec<u8>, count: usize) {
    bytes.extend((count as u32).to_le_bytes());
}

fn put_polygon(bytes: &mut Vec<u8>, rings: &[Ring]) {
    begin(bytes, POLYGON);
    put_count(bytes, rings.len());
    rings.iter().for_each(|ring| put_line(bytes, ring));
}

fn put_line(bytes: &mut Vec<u8>, line: &[[f64; 2]]) {
    put_count(bytes, line.len());
    put_places(bytes, line);
}

fn put_places(bytes: &mut Vec<u8>, places: &[[f64; 2]]) {
    for number in places.iter().flatten() {
        bytes.extend(number.to_le_bytes());
    }
}

/// Adds the index over the features of a layer, and the triggers that keep the index up to date
/// when a program changes features.
///
/// # Errors
/// When SQLite refuses a statement.
fn add_index(file: &Connection, layer: &Layer) -> io::Result<()> {
    let index = format!("rtree_{}_geom", layer.name);
    let create = "USING rtree(id, minx, maxx, miny, maxy)";
    run(file, &format!("CREATE VIRTUAL TABLE \"{index}\" {create}"))?;
    let boxes = (1..).zip(&layer.features).filter_map(|(fid, (geometry, _))| {
        let [west, south, east, north] = geometry.bounds();
        let ends = [west, east, south, north];
        // A feature without a place has no entry in the index.
        let is_placed = ends.iter().all(|end| end.is_finite());
        let ends = ends.map(Value::Real).into_iter();
        is_placed.then(|| Ok([Value::Integer(fid)].into_iter().chain(ends).collect()))
    });
    insert(file, &index, boxes)?;
    for (event, what) in triggers(&index, layer.name) {
        run(file, &format!("CREATE TRIGGER \"{index}_{event}\" {what}"))?;
    }
    Ok(())
}

/// Returns the triggers that keep the index up to date, by the names and conditions of the standard
/// (OGC 12-128r17, annex F.3).
fn triggers(index: &str, table: &str) -> [(&'static str, String); 6] {
    let is_some = "(NEW.geom NOTNULL AND NOT ST_IsEmpty(NEW.geom))";
    let is_none = "(NEW.geom ISNULL OR ST_IsEmpty(NEW.geom))";
    let insert = format!(
        "INSERT OR REPLACE INTO {index} VALUES (NEW.fid, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));"
    );
    let delete = format!("DELETE FROM {index} WHERE id = OLD.fid;");
    let delete_both = format!("DELETE FROM {index} WHERE id IN (OLD.fid, NEW.fid);");
    let of_geometry = format!("AFTER UPDATE OF geom ON {table} WHEN OLD.fid = NEW.fid AND");
    let of_number = format!("AFTER UPDATE ON {table} WHEN OLD.fid != NEW.fid AND");
    [
        ("insert", format!("AFTER INSERT ON {table} WHEN {is_some} BEGIN {insert} END")),
        ("update1", format!("{of_geometry} {is_some} BEGIN {insert} END")),
        ("update2", format!("{of_geometry} {is_none} BEGIN {delete} END")),
        ("update3", format!("{of_number} {is_some} BEGIN {delete} {insert} END")),
        ("update4", format!("{of_number} {is_none} BEGIN {delete_both} END")),
        ("delete", format!("AFTER DELETE ON {table} WHEN OLD.geom NOT NULL BEGIN {delete} END")),
    ]
}

/// Returns the row of the index in the table of extensions.
fn index_extension(layer: &Layer) -> Vec<Value> {
    let texts = [
        layer.name,
        "geom",
        "gpkg_rtree_index",
        "http://www.geopackage.org/spec120/#extension_rtree",
        "write-only",
    ];
    texts.map(text).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::LonLat;

    #[test]
    fn a_package_has_its_layers_with_index_and_style_and_is_the_same_again() {
        let folder = tempfile::tempdir().unwrap();
        let layer = |name, places: &[[f64; 2]]| Layer {
            name,
            title: name,
            about: "",
            geometry: "POINT",
            columns: "label TEXT".into(),
            features: (places.iter())
                .map(|place| (FeatureGeometry::Point(*place), vec![text("2 & 3")]))
                .collect(),
            style: format!("<qgis>{name}</qgis>"),
        };
        let layers = [layer("spots", &[[4e5, 3e6], [4.1e5, 3.2e6]]), layer("none", &[])];
        let crs = Crs::utm(LonLat { lon_deg: -82.0, lat_deg: 29.0 });
        let written = ["one.gpkg", "two.gpkg"].map(|name| {
            let path = folder.path().join(name);
            let summary = geopackage(&path, &crs, 1.5e9, &layers).unwrap();
            assert_eq!(summary.count, 2);
            assert_eq!(summary.extent, Some([[4e5, 4.1e5], [3e6, 3.2e6]]));
            std::fs::read(path).unwrap()
        });
        assert_eq!(written[0], written[1]);
        let holds = |text: &str| written[0].windows(text.len()).any(|part| part == text.as_bytes());
        assert!(holds("SQLite format 3") && holds("CREATE TABLE spots (fid INTEGER PRIMARY KEY"));
        assert!(holds("CREATE VIRTUAL TABLE \"rtree_none_geom\"") && holds("<qgis>spots</qgis>"));
        assert!(holds("WGS 84 / UTM zone 17N") && holds("2017-07-14T02:40:00.000Z"));
    }

    #[test]
    fn a_shape_is_well_known_binary_behind_a_header() {
        let point = FeatureGeometry::Point([1.5, -2.0]).bytes(4326);
        assert_eq!(point[..8], [b'G', b'P', 0, 1, 0xe6, 0x10, 0, 0]);
        assert_eq!(point[8..13], [1, 1, 0, 0, 0]);
        assert_eq!(point[13..21], 1.5_f64.to_le_bytes());
        assert_eq!(point.len(), 29);
        let ring = vec![[0.0, 0.0], [2.0, 0.0], [1.0, 3.0], [0.0, 0.0]];
        let polygon = FeatureGeometry::Polygon(vec![ring.clone()]).bytes(4326);
        assert_eq!(polygon[3], 3);
        // West, east, south, north.
        assert_eq!(polygon[16..24], 2.0_f64.to_le_bytes());
        assert_eq!(polygon[32..40], 3.0_f64.to_le_bytes());
        assert_eq!(polygon[40..49], [1, 3, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(polygon.len(), 8 + 32 + 5 + 8 + 4 * 16);
        let line = FeatureGeometry::Line(ring.clone()).bytes(4326);
        assert_eq!(line[40..49], [1, 2, 0, 0, 0, 4, 0, 0, 0]);
        let several = FeatureGeometry::Polygons(vec![vec![ring.clone()], vec![ring]]).bytes(4326);
        assert_eq!(several[40..49], [1, 6, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(several[49..], [&polygon[40..], &polygon[40..]].concat());
    }

    #[test]
    fn nothing_has_no_bounds() {
        assert!(FeatureGeometry::Line(Vec::new()).bounds().iter().all(|end| end.is_nan()));
        let line = FeatureGeometry::Line(vec![[3.0, 1.0], [-2.0, 5.0]]);
        assert_eq!(line.bounds(), [-2.0, 1.0, 3.0, 5.0]);
    }
}
