//! Writes the index of the maps and mosaics of an archive for other programs: VRTs of all tiles of
//! a zone (GDAL, QGIS) with their colours (`.qml`), and a STAC collection with an item for each
//! tile. The index depends on the records of tiles and logs alone, so that the same maps give the
//! same index. A tile without any known time is in the VRT only.

use super::log_record::LogRecord;
use super::record::Archive;
use super::tile::{TILE_M, TileId, ring, tile_bounds_deg};
use super::tile_files::{DEPTH, ISOBATHS, MOSAIC_FILE, SOURCE, TILES, TileRecord, UNCERTAINTY};
use super::{names_in, remove};
use crate::Error;
use crate::export::{make_folder, qgis_classes, qgis_style, write_bytes, write_json};
use bathyscope_bottom::bathymetry::CellSource;
use bathyscope_bottom::presentation::colours::{depth_colour, uncertainty_colour};
use bathyscope_log::formats::geotiff::NODATA;
use bathyscope_log::support::calendar::whole_seconds;
use bathyscope_log::support::geo::UtmZone;
use bathyscope_log::support::outline;
use bathyscope_log::support::printable::xml;
use bathyscope_log::support::statistics::ends;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;

const INDEX: &str = "index";
/// Number of steps of the colours in a style.
const STYLE_STEPS: usize = 10;
/// Identifier of the collection. The old word is kept: catalogues identify the collection by it.
const COLLECTION_ID: &str = "lake";
/// Standard deviations between which uncertainty is coloured, metres, the same in all archives:
/// twice the greatest one is the half metre by which a survey of order 1a may be wrong in shallow
/// water (IHO S-44).
const UNCERTAIN_M: [f64; 2] = [0.0, 0.25];

/// Writes the index of the tiles that have a map with depths or a mosaic, in the folder `index`.
///
/// # Errors
/// When a file cannot be written.
pub fn write_index(archive: &Archive, logs: &[LogRecord], tiles: &[TileId]) -> Result<(), Error> {
    let folder = archive.folder().join(INDEX);
    make_folder(&folder)?;
    let with_map = tiles.iter().filter_map(|tile| {
        let record = TileRecord::read(archive, *tile)?;
        (!record.files.is_empty()).then_some((*tile, record))
    });
    let maps: BTreeMap<TileId, TileRecord> = with_map.collect();
    let mut by_zone: BTreeMap<UtmZone, Vec<TileId>> = BTreeMap::new();
    for tile in maps.keys() {
        by_zone.entry(tile.zone).or_default().push(*tile);
    }
    let mut names = Vec::new();
    let mosaic_m = archive.record.settings()?.mosaic.cell_m;
    let layers = [
        IndexLayer::of_metres(DEPTH, "depth", archive.record.cell_m),
        IndexLayer::of_metres(UNCERTAINTY, "uncertainty", archive.record.cell_m),
        IndexLayer::of_levels(SOURCE, "source", archive.record.cell_m),
        IndexLayer::of_levels(MOSAIC_FILE, "mosaic", mosaic_m),
    ];
    for (zone, tiles) in &by_zone {
        for layer in &layers {
            let has_layer = |tile: &&TileId| maps.get(*tile).is_some_and(|map| map.has(layer.file));
            let tiles: Vec<TileId> = tiles.iter().filter(has_layer).copied().collect();
            if tiles.is_empty() {
                continue;
            }
            let name =
                format!("{}_{}{}.vrt", layer.stem, zone.number, if zone.north { 'N' } else { 'S' });
            let text = vrt(*zone, &tiles, layer);
            let path = folder.join(&name);
            write_bytes(&path, text)?;
            names.push(name.clone());
            if write_style(&path.with_extension("qml"), layer, &maps)? {
                names.push(name.replace(".vrt", ".qml"));
            }
        }
    }
    let mut items = BTreeMap::new();
    for (tile, record) in &maps {
        if let Some(span) = span_unix_s(logs, *tile) {
            let name = format!("{tile}.json");
            write_json(&folder.join(&name), &item(*tile, record, span))?;
            names.push(name);
            items.insert(*tile, span);
        }
    }
    names.push("collection.json".to_owned());
    write_json(&folder.join("collection.json"), &collection(&items))?;
    for name in names_in(&folder)? {
        let is_of_index = [".json", ".vrt", ".qml"].iter().any(|end| name.ends_with(end));
        if is_of_index && !names.contains(&name) {
            // The file belongs to a tile or a zone that has no map any more.
            remove(&folder.join(&name))?;
        }
    }
    Ok(())
}

/// Writes the colours of a layer for QGIS; those of depths span the depths of the whole archive.
/// Returns false for a layer without colours.
fn write_style(
    path: &Path,
    layer: &IndexLayer,
    maps: &BTreeMap<TileId, TileRecord>,
) -> Result<bool, Error> {
    match layer.file {
        DEPTH => {
            let depths_m = maps.values().flat_map(|map| map.depth_m.iter().copied());
            qgis_style(path, ends(depths_m), STYLE_STEPS, depth_colour)?;
        }
        UNCERTAINTY => qgis_style(path, UNCERTAIN_M, STYLE_STEPS, uncertainty_colour)?,
        SOURCE => qgis_classes(path, &CellSource::classes())?,
        _ => return Ok(false),
    }
    Ok(true)
}

/// Returns the Unix seconds of the first and the last row of a tile; `None` where no time is known.
fn span_unix_s(logs: &[LogRecord], tile: TileId) -> Option<[f64; 2]> {
    let spans = logs
        .iter()
        .filter_map(|log| <[f64; 2]>::try_from(log.rows_in(tile)?.unix_s.as_slice()).ok());
    spans.reduce(|[a, b], [from, to]| [a.min(from), b.max(to)])
}

