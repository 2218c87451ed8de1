//! Reads and writes the settings that all logs of an archive share, `lake.json`, and finds the logs
//! of an archive and their rows tile by tile.

use super::log_record::{AREA, LogRecord};
use super::tile::{TILE_M, TileId, tiles_read};
use super::{KINDS, LOGS, LONGEST_RECORD, names_in};
use crate::Error;
use crate::export::{make_folder, write_bytes, write_json};
use crate::pipeline::{
    Fingerprint, SettingValues, Settings, deserialize_values, from_values, is_of_one_log,
    setting_values,
};
use bathyscope_bottom::bathymetry::{Grid, LOCAL_MARGIN_CELLS, SwathDepth, local_reach_m};
use bathyscope_bottom::swath::{PART_DEPTHS_M, PART_STEP_M};
use bathyscope_log::formats::read_area;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::WaterArea;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Name of the record of an archive. The old word is kept, so that existing archives can be opened,
/// also by older versions of the program.
const RECORD: &str = "lake.json";
/// Name of the copy of the area of the isobaths, without its ending.
const AREA_STEM: &str = "isobath_area";
/// Version of the layout of rows: an archive of another version cannot be opened.
const FORMAT: u32 = 4;
/// Side of a cell where the settings give none, metres.
const USUAL_CELL_M: f64 = 0.5;
/// Smallest and largest cell, metres. Cells are powers of two, so that the coordinates of cells are
/// exact in every tile.
const CELLS_M: [f64; 2] = [0.125, 8.0];
/// Largest number of cells along the side of a tile's mosaic: a larger raster would exceed the
/// limits of a TIFF.
const MOST_MOSAIC_CELLS: f64 = 51_200.0;
/// Step of the halo, metres: the halo is a multiple of it, and so of every cell.
const HALO_STEP_M: f64 = 16.0;
/// Largest distance by which corrected positions move a point, metres: the halo holds all points
/// that may move into the tile.
pub(super) const MOST_MOVED_M: f64 = 12.0;
/// Groups of settings, by the first word of the key, that no row and no map of a tile depends on.
const REGARDLESS_OF: [&str; 5] = ["crs", "detector", "picture", "points", "report"];
/// Another setting that no row and no map depends on: mosaics of tiles store levels, which map
/// programs colour.
const COLOURS: &str = "mosaic.colours";
const _: () = assert!(TILE_M % PART_STEP_M == 0.0);
/// Largest cells of an archive with depths from levels, metres: larger cells would not show the
/// detail of these depths.
const MOST_CELL_M: f64 = 2.0;

/// Layout and settings that all logs of an archive share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArchiveRecord {
    /// Version of the layout of rows.
    format: u32,
    /// Side of a tile, metres.
    tile_m: f64,
    /// Width of the halo, metres: a tile has rows as far beyond its edges.
    pub halo_m: f64,
    /// Side of a cell of the maps, metres.
    pub cell_m: f64,
    /// Settings that rows and maps depend on, without those that belong to one log: draft, water
    /// level, mounting.
    #[serde(deserialize_with = "deserialize_values")]
    settings: SettingValues,
    /// Copy of the area that isobaths end at, in the folder of the archive; `None` without an area.
    /// The content of the area is the setting, not the place of the original file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    isobath_area: Option<Fingerprint>,
}

impl ArchiveRecord {
    /// Creates the record of an archive whose logs are processed with some settings.
    ///
    /// # Errors
    /// When `surface.cell_m` or `mosaic.cell_m` is no size for the cells of an archive, or the
    /// settings need rows from too far around a tile.
    pub fn new(settings: &Settings) -> Result<Self, Error> {
        let cell_m = settings.surface.cell_m.unwrap_or(USUAL_CELL_M);
        let is_power = cell_m.log2().fract() == 0.0;
        if !is_power || !(CELLS_M[0]..=CELLS_M[1]).contains(&cell_m) {
            return Err(Error::from(format!(
                "surface.cell_m is {cell_m}, but the tiles of an archive have cells of 0.125, 0.25, 0.5, 1, 2, 4 or 8 m; choose one of them"
            )));
        }
        let mosaic_m = settings.mosaic.cell_m;
        if !divides_tiles(mosaic_m) {
            return Err(Error::from(format!(
                "mosaic.cell_m is {mosaic_m}, which does not divide the 512 m of a tile into whole cells; choose 0.1, 0.125, 0.2, 0.25, 0.5 or 1"
            )));
        }
        let margin_m = cell_m * (LOCAL_MARGIN_CELLS + 1) as f64;
        let least_m = local_reach_m(settings.surface.max_gap_m) + margin_m + MOST_MOVED_M;
        let halo_m = (least_m / HALO_STEP_M).ceil() * HALO_STEP_M;
        if halo_m.is_nan() || halo_m > TILE_M {
            return Err(Error::from(format!(
                "surface.max_gap_m is {}, which reaches across whole tiles of an archive; choose at most 200",
                settings.surface.max_gap_m
            )));
        }
        check_reach(settings, cell_m, halo_m)?;
        let mut values = setting_values(settings);
        values.retain(|key, _| is_shared(key));
        let area = settings.isobaths.area.as_deref();
        Ok(Self {
            format: FORMAT,
            tile_m: TILE_M,
            halo_m,
            cell_m,
            settings: values,
            isobath_area: area.map(fingerprint_of),
        })
    }

