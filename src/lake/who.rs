//! Which recording saw this place: every log, ping, side and sample, from the rows of pings of the tiles concerned.

use super::error::LakeError;
use super::footprint::Seen;
use super::log_record::LogRecord;
use super::ping_rows::{self, PINGS, PingRow};
use super::record::Lake;
use super::tile::TileId;
use crate::geo::{LonLat, UtmZone};
use crate::progress::Progress;
use crate::survey::Side;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A side of a ping that saw a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Sighting {
    /// SHA-256 of the log.
    pub log: String,
    /// What the log is called.
    pub name: String,
    /// Which side-scan ping of it.
    pub ping: i32,
    /// Which side.
    pub side: Side,
    /// Sample, slant range and distance.
    pub seen: Seen,
    /// Seconds after the log's time zero.
    pub time_s: f64,
    /// Microseconds since 1970, UTC, where the recorder knew the time.
    pub unix_us: Option<i64>,
    /// Whether the settings leave the ping out of every result.
    pub is_left_out: bool,
}

/// Rows of pings that may have seen a place: a file, and the place in its zone.
struct Search<'a> {
    log: &'a LogRecord,
    tile: TileId,
    place: [f64; 2],
}

/// The sides of pings that saw ground within `radius_m` of a place, by log, ping and side. Each is told once, as it is nearest.
///
/// # Errors
/// When rows cannot be read, or the work was cancelled.
pub fn who(
    lake: &Lake,
    at: LonLat,
    radius_m: f64,
    progress: &Progress,
) -> Result<Vec<Sighting>, LakeError> {
    let zones = UtmZone::near(at, radius_m).into_iter().map(|zone| {
        let [x, y] = zone.to_metres(at);
        (
            zone,
            [x, y],
            [x - radius_m, y - radius_m, x + radius_m, y + radius_m],
        )
    });
    let zones: Vec<_> = zones.collect();
    let tiles = zones
        .iter()
        .flat_map(|(zone, _, around)| TileId::touched(*zone, *around));
    let logs = lake.logs_in(tiles)?;
    let mut searches = Vec::new();
    for (zone, place, around) in zones {
        for tile in TileId::touched(zone, around) {
            let rows = logs
                .iter()
                .filter_map(|log| Some((log, log.rows_in(tile)?)));
            let seen = rows.filter(|(_, rows)| {
                let saw = <[f64; 4]>::try_from(rows.seen_m.as_slice());
                rows.pings > 0 && saw.is_ok_and(|saw| touch(around, saw))
            });
            searches.extend(seen.map(|(log, _)| Search { log, tile, place }));
        }
    }
    progress.start(searches.len() as u64);
    let found = searches.par_iter().map(|search| {
        progress.check()?;
        let name = Lake::rows_name(PINGS, search.tile, &search.log.log);
        let pings = ping_rows::read(&lake.folder().join(name))?;
        progress.advance(1);
        Ok(sightings(search, &pings, radius_m))
    });
    let found: Vec<Vec<Sighting>> = found.collect::<Result<_, LakeError>>()?;
    // A ping stands in every tile whose ground it saw.
    let mut nearest: BTreeMap<(String, String, i32, Side), Sighting> = BTreeMap::new();
    for one in found.into_iter().flatten() {
        let key = (one.name.clone(), one.log.clone(), one.ping, one.side);
        match nearest.get(&key) {
            Some(known) if known.seen.distance_m <= one.seen.distance_m => {}
            _ => {
                nearest.insert(key, one);
            }
        }
    }
    Ok(nearest.into_values().collect())
}

/// Whether two boxes touch; west, south, east and north.
fn touch(a: [f64; 4], b: [f64; 4]) -> bool {
    a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]
}

fn sightings(search: &Search<'_>, pings: &[PingRow], radius_m: f64) -> Vec<Sighting> {
    let mut found = Vec::new();
    for ping in pings {
        for (side, seen) in Side::BOTH
            .into_iter()
            .zip(ping.footprint.seen(search.place, radius_m))
        {
            found.extend(seen.map(|seen| Sighting {
                log: search.log.log.clone(),
                name: search.log.name.clone(),
                ping: ping.ping,
                side,
                seen,
                time_s: ping.time_s,
                unix_us: ping.unix_us,
                is_left_out: ping.is_left_out,
            }));
        }
    }
    found
}
