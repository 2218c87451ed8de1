//! Writing the rows of a log into an archive.

use super::echo_rows::{ECHOES, EchoesByTile};
use super::error::ArchiveError;
use super::log_mosaic::LogMosaic;
use super::log_record::{LOGS, LogRecord, TileRows};
use super::ping_rows::{self, PINGS, PingsByTile};
use super::point_rows::{self, POINTS};
use super::record::{Archive, KINDS, names_in, write_json};
use super::spread::{self, Row, RowsByTile};
use super::tile::TileId;
use crate::bottom::bathymetry::SwathDepth;
use crate::bottom::bathymetry::crosslines::{TrackDepth, velocity_mps};
use crate::bottom::cloud::{CloudPoint, PointClass};
use crate::formats::parquet_table::{Column, Values, geo_key, write_parquet};
use crate::pipeline::{self, Fingerprint, LogFiles, ProcessedLog, Products, Settings};
use crate::products::export::write_atomically;
use crate::support::geo::{LonLat, UtmZone};
use crate::support::progress::Progress;
use crate::survey::{PingNav, Survey};
use serde_json::json;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// What became of a log.
#[derive(Clone, Debug, PartialEq)]
pub enum Added {
    /// Its rows were written.
    Written(LogRecord),
    /// They are there already, made from the same bytes with the same settings.
    UpToDate(LogRecord),
    /// The same bytes were added before under another name.
    Twice,
}

/// A log whose rows are written.
pub(super) struct LogRows<'a> {
    pub survey: &'a Survey,
    pub products: &'a Products,
    pub sha256: &'a str,
    /// The boat's place in the log's plane by time, of every sounding or, in a log without any, of every ping; no two at one time.
    pub track: &'a [TrackDepth],
}

/// What [`LogRows::track`] is; depths do not count.
fn track(survey: &Survey, products: &Products) -> Vec<TrackDepth> {
    let navigation = &products.navigation;
    let of_soundings = survey.soundings.iter().map(|one| one.time_s);
    let of_pings = survey.side_scan.iter().map(|one| one.time_s);
    let fixes: Vec<(f64, &PingNav)> = match survey.soundings.is_empty() {
        false => of_soundings.zip(navigation.soundings.iter()).collect(),
        true => of_pings.zip(navigation.pings.iter()).collect(),
    };
    let depth = |(time_s, fix): (f64, &PingNav)| TrackDepth {
        time_s,
        east_m: fix.east_m,
        north_m: fix.north_m,
        depth_m: 0.0,
    };
    let mut track: Vec<TrackDepth> = (fixes.into_iter().map(depth))
        .filter(|one| (one.time_s + one.east_m + one.north_m).is_finite())
        .collect();
    track.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    track.dedup_by(|a, b| a.time_s == b.time_s);
    track
}

