//! Writes and reads the files of a tile: `tiles/NAME/depth.tif`, `uncertainty.tif`, `source.tif`,
//! `isobaths.geojson`, `mosaic.tif` and, last, `tile.json`, the record of their inputs. The mosaic
//! is joined from the parts of all logs.

use super::log_mosaic::{in_words, open_part, write_levels};
use super::log_record::LogRecord;
use super::offsets::Offsets;
use super::record::{Archive, ArchiveRecord};
use super::tile::{TileId, tiles_read};
use super::tile_map::{TileInputs, TileMap};
use super::{ECHOES, LONGEST_RECORD, MOSAIC, POINTS, WEIGHTS, fingerprint, names_in, remove};
use crate::export::{
    DrawnLines, isobaths_geojson, make_folder, metres_raster, source_raster, write_json,
};
use crate::pipeline::Fingerprint;
use crate::{Error, PROGRAM};
use bathyscope_bottom::bathymetry::{Surface, SurfaceMethod, SwathDepth};
use bathyscope_bottom::mosaic::{MosaicPart, join_parts};
use bathyscope_log::formats::geotiff::{Band, CellsError, RasterSpec, RasterTiles};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::regular_file;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folder of the maps.
pub(super) const TILES: &str = "tiles";
const RECORD: &str = "tile.json";
pub(super) const DEPTH: &str = "depth.tif";
pub(super) const UNCERTAINTY: &str = "uncertainty.tif";
pub(super) const ISOBATHS: &str = "isobaths.geojson";
pub(super) const SOURCE: &str = "source.tif";
pub(super) const MOSAIC_FILE: &str = "mosaic.tif";
/// Files of a tile that the web map depends on.
pub(super) const DEPTH_FILES: [&str; 3] = [DEPTH, UNCERTAINTY, ISOBATHS];
/// All files, the record of the others first.
const FILES: [&str; 6] = [RECORD, DEPTH, UNCERTAINTY, SOURCE, ISOBATHS, MOSAIC_FILE];

/// Record of a tile's map: its inputs, contents and files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TileRecord {
    /// Inputs of the map.
    made: MadeFrom,
    /// Number of cells with a depth; without any there is no file of depths.
    pub cells: usize,
    /// Least and greatest depth, metres; empty without any.
    pub depth_m: Vec<f64>,
    /// West, south, east and north edge of the cells with a depth, metres of the zone; empty
    /// without any.
    pub bounds_m: Vec<f64>,
    /// Number of isobaths.
    pub isobaths: usize,
    /// Number of cells of the mosaic that have a level; without any there is no file of the mosaic.
    pub mosaic_cells: usize,
    /// Fingerprints of the files, in the folder of the tile.
    pub files: Vec<Fingerprint>,
}

/// Inputs of a tile's map: the same inputs give the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MadeFrom {
    program: String,
    archive: ArchiveRecord,
    logs: Vec<TileLog>,
    /// Parts of the mosaic, in the order in which they are laid over each other.
    mosaic: Vec<PartRecord>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TileLog {
    log: String,
    /// Tile and SHA-256 of every file of the log's rows.
    rows: Vec<String>,
    offset_m: f64,
    /// Correction east and north, metres, and latency, seconds.
    shift: [f64; 3],
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PartRecord {
    log: String,
    sha256: String,
    /// SHA-256 of the weights of the levels; empty where all levels have the same weight.
    weights_sha256: String,
    level_factor: f64,
}

/// State of a tile's map with respect to the rows and offsets of its logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileState {
    /// The map was made from these rows and offsets.
    UpToDate,
    /// The map was made from other inputs, or one of its files is missing or has another length.
    Stale,
    /// There is no map.
    Missing,
}

impl TileState {
    /// Returns `up to date`, `stale` or `missing`.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::UpToDate => "up to date",
            Self::Stale => "stale",
            Self::Missing => "missing",
        }
    }
}

