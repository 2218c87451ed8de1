//! Writes and reads the side-scan pings of a log, a row for each ping in every tile whose ground it
//! insonified: `pings/tile=.../SHA256.parquet`. From these rows the ping, side and sample that
//! insonified a place are found without the log: a row has the footprint of its ping, the ground
//! that the ping insonified.

use super::log_rows::{self, LogRows, RowsByTile, TileRow};
use super::tile::TileId;
use crate::Error;
use bathyscope_bottom::mosaic::joined_way_m;
use bathyscope_log::formats::parquet_table::{Column, Values};
use bathyscope_log::support::geo::UtmZone;
use bathyscope_log::support::outline::box_around;
use bathyscope_log::survey::{Side, SideSpan};
use std::collections::BTreeMap;
use std::path::Path;

/// Length over which the direction to starboard is computed in the zone, metres.
const PROBE_M: f64 = 20.0;
/// Length of the footprint ahead of and behind a ping without a neighbour, metres.
const ALONE_M: f64 = 0.5;

/// Slant ranges that one side of a ping recorded, calibrated, with the true speed of sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SideRange {
    /// Slant range at the near edge of the first sample, metres.
    pub near_m: f64,
    /// Slant range that each sample adds, metres.
    pub sample_m: f64,
    /// Number of samples.
    pub count: i32,
}

/// Footprint of a ping over level ground, in the metres of a zone. Across the track a sample of
/// slant range `r` lies `sqrt(r^2 - a^2)` from the boat, where `a` is the altitude; along the track
/// the footprint reaches half way to the pings before and behind, as in the mosaic. The width of
/// the beam is ignored: it is wider than the distance between two pings, and the ground that it
/// adds is the footprint of the neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footprint {
    /// Place of the transducer, metres of the zone.
    pub place: [f64; 2],
    /// Vector in the zone that is one metre on the bottom to starboard.
    pub starboard: [f64; 2],
    /// Height of the transducer over the ground, metres.
    pub altitude_m: f64,
    /// Length of the footprint backward along the track, metres.
    pub behind_m: f64,
    /// Length of the footprint forward along the track, metres.
    pub ahead_m: f64,
    /// Slant ranges of port and starboard; `None` for a side that was not recorded.
    pub sides: [Option<SideRange>; 2],
}

/// Samples of one side of a ping that cover a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredSamples {
    /// First and last of the samples in the place or nearest to it, counted outward from 0; for a
    /// single point both are the same sample.
    pub samples: [i32; 2],
    /// Slant range of the first of these samples, metres.
    pub range_m: f64,
    /// Distance from the place to the insonified ground, metres; 0 within it.
    pub distance_m: f64,
}

impl SideRange {
    /// Returns the slant range at the far edge of the last sample, metres.
    fn far_m(&self) -> f64 {
        self.near_m + self.sample_m * f64::from(self.count)
    }

    /// Returns the across-track distances on the bottom of the first and the last sample; `None`
    /// where all samples are of water.
    pub(super) fn ground_m(&self, altitude_m: f64) -> Option<[f64; 2]> {
        let far_m = self.far_m();
        let ground = |range_m: f64| (range_m * range_m - altitude_m * altitude_m).max(0.0).sqrt();
        let is_known = self.sample_m > 0.0 && self.count > 0 && far_m > altitude_m;
        is_known.then(|| [ground(self.near_m.max(0.0)), ground(far_m)])
    }

    /// Returns the samples between two across-track distances on the bottom.
    pub(super) fn seen(
        &self,
        altitude_m: f64,
        across_m: [f64; 2],
        distance_m: f64,
    ) -> CoveredSamples {
        let ranges_m = across_m.map(|across_m| across_m.hypot(altitude_m));
        let sample = |range_m: f64| {
            let sample = ((range_m - self.near_m) / self.sample_m).floor() as i32;
            sample.clamp(0, self.count - 1)
        };
        CoveredSamples { samples: ranges_m.map(sample), range_m: ranges_m[0], distance_m }
    }
}

impl Footprint {
    /// Returns the samples of each side, port first, that cover a place of the zone; `None` for a
    /// side whose footprint is farther from the place than `radius_m`.
    pub(super) fn seen(&self, place: [f64; 2], radius_m: f64) -> [Option<CoveredSamples>; 2] {
        let [to_starboard_m, forward_m] = self.on_ground(place);
        let along_m = forward_m.clamp(-self.behind_m, self.ahead_m);
        let seen = |side: &SideRange, out_m: f64| {
            let [near_m, far_m] = side.ground_m(self.altitude_m)?;
            let across_m = out_m.clamp(near_m, far_m);
            let distance_m = (out_m - across_m).hypot(forward_m - along_m);
            (distance_m <= radius_m).then(|| side.seen(self.altitude_m, [across_m; 2], distance_m))
        };
        let outward_m = [-to_starboard_m, to_starboard_m];
        [0, 1].map(|side| seen(self.sides[side].as_ref()?, outward_m[side]))
    }