impl LogRows<'_> {
    /// A point of the cloud and its class.
    pub fn point(&self, index: usize) -> (&CloudPoint, PointClass) {
        (
            &self.products.cloud.points[index],
            self.products.classes[index],
        )
    }

    /// What a point counts for maps.
    pub fn weight(&self, point: &CloudPoint, class: PointClass) -> f64 {
        match class.is_kept() {
            true => self.products.settings.surface.weight(point),
            false => 0.0,
        }
    }

    /// Seconds after the log's time zero.
    pub fn time_of(&self, point: &CloudPoint) -> f64 {
        let sounding = point
            .sounding
            .and_then(|one| self.survey.soundings.get(one.get()));
        let ping = || {
            self.survey
                .side_scan
                .get(point.ping as usize)
                .map(|ping| ping.time_s)
        };
        let time_s = sounding.map(|one| one.time_s).or_else(ping);
        time_s.unwrap_or(f64::NAN)
    }

    /// Microseconds since 1970 of a time of the log.
    pub fn unix_us(&self, time_s: f64) -> Option<i64> {
        let unix_us = 1e6 * (self.survey.start_unix_s? + time_s);
        unix_us.is_finite().then_some(unix_us.round() as i64)
    }

    /// Unix seconds of the first and the last of some rows of points and pings; empty where the recorder did not know the time.
    fn span_unix_s(&self, points: Option<&Vec<Row>>, pings: Option<&Vec<Row>>) -> Vec<f64> {
        let Some(start_unix_s) = self.survey.start_unix_s else {
            return Vec::new();
        };
        let of_points = points
            .into_iter()
            .flatten()
            .map(|row| self.time_of(self.point(row.index).0));
        let of_pings = pings
            .into_iter()
            .flatten()
            .map(|row| self.survey.side_scan[row.index].time_s);
        let span = of_points
            .chain(of_pings)
            .filter(|time_s| time_s.is_finite())
            .fold(None, |span, time_s| {
                let [from_s, to_s]: [f64; 2] = span.unwrap_or([time_s; 2]);
                Some([from_s.min(time_s), to_s.max(time_s)])
            });
        span.map_or(Vec::new(), |span| {
            span.map(|time_s| start_unix_s + time_s).to_vec()
        })
    }

    /// What the rows of points and of pings end with: whether they lie in the halo, when they were recorded (`times_s`, seconds after the
    /// log's time zero), and of which log they are.
    pub fn common_columns(&self, rows: &[Row], times_s: Vec<f64>) -> [Column; 5] {
        let halo = rows.iter().map(|row| !row.is_core).collect();
        let unix_us = times_s.iter().map(|time_s| self.unix_us(*time_s)).collect();
        [
            Column::new("halo", Values::Flag(halo)),
            Column::new("time", Values::Time(unix_us)),
            Column::new("time_s", Values::Double(times_s)),
            Column::new("log", Values::Same(self.sha256.to_owned(), rows.len())),
            Column::new("name", Values::Same(self.survey.name(), rows.len())),
        ]
    }

    /// Velocity of the boat at a time of the log, metres a second along the axes of a zone; zero where it is not known.
    pub fn velocity_mps(&self, time_s: f64, zone: UtmZone) -> [f64; 2] {
        let after = self.track.partition_point(|one| one.time_s < time_s);
        let Some(here) = self
            .track
            .get(after.min(self.track.len().saturating_sub(1)))
        else {
            return [0.0; 2];
        };
        let index = after.min(self.track.len() - 1);
        let [east, north] = velocity_mps(self.track, index);
        let place = |seconds: f64| {
            let at = [here.east_m + seconds * east, here.north_m + seconds * north];
            zone.to_metres(self.position(at[0], at[1]))
        };
        let ([from_x, from_y], [to_x, to_y]) = (place(0.0), place(1.0));
        let velocity = [to_x - from_x, to_y - from_y];
        match velocity.iter().all(|value| value.is_finite()) {
            true => velocity,
            false => [0.0; 2],
        }
    }

    /// Where a place of the log's plane lies.
    pub fn position(&self, east_m: f64, north_m: f64) -> LonLat {
        let navigation = &self.products.navigation;
        navigation.to_lon_lat(&self.survey.track, east_m, north_m)
    }
}

/// Writes the points and pings of a log and its parts of the mosaic into an archive, unless they are there. The rows of a version of it that was made otherwise go.
///
/// # Errors
/// When the log has no place, a file cannot be written, or the work was cancelled; what was written is then no part of the archive.
pub fn add(
    archive: &Archive,
    survey: &Arc<Survey>,
    settings: &Settings,
    progress: &Progress,
) -> Result<Added, ArchiveError> {
    let files = LogFiles::of(survey, settings, progress)?;
    if !archive.begins(&files.sha256) {
        return Ok(Added::Twice);
    }
    let record = LogRecord::new(survey, settings, &files);
    let path = archive
        .folder()
        .join(LOGS)
        .join(format!("{}.json", record.log));
    if let Ok(there) = LogRecord::read(&path)
        && there.is_made_alike(&record)
        && there.is_whole(archive.folder())
    {
        return Ok(Added::UpToDate(there));
    }
    if !survey.has_place() {
        return Err(ArchiveError::Refused(format!(
            "the log has no positions, so nothing of it has a place in an archive; give those of another receiver with --track: {}",
            survey.name()
        )));
    }
    let log = ProcessedLog {
        survey: survey.clone(),
        products: pipeline::run(survey, settings, None, progress, |_| ())?,
    };
    if path.exists() {
        // From here on its rows are those of two versions.
        fs::remove_file(&path)
            .map_err(|error| format!("cannot remove the file: {error}: {}", path.display()))?;
    }
    let record = write_rows(archive, &log, record, progress)?;
    remove_others(archive, &record)?;
    make_folder(&archive.folder().join(LOGS))?;
    write_json(&path, &record)?;
    Ok(Added::Written(record))
}

/// All that a log gives to tiles, before any of it is written.
struct Spread<'a> {
    log: &'a LogRows<'a>,
    points: RowsByTile,
    pings: PingsByTile,
    /// Where depths come from echo levels.
    echoes: Option<EchoesByTile<'a>>,
    mosaic: LogMosaic,
    /// The same of every file of rows: what it was made from, and how.
    made: String,
}

/// Writes all rows and parts; gives back the record with them.
fn write_rows(
    archive: &Archive,
    log: &ProcessedLog,
    mut record: LogRecord,
    progress: &Progress,
) -> Result<LogRecord, ArchiveError> {
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
    let points = spread::by_tile(placed, archive.record.halo_m);
    let pings = ping_rows::by_tile(&rows);
    let zones = pings.rows.keys().map(|tile| tile.zone).collect();
    let echoes = match rows.products.settings.surface.swath {
        SwathDepth::Off | SwathDepth::Auto => None,
        SwathDepth::Always => Some(EchoesByTile::new(&rows, archive.record.halo_m, progress)?),
    };
    let spread = Spread {
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
        let (rows, soundings) = spread.write(archive, tile, progress)?;
        if !rows.files.is_empty() {
            record.points += rows.core_points;
            record.soundings += soundings;
            record.tiles.push(rows);
        }
    }
    Ok(record)
}

