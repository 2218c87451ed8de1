//! Writes and reads the echoes of a log, a row for each side-scan ping with a place:
//! `echoes/tile=.../SHA256.parquet`, in archives whose depths come from echo levels. The rows hold
//! all that the correction by echo levels reads of the log, so that a map of a tile is made without
//! the log.

use super::log_record::LogRecord;
use super::log_rows::{self, LogRows, RowsByTile, TileRow};
use super::offsets::{Offsets, moved};
use super::tile::{TileId, is_within};
use crate::Error;
use crate::pipeline::{depth_points, log_echoes};
use bathyscope_bottom::swath::{
    LaidOutLog, LearntLevels, LogEchoes, PingChunk, PingPlace, SampleSource, SideEchoes,
};
use bathyscope_log::formats::parquet_table::{Column, Values};
use bathyscope_log::support::geo::{LonLat, UtmZone};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Side;
use std::path::Path;

/// The echoes of a whole log, assigned to tiles.
pub(super) struct EchoesByTile<'a> {
    log: LaidOutLog<'a>,
    /// Law and curves of the levels, learnt from the log; `None` where its levels cannot be used.
    pub learnt: Option<LearntLevels>,
    /// Index of the chunk of each ping; `None` for a ping in no chunk.
    chunks: Vec<Option<usize>>,
    /// Rows by tile. Each ping has a row in the tile that holds it, in its own zone and in a
    /// neighbouring zone that is near.
    pub rows: RowsByTile,
}

impl<'a> EchoesByTile<'a> {
    /// Assigns the echoes of a log to tiles.
    pub(super) fn new(
        log: &LogRows<'a>,
        halo_m: f64,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let echoes = log_echoes(log.survey, log.products, |place| place);
        let laid_out = LaidOutLog::new(echoes, progress)?;
        let mut rows = RowsByTile::new();
        for (index, ping) in laid_out.echoes.pings.iter().enumerate() {
            if !ping.is_placed() {
                continue;
            }
            let at = log.position(ping.place_m[0], ping.place_m[1]);
            if !at.is_on_earth() {
                continue;
            }
            for (rank, zone) in UtmZone::near(at, halo_m).into_iter().enumerate() {
                let place = zone.to_metres(at);
                rows.entry(TileId::at(zone, place)).or_default().push(TileRow {
                    index,
                    at,
                    zone,
                    place,
                    is_core: rank == 0,
                });
            }
        }
        let mut chunks = vec![None; laid_out.echoes.pings.len()];
        for (place, chunk) in laid_out.chunks.iter().enumerate() {
            chunks[chunk.pings.clone()].fill(Some(place));
        }
        let products = log.products;
        let measured =
            depth_points(&products.cloud, &products.classes, &products.settings.surface, |point| {
                [point.east_m, point.north_m, point.z_m]
            });
        Ok(Self {
            learnt: LearntLevels::of(&laid_out, &measured, progress)?,
            log: laid_out,
            chunks,
            rows,
        })
    }

