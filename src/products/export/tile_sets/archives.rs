//! Writes tiles to MBTiles and PMTiles archives.
//!
//! MBTiles 1.3 is a database of SQLite with a row for each tile, whose rows are counted from the
//! south (<https://github.com/mapbox/mbtiles-spec/blob/master/1.3/spec.md>).
//!
//! PMTiles version 3 holds all tiles in one file that a page reads in parts
//! (<https://github.com/protomaps/PMTiles/blob/main/spec/v3/spec.md>). The crate `pmtiles` reads
//! and writes such files too, but depends on an asynchronous runtime; the file is only a header, a
//! list of numbers, and the pictures one after the other.

use super::{Stored, TileSet};
use crate::export::sqlite::{DatabaseKind, Value, database, insert, run, text};
use crate::export::{ExportError, write_atomically};
use crate::map_tiles::{TileStyle, WebTile};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::json;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// `MPBX` as a number.
const KIND: DatabaseKind = DatabaseKind { application: 0x4d50_4258, version: 0 };
const METADATA_SQL: &str = "CREATE TABLE metadata (name TEXT NOT NULL PRIMARY KEY, value TEXT)";
const TILES_SQL: &str = "CREATE TABLE tiles (zoom_level INTEGER NOT NULL, tile_column INTEGER NOT NULL, tile_row INTEGER NOT NULL, tile_data BLOB NOT NULL, PRIMARY KEY (zoom_level, tile_column, tile_row))";
/// Number of bytes of the header of PMTiles.
const HEADER: usize = 127;
/// Number of bytes that must hold the header and the first directory.
const FIRST_READ: usize = 16_384;
/// Number of tiles of a directory that the first directory refers to.
const LEAF: usize = 4096;
/// Numbers for gzip, for no compression, and for PNG.
const GZIP: u8 = 2;
const PLAIN: u8 = 1;
const PNG: u8 = 2;

/// Writes the pictures of one style to an MBTiles file.
pub(crate) fn mbtiles(path: &Path, set: &TileSet, picture: TileStyle) -> Result<(), ExportError> {
    database(path, KIND, |file| {
        run(file, METADATA_SQL)?;
        let metadata = mbtiles_metadata(set).into_iter();
        let rows = metadata.map(|(name, value)| Ok(vec![text(name), Value::Text(value)]));
        insert(file, "metadata", rows)?;
        run(file, TILES_SQL)?;
        let rows = set.store.tiles(picture).into_iter().map(|(_, stored)| {
            let WebTile { zoom, x, y } = stored.tile;
            let from_south = (1_i64 << zoom) - 1 - i64::from(y);
            let mut row = [i64::from(zoom), i64::from(x), from_south].map(Value::Integer).to_vec();
            row.push(Value::Blob(set.store.read(stored)?));
            Ok(row)
        });
        insert(file, "tiles", rows)
    })
}

fn mbtiles_metadata(set: &TileSet) -> Vec<(&'static str, String)> {
    let [west, south, east, north] = set.scales.zooms.bounds_deg;
    let [lon, lat] = set.middle_deg();
    let zoom = set.scales.zooms.coarsest;
    vec![
        ("name", set.name.clone()),
        ("format", "png".to_owned()),
        ("bounds", format!("{west:.7},{south:.7},{east:.7},{north:.7}")),
        ("center", format!("{lon:.7},{lat:.7},{zoom}")),
        ("minzoom", zoom.to_string()),
        ("maxzoom", set.scales.zooms.finest.to_string()),
        ("attribution", TileSet::ATTRIBUTION.to_owned()),
        ("description", set.description.clone()),
        ("type", "overlay".to_owned()),
        ("version", "1".to_owned()),
    ]
}

/// Writes the pictures of one style to a PMTiles file, in the order of Hilbert's curve.
pub(crate) fn pmtiles(path: &Path, set: &TileSet, picture: TileStyle) -> Result<(), ExportError> {
    write_atomically(path, |file| {
        let tiles = set.store.tiles(picture);
        let [root, leaves] = directories(&tiles)?;
        let metadata = gzip(&pmtiles_metadata(picture, set))?;
        let mut out = BufWriter::new(file);
        out.write_all(&header(set, &tiles, [&root, &metadata, &leaves]))?;
        for part in [root, metadata, leaves] {
            out.write_all(&part)?;
        }
        for (_, stored) in tiles {
            out.write_all(&set.store.read(stored)?)?;
        }
        out.flush()
    })
}

