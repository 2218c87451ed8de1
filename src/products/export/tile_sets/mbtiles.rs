//! MBTiles 1.3: a database of SQLite with a row for each tile, rows of tiles counted from the south
//! (<https://github.com/mapbox/mbtiles-spec/blob/master/1.3/spec.md>).

use super::{TileSet, TileStore};
use crate::export::ExportError;
use crate::export::sqlite::{DatabaseKind, Value, database, insert, run, text};
use crate::map_tiles::{TileStyle, WebTile};
use std::path::Path;

/// `MPBX`.
const KIND: DatabaseKind = DatabaseKind { application: 0x4d50_4258, version: 0 };
const METADATA_SQL: &str = "CREATE TABLE metadata (name TEXT NOT NULL PRIMARY KEY, value TEXT)";
const TILES_SQL: &str = "CREATE TABLE tiles (zoom_level INTEGER NOT NULL, tile_column INTEGER NOT NULL, tile_row INTEGER NOT NULL, tile_data BLOB NOT NULL, PRIMARY KEY (zoom_level, tile_column, tile_row))";

/// Writes the pictures of one kind.
pub(crate) fn mbtiles(
    path: &Path,
    store: &TileStore,
    picture: TileStyle,
    set: &TileSet,
) -> Result<(), ExportError> {
    database(path, KIND, |file| {
        run(file, METADATA_SQL)?;
        let metadata = metadata(set).into_iter();
        let rows = metadata.map(|(name, value)| Ok(vec![text(name), Value::Text(value)]));
        insert(file, "metadata", rows)?;
        run(file, TILES_SQL)?;
        let rows = store.tiles(picture).into_iter().map(|(_, stored)| {
            let WebTile { zoom, x, y } = stored.tile;
            let from_south = (1_i64 << zoom) - 1 - i64::from(y);
            let mut row = [i64::from(zoom), i64::from(x), from_south].map(Value::Integer).to_vec();
            row.push(Value::Blob(store.read(stored)?));
            Ok(row)
        });
        insert(file, "tiles", rows)
    })
}

fn metadata(set: &TileSet) -> Vec<(&'static str, String)> {
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