    /// Returns the columns of rows in a tile.
    pub(super) fn columns(&self, log: &LogRows<'_>, rows: &[TileRow]) -> Vec<Column> {
        let pings: Vec<&PingPlace> =
            rows.iter().map(|row| &self.log.echoes.pings[row.index]).collect();
        let of_rows = |name: &'static str, value: &dyn Fn(&TileRow) -> f64| {
            Column::doubles(name, rows.iter().map(value))
        };
        let of_pings = |name: &'static str, value: fn(&PingPlace) -> f64| {
            Column::doubles(name, pings.iter().map(move |ping| value(ping)))
        };
        let chunk = |row: &TileRow| Some(&self.log.chunks[self.chunks[row.index]?]);
        let of_chunks = |name: &'static str, value: fn(&PingChunk) -> i32| {
            Column::wholes(name, rows.iter().map(move |row| chunk(row).map(value)))
        };
        let starboard: Vec<[f64; 2]> = rows.iter().map(|row| self.starboard(log, row)).collect();
        let velocity: Vec<[f64; 2]> = (rows.iter().zip(&pings))
            .map(|(row, ping)| log.velocity_mps(ping.time_s, row.zone))
            .collect();
        let part = |name: &'static str, of: &[[f64; 2]], axis: usize| {
            Column::doubles(name, of.iter().map(move |of| of[axis]))
        };
        let levels = |side: Side| {
            let mut levels = Vec::new();
            let read = |row: &TileRow| {
                self.log.echoes.read(row.index, side, &mut levels);
                levels.clone()
            };
            Values::Bytes(rows.iter().map(read).collect())
        };
        let times_s = pings.iter().map(|ping| ping.time_s).collect();
        let numbers = rows.iter().map(|row| Some(row.index as i32));
        let weed = rows.iter().map(|row| self.log.is_weed[row.index]);
        let mut columns = vec![
            log_rows::geometry(rows),
            of_rows("x", &|row| row.place[0]),
            of_rows("y", &|row| row.place[1]),
            part("starboard_x", &starboard, 0),
            part("starboard_y", &starboard, 1),
            part("velocity_x_mps", &velocity, 0),
            part("velocity_y_mps", &velocity, 1),
            of_pings("transducer_m", |ping| ping.transducer_m),
            of_pings("port_near_m", |ping| ping.sides[0].near_m),
            of_pings("port_sample_m", |ping| ping.sides[0].step_m),
            of_pings("starboard_near_m", |ping| ping.sides[1].near_m),
            of_pings("starboard_sample_m", |ping| ping.sides[1].step_m),
            Column::wholes("ping", numbers),
            of_chunks("chunk", |chunk| chunk.number as i32),
            of_chunks("range_setting", |chunk| chunk.range_setting),
            of_chunks("gain_segment", |chunk| chunk.stretch as i32),
            of_rows("gain", &|row| chunk(row).map_or(f64::NAN, |chunk| chunk.gain)),
            Column::flags("weed", weed),
            Column::new("port", levels(Side::Port)),
            Column::new("starboard", levels(Side::Starboard)),
        ];
        columns.extend(log.common_columns(rows, times_s));
        columns
    }

    /// Returns the unit vector to starboard of a ping in the zone of the row.
    fn starboard(&self, log: &LogRows<'_>, row: &TileRow) -> [f64; 2] {
        let PingPlace { place_m, starboard, .. } = self.log.echoes.pings[row.index];
        let beside: LonLat = log.position(place_m[0] + starboard[0], place_m[1] + starboard[1]);
        let [x, y] = row.zone.to_metres(beside);
        let across = [x - row.place[0], y - row.place[1]];
        let length_m = across[0].hypot(across[1]);
        across.map(|part| part / length_m)
    }
}

/// A ping of an archive with its echoes.
pub(super) struct EchoRow {
    ping: i32,
    /// Chunk of the ping, with an empty range of pings; `None` for a ping in no chunk.
    chunk: Option<PingChunk>,
    is_weed: bool,
    velocity_mps: [f64; 2],
    place: PingPlace,
    /// Echo levels of each side, port first.
    levels: [Vec<u8>; 2],
}

/// The echoes of a log in some tiles.
#[derive(Default)]
pub(super) struct StoredEchoes {
    rows: Vec<EchoRow>,
    learnt: Option<LearntLevels>,
}

impl SampleSource for StoredEchoes {
    fn read(&self, ping: usize, side: Side, out: &mut Vec<u8>) {
        out.clear();
        if let Some(row) = self.rows.get(ping) {
            out.extend(&row.levels[usize::from(side == Side::Starboard)]);
        }
    }
}

