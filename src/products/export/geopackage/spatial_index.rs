//! The R-tree of a layer (GeoPackage extension `gpkg_rtree_index`), so that a map program finds what lies in its window without reading all
//! features. Nodes are those of SQLite's R*Tree module (`ext/rtree/rtree.c`): the depth of the tree in the root, how many cells, and for
//! each the number of a feature or node and the box around it, all with the highest byte first.

use super::Layer;
use crate::products::export::sqlite::{SchemaEntry, Table, Value};

/// Cells of a node, and bytes of one and of what stands before them.
const CELLS: usize = 51;
const CELL: usize = 24;
const HEADER: usize = 4;

/// A number and the box around it: least and most x, least and most y.
type Cell = (i64, [f32; 4]);

/// The tables of the index, of a name that begins with that of the index.
pub fn tables(layer: &Layer) -> Vec<Table> {
    let levels = levels(cells(layer));
    let starts = starts(&levels);
    let (mut nodes, mut parents, mut features) = (Vec::new(), Vec::new(), Vec::new());
    for (level, of_level) in levels.iter().enumerate().rev() {
        for (number, cells) in (starts[level]..).zip(of_level) {
            let depth = if number == 1 { level } else { 0 };
            let numbered = |(id, bounds): &Cell| match level {
                0 => (*id, *bounds),
                _ => (starts[level - 1] + id, *bounds),
            };
            let cells: Vec<Cell> = cells.iter().map(numbered).collect();
            let below = cells
                .iter()
                .map(|(id, _)| (*id, vec![Value::Null, Value::Integer(number)]));
            match level {
                0 => features.extend(below),
                _ => parents.extend(below),
            }
            nodes.push((number, vec![Value::Null, Value::Blob(node(depth, &cells))]));
        }
    }
    for rows in [&mut nodes, &mut parents, &mut features] {
        rows.sort_by_key(|(number, _)| *number);
    }
    let index = name(layer);
    let table = |part: &str, columns: &str, rows| Table {
        name: format!("{index}_{part}"),
        sql: format!("CREATE TABLE \"{index}_{part}\"({columns})"),
        rows,
        keys: &[],
    };
    vec![
        table("rowid", "rowid INTEGER PRIMARY KEY,nodeno", features),
        table("node", "nodeno INTEGER PRIMARY KEY,data", nodes),
        table("parent", "nodeno INTEGER PRIMARY KEY,parentnode", parents),
    ]
}

/// What the schema says of the index: that it is one, and what keeps it up to date when a program changes features.
pub fn entries(layer: &Layer) -> Vec<SchemaEntry> {
    let (index, table) = (name(layer), layer.name);
    let is_some = "(NEW.geom NOTNULL AND NOT ST_IsEmpty(NEW.geom))";
    let is_none = "(NEW.geom ISNULL OR ST_IsEmpty(NEW.geom))";
    let insert = format!(
        "INSERT OR REPLACE INTO {index} VALUES (NEW.fid, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));"
    );
    let delete = format!("DELETE FROM {index} WHERE id = OLD.fid;");
    let delete_both = format!("DELETE FROM {index} WHERE id IN (OLD.fid, NEW.fid);");
    let of_geometry = format!("AFTER UPDATE OF geom ON {table} WHEN OLD.fid = NEW.fid AND");
    let of_number = format!("AFTER UPDATE ON {table} WHEN OLD.fid != NEW.fid AND");
    // The names and conditions are those of the standard (OGC 12-128r17, annex F.3).
    let triggers = [
        (
            "insert",
            format!("AFTER INSERT ON {table} WHEN {is_some} BEGIN {insert} END"),
        ),
        (
            "update1",
            format!("{of_geometry} {is_some} BEGIN {insert} END"),
        ),
        (
            "update2",
            format!("{of_geometry} {is_none} BEGIN {delete} END"),
        ),
        (
            "update3",
            format!("{of_number} {is_some} BEGIN {delete} {insert} END"),
        ),
        (
            "update4",
            format!("{of_number} {is_none} BEGIN {delete_both} END"),
        ),
        (
            "delete",
            format!("AFTER DELETE ON {table} WHEN OLD.geom NOT NULL BEGIN {delete} END"),
        ),
    ];
    let virtual_table = SchemaEntry {
        kind: "table",
        sql: format!("CREATE VIRTUAL TABLE \"{index}\" USING rtree(id, minx, maxx, miny, maxy)"),
        table: index.clone(),
        name: index.clone(),
    };
    let triggers = triggers.into_iter().map(|(event, what)| SchemaEntry {
        kind: "trigger",
        name: format!("{index}_{event}"),
        table: table.to_owned(),
        sql: format!("CREATE TRIGGER \"{index}_{event}\" {what}"),
    });
    std::iter::once(virtual_table).chain(triggers).collect()
}

/// What the table of extensions says of the index.
pub fn extension(layer: &Layer) -> Vec<Value> {
    let texts = [
        layer.name,
        "geom",
        "gpkg_rtree_index",
        "http://www.geopackage.org/spec120/#extension_rtree",
        "write-only",
    ];
    texts.map(super::text).into()
}

fn name(layer: &Layer) -> String {
    format!("rtree_{}_geom", layer.name)
}