impl Spread<'_> {
    /// Writes what the log gives to a tile; how many soundings of it count for maps, too.
    fn write(
        &self,
        archive: &Archive,
        tile: TileId,
        progress: &Progress,
    ) -> Result<(TileRows, usize), ArchiveError> {
        let log = self.log;
        let mut files = Vec::new();
        let mut write = |kind: &str, columns: Vec<Column>| {
            let name = Archive::rows_name(kind, tile, log.sha256);
            files.push(write_file(archive, &name, &columns, &self.made)?);
            Ok::<_, ArchiveError>(())
        };
        let of_tile = self.points.get(&tile);
        if let Some(points) = of_tile {
            write(POINTS, point_rows::columns(log, points))?;
        }
        let soundings = of_tile.into_iter().flatten().filter(|row| {
            let (point, class) = log.point(row.index);
            row.is_core && point.sounding.is_some() && log.weight(point, class) > 0.0
        });
        let seen = (self.pings.rows.get(&tile)).zip(self.pings.footprints.get(&tile));
        if let Some((pings, footprints)) = seen {
            write(PINGS, ping_rows::columns(log, pings, footprints))?;
        }
        if let Some((echoes, rows)) =
            (self.echoes.as_ref()).and_then(|echoes| Some((echoes, echoes.rows.get(&tile)?)))
        {
            write(ECHOES, echoes.columns(log, rows))?;
        }
        let (mosaic_cells, parts) = self.write_mosaic(archive, tile, progress)?;
        files.extend(parts);
        let grounds = seen
            .into_iter()
            .flat_map(|(_, footprints)| footprints)
            .filter_map(|ping| ping.bounds_m());
        let around = grounds.reduce(|[w, s, e, n], [west, south, east, north]| {
            [w.min(west), s.min(south), e.max(east), n.max(north)]
        });
        let is_core = |row: &&Row| row.is_core;
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

    /// Writes its part of the mosaic; how many cells show something, and the files.
    fn write_mosaic(
        &self,
        archive: &Archive,
        tile: TileId,
        progress: &Progress,
    ) -> Result<(usize, Vec<Fingerprint>), ArchiveError> {
        let cells = self
            .mosaic
            .write(archive, tile, self.log.sha256, progress)?;
        let mut files = Vec::new();
        for kind in self.mosaic.kinds().iter().filter(|_| cells > 0) {
            let name = Archive::rows_name(kind, tile, self.log.sha256);
            files.push(fingerprint(archive, &name)?);
        }
        Ok((cells, files))
    }
}

fn write_file(
    archive: &Archive,
    name: &str,
    columns: &[Column],
    made: &str,
) -> Result<Fingerprint, ArchiveError> {
    let path = archive.folder().join(name);
    make_folder(path.parent().unwrap_or(archive.folder()))?;
    let places = columns.iter().find_map(|column| match &column.values {
        Values::Points(places) => Some(places.as_slice()),
        _ => None,
    });
    let keys = [
        ("geo", geo_key("geometry", places.unwrap_or_default())),
        ("bathyscope", made.to_owned()),
    ];
    write_atomically(&path, |file| write_parquet(file, columns, &keys))?;
    fingerprint(archive, name)
}

fn fingerprint(archive: &Archive, name: &str) -> Result<Fingerprint, ArchiveError> {
    let hashed = Fingerprint::of(archive.folder(), name, &Progress::new());
    Ok(hashed.map_err(|error| {
        format!(
            "cannot read the file: {error}: {}",
            archive.folder().join(name).display()
        )
    })?)
}

pub(super) fn make_folder(folder: &Path) -> Result<(), ArchiveError> {
    Ok(fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder: {error}: {}", folder.display()))?)
}

/// Removes rows of the log in tiles where it has none any more.
fn remove_others(archive: &Archive, record: &LogRecord) -> Result<(), ArchiveError> {
    let files: BTreeSet<&str> = (record.tiles.iter())
        .flat_map(|rows| rows.files.iter().map(|file| file.file.as_str()))
        .collect();
    for (kind, ending) in KINDS {
        for tile in names_in(&archive.folder().join(kind))? {
            let name = format!("{kind}/{tile}/{}.{ending}", record.log);
            let path = archive.folder().join(&name);
            if !files.contains(name.as_str()) && path.is_file() {
                fs::remove_file(&path).map_err(|error| {
                    format!("cannot remove the file: {error}: {}", path.display())
                })?;
            }
        }
    }
    Ok(())
}
