//! Writes the rows of a log into an archive.

use super::echo_rows::EchoesByTile;
use super::log_mosaic::LogMosaic;
use super::log_record::{LogRecord, TileRows};
use super::log_rows::{self, LogRows, RowsByTile, TileRow, track};
use super::ping_rows::{self, PingsByTile};
use super::record::Archive;
use super::tile::TileId;
use super::{ECHOES, KINDS, LOGS, PINGS, POINTS, fingerprint, names_in, point_rows, remove};
use crate::Error;
use crate::export::{make_folder, write_atomically, write_json};
use crate::pipeline::{self, Fingerprint, LogFiles, ProcessedLog, Settings};
use bathyscope_bottom::bathymetry::SwathDepth;
use bathyscope_log::formats::parquet_table::{Column, Values, geo_key, write_parquet};
use bathyscope_log::support::outline;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use serde_json::json;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Result of adding a log.
#[derive(Clone, Debug, PartialEq)]
pub enum Added {
    /// The rows of the log were written.
    Written(LogRecord),
    /// The rows are in the archive already, made from the same bytes with the same settings.
    UpToDate(LogRecord),
    /// The same bytes were added before under another name.
    Twice,
}

/// Writes the points and pings of a log and its parts of the mosaic into an archive, unless they
/// are there. Removes the rows of an earlier version of the log that was made from other inputs or
/// settings.
///
/// # Errors
/// When the log has no positions, its files were cut or changed meanwhile, a file cannot be
/// written, or the work was cancelled; what was written then does not count as part of the archive.
pub fn add(
    archive: &Archive,
    survey: &Arc<Survey>,
    settings: &Settings,
    progress: &Progress,
) -> Result<Added, Error> {
    let files = LogFiles::of(survey, settings, progress)?;
    if !archive.begins(&files.sha256) {
        return Ok(Added::Twice);
    }
    let record = LogRecord::new(survey, settings, &files);
    let path = archive.folder().join(LOGS).join(format!("{}.json", record.log));
    if let Ok(there) = LogRecord::read(&path)
        && there.is_made_alike(&record)
        && there.is_whole(archive.folder())
    {
        return Ok(Added::UpToDate(there));
    }
    if !survey.has_place() {
        return Err(Error::from(format!(
            "the log has no positions, so nothing of it has a place in an archive; give those of another receiver with --track: {}",
            survey.name()
        )));
    }
    let log = ProcessedLog {
        survey: survey.clone(),
        products: pipeline::run(survey, settings, None, progress, |_| ())?,
    };
    // From here on the rows of the log in the archive are a mixture of two versions.
    remove(&path)?;
    let record = write_rows(archive, &log, record, progress)?;
    survey.check_files()?;
    remove_others(archive, &record)?;
    make_folder(&archive.folder().join(LOGS))?;
    write_json(&path, &record)?;
    Ok(Added::Written(record))
}

/// All that a log adds to the tiles of an archive, before any of it is written.
struct LogTiles<'a> {
    archive: &'a Archive,
    progress: &'a Progress,
    log: &'a LogRows<'a>,
    points: RowsByTile,
    pings: PingsByTile,
    /// Rows of echoes; only in archives whose depths come from echo levels.
    echoes: Option<EchoesByTile<'a>>,
    mosaic: LogMosaic,
    /// Inputs and settings of the log, the same for every file of rows.
    made: String,
}

/// Writes all rows and parts of the mosaic of a log; returns the record with their numbers and
/// files.
fn write_rows(
    archive: &Archive,
    log: &ProcessedLog,
    mut record: LogRecord,
    progress: &Progress,
) -> Result<LogRecord, Error> {
    let rows = LogRows {
        survey: &log.survey,
        products: &log.products,
        sha256: &record.log.clone(),
        track: &track(&log.survey, &log.products),
    };
    let points = rows.products.cloud.points.iter().enumerate();
    let placed = points.filter_map(|(index, point)| {
        let at = rows.position(point.east_m, point.north_m);
        (at.is_on_earth() && point.z_m.is_finite()).then_some((index, at))
    });
    let points = log_rows::by_tile(placed, archive.record.halo_m);
    let pings = ping_rows::by_tile(&rows);
    let zones = pings.rows.keys().map(|tile| tile.zone).collect();
    let echoes = match rows.products.settings.surface.swath {
        SwathDepth::Off | SwathDepth::Auto => None,
        SwathDepth::Always => Some(EchoesByTile::new(&rows, archive.record.halo_m, progress)?),
    };
    let spread = LogTiles {
        archive,
        progress,
        log: &rows,
        points,
        echoes,
        mosaic: LogMosaic::new(log, zones, progress)?,
        made: json!({ "log": record.log, "name": record.name, "made": record.made }).to_string(),
        pings,
    };
    record.pings = spread.pings.count;
    record.levels = (spread.echoes.as_ref()).and_then(|echoes| echoes.learnt.clone());
    let of_rows = spread.points.keys().chain(spread.pings.rows.keys());
    let of_echoes = spread.echoes.iter().flat_map(|echoes| echoes.rows.keys());
    let tiles = of_rows.chain(of_echoes).chain(&spread.mosaic.tiles);
    let tiles: BTreeSet<TileId> = tiles.copied().collect();
    for tile in tiles {
        progress.check()?;
        let (rows, soundings) = spread.write(tile)?;
        if !rows.files.is_empty() {
            record.points += rows.core_points;
            record.soundings += soundings;
            record.tiles.push(rows);
        }
    }
    Ok(record)
}