/// The features that have a place, those beside each other near each other: by strips from west to east, and within each from south to
/// north.
fn cells(layer: &Layer) -> Vec<Cell> {
    let boxes = layer.features.iter().map(|(geometry, _)| geometry.bounds());
    let mut placed: Vec<(i64, [f64; 4])> = (1..).zip(boxes).collect();
    placed.retain(|(_, bounds)| bounds.iter().all(|end| end.is_finite()));
    let along = |axis: usize| {
        move |a: &(i64, [f64; 4]), b: &(i64, [f64; 4])| {
            (a.1[axis] + a.1[axis + 2]).total_cmp(&(b.1[axis] + b.1[axis + 2]))
        }
    };
    placed.sort_by(along(0));
    let strips = (placed.len() as f64 / CELLS as f64).sqrt().ceil().max(1.0);
    let strip = (placed.len() as f64 / strips).ceil().max(1.0) as usize;
    placed
        .chunks_mut(strip)
        .for_each(|strip| strip.sort_by(along(1)));
    let rounded = placed.into_iter().map(|(id, [west, south, east, north])| {
        let bounds = [below(west), above(east), below(south), above(north)];
        (id, bounds)
    });
    rounded.collect()
}

/// Nodes of leaves, of what leads to them, and so on up to the root alone; above the leaves cells name nodes of the level below, from 0.
fn levels(cells: Vec<Cell>) -> Vec<Vec<Vec<Cell>>> {
    let mut levels = vec![grouped(cells)];
    while let Some(last) = levels.last().filter(|last| last.len() > 1) {
        let around = last.iter().map(|cells| {
            let boxes = cells.iter().map(|(_, bounds)| *bounds);
            boxes.reduce(|a, b| {
                [
                    a[0].min(b[0]),
                    a[1].max(b[1]),
                    a[2].min(b[2]),
                    a[3].max(b[3]),
                ]
            })
        });
        let cells = (0..).zip(around.map(Option::unwrap_or_default)).collect();
        levels.push(grouped(cells));
    }
    levels
}

/// Cells in nodes, as even as can be; there is one node at least.
fn grouped(cells: Vec<Cell>) -> Vec<Vec<Cell>> {
    let count = cells.len().div_ceil(CELLS).max(1);
    let each = cells.len().div_ceil(count).max(1);
    match cells.is_empty() {
        true => vec![Vec::new()],
        false => cells.chunks(each).map(<[Cell]>::to_vec).collect(),
    }
}

/// The number of the first node of each level: the root is 1, and each level follows the one above it.
fn starts(levels: &[Vec<Vec<Cell>>]) -> Vec<i64> {
    let mut next = 1;
    let mut starts: Vec<i64> = (levels.iter().rev())
        .map(|level| {
            let start = next;
            next += level.len() as i64;
            start
        })
        .collect();
    starts.reverse();
    starts
}

fn node(depth: usize, cells: &[Cell]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + CELLS * CELL);
    for number in [depth, cells.len()] {
        bytes.extend((number as u16).to_be_bytes());
    }
    for (id, bounds) in cells {
        bytes.extend(id.to_be_bytes());
        bounds
            .iter()
            .for_each(|end| bytes.extend(end.to_be_bytes()));
    }
    bytes.resize(HEADER + CELLS * CELL, 0);
    bytes
}

/// The nearest single-precision number that is not above a value, and that is not below it.
fn below(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) > value {
        near.next_down()
    } else {
        near
    }
}

fn above(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) < value {
        near.next_up()
    } else {
        near
    }
}

#[cfg(test)]
mod tests {
    use super::super::Geometry;
    use super::*;

    fn layer(count: usize) -> Layer {
        let at = |index: usize| {
            let share = |step: f64| (0.5 + step * index as f64).fract() * 1e3;
            Geometry::Point([share(0.754_877_666) + 4e5, share(0.569_840_291) + 4e6])
        };
        Layer {
            name: "spots",
            title: "",
            about: "",
            geometry: "POINT",
            columns: "",
            features: (0..count).map(|index| (at(index), Vec::new())).collect(),
            style: String::new(),
        }
    }

    #[test]
    fn every_feature_is_in_a_leaf_and_every_box_holds_what_is_below_it() {
        for count in [0, 1, 51, 52, 3000] {
            let layer = layer(count);
            let levels = levels(cells(&layer));
            let leaves = levels[0].iter().flatten();
            let mut ids: Vec<i64> = leaves.map(|(id, _)| *id).collect();
            ids.sort_unstable();
            assert_eq!(ids, (1..=count as i64).collect::<Vec<_>>());
            assert_eq!(levels.last().map(Vec::len), Some(1));
            for pair in levels.windows(2) {
                for (id, bounds) in pair[1].iter().flatten() {
                    for (_, inner) in &pair[0][*id as usize] {
                        assert!(bounds[0] <= inner[0] && inner[1] <= bounds[1]);
                        assert!(bounds[2] <= inner[2] && inner[3] <= bounds[3]);
                    }
                }
            }
            let [features, nodes, parents] = tables(&layer).try_into().ok().expect("three");
            let all: usize = levels.iter().map(Vec::len).sum();
            assert_eq!([features.rows.len(), nodes.rows.len()], [count, all]);
            assert_eq!(parents.rows.len(), all - 1);
        }
    }

    #[test]
    fn boxes_are_rounded_outwards() {
        assert!(f64::from(below(4_000_000.123)) <= 4_000_000.123);
        assert!(f64::from(above(4_000_000.123)) >= 4_000_000.123);
        assert_eq!([below(2.5), above(2.5)], [2.5; 2]);
    }
}