/// A kind of file of which each tile has at most one.
struct IndexLayer {
    file: &'static str,
    /// Name of its VRT; the zone is added to it.
    stem: &'static str,
    cell_m: f64,
    /// Data type of the cells, by its GDAL name.
    data_type: &'static str,
    nodata: f32,
}

impl IndexLayer {
    fn of_metres(file: &'static str, stem: &'static str, cell_m: f64) -> Self {
        Self { file, stem, cell_m, data_type: "Float32", nodata: NODATA }
    }

    /// Creates a layer of levels or classes, which are 0 where nothing is known.
    fn of_levels(file: &'static str, stem: &'static str, cell_m: f64) -> Self {
        Self { data_type: "Byte", nodata: 0.0, ..Self::of_metres(file, stem, cell_m) }
    }
}

fn vrt(zone: UtmZone, tiles: &[TileId], layer: &IndexLayer) -> String {
    let IndexLayer { file, cell_m, data_type, nodata, .. } = layer;
    let [west, south, east, north] =
        tiles.iter().map(TileId::bounds_m).fold(outline::NOWHERE, outline::box_around);
    let cells = |metres: f64| (metres / cell_m).round() as usize;
    let mut text = format!(
        "<VRTDataset rasterXSize=\"{}\" rasterYSize=\"{}\">\n  <SRS>{}</SRS>\n  <GeoTransform>{west}, {cell_m}, 0, {north}, 0, -{cell_m}</GeoTransform>\n  <VRTRasterBand dataType=\"{data_type}\" band=\"1\">\n    <NoDataValue>{nodata}</NoDataValue>\n",
        cells(east - west),
        cells(north - south),
        xml(&format!("EPSG:{}", zone.epsg())),
    );
    let side = cells(TILE_M);
    for tile in tiles {
        let [tile_west, _, _, tile_north] = tile.bounds_m();
        let (x, y) = (cells(tile_west - west), cells(north - tile_north));
        text += &format!(
            "    <ComplexSource>\n      <SourceFilename relativeToVRT=\"1\">../{TILES}/{tile}/{file}</SourceFilename>\n      <SourceBand>1</SourceBand>\n      <SrcRect xOff=\"0\" yOff=\"0\" xSize=\"{side}\" ySize=\"{side}\"/>\n      <DstRect xOff=\"{x}\" yOff=\"{y}\" xSize=\"{side}\" ySize=\"{side}\"/>\n      <NODATA>{nodata}</NODATA>\n    </ComplexSource>\n"
        );
    }
    text + "  </VRTRasterBand>\n</VRTDataset>\n"
}

/// Returns an item of STAC 1.1. Such an item must have a time: that of a map spans the first to the
/// last row that the map was made from.
fn item(tile: TileId, record: &TileRecord, span_unix_s: [f64; 2]) -> Value {
    let asset = |file: &str, title: &str, kind: &str| json!({ "href": format!("../{TILES}/{tile}/{file}"), "title": title, "type": kind, "roles": ["data"] });
    let raster = "image/tiff; application=geotiff; profile=cloud-optimized";
    let lines = "application/geo+json";
    let assets = [
        (DEPTH, "depth", "Depth in metres, positive down", raster),
        (UNCERTAINTY, "uncertainty", "Standard deviation of the depths in metres", raster),
        (SOURCE, "source", "The source of the depth in a cell", raster),
        (ISOBATHS, "isobaths", "Lines of equal depth", lines),
        (MOSAIC_FILE, "mosaic", "Side-scan mosaic: echo levels", raster),
    ];
    let there = assets.into_iter().filter(|asset| record.has(asset.0));
    let assets: Map<String, Value> =
        there.map(|(file, key, title, kind)| (key.to_owned(), asset(file, title, kind))).collect();
    json!({
        "type": "Feature",
        "stac_version": "1.1.0",
        "stac_extensions": ["https://stac-extensions.github.io/projection/v2.0.0/schema.json"],
        "id": tile.to_string(),
        "collection": COLLECTION_ID,
        "geometry": { "type": "Polygon", "coordinates": [ring(tile.zone, tile.bounds_m())] },
        "bbox": tile_bounds_deg(&[tile]),
        "properties": {
            "datetime": null,
            "start_datetime": whole_seconds(span_unix_s[0]),
            "end_datetime": whole_seconds(span_unix_s[1]),
            "proj:code": format!("EPSG:{}", tile.zone.epsg()),
            "proj:bbox": tile.bounds_m(),
            "depth_m": record.depth_m,
            "cells": record.cells,
        },
        "links": [{ "rel": "collection", "href": "./collection.json", "type": "application/json" }],
        "assets": assets,
    })
}

fn collection(spans_unix_s: &BTreeMap<TileId, [f64; 2]>) -> Value {
    let tiles: Vec<TileId> = spans_unix_s.keys().copied().collect();
    let span = spans_unix_s.values().copied().reduce(|[a, b], [from, to]| [a.min(from), b.max(to)]);
    let interval = span.map(|span| span.map(whole_seconds));
    let items = tiles.iter().map(|tile| {
        json!({ "rel": "item", "href": format!("./{tile}.json"), "type": "application/geo+json" })
    });
    let bounds =
        if tiles.is_empty() { [-180.0, -90.0, 180.0, 90.0] } else { tile_bounds_deg(&tiles) };
    json!({
        "type": "Collection",
        "stac_version": "1.1.0",
        "id": COLLECTION_ID,
        "description": "Depth maps and side-scan mosaics of a water by tile, from the logs of many fish-finders",
        "license": "other",
        "extent": {
            "spatial": { "bbox": [bounds] },
            "temporal": { "interval": [interval.map_or(json!([null, null]), |span| json!(span))] },
        },
        "links": items.collect::<Vec<Value>>(),
    })
}