impl MadeFrom {
    fn of(archive: &Archive, tile: TileId, logs: &[LogRecord], offsets: &Offsets) -> Self {
        let swath = archive.record.settings().unwrap_or_default().surface.swath;
        let with_rows = logs.iter().filter_map(|log| {
            let rows = hashes_read(swath, tile, log);
            (!rows.is_empty()).then(|| TileLog {
                log: log.log.clone(),
                rows,
                offset_m: offsets.of(&log.log),
                shift: offsets.shift_of(&log.log).values(),
            })
        });
        let parts = logs_in_order(tile, logs).into_iter().filter_map(|log| {
            let rows = log.rows_in(tile)?;
            Some(PartRecord {
                log: log.log.clone(),
                sha256: rows.sha256_of(MOSAIC).to_owned(),
                weights_sha256: rows.sha256_of(WEIGHTS).to_owned(),
                level_factor: offsets.level_factor(&log.log),
            })
        });
        Self {
            program: PROGRAM.to_owned(),
            archive: archive.record.clone(),
            logs: with_rows.collect(),
            mosaic: parts.collect(),
        }
    }
}

/// Returns the SHA-256 of the rows of a log that the map of a tile is made from, by tile, kind
/// after kind.
fn hashes_read(swath: SwathDepth, tile: TileId, log: &LogRecord) -> Vec<String> {
    let kinds: &[&str] = match swath {
        SwathDepth::Off | SwathDepth::Auto => &[POINTS],
        SwathDepth::Always => &[POINTS, ECHOES],
    };
    let tiles = tiles_read(swath, tile);
    let rows = tiles.iter().filter_map(|id| Some((id, log.rows_in(*id)?)));
    rows.flat_map(|(id, rows)| {
        let hashes = kinds.iter().map(|kind| rows.sha256_of(kind));
        hashes.filter(|hash| !hash.is_empty()).map(move |hash| format!("{id} {hash}"))
    })
    .collect()
}

impl TileRecord {
    /// Reads the record of a tile; `None` where the tile has no map.
    pub(crate) fn read(archive: &Archive, tile: TileId) -> Option<Self> {
        let text = regular_file::read_text(&folder_of(archive, tile).join(RECORD), LONGEST_RECORD);
        serde_json::from_str(&text.ok()?).ok()
    }

    /// Returns the west, south, east and north edge of the cells with a depth, metres of the zone;
    /// without any, the edges of the tile.
    pub(super) fn depth_bounds_m(&self, tile: TileId) -> [f64; 4] {
        <[f64; 4]>::try_from(self.bounds_m.as_slice()).unwrap_or(tile.bounds_m())
    }

    /// Returns true if the tile has a file of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.files.iter().any(|file| file.file == name)
    }
}

/// Returns the folder of the files of a tile's map.
pub(super) fn folder_of(archive: &Archive, tile: TileId) -> PathBuf {
    archive.folder().join(TILES).join(tile.to_string())
}

/// Returns the state of the map of a tile.
pub fn tile_state(
    archive: &Archive,
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
) -> TileState {
    let Some(record) = TileRecord::read(archive, tile) else {
        return TileState::Missing;
    };
    let folder = folder_of(archive, tile);
    let is_whole = record.files.iter().all(|file| file.is_as_long_in(&folder));
    if is_whole && record.made == MadeFrom::of(archive, tile, logs, offsets) {
        TileState::UpToDate
    } else {
        TileState::Stale
    }
}

/// Removes the maps of tiles in which no log has rows any more; returns these tiles.
///
/// # Errors
/// When a file cannot be removed.
pub fn remove_left_over(archive: &Archive, tiles: &[TileId]) -> Result<Vec<TileId>, Error> {
    let names = names_in(&archive.folder().join(TILES))?;
    let found = names.iter().filter_map(|name| name.parse::<TileId>().ok());
    let mut left: Vec<TileId> = found.filter(|tile| !tiles.contains(tile)).collect();
    left.sort_unstable();
    for tile in &left {
        let folder = folder_of(archive, *tile);
        for name in FILES {
            remove(&folder.join(name))?;
        }
        // Files of other programs stay, with the folder.
        fs::remove_dir(&folder).ok();
    }
    Ok(left)
}