    /// Returns the grid of the mosaic of a tile.
    ///
    /// # Errors
    /// As [`ArchiveRecord::settings`], or when the recorded `mosaic.cell_m` does not divide a tile
    /// into whole cells.
    pub(crate) fn mosaic_grid(&self, tile: TileId) -> Result<Grid, Error> {
        let cell_m = self.settings()?.mosaic.cell_m;
        if divides_tiles(cell_m) {
            Ok(tile.grid(0.0, cell_m))
        } else {
            Err(Error::from(format!(
                "mosaic.cell_m is {cell_m}, which is no size for an archive: {RECORD}"
            )))
        }
    }

    /// Returns the settings that maps are made with, without the area of the isobaths (for which
    /// see [`Archive::settings`]).
    ///
    /// # Errors
    /// When the recorded settings are not valid because a person has changed the record.
    pub fn settings(&self) -> Result<Settings, Error> {
        let settings = from_values(&self.settings);
        settings.map_err(|error| Error::from(format!("{error}: {RECORD}")))
    }

    /// Describes the first setting that differs from another record, with both values; `None` where
    /// the records are equal.
    fn difference(&self, other: &Self) -> Option<String> {
        let keys: BTreeSet<&String> = self.settings.keys().chain(other.settings.keys()).collect();
        let value = |record: &Self, key: &str| {
            let value = record.settings.get(key);
            value.map_or("not given".to_owned(), ToString::to_string)
        };
        let differs =
            keys.into_iter().find(|key| self.settings.get(*key) != other.settings.get(*key));
        let in_settings = differs.map(|key| {
            format!("{key} is {} there, and {} here", value(self, key), value(other, key))
        });
        let areas = (self.isobath_area != other.isobath_area).then(|| {
            let [there, here] =
                [self, other].map(|record| area_in_words(record.isobath_area.as_ref()));
            format!("{AREA} is {there} there, and {here} here")
        });
        in_settings
            .or(areas)
            .or_else(|| (self != other).then(|| "its tiles are laid out in another way".to_owned()))
    }
}

/// Refuses settings whose maps depend on more than a tile and its neighbours.
///
/// # Errors
/// When cells are too large or `surface.max_gap_m` reaches too far for depths from echo levels.
fn check_reach(settings: &Settings, cell_m: f64, halo_m: f64) -> Result<(), Error> {
    if settings.surface.swath != SwathDepth::Always {
        return Ok(());
    }
    if cell_m > MOST_CELL_M {
        return Err(Error::from(format!(
            "surface.cell_m is {cell_m}, but depths from echo levels need cells of {MOST_CELL_M} m at most; choose smaller ones, or surface.swath = off"
        )));
    }
    if PART_DEPTHS_M + halo_m > TILE_M {
        return Err(Error::from(format!(
            "surface.max_gap_m is {}, which is too far for depths from echo levels; choose at most 190, or surface.swath = off",
            settings.surface.max_gap_m
        )));
    }
    Ok(())
}

fn is_shared(key: &str) -> bool {
    let group = key.split('.').next().unwrap_or(key);
    !is_of_one_log(key) && !REGARDLESS_OF.contains(&group) && ![AREA, COLOURS].contains(&key)
}

/// Returns true if cells of this size divide the side of a tile: the mosaics of neighbouring tiles
/// then meet at whole cells.
fn divides_tiles(cell_m: f64) -> bool {
    let side = TILE_M / cell_m;
    (side - side.round()).abs() < 1e-9 && (1.0..=MOST_MOSAIC_CELLS).contains(&side)
}

/// Returns the fingerprint of the copy of an area: its name in the archive, length and SHA-256.
fn fingerprint_of(area: &WaterArea) -> Fingerprint {
    let ending = area.path.extension().unwrap_or_default().to_string_lossy();
    let is_plain = |ending: &str| ending.chars().all(|letter| letter.is_ascii_alphanumeric());
    let file = match ending.to_lowercase() {
        ending if !ending.is_empty() && is_plain(&ending) => format!("{AREA_STEM}.{ending}"),
        _ => AREA_STEM.to_owned(),
    };
    Fingerprint { file, bytes: area.bytes as u64, sha256: area.sha256.clone() }
}

