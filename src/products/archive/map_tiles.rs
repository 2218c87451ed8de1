//! Joins the maps of all tiles of an archive into one web map: `map_tiles/depth.mbtiles`,
//! `depth.pmtiles`, `depth_values.pmtiles`, `index.html` and, last, `map_tiles.json`, the record of
//! their inputs. Parts of the map over unchanged tiles are not drawn again.

use super::map_parts::{DrawnWith, MapParts, remove_parts};
use super::record::Archive;
use super::tile::{TileId, beside, zone_bounds_deg};
use super::tile_content::TileContents;
use super::tile_files::{DEPTH, DEPTH_FILES, TileRecord};
use super::tile_map::{isobath_settings, without_error};
use super::{LONGEST_RECORD, fingerprint, remove};
use crate::export::tile_sets::{PMTILES, TileSet, TileStore, map_page, mbtiles, pmtiles};
use crate::export::{make_folder, write_json};
use crate::map_tiles::{
    LitSurface, MapPart, MapScales, PixelPlaces, Pixels, PyramidSource, TileStyle, WebTile,
    ZoomRange,
};
use crate::pipeline::Fingerprint;
use crate::{Error, PROGRAM};
use bathyscope_bottom::bathymetry::isobaths::{Isobath, IsobathSettings};
use bathyscope_bottom::bathymetry::{Grid, Light, Surface, hill_shade};
use bathyscope_bottom::presentation::ticks::round_up;
use bathyscope_log::support::geo::{LonLat, UtmZone, boxes_meet};
use bathyscope_log::support::outline;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::regular_file;
use bathyscope_log::support::statistics::ends;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// The folder of the files.
const FOLDER: &str = "map_tiles";
const RECORD: &str = "map_tiles.json";
const CHART: &str = "depth.mbtiles";
const PAGE: &str = "index.html";
/// The folder of the stored parts of the map.
const PARTS: &str = "map_parts";
/// All files, the record of the others first.
const FILES: [&str; 5] = [RECORD, CHART, PMTILES[0], PMTILES[1], PAGE];
/// Greatest number of tiles that the light is chosen from, evenly spread over the archive.
const LIT_BY: usize = 16;
/// Number of cells around a web tile that its hill-shade depends on. The box of the cells with a
/// depth is enlarged by it too, because a pixel beside these cells may show a depth.
const MARGIN_CELLS: f64 = 2.0;
/// Number by which the range of depths is divided for the step of the colour scale; the step is
/// rounded up to a round number. The ends of the scale are multiples of the step, so that a new log
/// that is a little shallower or deeper than all others leaves the colours of the map unchanged.
const SCALE_STEPS: f64 = 10.0;
/// Name of the map, the same for every folder.
const NAME: &str = "Depth map of an archive";

/// Result of [`write_map_tiles`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapTilesState {
    /// The web map is up to date with the maps of the archive's tiles.
    UpToDate,
    /// The web map was made.
    Made,
    /// No tile of the archive has a map.
    None,
}

/// Record of the web tiles: their inputs and their files.
#[derive(PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    made: MadeFrom,
    files: Vec<Fingerprint>,
}

#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MadeFrom {
    program: String,
    /// Files of the maps of the archive's tiles, by the name of the tile.
    tiles: BTreeMap<String, Vec<Fingerprint>>,
}

/// Joins the maps of tiles into one web map, if any of them has changed.
///
/// # Errors
/// When a map cannot be read, a file cannot be written, or the work was cancelled.
pub fn write_map_tiles(
    archive: &Archive,
    tiles: &[TileId],
    progress: &Progress,
) -> Result<MapTilesState, Error> {
    let folder = archive.folder().join(FOLDER);
    let maps = tiles.iter().filter_map(|tile| {
        let record = TileRecord::read(archive, *tile)?;
        record.has(DEPTH).then_some((*tile, record))
    });
    let maps: BTreeMap<TileId, TileRecord> = maps.collect();
    if maps.is_empty() {
        FILES.iter().try_for_each(|name| remove(&folder.join(name)))?;
        remove_parts(&archive.folder().join(PARTS), |_| true)?;
        return Ok(MapTilesState::None);
    }
    let made = MadeFrom {
        program: PROGRAM.to_owned(),
        tiles: (maps.iter())
            .map(|(tile, record)| (tile.to_string(), depth_files(record)))
            .collect(),
    };
    if is_up_to_date(&folder, &made) {
        return Ok(MapTilesState::UpToDate);
    }
    make_folder(&folder)?;
    // From here on the files may be a mixture of two maps.
    remove(&folder.join(RECORD))?;
    write_files(archive, &maps, &folder, progress)?;
    let files = FILES.iter().skip(1);
    let files = files.map(|name| fingerprint(&folder, name, progress));
    let files = files.collect::<Result<_, Error>>()?;
    write_json(&folder.join(RECORD), &Record { made, files })?;
    Ok(MapTilesState::Made)
}