impl LogTiles<'_> {
    /// Writes the rows and the part of the mosaic that the log has in a tile; returns their record
    /// and the number of soundings in the tile that count for maps.
    fn write(&self, tile: TileId) -> Result<(TileRows, usize), Error> {
        let log = self.log;
        let mut files = Vec::new();
        let mut write = |kind: &str, columns: Vec<Column>| {
            let name = Archive::rows_name(kind, tile, log.sha256);
            files.push(self.write_file(&name, &columns)?);
            Ok::<_, Error>(())
        };
        let of_tile = self.points.get(&tile);
        if let Some(points) = of_tile {
            write(POINTS, point_rows::columns(log, points))?;
        }
        let soundings = of_tile.into_iter().flatten().filter(|row| {
            let (point, class) = log.point(row.index);
            row.is_core && point.sounding().is_some() && log.weight(point, class) > 0.0
        });
        let seen = (self.pings.rows.get(&tile)).zip(self.pings.footprints.get(&tile));
        if let Some((pings, footprints)) = seen {
            write(PINGS, ping_rows::columns(log, pings, footprints))?;
        }
        if let Some(echoes) = &self.echoes
            && let Some(rows) = echoes.rows.get(&tile)
        {
            write(ECHOES, echoes.columns(log, rows))?;
        }
        let (mosaic_cells, parts) = self.write_mosaic(tile)?;
        files.extend(parts);
        let grounds = seen
            .into_iter()
            .flat_map(|(_, footprints)| footprints)
            .filter_map(|ping| ping.bounds_m());
        let around = grounds.reduce(outline::box_around);
        let is_core = |row: &&TileRow| row.is_core;
        let rows = TileRows {
            tile,
            points: of_tile.map_or(0, Vec::len),
            core_points: of_tile.map_or(0, |points| points.iter().filter(is_core).count()),
            pings: seen.map_or(0, |(pings, _)| pings.len()),
            mosaic_cells,
            seen_m: around.map_or(Vec::new(), Vec::from),
            unix_s: log.span_unix_s(of_tile, seen.map(|(pings, _)| pings)),
            files,
        };
        Ok((rows, soundings.count()))
    }

    /// Writes the log's part of the mosaic of a tile; returns the number of cells that have a
    /// level, and the files.
    fn write_mosaic(&self, tile: TileId) -> Result<(usize, Vec<Fingerprint>), Error> {
        let Self { archive, progress, log, .. } = *self;
        let cells = self.mosaic.write(archive, tile, log.sha256, progress)?;
        let mut files = Vec::new();
        for kind in self.mosaic.kinds().iter().filter(|_| cells > 0) {
            let name = Archive::rows_name(kind, tile, log.sha256);
            files.push(fingerprint(archive.folder(), &name, &Progress::new())?);
        }
        Ok((cells, files))
    }

    fn write_file(&self, name: &str, columns: &[Column]) -> Result<Fingerprint, Error> {
        let folder = self.archive.folder();
        let path = folder.join(name);
        make_folder(path.parent().unwrap_or(folder))?;
        let places = columns.iter().find_map(|column| match &column.values {
            Values::Points(places) => Some(places.as_slice()),
            _ => None,
        });
        let geo = geo_key("geometry", places.unwrap_or_default());
        let keys = [("geo", geo), ("bathyscope", self.made.clone())];
        write_atomically(&path, |file| write_parquet(file, columns, &keys))?;
        fingerprint(folder, name, &Progress::new())
    }
}

/// Removes the files of the log in tiles where it has no rows any more.
fn remove_others(archive: &Archive, record: &LogRecord) -> Result<(), Error> {
    let files: BTreeSet<&str> = (record.tiles.iter())
        .flat_map(|rows| rows.files.iter().map(|file| file.file.as_str()))
        .collect();
    for (kind, ending) in KINDS {
        for tile in names_in(&archive.folder().join(kind))? {
            let name = format!("{kind}/{tile}/{}.{ending}", record.log);
            let path = archive.folder().join(&name);
            if !files.contains(name.as_str()) && path.is_file() {
                remove(&path)?;
            }
        }
    }
    Ok(())
}
