//! GeoPackages (version 1.3, OGC 12-128r17): layers of features in one file, each with its R-tree
//! and the style in which QGIS draws it.
//!
//! In: layers of features. Out: a GeoPackage.

mod geometry;
mod spatial_index;

pub(crate) use geometry::{FeatureGeometry, Ring};

use super::sqlite::{DatabaseKind, Value, database, insert, run, text};
use super::{ExportError, Summary};
use bathyscope_log::support::calendar;
use bathyscope_log::support::geo::Crs;
use geometry::united;
use rusqlite::Connection;
use std::borrow::Cow;
use std::io;
use std::path::Path;

/// `GPKG`, and version 1.3.0.
const KIND: DatabaseKind = DatabaseKind { application: 0x4750_4b47, version: 10_300 };
/// WGS84 in EPSG's register.
const WGS84: u16 = 4326;
const WGS84_WKT: &str = "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563,AUTHORITY[\"EPSG\",\"7030\"]],AUTHORITY[\"EPSG\",\"6326\"]],PRIMEM[\"Greenwich\",0,AUTHORITY[\"EPSG\",\"8901\"]],UNIT[\"degree\",0.0174532925199433,AUTHORITY[\"EPSG\",\"9122\"]],AUTHORITY[\"EPSG\",\"4326\"]]";

const SYSTEMS_SQL: &str = "CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT)";
const CONTENTS_SQL: &str = "CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '', last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')), min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER, CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id))";
const COLUMNS_SQL: &str = "CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL, CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name), CONSTRAINT uk_gc_table_name UNIQUE (table_name), CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name), CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id))";
const EXTENSIONS_SQL: &str = "CREATE TABLE gpkg_extensions (table_name TEXT, column_name TEXT, extension_name TEXT NOT NULL, definition TEXT NOT NULL, scope TEXT NOT NULL, CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name))";
/// The table that QGIS keeps styles in, with its names.
const STYLES: &str = "layer_styles";
const STYLES_SQL: &str = "CREATE TABLE layer_styles (id INTEGER PRIMARY KEY NOT NULL, f_table_catalog TEXT(256), f_table_schema TEXT(256), f_table_name TEXT(256), f_geometry_column TEXT(256), styleName TEXT(30), styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN, description TEXT, owner TEXT(30), ui TEXT(30), update_time DATETIME DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')))";

/// A layer: a table of features.
pub(crate) struct Layer {
    /// Its name in the file.
    pub name: &'static str,
    /// Title in a map program.
    pub title: &'static str,
    /// Description of its content, in a few words.
    pub about: &'static str,
    /// The kind of all its geometries: `POINT`, `LINESTRING`, `POLYGON` or `MULTIPOLYGON`.
    pub geometry: &'static str,
    /// Its columns behind the geometry, as SQL declares them: `depth_m DOUBLE, label TEXT`.
    pub columns: Cow<'static, str>,
    /// Its features, each with a value a column.
    pub features: Vec<(FeatureGeometry, Vec<Value>)>,
    /// Style in which QGIS draws it (QML).
    pub style: String,
}

impl Layer {
    /// The box around its features; NaN without any.
    fn bounds(&self) -> [f64; 4] {
        let features = self.features.iter();
        features.fold([f64::NAN; 4], |bounds, (geometry, _)| united(bounds, geometry.bounds()))
    }
}

/// Writes layers in a system. The time of the last change is that of the first recording (Unix
/// seconds), so that the same survey gives the same bytes. Gives back how many features there are
/// and where.
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

/// The tables that every GeoPackage has.
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
    let extensions = layers.iter().map(|layer| Ok(spatial_index::extension(layer)));
    insert(file, "gpkg_extensions", extensions)
}

/// A layer with its features, and the index over them.
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
    spatial_index::add(file, layer)
}

/// The systems that every GeoPackage names, and that of the layers.
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

/// A layer in the table of contents, with its extent.
fn contents(layer: &Layer, crs: &Crs, changed: &str) -> Vec<Value> {
    let named = [layer.name, "features", layer.title, layer.about, changed].map(text);
    // Without features the bounds are NaN, which is written as nothing.
    let bounds = layer.bounds().map(Value::Real);
    let system = Value::Integer(crs.epsg().into());
    named.into_iter().chain(bounds).chain([system]).collect()
}

fn styles_contents(changed: &str) -> Vec<Value> {
    let named = [STYLES, "attributes", STYLES, "Styles for QGIS", changed].map(text);
    let nothing = [Value::Null, Value::Null, Value::Null, Value::Null, Value::Null];
    named.into_iter().chain(nothing).collect()
}

/// The style of a layer: catalogue and schema, which QGIS looks for as empty texts, table, column,
/// name, style, whether QGIS takes it up by itself.
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
}