/// Describes an area by its length and the first hexadecimal digits of its SHA-256, because two
/// files of one name may differ.
fn area_in_words(area: Option<&Fingerprint>) -> String {
    area.map_or("not given".to_owned(), |area| {
        let digits = area.sha256.get(..12).unwrap_or(&area.sha256);
        format!("a file of {} bytes (SHA-256 {digits}...)", area.bytes)
    })
}

/// A folder with an archive.
#[derive(Clone, Debug)]
pub struct Archive {
    folder: PathBuf,
    /// Layout and settings that the logs of the archive share.
    pub record: ArchiveRecord,
    /// Logs that were added through this value or a copy of it.
    begun: Arc<Mutex<BTreeSet<String>>>,
    /// The area of the isobaths; empty until it is read.
    area: Arc<OnceLock<Arc<WaterArea>>>,
}

impl Archive {
    /// Opens the archive of a folder.
    ///
    /// # Errors
    /// When the folder holds no archive, or one of another version, or its record cannot be used.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(RECORD);
        let text = regular_file::read_text(&path, LONGEST_RECORD).map_err(|error| {
            format!(
                "no archive in this folder ({RECORD}: {error}); `bathyscope process LOG... -o {0} --products tiles` makes one: {0}",
                folder.display()
            )
        })?;
        let record: ArchiveRecord = serde_json::from_str(&text).map_err(|error| {
            format!("the record of the archive cannot be used: {error}: {}", path.display())
        })?;
        if record.format != FORMAT || record.tile_m != TILE_M {
            return Err(Error::from(format!(
                "another version of the program laid this archive out; process its logs into a new folder: {}",
                folder.display()
            )));
        }
        record.settings()?;
        Ok(Self { folder: folder.to_owned(), record, begun: Arc::default(), area: Arc::default() })
    }

    /// Opens the archive of a folder for logs that are processed with some settings; creates an
    /// archive where there is none.
    ///
    /// # Errors
    /// When the folder holds something else or an archive of other settings, or cannot be written
    /// into.
    pub fn open_for(folder: &Path, settings: &Settings) -> Result<Self, Error> {
        let record = ArchiveRecord::new(settings)?;
        if !folder.join(RECORD).exists() {
            refuse_other_content(folder)?;
            make_folder(folder)?;
            write_json(&folder.join(RECORD), &record)?;
        }
        let archive = Self::open(folder)?;
        archive.check(settings)?;
        archive.keep_area(settings)?;
        Ok(archive)
    }

    /// Refuses settings other than those of the archive. Settings that belong to one log are not
    /// compared.
    ///
    /// # Errors
    /// When a setting differs: the sentence names the first one, with both values.
    pub fn check(&self, settings: &Settings) -> Result<(), Error> {
        match self.record.difference(&ArchiveRecord::new(settings)?) {
            None => Ok(()),
            Some(what) => Err(Error::from(format!(
                "the archive was made with other settings: {what}; give the same, or choose another folder: {}",
                self.folder.display()
            ))),
        }
    }

    /// Copies the area of the isobaths into the archive, unless the copy is there: the run that
    /// created the archive may have ended before.
    fn keep_area(&self, settings: &Settings) -> Result<(), Error> {
        let (Some(kept), Some(area)) = (&self.record.isobath_area, &settings.isobaths.area) else {
            return Ok(());
        };
        if kept.is_unchanged(&self.folder) {
            return Ok(());
        }
        let bytes = regular_file::read(&area.path, kept.bytes)
            .map_err(|error| format!("cannot read the area: {error}: {}", area.path.display()))?;
        Ok(write_bytes(&self.folder.join(&kept.file), bytes)?)
    }

    /// Returns the settings that maps are made with.
    ///
    /// # Errors
    /// When the recorded settings are not valid, or the copy of the area of the isobaths has
    /// changed or cannot be read.
    pub fn settings(&self) -> Result<Settings, Error> {
        let mut settings = self.record.settings()?;
        let Some(kept) = &self.record.isobath_area else {
            return Ok(settings);
        };
        let area = match self.area.get() {
            Some(area) => area.clone(),
            None => {
                let read = self.read_area(kept)?;
                self.area.get_or_init(|| read).clone()
            }
        };
        settings.isobaths.clip = Some(area.path.clone());
        settings.isobaths.area = Some(area);
        Ok(settings)
    }

    fn read_area(&self, kept: &Fingerprint) -> Result<Arc<WaterArea>, Error> {
        let path = self.folder.join(&kept.file);
        let area = read_area(&path)?;
        if area.sha256 == kept.sha256 {
            Ok(Arc::new(area))
        } else {
            Err(Error::from(format!(
                "the area of the archive's isobaths is not the one that it was made with; put that one back: {}",
                path.display()
            )))
        }
    }

    /// Returns true if a log is added for the first time through this value or a copy of it: one
    /// log under two names must not be written at the same time.
    pub(super) fn begins(&self, log: &str) -> bool {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        begun.insert(log.to_owned())
    }

    /// Returns the folder of the archive.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the name of a file of a log in a tile, of a kind of [`KINDS`], with `/` between
    /// folders.
    pub(super) fn rows_name(kind: &str, tile: TileId, log: &str) -> String {
        let ending = KINDS.iter().find(|(name, _)| *name == kind);
        format!("{kind}/tile={tile}/{log}.{}", ending.map_or("parquet", |(_, ending)| ending))
    }

    /// Returns the path of the file named by [`Self::rows_name`].
    pub(super) fn rows_path(&self, kind: &str, tile: TileId, log: &str) -> PathBuf {
        self.folder.join(Self::rows_name(kind, tile, log))
    }

    /// Reads the records of the logs that the maps of some tiles are made from, sorted by hash.
    ///
    /// # Errors
    /// When a record cannot be used.
    pub fn logs_of_maps(&self, tiles: &[TileId]) -> Result<Vec<LogRecord>, Error> {
        let swath = self.record.settings()?.surface.swath;
        let read = tiles.iter().flat_map(|tile| tiles_read(swath, *tile));
        self.logs_in(read)
    }

    /// Reads the records of the logs that have rows in some tiles, sorted by hash. No other record
    /// is read, so that the time does not grow with logs elsewhere.
    ///
    /// # Errors
    /// When a record cannot be used.
    pub fn logs_in(&self, tiles: impl Iterator<Item = TileId>) -> Result<Vec<LogRecord>, Error> {
        let mut logs = BTreeSet::new();
        for tile in tiles {
            for (kind, ending) in KINDS {
                let names = names_in(&self.folder.join(format!("{kind}/tile={tile}")))?;
                let logs_of = names.iter().filter_map(|name| {
                    let (log, end) = name.rsplit_once('.')?;
                    (end == ending).then(|| log.to_owned())
                });
                logs.extend(logs_of);
            }
        }
        let paths = logs.iter().map(|log| self.folder.join(LOGS).join(format!("{log}.json")));
        paths.filter(|path| path.is_file()).map(|path| LogRecord::read(&path)).collect()
    }

    /// Reads the records of all logs, sorted by hash. A log that is being written, or was when the
    /// program ended, has no record.
    ///
    /// # Errors
    /// When a record cannot be used.
    pub fn logs(&self) -> Result<Vec<LogRecord>, Error> {
        let mut names = names_in(&self.folder.join(LOGS))?;
        names.retain(|name| name.ends_with(".json") && !name.starts_with('.'));
        names.sort_unstable();
        let read = |name: &String| LogRecord::read(&self.folder.join(LOGS).join(name));
        names.iter().map(read).collect()
    }
}