impl StoredEchoes {
    /// Reads the pings of a log from some files and keeps those within a box (west, south, east and
    /// north, metres). Applies the height offset of the log and the correction of its positions;
    /// returns the pings in the order of the log.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub(super) fn read(
        paths: &[impl AsRef<Path>],
        log: &LogRecord,
        offsets: &Offsets,
        within_m: [f64; 4],
    ) -> Result<Self, Error> {
        let (shift, offset_m) = (offsets.shift_of(&log.log), offsets.of(&log.log));
        let mut rows = Vec::new();
        for path in paths {
            for mut row in read(path.as_ref())? {
                let place = &mut row.place;
                place.place_m = moved(place.place_m, shift, row.velocity_mps);
                // An offset is added to elevations, so it is subtracted from depths.
                place.transducer_m -= offset_m;
                if is_within(within_m, place.place_m) {
                    rows.push(row);
                }
            }
        }
        rows.sort_by_key(|row: &EchoRow| row.ping);
        Ok(Self { rows, learnt: log.levels.clone() })
    }

    /// Returns the echoes and the learnt levels that depths are computed from; `None` where the
    /// levels of the log cannot be used.
    pub(super) fn laid_out(&self) -> Option<(LaidOutLog<'_>, &LearntLevels)> {
        let learnt = self.learnt.as_ref()?;
        let mut chunks: Vec<PingChunk> = Vec::new();
        for (ping, row) in self.rows.iter().enumerate() {
            let Some(of_row) = &row.chunk else { continue };
            match chunks.last_mut() {
                Some(chunk) if chunk.number == of_row.number => chunk.pings.end = ping + 1,
                _ => chunks.push(PingChunk { pings: ping..ping + 1, ..of_row.clone() }),
            }
        }
        let log = LaidOutLog {
            echoes: LogEchoes {
                levels: self,
                pings: self.rows.iter().map(|row| row.place).collect(),
            },
            chunks,
            law: Some(learnt.law),
            is_weed: self.rows.iter().map(|row| row.is_weed).collect(),
        };
        Some((log, learnt))
    }
}

const NUMBERS: [&str; 13] = [
    "x",
    "y",
    "starboard_x",
    "starboard_y",
    "velocity_x_mps",
    "velocity_y_mps",
    "transducer_m",
    "time_s",
    "port_near_m",
    "port_sample_m",
    "starboard_near_m",
    "starboard_sample_m",
    "gain",
];
const OTHERS: [&str; 7] =
    ["ping", "chunk", "range_setting", "gain_segment", "weed", "port", "starboard"];

pub(super) fn read(path: &Path) -> Result<Vec<EchoRow>, Error> {
    let damaged = || log_rows::damaged("its columns are not those of echoes of an archive", path);
    let (numbers, others) = log_rows::columns(path, &NUMBERS, &OTHERS)?.ok_or_else(damaged)?;
    let [
        Values::Whole(pings),
        Values::Whole(chunks),
        Values::Whole(settings),
        Values::Whole(segments),
        Values::Flag(weed),
        Values::Bytes(port),
        Values::Bytes(starboard),
    ] = others
    else {
        return Err(damaged());
    };
    let levels = port.into_iter().zip(starboard);
    let row = |(index, (port, starboard)): (usize, (Vec<u8>, Vec<u8>))| {
        let number = |column: usize| numbers[column][index];
        let side = |near: usize| SideEchoes {
            near_m: number(near),
            step_m: number(near + 1),
            // Depths that depend on the first return were computed from the whole log before.
            first_return: f64::NAN,
            above_bottom: false,
        };
        let chunk = match (chunks[index], settings[index], segments[index]) {
            (Some(chunk), Some(range_setting), Some(segment)) => Some(PingChunk {
                number: u32::try_from(chunk).ok()?,
                pings: 0..0,
                range_setting,
                stretch: u32::try_from(segment).ok()?,
                gain: number(12),
            }),
            _ => None,
        };
        Some(EchoRow {
            ping: pings[index]?,
            chunk,
            is_weed: weed[index],
            velocity_mps: [number(4), number(5)],
            place: PingPlace {
                time_s: number(7),
                place_m: [number(0), number(1)],
                starboard: [number(2), number(3)],
                transducer_m: number(6),
                sides: [side(8), side(10)],
            },
            levels: [port, starboard],
        })
    };
    let rows = levels.enumerate().map(row).collect::<Option<_>>();
    rows.ok_or_else(damaged)
}
