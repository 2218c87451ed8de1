//! Finds the recordings that cover a place or an area: every log, ping, side and sample, from the
//! rows of pings of the tiles concerned.

use super::PINGS;
use super::log_record::LogRecord;
use super::offsets::{Offsets, moved};
use super::ping_rows::{self, CoveredSamples, Footprint, PingRow, SideRange};
use super::record::{Archive, MOST_MOVED_M};
use super::tile::{TileId, beside};
use crate::Error;
use bathyscope_bottom::bathymetry::crosslines::{TrackDepth, velocity_mps};
use bathyscope_bottom::bathymetry::position_offsets::Shift;
use bathyscope_log::support::geo::{LonLat, UtmZone};
use bathyscope_log::support::outline::{between, bounds, boxes_meet, goes_around};
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

/// Closed rings in the metres of a zone. A place is in the area if an odd number of rings go around
/// it; an island is therefore a further ring.
#[derive(Clone, Debug, PartialEq)]
struct Area {
    rings: Vec<Vec<[f64; 2]>>,
    /// West, south, east and north.
    bounds_m: [f64; 4],
}

impl Area {
    /// Creates an area from rings of corners, each corner named once; `None` without a corner.
    fn new(zone: UtmZone, rings: &[Vec<LonLat>]) -> Option<Self> {
        let closed = |ring: &Vec<LonLat>| {
            let corners = ring.iter().chain(ring.first());
            corners.map(|at| zone.to_metres(*at)).collect()
        };
        Self::of(rings.iter().map(closed).collect())
    }

    fn of(rings: Vec<Vec<[f64; 2]>>) -> Option<Self> {
        let corners = || rings.iter().flatten().copied();
        corners().next()?;
        Some(Self { bounds_m: bounds(corners()), rings })
    }

    /// Returns the samples of each side of a ping, port first, that lie in the area, from the
    /// nearest to the farthest. The footprint of a side is a rectangle next to the boat; its
    /// overlap with the area ends at corners of the area, at corners of the rectangle, and where
    /// their edges cross.
    fn seen_by(&self, ping: &Footprint) -> [Option<CoveredSamples>; 2] {
        let local = |ring: &Vec<[f64; 2]>| ring.iter().map(|at| ping.on_ground(*at)).collect();
        let rings: Vec<Vec<[f64; 2]>> = self.rings.iter().map(local).collect();
        let seen = |side: &SideRange, sign: f64| {
            let [near_m, far_m] = side.ground_m(ping.altitude_m)?;
            let across = [sign * near_m, sign * far_m];
            let along = [-ping.behind_m, ping.ahead_m];
            let ground = [across[0].min(across[1]), along[0], across[0].max(across[1]), along[1]];
            let is_within = |place: &[f64; 2]| {
                rings.iter().filter(|ring| goes_around(ring, *place)).count() % 2 == 1
            };
            let corners = across.iter().flat_map(|x| along.map(|y| [*x, y]));
            let edges = rings.iter().flat_map(|ring| ring.windows(2));
            let crossed = edges.filter_map(|edge| inside(edge[0], edge[1], ground)).flatten();
            let reached = corners.filter(is_within).chain(crossed);
            let reached_m = reached.map(|[x, _]| [(sign * x).max(near_m); 2]);
            let ends_m = reached_m.reduce(|[a, b], [from, to]| [a.min(from), b.max(to)]);
            Some(side.seen(ping.altitude_m, ends_m?, 0.0))
        };
        [0, 1].map(|side| seen(ping.sides[side].as_ref()?, [-1.0, 1.0][side]))
    }
}

/// Returns the ends of the part of a line that lies in a rectangle (west, south, east and north),
/// after Liang and Barsky 1984; `None` if no part does.
fn inside(from: [f64; 2], to: [f64; 2], ground: [f64; 4]) -> Option<[[f64; 2]; 2]> {
    let mut shares = [0.0_f64, 1.0];
    for axis in 0..2 {
        let way = to[axis] - from[axis];
        let ends = [ground[axis], ground[axis + 2]].map(|end| end - from[axis]);
        if way == 0.0 {
            if ends[0] > 0.0 || ends[1] < 0.0 {
                return None;
            }
            continue;
        }
        let [a, b] = ends.map(|end| end / way);
        shares = [shares[0].max(a.min(b)), shares[1].min(a.max(b))];
    }
    (shares[0] <= shares[1]).then(|| shares.map(|share| between(from, to, share)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heads north-east over 3 m of water.
    fn ping() -> Footprint {
        let half = 0.5_f64.sqrt();
        Footprint {
            place: [100.0, 50.0],
            starboard: [half, -half],
            altitude_m: 3.0,
            behind_m: 0.4,
            ahead_m: 0.6,
            sides: [Some(SideRange { near_m: 0.0, sample_m: 0.05, count: 300 }); 2],
        }
    }

    fn closed(mut ring: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        ring.push(ring[0]);
        ring
    }

    #[test]
    fn the_samples_of_an_area_are_those_of_all_places_in_it() {
        let ping = ping();
        // Areas around the boat, beside it with an island, at a corner of its footprint, around the
        // whole footprint, and away from the footprint.
        let square = |x: f64, y: f64, half: f64| {
            closed(vec![
                [x - half, y - half],
                [x + half, y - half],
                [x + half, y + half],
                [x - half, y + half],
            ])
        };
        let areas = [
            vec![square(100.0, 50.0, 2.0)],
            vec![square(104.0, 46.0, 2.5), square(104.0, 46.0, 1.7)],
            vec![closed(vec![[93.0, 50.0], [99.0, 52.5], [95.0, 58.0]])],
            vec![square(100.0, 50.0, 60.0)],
            vec![square(140.0, 50.0, 3.0)],
        ];
        for rings in areas {
            let area = Area::of(rings.clone()).expect("corners");
            let [west, south, east, north] = area.bounds_m.map(|end| end.clamp(20.0, 180.0));
            let mut samples: [Option<[i32; 2]>; 2] = [None; 2];
            let steps = |from: f64, to: f64| {
                (0..=400).map(move |k| from + (to - from) * f64::from(k) / 400.0)
            };
            for x in steps(west, east) {
                for y in steps(south, north) {
                    if rings.iter().filter(|ring| goes_around(ring, [x, y])).count() % 2 == 0 {
                        continue;
                    }
                    for (side, seen) in ping.seen([x, y], 0.0).into_iter().enumerate() {
                        if let Some(seen) = seen {
                            let [least, most] = samples[side].unwrap_or([seen.samples[0]; 2]);
                            let [from, to] = seen.samples;
                            samples[side] = Some([least.min(from), most.max(to)]);
                        }
                    }
                }
            }
            for (found, expected) in area.seen_by(&ping).into_iter().zip(samples) {
                assert_eq!(found.is_some(), expected.is_some(), "{rings:?}");
                if let (Some(found), Some(expected)) = (found, expected) {
                    // Steps of up to 0.3 m are six samples.
                    for (a, b) in found.samples.iter().zip(expected) {
                        assert!(a.abs_diff(b) < 7, "{:?} {expected:?} {rings:?}", found.samples);
                    }
                    assert!(found.samples[0] <= expected[0] && found.samples[1] >= expected[1]);
                }
            }
        }
    }
}