/// Refuses a folder with content of a run or of anything else, because an archive is not mixed with
/// it. Another job may have created the archive at this moment.
fn refuse_other_content(folder: &Path) -> Result<(), Error> {
    let names = names_in(folder)?;
    let other = names.iter().find(|name| !name.starts_with('.'));
    match other.filter(|_| !names.iter().any(|name| name == RECORD)) {
        None => Ok(()),
        Some(name) => Err(Error::from(format!(
            "the folder holds {name} and no archive; choose an empty or a new one: {}",
            folder.display()
        ))),
    }
}

/// Numbers of rows of a tile, of all logs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileRowCounts {
    /// Number of logs with rows of points or pings.
    pub logs: usize,
    /// Number of rows of points, with those of the halo.
    pub points: usize,
    /// Number of points in the tile itself.
    pub core_points: usize,
    /// Number of rows of pings.
    pub pings: usize,
}

/// Returns all tiles that have rows, in order.
///
/// # Errors
/// When a record cannot be used.
pub fn contents(archive: &Archive) -> Result<BTreeMap<TileId, TileRowCounts>, Error> {
    let mut tiles: BTreeMap<TileId, TileRowCounts> = BTreeMap::new();
    for log in archive.logs()? {
        for rows in &log.tiles {
            let content = tiles.entry(rows.tile).or_default();
            content.logs += 1;
            content.points += rows.points;
            content.core_points += rows.core_points;
            content.pings += rows.pings;
        }
    }
    Ok(tiles)
}