/// Returns the files of a tile that the web map depends on.
fn depth_files(record: &TileRecord) -> Vec<Fingerprint> {
    let mut files = record.files.clone();
    files.retain(|file| DEPTH_FILES.contains(&file.file.as_str()));
    files
}

fn is_up_to_date(folder: &Path, made: &MadeFrom) -> bool {
    let text = regular_file::read_text(&folder.join(RECORD), LONGEST_RECORD);
    let record = text.ok().and_then(|text| serde_json::from_str::<Record>(&text).ok());
    record.is_some_and(|record| {
        let is_there = |file: &Fingerprint| file.is_as_long_in(folder);
        record.made == *made && record.files.iter().all(is_there)
    })
}

fn write_files(
    archive: &Archive,
    maps: &BTreeMap<TileId, TileRecord>,
    folder: &Path,
    progress: &Progress,
) -> Result<(), Error> {
    let source = ArchiveTiles::new(archive, maps)?;
    let store = TileStore::draw(folder, &source, progress)?;
    let set = TileSet {
        name: NAME.to_owned(),
        description: format!(
            "Depth in metres, of all logs of an archive. In cells of {} m, none farther than {} m from a depth.",
            archive.record.cell_m,
            archive.record.settings()?.surface.max_gap_m
        ),
        scales: source.scales,
        store,
    };
    mbtiles(&folder.join(CHART), &set, TileStyle::Chart)?;
    for (name, picture) in PMTILES.iter().zip([TileStyle::Colours, TileStyle::Elevations]) {
        pmtiles(&folder.join(name), &set, picture)?;
    }
    map_page(&folder.join(PAGE), &set)?;
    source.parts.remove_others()
}

/// The maps of all tiles of an archive.
struct ArchiveTiles {
    contents: TileContents,
    /// West, south, east and north edge, degrees, of the depths of each tile that has a map.
    tiles: BTreeMap<TileId, [f64; 4]>,
    cell_m: f64,
    scales: MapScales,
    light: Light,
    parts: MapParts,
}

impl ArchiveTiles {
    fn new(archive: &Archive, maps: &BTreeMap<TileId, TileRecord>) -> Result<Self, Error> {
        let cell_m = archive.record.cell_m;
        let boxes = || {
            let maps = maps.iter();
            maps.map(|(tile, map)| {
                (*tile, beside(map.depth_bounds_m(*tile), MARGIN_CELLS * cell_m))
            })
        };
        let tiles = boxes().map(|(tile, bounds_m)| {
            let own = std::iter::once((tile.zone, bounds_m));
            (tile, zone_bounds_deg(own))
        });
        let tiles: BTreeMap<TileId, [f64; 4]> = tiles.collect();
        let all: Vec<TileId> = maps.keys().copied().collect();
        let of_map = zone_bounds_deg(boxes().map(|(tile, bounds_m)| (tile.zone, bounds_m)));
        let zooms = ZoomRange::of_map(of_map, cell_m);
        let range_m = ends(maps.values().flat_map(|record| record.depth_m.iter().copied()));
        let settings: IsobathSettings = isobath_settings(&archive.record.settings()?.isobaths);
        let contents = TileContents::new(archive, zooms.finest);
        let light = light(&contents, &all)?;
        let scales = MapScales {
            zooms,
            range_m: colour_range_m(range_m),
            // Too many isobaths are reported as a warning for the tiles; the web map is drawn
            // without isobaths.
            levels_m: settings.levels_m(without_error(range_m)).unwrap_or_default(),
            isobaths: settings,
        };
        let drawn_with = DrawnWith {
            program: PROGRAM.to_owned(),
            finest_zoom: zooms.finest,
            range_m: scales.range_m,
            exaggeration: light.exaggeration,
            interval_m: scales.interval_m().map(|interval_m| interval_m as f32),
            isobaths: scales.isobaths.clone(),
        };
        let files = maps.iter().map(|(tile, record)| (*tile, depth_files(record)));
        let parts = MapParts::new(archive.folder().join(PARTS), drawn_with, files.collect());
        Ok(Self { light, scales, contents, tiles, cell_m, parts })
    }

    /// Returns the tiles of the archive under a web tile.
    fn under(&self, tile: WebTile) -> Vec<TileId> {
        let own = tile.bounds_deg();
        let tiles = self.tiles.iter();
        let under = tiles.filter(|(_, bounds)| boxes_meet(own, **bounds));
        under.map(|(tile, _)| *tile).collect()
    }

    /// Returns the cells of a zone in and around a web tile; `None` where no tile of the archive
    /// has any.
    fn window(
        &self,
        zone: UtmZone,
        tile: WebTile,
        under: &[TileId],
    ) -> io::Result<Option<Surface>> {
        let wanted = cells_around(zone, tile, self.cell_m);
        let mut grid = None;
        for id in under.iter().filter(|id| id.zone == zone) {
            let content = self.contents.of(*id)?;
            let (grid, depth_m) =
                grid.get_or_insert_with(|| (wanted, vec![f32::NAN; wanted.len()]));
            content.copy_into(grid, depth_m);
        }
        Ok(grid.map(|(grid, depth_m)| Surface::of_depths(grid, depth_m)))
    }
}