/// Makes the map and the mosaic of a tile and writes their files, the record last.
///
/// # Errors
/// When the tile has no rows, rows cannot be read, a file cannot be written, or the work was
/// cancelled; the map of the tile is then missing or unchanged.
pub fn write_tile(
    archive: &Archive,
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<TileRecord, Error> {
    if logs.iter().all(|log| log.rows_in(tile).is_none()) {
        return Err(Error::from(format!(
            "no log of this archive has rows in tile {tile}; `bathyscope tiles` lists those that have: {}",
            archive.folder().display()
        )));
    }
    let inputs = TileInputs { archive, tile, logs, offsets, progress };
    let made = inputs.map()?;
    let folder = folder_of(archive, tile);
    make_folder(&folder)?;
    // From here on the files of the tile may be a mixture of two maps.
    remove(&folder.join(RECORD))?;
    let mut record = TileRecord {
        made: MadeFrom::of(archive, tile, logs, offsets),
        cells: 0,
        depth_m: Vec::new(),
        bounds_m: Vec::new(),
        isobaths: 0,
        mosaic_cells: write_mosaic(&inputs, &folder.join(MOSAIC_FILE))?,
        files: Vec::new(),
    };
    if let Some(made) = made {
        record.cells = made.surface.depth_m.iter().filter(|depth| !depth.is_nan()).count();
        record.depth_m = Vec::from(made.surface.range_m());
        record.bounds_m = (made.surface.known_bounds_m()).map_or_else(Vec::new, Vec::from);
        record.isobaths = made.isobaths.len();
        write_files(&inputs, &made)?;
    }
    for name in FILES.into_iter().skip(1) {
        let is_made = match name {
            MOSAIC_FILE => record.mosaic_cells > 0,
            _ => record.cells > 0,
        };
        if is_made {
            record.files.push(fingerprint(&folder, name, progress)?);
        } else {
            remove(&folder.join(name))?;
        }
    }
    write_json(&folder.join(RECORD), &record)?;
    Ok(record)
}

fn write_files(inputs: &TileInputs<'_>, made: &TileMap) -> Result<(), Error> {
    let TileInputs { archive, tile, progress, .. } = *inputs;
    let folder = folder_of(archive, tile);
    let surface = &made.surface;
    let how = how(archive, surface)?;
    let layers = [
        (DEPTH, "depth", true, "Depth in metres, positive down", &surface.depth_m),
        (
            UNCERTAINTY,
            "standard deviation of depth",
            false,
            "Standard deviation in metres of the depths that carry a cell",
            &surface.spread_m,
        ),
    ];
    let grid = &surface.grid;
    for (file, name, positive_down, what, values_m) in layers {
        let spec = RasterSpec {
            band: Some(Band { name, unit: "metre", positive_down }),
            description: format!("{what}; tile {tile} of an archive. {how}"),
            ..tile.raster(grid)
        };
        metres_raster(&folder.join(file), &spec, grid, values_m, progress)?;
    }
    let about = format!("tile {tile} of an archive. {how}");
    let over = tile.raster(grid);
    source_raster(&folder.join(SOURCE), over, surface, &about, progress)?;
    let place = |at| tile.zone.to_lon_lat(at);
    let settings = archive.record.settings()?.isobaths;
    let mut levels_m: Vec<f64> = made.isobaths.iter().map(|line| line.depth_m).collect();
    levels_m.dedup();
    let drawn = DrawnLines {
        lines: &made.isobaths,
        settings: &settings,
        index_levels_m: settings.index_levels_m(&levels_m),
    };
    isobaths_geojson(&folder.join(ISOBATHS), &drawn, place)?;
    Ok(())
}

/// Describes the interpolation of the cells, and a requested method that cannot be used.
fn how(archive: &Archive, surface: &Surface) -> Result<String, Error> {
    let settings = archive.record.settings()?.surface;
    let method = surface.method_in_words();
    let instead = match settings.method {
        SurfaceMethod::Linear => String::new(),
        other => format!(" in place of {}, which reaches beyond a tile", other.in_words()),
    };
    Ok(format!(
        "By {method}{instead} in cells of {} m, none farther than {} m from a depth.",
        surface.grid.cell_m, settings.max_gap_m
    ))
}

/// Returns the logs that have a part in the mosaic of a tile, in the order in which they are laid
/// over each other: by the time of recording, as in `bathyscope process`. Logs without a known time
/// come first; logs that began at the same time are ordered by their hashes.
fn logs_in_order(tile: TileId, logs: &[LogRecord]) -> Vec<&LogRecord> {
    let has_part = |log: &&LogRecord| log.rows_in(tile).is_some_and(|rows| rows.mosaic_cells > 0);
    let mut with_part: Vec<&LogRecord> = logs.iter().filter(has_part).collect();
    let start_s = |log: &LogRecord| log.start_unix_s.unwrap_or(f64::NEG_INFINITY);
    with_part.sort_by(|a, b| {
        let in_time = start_s(a).total_cmp(&start_s(b));
        in_time.then_with(|| a.log.cmp(&b.log))
    });
    with_part
}

/// Writes the mosaic of a tile and returns the number of cells that have a level. Writes no file if
/// there is no such cell. Memory grows neither with the cells nor with the logs.
///
/// # Errors
/// When a part cannot be read, the file cannot be written, or the work was cancelled.
fn write_mosaic(inputs: &TileInputs<'_>, path: &Path) -> Result<usize, Error> {
    let TileInputs { archive, tile, logs, offsets, progress } = *inputs;
    let overlap = archive.record.settings()?.mosaic.overlap;
    let grid = archive.record.mosaic_grid(tile)?;
    let parts = (logs_in_order(tile, logs).into_iter())
        .map(|log| {
            let open = |kind: &str| open_part(archive, kind, tile, &log.log);
            let (levels, path) = open(MOSAIC)?;
            let weights = overlap.is_weighted().then(|| open(WEIGHTS)).transpose()?;
            let weights = weights.map(|(weights, _)| weights);
            let factor = offsets.level_factor(&log.log) as f32;
            Ok(StoredPart { path, levels, weights, factor })
        })
        .collect::<Result<Vec<_>, Error>>()?;
    if let Some(other) = (parts.iter()).find(|part| part.levels.size() != [grid.columns, grid.rows])
    {
        return Err(Error::from(format!(
            "this part of the mosaic has other cells than the archive; process its log again: {}",
            other.path.display()
        )));
    }
    let places: BTreeSet<[usize; 2]> = parts.iter().flat_map(|part| part.levels.tiles()).collect();
    let places: Vec<[usize; 2]> = places.into_iter().collect();
    if places.is_empty() {
        return Ok(0);
    }
    let draw = |place: [usize; 2]| {
        let here = parts.iter().filter(|part| part.levels.may_hold(place));
        join_parts(here.map(|part| part.read(place)), overlap)
    };
    let description = format!("Side-scan mosaic of all logs in tile {tile} of an archive");
    write_levels(path, (tile, &grid), description, &places, draw, progress)
}

/// Files of the part of a log in the mosaic of a tile.
struct StoredPart {
    path: PathBuf,
    levels: RasterTiles,
    weights: Option<RasterTiles>,
    /// Factor on the levels of the log.
    factor: f32,
}

impl StoredPart {
    fn read(&self, place: [usize; 2]) -> io::Result<MosaicPart> {
        let fail = |error: CellsError| io::Error::other(in_words(&error, &self.path));
        let weights = self.weights.as_ref().map(|weights| weights.values(place));
        let part = MosaicPart {
            levels: self.levels.levels(place).map_err(fail)?,
            weights: weights.transpose().map_err(fail)?.unwrap_or_default(),
        };
        Ok(part.brightened(self.factor))
    }
}