/// An entry of a directory: the number of a tile, and the place and length of its bytes; or the
/// same of a directory, for which the run is 0.
struct DirectoryEntry {
    id: u64,
    run: u64,
    at: u64,
    length: u64,
}

/// Returns the first directory, and the directories that it refers to, one after the other; the
/// latter are empty where the first directory holds all tiles.
fn directories(tiles: &[(u64, Stored)]) -> io::Result<[Vec<u8>; 2]> {
    let mut at = 0;
    let entries = tiles.iter().map(|(id, stored)| {
        let entry = DirectoryEntry { id: *id, run: 1, at, length: u64::from(stored.length) };
        at += entry.length;
        entry
    });
    let entries: Vec<DirectoryEntry> = entries.collect();
    let root = directory(&entries)?;
    if HEADER + root.len() <= FIRST_READ {
        return Ok([root, Vec::new()]);
    }
    let mut size = LEAF;
    loop {
        let (mut leaves, mut lead) = (Vec::new(), Vec::new());
        for part in entries.chunks(size) {
            let leaf = directory(part)?;
            lead.push(DirectoryEntry {
                id: part.first().map_or(0, |first| first.id),
                run: 0,
                at: leaves.len() as u64,
                length: leaf.len() as u64,
            });
            leaves.extend(leaf);
        }
        let root = directory(&lead)?;
        if HEADER + root.len() <= FIRST_READ {
            return Ok([root, leaves]);
        }
        size *= 2;
    }
}

fn directory(entries: &[DirectoryEntry]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    put(&mut bytes, entries.len() as u64);
    let before = std::iter::once(0).chain(entries.iter().map(|entry| entry.id));
    for (entry, before) in entries.iter().zip(before) {
        put(&mut bytes, entry.id - before);
    }
    entries.iter().for_each(|entry| put(&mut bytes, entry.run));
    entries.iter().for_each(|entry| put(&mut bytes, entry.length));
    let ends = entries.iter().map(|entry| Some(entry.at + entry.length));
    for (entry, end_before) in entries.iter().zip(std::iter::once(None).chain(ends)) {
        // 0 means that the bytes follow those of the entry before.
        put(&mut bytes, if end_before == Some(entry.at) { 0 } else { entry.at + 1 });
    }
    gzip(&bytes)
}

/// Appends a number in as few bytes as it needs, seven bits each, the lowest first.
fn put(bytes: &mut Vec<u8>, mut number: u64) {
    while number > 0x7f {
        bytes.push((number & 0x7f) as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

fn gzip(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(bytes)?;
    packed.finish()
}

fn pmtiles_metadata(picture: TileStyle, set: &TileSet) -> Vec<u8> {
    let mut metadata = json!({
        "name": set.name,
        "description": set.description,
        "attribution": TileSet::ATTRIBUTION,
        "type": "overlay",
        "version": "1",
    });
    if picture == TileStyle::Elevations {
        metadata["encoding"] = json!("terrarium");
    }
    metadata.to_string().into_bytes()
}

fn header(set: &TileSet, tiles: &[(u64, Stored)], [root, metadata, leaves]: [&[u8]; 3]) -> Vec<u8> {
    let mut header = b"PMTiles\x03".to_vec();
    let mut at = HEADER as u64;
    let content = tiles.iter().map(|(_, stored)| u64::from(stored.length)).sum();
    let parts = [root, metadata, leaves].map(|part| part.len() as u64);
    for length in parts.into_iter().chain([content]) {
        header.extend(at.to_le_bytes());
        header.extend(length.to_le_bytes());
        at += length;
    }
    // Numbers of tiles with a picture, of directory entries and of pictures.
    header.extend((tiles.len() as u64).to_le_bytes().repeat(3));
    // 1: the pictures are in the order of the directory.
    header.extend([1, GZIP, PLAIN, PNG, set.scales.zooms.coarsest, set.scales.zooms.finest]);
    let place = |degrees: f64| ((degrees * 1e7).round() as i32).to_le_bytes();
    header.extend(set.scales.zooms.bounds_deg.map(place).concat());
    header.push(set.scales.zooms.coarsest);
    header.extend(set.middle_deg().map(place).concat());
    header
}