/// Returns the ends of the colour scale for a range of depths, least and greatest: round numbers
/// beyond them.
fn colour_range_m([least_m, most_m]: [f64; 2]) -> [f32; 2] {
    let step_m = round_up((most_m - least_m) / SCALE_STEPS);
    [(least_m / step_m).floor() * step_m, (most_m / step_m).ceil() * step_m]
        .map(|depth_m| depth_m as f32)
}

/// Returns the grid of a zone's cells in a web tile and [`MARGIN_CELLS`] around it.
fn cells_around(zone: UtmZone, tile: WebTile, cell_m: f64) -> Grid {
    let [west, south, east, north] = tile.bounds_deg();
    let steps = [0.0, 0.5, 1.0];
    let places = steps.iter().flat_map(|across| steps.map(|up| [*across, up]));
    let [west_m, south_m, east_m, north_m] = outline::bounds(places.map(|[across, up]| {
        zone.to_metres(LonLat {
            lon_deg: west + across * (east - west),
            lat_deg: south + up * (north - south),
        })
    }));
    let [first, last] = [[west_m, north_m], [east_m, south_m]].map(|at| at.map(|m| m / cell_m));
    let (column, row) = ((first[0] - MARGIN_CELLS).floor(), (first[1] + MARGIN_CELLS).ceil());
    Grid {
        west_m: column * cell_m,
        north_m: row * cell_m,
        cell_m,
        columns: (last[0] + MARGIN_CELLS - column).ceil() as usize,
        rows: (row - last[1] + MARGIN_CELLS).ceil() as usize,
    }
}

/// Returns a light for the whole map: the one of median exaggeration among those suited to some
/// tiles of the archive.
fn light(contents: &TileContents, tiles: &[TileId]) -> Result<Light, Error> {
    let mut lights = Vec::new();
    for tile in tiles.iter().step_by(tiles.len().div_ceil(LIT_BY).max(1)) {
        let content = contents.of(*tile)?;
        lights.push(Light::suited(&content.surface()));
    }
    lights.sort_by(|a, b| a.exaggeration.total_cmp(&b.exaggeration));
    let middle = lights.get(lights.len() / 2);
    middle.copied().ok_or_else(|| Error::from("no tile of the archive has a map".to_owned()))
}

impl PyramidSource for ArchiveTiles {
    fn scales(&self) -> &MapScales {
        &self.scales
    }

    fn reaches(&self, tile: WebTile) -> bool {
        let own = tile.bounds_deg();
        self.tiles.values().any(|bounds| boxes_meet(own, *bounds))
    }

    fn pixels(&self, tile: WebTile) -> io::Result<Option<Pixels>> {
        let under = self.under(tile);
        let mut zones: Vec<UtmZone> = under.iter().map(|id| id.zone).collect();
        zones.dedup();
        let mut windows = Vec::with_capacity(zones.len());
        for zone in zones {
            if let Some(window) = self.window(zone, tile, &under)? {
                let shade = hill_shade(&window, &self.light, &Progress::new());
                windows.push((zone, window, shade.map_err(io::Error::other)?));
            }
        }
        let lit: Vec<(PixelPlaces, LitSurface<'_>)> = (windows.iter())
            .map(|(zone, window, shade)| {
                let places = PixelPlaces::new(tile, |at| zone.to_metres(at));
                (places, LitSurface::new(window, shade, &self.light))
            })
            .collect();
        Ok(Pixels::draw(|pixel| lit.iter().find_map(|(places, lit)| lit.at(places.of(pixel)))))
    }

    fn isobaths(&self, tile: WebTile) -> io::Result<Vec<Isobath>> {
        let mut lines = Vec::new();
        for id in self.under(tile) {
            let content = self.contents.of(id)?;
            lines.extend(tile.isobaths(content.lines.iter(), &self.scales.zooms));
        }
        Ok(lines)
    }

    fn kept(&self, tile: WebTile) -> Option<MapPart> {
        self.parts.read(tile, &self.under(tile))
    }

    fn keep(&self, tile: WebTile, part: &MapPart) -> io::Result<()> {
        self.parts.write(tile, &self.under(tile), part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_end_at_round_depths_beyond_all() {
        assert_eq!(colour_range_m([1.29, 6.05]), [1.0, 6.5]);
        assert_eq!(colour_range_m([1.41, 6.31]), [1.0, 6.5]);
        assert_eq!(colour_range_m([-0.2, 0.7]), [-0.2, 0.7]);
        assert_eq!(colour_range_m([0.0, 31.0]), [0.0, 35.0]);
        let level_m = colour_range_m([2.5, 2.5]);
        assert!((level_m[0] - 2.5).abs() < 1e-6 && (level_m[1] - 2.5).abs() < 1e-6);
    }
}
