//! Finds the recordings that cover a place: every log, ping, side and sample, from the rows of
//! pings of the tiles concerned.

use super::PINGS;
use super::area::Area;
use super::footprint::{CoveredSamples, Footprint};
use super::log_record::LogRecord;
use super::offsets::{Offsets, moved};
use super::ping_rows::{self, PingRow};
use super::record::{Archive, MOST_MOVED_M};
use super::tile::{TileId, beside};
use crate::Error;
use bathyscope_bottom::bathymetry::crosslines::{TrackDepth, velocity_mps};
use bathyscope_bottom::bathymetry::position_offsets::Shift;
use bathyscope_log::support::geo::{LonLat, UtmZone};
use bathyscope_log::support::outline::boxes_meet;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// A side of a ping that covers a place: it insonified the ground there.
#[derive(Clone, Debug, PartialEq)]
pub struct PingCoverage {
    /// SHA-256 of the log.
    pub log: String,
    /// Name of the log.
    pub name: String,
    /// Index of the side-scan ping in the log.
    pub ping: i32,
    /// Side of the ping.
    pub side: Side,
    /// Sample, slant range and distance.
    pub seen: CoveredSamples,
    /// Time of the ping, seconds after the log's time zero.
    pub time_s: f64,
    /// Time of the ping, microseconds since 1970, UTC; `None` where it is not known.
    pub unix_us: Option<i64>,
    /// True if the settings exclude the ping from every result.
    pub is_excluded: bool,
}

/// The place whose coverage is requested.
#[derive(Clone, Copy, Debug)]
pub enum CoverageQuery<'a> {
    /// All ground within a radius, metres, of a position.
    Around(LonLat, f64),
    /// All ground within rings of corners, each corner named once. A place is within if an odd
    /// number of rings go around it; an island is therefore a further ring.
    Within(&'a [Vec<LonLat>]),
}

/// Place whose coverage is requested, in the metres of one zone.
enum InZone {
    Around([f64; 2], f64),
    Within(Area),
}

impl CoverageQuery<'_> {
    /// Returns the zones that the place lies in, and the place in the metres of each zone.
    fn in_zones(&self) -> Vec<(UtmZone, InZone)> {
        match self {
            Self::Around(at, radius_m) => {
                let zones = UtmZone::near(*at, *radius_m).into_iter();
                let place = |zone: UtmZone| (zone, InZone::Around(zone.to_metres(*at), *radius_m));
                zones.map(place).collect()
            }
            Self::Within(rings) => {
                let corners = rings.iter().flatten();
                let zones: BTreeSet<UtmZone> = corners.map(|at| UtmZone::of(*at)).collect();
                let area = |zone| Some((zone, InZone::Within(Area::new(zone, rings)?)));
                zones.into_iter().filter_map(area).collect()
            }
        }
    }
}

impl InZone {
    /// Returns the west, south, east and north edge of the place, metres.
    fn bounds_m(&self) -> [f64; 4] {
        match self {
            Self::Around([x, y], radius_m) => beside([*x, *y, *x, *y], *radius_m),
            Self::Within(area) => area.bounds_m,
        }
    }

    fn seen_by(&self, ping: &Footprint) -> [Option<CoveredSamples>; 2] {
        match self {
            Self::Around(place, radius_m) => ping.seen(*place, *radius_m),
            Self::Within(area)
                if ping.bounds_m().is_some_and(|saw| boxes_meet(area.bounds_m, saw)) =>
            {
                area.seen_by(ping)
            }
            Self::Within(_) => [None; 2],
        }
    }
}

/// A file with rows of pings that may cover a place, and the place in the metres of its zone.
struct Search<'a> {
    log: &'a LogRecord,
    tile: TileId,
    place: &'a InZone,
    /// Correction of the positions of the log.
    shift: Shift,
}

/// Returns the sides of pings that cover ground of a place, by log, ping and side, with the
/// positions of each log corrected as for the depth maps. A side that several tiles list is
/// returned once, with its least distance.
///
/// # Errors
/// When rows cannot be read, or the work was cancelled.
pub fn coverage_at(
    archive: &Archive,
    asked: CoverageQuery<'_>,
    progress: &Progress,
) -> Result<Vec<PingCoverage>, Error> {
    let zones = asked.in_zones();
    // Rows are stored in the tiles of the ground at the positions as recorded, without the
    // correction.
    let around = |place: &InZone| beside(place.bounds_m(), MOST_MOVED_M);
    let tiles = zones.iter().flat_map(|(zone, place)| TileId::touched(*zone, around(place)));
    let logs = archive.logs_in(tiles)?;
    let offsets = Offsets::read(archive)?;
    let mut searches = Vec::new();
    for (zone, place) in &zones {
        let around = around(place);
        for tile in TileId::touched(*zone, around) {
            let rows = logs.iter().filter_map(|log| Some((log, log.rows_in(tile)?)));
            let seen = rows.filter(|(_, rows)| {
                let saw = <[f64; 4]>::try_from(rows.seen_m.as_slice());
                rows.pings > 0 && saw.is_ok_and(|saw| boxes_meet(around, saw))
            });
            searches.extend(seen.map(|(log, _)| Search {
                log,
                tile,
                place,
                shift: offsets.shift_of(&log.log),
            }));
        }
    }
    progress.start(searches.len() as u64);
    let found = searches.par_iter().map(|search| {
        progress.check()?;
        let path = archive.rows_path(PINGS, search.tile, &search.log.log);
        let mut pings = ping_rows::read(&path)?;
        correct(&mut pings, search.shift);
        progress.advance(1);
        Ok(sightings(search, &pings))
    });
    let found: Vec<Vec<PingCoverage>> = found.collect::<Result<_, Error>>()?;
    // A ping has a row in every tile whose ground it insonified, with the same footprint.
    let mut nearest: BTreeMap<(String, String, i32, Side), PingCoverage> = BTreeMap::new();
    for sighting in found.into_iter().flatten() {
        let key = (sighting.name.clone(), sighting.log.clone(), sighting.ping, sighting.side);
        match nearest.get(&key) {
            Some(known) if known.seen.distance_m <= sighting.seen.distance_m => {}
            _ => {
                nearest.insert(key, sighting);
            }
        }
    }
    Ok(nearest.into_values().collect())
}

/// Moves pings to the corrected positions of the boat.
fn correct(pings: &mut [PingRow], shift: Shift) {
    if shift == Shift::default() {
        return;
    }
    let place = |ping: &PingRow| TrackDepth::new(ping.time_s, ping.footprint.place, 0.0);
    let track: Vec<TrackDepth> = pings.iter().map(place).collect();
    for (index, ping) in pings.iter_mut().enumerate() {
        let velocity_mps = velocity_mps(&track, index);
        ping.footprint.place = moved(ping.footprint.place, shift, velocity_mps);
    }
}

fn sightings(search: &Search<'_>, pings: &[PingRow]) -> Vec<PingCoverage> {
    let mut found = Vec::new();
    for ping in pings {
        let seen = search.place.seen_by(&ping.footprint);
        for (side, seen) in Side::BOTH.into_iter().zip(seen) {
            found.extend(seen.map(|seen| PingCoverage {
                log: search.log.log.clone(),
                name: search.log.name.clone(),
                ping: ping.ping,
                side,
                seen,
                time_s: ping.time_s,
                unix_us: ping.unix_us,
                is_excluded: ping.is_excluded,
            }));
        }
    }
    found
}
