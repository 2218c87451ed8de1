//! Writes and reads the side-scan pings of a log, a row for each ping in every tile whose ground it
//! insonified: `pings/tile=.../SHA256.parquet`. From these rows the ping, side and sample that
//! insonified a place are found without the log.

use super::footprint::{Footprint, SideRange};
use super::log_rows::{self, LogRows, RowsByTile, TileRow};
use super::tile::TileId;
use crate::Error;
use bathyscope_bottom::mosaic::joined_way_m;
use bathyscope_log::formats::parquet_table::{Column, Values};
use bathyscope_log::support::geo::{LonLat, UtmZone};
use bathyscope_log::survey::{Side, SideSpan};
use std::collections::BTreeMap;
use std::path::Path;

/// Length over which the direction to starboard is computed in the zone, metres.
const PROBE_M: f64 = 20.0;
/// Length of the footprint ahead of and behind a ping without a neighbour, metres.
const ALONE_M: f64 = 0.5;

/// Footprint of a ping before it is placed in a zone.
struct Ping {
    index: usize,
    at: LonLat,
    /// Place to starboard of the boat, [`PROBE_M`] away.
    probe: LonLat,
    altitude_m: f64,
    behind_m: f64,
    ahead_m: f64,
    sides: [Option<SideRange>; 2],
}

/// Rows of pings and their footprints, by tile of the insonified ground.
pub(super) struct PingsByTile {
    /// Rows by tile; the core flag is set in the tile of the boat itself.
    pub rows: RowsByTile,
    /// Footprints of the rows, in the same order.
    pub footprints: BTreeMap<TileId, Vec<Footprint>>,
    /// Number of pings with a place and a heading.
    pub count: usize,
}

/// Assigns the pings of a log to the tiles that they insonified. Pings without a place or a heading
/// are dropped: the ground that they insonified is not known.
pub(super) fn by_tile(log: &LogRows<'_>) -> PingsByTile {
    let altitudes_m = altitudes_m(log);
    let halves_m = halves_m(log);
    let pings = (0..log.survey.side_scan.len()).filter_map(|index| {
        let boat = log.products.navigation.pings.get(index)?;
        let [x, y] = boat.starboard()?;
        let place = |out_m: f64| log.position(boat.east_m + out_m * x, boat.north_m + out_m * y);
        let [behind_m, ahead_m] = *halves_m.get(index)?;
        Some(Ping {
            index,
            at: place(0.0),
            probe: place(PROBE_M),
            altitude_m: *altitudes_m.get(index)?,
            behind_m,
            ahead_m,
            sides: Side::BOTH
                .map(|side| log.survey.span(index, side).map(|span| side_range(log, span))),
        })
    });
    let mut made = PingsByTile { rows: RowsByTile::new(), footprints: BTreeMap::new(), count: 0 };
    for ping in pings {
        made.count += 1;
        made.add(&ping);
    }
    made
}

impl PingsByTile {
    fn add(&mut self, ping: &Ping) {
        let far = |side: &SideRange| side.near_m + side.sample_m * f64::from(side.count);
        let reach_m = ping.sides.iter().flatten().map(far).fold(0.0, f64::max);
        for (rank, zone) in UtmZone::near(ping.at, reach_m).into_iter().enumerate() {
            let footprint = ping.in_zone(zone);
            let Some(bounds) =
                footprint.bounds_m().filter(|bounds| bounds.iter().all(|m| m.is_finite()))
            else {
                continue;
            };
            let own = (rank == 0).then(|| TileId::at(zone, footprint.place));
            for tile in TileId::touched(zone, bounds) {
                self.rows.entry(tile).or_default().push(TileRow {
                    index: ping.index,
                    at: ping.at,
                    zone,
                    place: footprint.place,
                    is_core: own == Some(tile),
                });
                self.footprints.entry(tile).or_default().push(footprint);
            }
        }
    }
}

impl Ping {
    fn in_zone(&self, zone: UtmZone) -> Footprint {
        let place = zone.to_metres(self.at);
        let probe = zone.to_metres(self.probe);
        Footprint {
            place,
            starboard: [0, 1].map(|axis| (probe[axis] - place[axis]) / PROBE_M),
            altitude_m: self.altitude_m,
            behind_m: self.behind_m,
            ahead_m: self.ahead_m,
            sides: self.sides,
        }
    }
}

fn side_range(log: &LogRows<'_>, span: &SideSpan) -> SideRange {
    let reduction = log.products.reduction();
    let near_m = reduction.range_m(span, 0.0);
    SideRange {
        near_m,
        // Every scale is linear in the sample.
        sample_m: reduction.range_m(span, 1.0) - near_m,
        count: i32::try_from(span.count).unwrap_or(i32::MAX),
    }
}

/// Returns the altitude of the transducer at every ping. Where no depth is known, the altitude of
/// the last ping before is used, or that of the first ping with a depth; 0 in a log without any
/// depth.
fn altitudes_m(log: &LogRows<'_>) -> Vec<f64> {
    let pings = log.survey.side_scan.iter().zip(log.products.depths.iter());
    let known: Vec<f64> = pings
        .map(|(ping, depth)| {
            let surface_m = log.products.correction.depth_m(ping.time_s, 0.0);
            f64::from(depth.depth_m) - surface_m
        })
        .collect();
    let first = known.iter().copied().find(|metres| metres.is_finite());
    let mut last_m = first.unwrap_or(0.0);
    let filled = known.into_iter().map(|metres| {
        if metres.is_finite() {
            last_m = metres;
        }
        last_m.max(0.0)
    });
    filled.collect()
}

