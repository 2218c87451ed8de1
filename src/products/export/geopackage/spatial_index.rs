//! The R-tree of a layer (GeoPackage extension `gpkg_rtree_index`), so that a map program finds
//! what lies in its window without reading all features.

use super::Layer;
use crate::export::sqlite::{Value, insert, run, text};
use rusqlite::Connection;
use std::io;

/// Adds the index over the features of a layer, and what keeps it up to date when a program changes
/// features.
///
/// # Errors
/// What SQLite says.
pub(super) fn add(file: &Connection, layer: &Layer) -> io::Result<()> {
    let index = format!("rtree_{}_geom", layer.name);
    let create = "USING rtree(id, minx, maxx, miny, maxy)";
    run(file, &format!("CREATE VIRTUAL TABLE \"{index}\" {create}"))?;
    let boxes = (1..).zip(&layer.features).filter_map(|(fid, (geometry, _))| {
        let [west, south, east, north] = geometry.bounds();
        let ends = [west, east, south, north];
        // A feature without a place is in no window.
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
pub(super) fn extension(layer: &Layer) -> Vec<Value> {
    let texts = [
        layer.name,
        "geom",
        "gpkg_rtree_index",
        "http://www.geopackage.org/spec120/#extension_rtree",
        "write-only",
    ];
    texts.map(text).into()
}