    /// Returns the distance of a place to starboard of and forward of the transducer, metres on the
    /// ground.
    pub(super) fn on_ground(&self, place: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| place[axis] - self.place[axis]);
        let [east, north] = self.starboard;
        let scale = east * east + north * north;
        [(x * east + y * north) / scale, (y * east - x * north) / scale]
    }

    /// Returns the west, south, east and north edge of all insonified ground, metres of the zone;
    /// `None` where the ping insonified none.
    pub(super) fn bounds_m(&self) -> Option<[f64; 4]> {
        let [east, north] = self.starboard;
        let corner = |out_m: f64, along_m: f64| {
            [
                self.place[0] + out_m * east - along_m * north,
                self.place[1] + out_m * north + along_m * east,
            ]
        };
        let reaches = self.sides.iter().zip([-1.0, 1.0]).filter_map(|(side, sign)| {
            let [near_m, far_m] = side.as_ref()?.ground_m(self.altitude_m)?;
            Some([sign * near_m, sign * far_m])
        });
        let corners = reaches
            .flatten()
            .flat_map(|out_m| [-self.behind_m, self.ahead_m].map(|along_m| corner(out_m, along_m)));
        corners.map(|[x, y]| [x, y, x, y]).reduce(box_around)
    }
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
    let mut made = PingsByTile { rows: RowsByTile::new(), footprints: BTreeMap::new(), count: 0 };
    let (altitudes_m, halves_m) = (altitudes_m(log), halves_m(log));
    let boats = log.products.navigation.pings.iter().zip(altitudes_m).zip(halves_m);
    for (index, ((boat, altitude_m), [behind_m, ahead_m])) in boats.enumerate() {
        let Some([x, y]) = boat.starboard() else {
            continue;
        };
        made.count += 1;
        let [at, probe] = [0.0, PROBE_M]
            .map(|out_m| log.position(boat.east_m + out_m * x, boat.north_m + out_m * y));
        let sides =
            Side::BOTH.map(|side| log.survey.span(index, side).map(|span| side_range(log, span)));
        let reach_m = sides.iter().flatten().map(SideRange::far_m).fold(0.0, f64::max);
        for (rank, zone) in UtmZone::near(at, reach_m).into_iter().enumerate() {
            let (place, probe) = (zone.to_metres(at), zone.to_metres(probe));
            let footprint = Footprint {
                place,
                starboard: [0, 1].map(|axis| (probe[axis] - place[axis]) / PROBE_M),
                altitude_m,
                behind_m,
                ahead_m,
                sides,
            };
            let Some(bounds) =
                footprint.bounds_m().filter(|bounds| bounds.iter().all(|m| m.is_finite()))
            else {
                continue;
            };
            let own = (rank == 0).then(|| TileId::at(zone, place));
            for tile in TileId::touched(zone, bounds) {
                made.rows.entry(tile).or_default().push(TileRow {
                    index,
                    at,
                    zone,
                    place,
                    is_core: own == Some(tile),
                });
                made.footprints.entry(tile).or_default().push(footprint);
            }
        }
    }
    made
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

#[cfg(test)]
mod tests {
    use super::*;

    fn heading_east() -> Footprint {
        Footprint {
            place: [100.0, 50.0],
            starboard: [0.0, -1.0],
            altitude_m: 3.0,
            behind_m: 0.2,
            ahead_m: 0.3,
            sides: [Some(SideRange { near_m: 0.0, sample_m: 0.05, count: 400 }); 2],
        }
    }

    #[test]
    fn a_place_to_port_is_seen_at_its_slant_range_and_between_the_neighbours_only() {
        let ping = heading_east();
        // Port is north: 4 m out and 3 m up give 5 m of slant range, the hundredth sample.
        let [port, starboard] = ping.seen([100.1, 54.0], 0.0);
        let port = port.unwrap();
        assert_eq!((port.samples, port.distance_m), ([100; 2], 0.0));
        assert!((port.range_m - 5.0).abs() < 1e-12 && starboard.is_none());
        assert_eq!(ping.seen([100.4, 54.0], 0.0), [None; 2]);
        assert_eq!(ping.seen([99.7, 54.0], 0.0), [None; 2]);
        assert_eq!(ping.seen([100.0, 70.0], 0.0), [None; 2], "beyond 19.77 m");
        let [near, _] = ping.seen([101.0, 54.0], 0.71);
        assert!((near.unwrap().distance_m - 0.7).abs() < 1e-9);
        let bounds = ping.bounds_m().unwrap();
        let out_m = (400.0_f64 - 9.0).sqrt();
        for (found, expected) in bounds.iter().zip([99.8, 50.0 - out_m, 100.3, 50.0 + out_m]) {
            assert!((found - expected).abs() < 1e-9, "{bounds:?}");
        }
    }

    #[test]
    fn a_side_that_ends_in_the_water_saw_no_ground() {
        let short = Some(SideRange { near_m: 0.0, sample_m: 0.05, count: 50 });
        let ping = Footprint { sides: [short, None], ..heading_east() };
        assert_eq!(ping.seen([100.0, 50.0], 9.0), [None; 2]);
        assert_eq!(ping.bounds_m(), None);
    }
}