/// Returns half of the distances to the pings before and behind, metres; where one of these pings
/// is not joined, half of the distance to the other.
fn halves_m(log: &LogRows<'_>) -> Vec<[f64; 2]> {
    let half_m = |from: usize| {
        let way_m = joined_way_m(log.survey, &log.products.navigation, from)?;
        Some(0.5 * way_m)
    };
    let of_ping = |ping: usize| {
        let behind = ping.checked_sub(1).and_then(half_m);
        let ahead = half_m(ping);
        let alone = behind.or(ahead).unwrap_or(ALONE_M);
        [behind.unwrap_or(alone), ahead.unwrap_or(alone)]
    };
    (0..log.survey.side_scan.len()).map(of_ping).collect()
}

/// Returns the columns of the rows of pings in a tile.
pub(super) fn columns(
    log: &LogRows<'_>,
    rows: &[TileRow],
    footprints: &[Footprint],
) -> Vec<Column> {
    let of = |name: &'static str, value: fn(&Footprint) -> f64| {
        Column::doubles(name, footprints.iter().map(value))
    };
    let side = |name: &'static str, side: usize, value: fn(&SideRange) -> f64| {
        let ranges = footprints.iter().map(move |ping| ping.sides[side].as_ref());
        Column::doubles(name, ranges.map(move |range| range.map_or(f64::NAN, value)))
    };
    let samples = |name: &'static str, side: usize| {
        let ranges = footprints.iter().map(move |ping| ping.sides[side]);
        Column::wholes(name, ranges.map(|range| Some(range?.count)))
    };
    let times_s: Vec<f64> = rows.iter().map(|row| log.survey.side_scan[row.index].time_s).collect();
    let depths_m = (rows.iter()).map(|row| f64::from(log.products.depths[row.index].depth_m));
    let numbers = rows.iter().map(|row| i32::try_from(row.index).ok());
    let excluded = (rows.iter()).map(|row| log.products.exclusions.ping(row.index).is_some());
    let mut columns = vec![
        log_rows::geometry(rows),
        of("x", |ping| ping.place[0]),
        of("y", |ping| ping.place[1]),
        of("starboard_x", |ping| ping.starboard[0]),
        of("starboard_y", |ping| ping.starboard[1]),
        of("altitude_m", |ping| ping.altitude_m),
        Column::doubles("depth_m", depths_m),
        of("behind_m", |ping| ping.behind_m),
        of("ahead_m", |ping| ping.ahead_m),
        side("port_near_m", 0, |range| range.near_m),
        side("port_sample_m", 0, |range| range.sample_m),
        samples("port_samples", 0),
        side("starboard_near_m", 1, |range| range.near_m),
        side("starboard_sample_m", 1, |range| range.sample_m),
        samples("starboard_samples", 1),
        Column::wholes("ping", numbers),
        // True if the settings exclude the ping. The column keeps its old name: archives hold files
        // of many years.
        Column::flags("left_out", excluded),
    ];
    columns.extend(log.common_columns(rows, times_s));
    columns
}

/// A ping of an archive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PingRow {
    /// Index of the ping in the log.
    pub ping: i32,
    /// Footprint of the ping.
    pub footprint: Footprint,
    /// Depth under the ping as the log has it, metres; NaN where none is known.
    pub depth_m: f64,
    /// True if the settings exclude the ping.
    pub is_excluded: bool,
    /// Time of the ping, seconds after the log's time zero.
    pub time_s: f64,
    /// Time of the ping, microseconds since 1970, UTC; `None` where it is not known.
    pub unix_us: Option<i64>,
}

/// Names of the columns of numbers that are read.
const NUMBERS: [&str; 13] = [
    "x",
    "y",
    "starboard_x",
    "starboard_y",
    "altitude_m",
    "depth_m",
    "behind_m",
    "ahead_m",
    "port_near_m",
    "port_sample_m",
    "starboard_near_m",
    "starboard_sample_m",
    "time_s",
];

/// Names of the other columns that are read.
const OTHERS: [&str; 5] = ["port_samples", "starboard_samples", "ping", "left_out", "time"];

/// Reads the rows of a file, in the order of the log.
///
/// # Errors
/// When the file cannot be read, or its columns are not those of pings.
pub(super) fn read(path: &Path) -> Result<Vec<PingRow>, Error> {
    let damaged = || log_rows::damaged("its columns are not those of pings of an archive", path);
    let (numbers, others) = log_rows::columns(path, &NUMBERS, &OTHERS)?.ok_or_else(damaged)?;
    let [
        Values::Whole(port),
        Values::Whole(starboard),
        Values::Whole(pings),
        Values::Flag(excluded),
        Values::Time(times),
    ] = others
    else {
        return Err(damaged());
    };
    let row = |index: usize| {
        let number = |column: usize| numbers[column][index];
        // A side without a number of samples was not recorded.
        let side = |near: usize, samples: &[Option<i32>]| {
            Some(SideRange {
                near_m: number(near),
                sample_m: number(near + 1),
                count: samples[index]?,
            })
        };
        Some(PingRow {
            ping: pings[index]?,
            footprint: Footprint {
                place: [number(0), number(1)],
                starboard: [number(2), number(3)],
                altitude_m: number(4),
                behind_m: number(6),
                ahead_m: number(7),
                sides: [side(8, &port), side(10, &starboard)],
            },
            depth_m: number(5),
            is_excluded: excluded[index],
            time_s: number(12),
            unix_us: times[index],
        })
    };
    let rows = (0..pings.len()).map(row).collect::<Option<_>>();
    rows.ok_or_else(damaged)
}
