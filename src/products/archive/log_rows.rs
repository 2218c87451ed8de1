//! Holds a log while its rows are made and assigned to tiles.

use super::tile::{TileId, beside};
use crate::Error;
use crate::pipeline::Products;
use bathyscope_bottom::bathymetry::crosslines::{TrackDepth, velocity_mps};
use bathyscope_bottom::cloud::{CloudPoint, PointClass};
use bathyscope_log::formats::parquet_table::{Column, Values, read_parquet};
use bathyscope_log::support::file_error::{FaultText, FileError};
use bathyscope_log::support::geo::{LonLat, UtmZone};
use bathyscope_log::survey::{PingNav, Survey};
use std::collections::BTreeMap;
use std::path::Path;

/// A row of a tile: its point or ping, and the place.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileRow {
    /// Index of the point or ping in the log.
    pub index: usize,
    /// Place of the point or ping.
    pub at: LonLat,
    /// The zone of the tile.
    pub zone: UtmZone,
    /// The place in metres of the zone.
    pub place: [f64; 2],
    /// True if the place lies in the tile itself, not in its halo.
    pub is_core: bool,
}

/// Rows by tile; the rows of a tile are in the order of the log.
pub(super) type RowsByTile = BTreeMap<TileId, Vec<TileRow>>;

/// A log whose rows are written.
pub(super) struct LogRows<'a> {
    pub survey: &'a Survey,
    pub products: &'a Products,
    pub sha256: &'a str,
    /// Places of the boat in the log's local coordinate frame by time: at every sounding or, in a
    /// log without soundings, at every ping; no two have the same time.
    pub track: &'a [TrackDepth],
}

/// Computes [`LogRows::track`]; its depths are not used.
pub(super) fn track(survey: &Survey, products: &Products) -> Vec<TrackDepth> {
    let navigation = &products.navigation;
    let of_soundings = survey.soundings.iter().map(|sounding| sounding.time_s);
    let of_pings = survey.side_scan.iter().map(|ping| ping.time_s);
    let fixes: Vec<(f64, &PingNav)> = if !survey.soundings.is_empty() {
        of_soundings.zip(navigation.soundings.iter()).collect()
    } else {
        of_pings.zip(navigation.pings.iter()).collect()
    };
    let depth = |(time_s, fix): (f64, &PingNav)| TrackDepth::new(time_s, fix.place(), 0.0);
    let mut track: Vec<TrackDepth> = (fixes.into_iter().map(depth))
        .filter(|track_depth| {
            (track_depth.time_s + track_depth.east_m + track_depth.north_m).is_finite()
        })
        .collect();
    track.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    track.dedup_by(|a, b| a.time_s == b.time_s);
    track
}

impl LogRows<'_> {
    /// Returns a point of the cloud and its class.
    pub(super) fn point(&self, index: usize) -> (&CloudPoint, PointClass) {
        (&self.products.cloud.points[index], self.products.classes[index])
    }

    /// Returns the weight of a point in maps; 0 if its class is not kept.
    pub(super) fn weight(&self, point: &CloudPoint, class: PointClass) -> f64 {
        if class.is_kept() { self.products.settings.surface.weight(point) } else { 0.0 }
    }

    /// Returns the time of a point, seconds after the log's time zero; NaN where it is not known.
    pub(super) fn time_of(&self, point: &CloudPoint) -> f64 {
        point.record().time_s(self.survey).unwrap_or(f64::NAN)
    }

    /// Converts a time of the log to microseconds since 1970; `None` where the time is not known.
    pub(super) fn unix_us(&self, time_s: f64) -> Option<i64> {
        let unix_us = 1e6 * (self.survey.start_unix_s? + time_s);
        unix_us.is_finite().then_some(unix_us.round() as i64)
    }

    /// Returns the Unix seconds of the first and the last of some rows of points and pings; empty
    /// where the time is not known.
    pub(super) fn span_unix_s(
        &self,
        points: Option<&Vec<TileRow>>,
        pings: Option<&Vec<TileRow>>,
    ) -> Vec<f64> {
        let Some(start_unix_s) = self.survey.start_unix_s else {
            return Vec::new();
        };
        let of_points =
            points.into_iter().flatten().map(|row| self.time_of(self.point(row.index).0));
        let of_pings =
            pings.into_iter().flatten().map(|row| self.survey.side_scan[row.index].time_s);
        let times_s = of_points.chain(of_pings).filter(|time_s| time_s.is_finite());
        let times_s = times_s.map(|time_s| [time_s; 2]);
        let span = times_s.reduce(|[a, b], [from, to]| [a.min(from), b.max(to)]);
        span.map_or(Vec::new(), |span| span.map(|time_s| start_unix_s + time_s).to_vec())
    }

    /// Returns the last columns of the rows of points and of pings: the halo flag, the time of
    /// recording (`times_s`, seconds after the log's time zero), and the log.
    pub(super) fn common_columns(&self, rows: &[TileRow], times_s: Vec<f64>) -> [Column; 5] {
        let unix_us = times_s.iter().map(|time_s| self.unix_us(*time_s)).collect();
        [
            Column::flags("halo", rows.iter().map(|row| !row.is_core)),
            Column::new("time", Values::Time(unix_us)),
            Column::new("time_s", Values::Double(times_s)),
            Column::new("log", Values::Same(self.sha256.to_owned(), rows.len())),
            Column::new("name", Values::Same(self.survey.name(), rows.len())),
        ]
    }

    /// Returns the velocity of the boat at a time of the log, metres a second along the axes of a
    /// zone; zero where it is not known.
    pub(super) fn velocity_mps(&self, time_s: f64, zone: UtmZone) -> [f64; 2] {
        let after = self.track.partition_point(|track_depth| track_depth.time_s < time_s);
        let index = after.min(self.track.len().saturating_sub(1));
        let Some(here) = self.track.get(index) else {
            return [0.0; 2];
        };
        let [east, north] = velocity_mps(self.track, index);
        let place = |seconds: f64| {
            let at = [here.east_m + seconds * east, here.north_m + seconds * north];
            zone.to_metres(self.position(at[0], at[1]))
        };
        let ([from_x, from_y], [to_x, to_y]) = (place(0.0), place(1.0));
        let velocity = [to_x - from_x, to_y - from_y];
        if velocity.iter().all(|value| value.is_finite()) { velocity } else { [0.0; 2] }
    }

    /// Converts a place of the log's local coordinate frame to longitude and latitude.
    pub(super) fn position(&self, east_m: f64, north_m: f64) -> LonLat {
        let navigation = &self.products.navigation;
        navigation.to_lon_lat(&self.survey.track, east_m, north_m)
    }
}

/// Assigns each point to the tile that holds it and to the tiles whose halo holds it, in the
/// neighbouring zone too.
pub(super) fn by_tile(points: impl Iterator<Item = (usize, LonLat)>, halo_m: f64) -> RowsByTile {
    let mut tiles = RowsByTile::new();
    for (index, at) in points {
        let zones = UtmZone::near(at, halo_m);
        for (rank, zone) in zones.into_iter().enumerate() {
            let place = zone.to_metres(at);
            let [x, y] = place;
            if !(x.is_finite() && y.is_finite()) {
                continue;
            }
            let own = (rank == 0).then(|| TileId::at(zone, place));
            let around = beside([x, y, x, y], halo_m);
            for tile in TileId::touched(zone, around).filter(|tile| tile.holds(place, halo_m)) {
                tiles.entry(tile).or_default().push(TileRow {
                    index,
                    at,
                    zone,
                    place,
                    is_core: own == Some(tile),
                });
            }
        }
    }
    tiles
}

/// Returns the places of rows as a column.
pub(super) fn geometry(rows: &[TileRow]) -> Column {
    let places = rows.iter().map(|row| row.at).collect();
    Column::new("geometry", Values::Points(places))
}

/// Columns of numbers, and others.
type Columns<const N: usize> = (Vec<Vec<f64>>, [Values; N]);

/// Reads columns of numbers, and others; `None` where one of the numbers is of another type, or the
/// columns differ in length.
///
/// # Errors
/// When the file cannot be read.
pub(super) fn columns<const N: usize>(
    path: &Path,
    numbers: &[&str],
    others: &[&str; N],
) -> Result<Option<Columns<N>>, Error> {
    let numbers = read_parquet(path, numbers)?.into_iter().map(|values| match values {
        Values::Double(values) => Some(values),
        _ => None,
    });
    let Some(numbers) = numbers.collect::<Option<Vec<Vec<f64>>>>() else {
        return Ok(None);
    };
    let others = read_parquet(path, others)?;
    let count = others.first().map_or(0, Values::row_count);
    let mut counts = numbers.iter().map(Vec::len).chain(others.iter().map(Values::row_count));
    let is_even = counts.all(|other| other == count);
    Ok(<[Values; N]>::try_from(others).ok().filter(|_| is_even).map(|others| (numbers, others)))
}

/// Returns the error of a file with other columns than those of its kind.
pub(super) fn damaged(what: &str, path: &Path) -> Error {
    let what = format!("cannot read the Parquet file: {what}");
    FileError::<FaultText>::new(what.into(), path).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_in_one_core_and_in_halos_across_the_meridian() {
        let at = LonLat { lon_deg: 11.9999, lat_deg: 47.5 };
        let tiles = by_tile([(7, at)].into_iter(), 64.0);
        let rows: Vec<(TileId, TileRow)> =
            tiles.into_iter().map(|(tile, rows)| (tile, rows[0])).collect();
        assert_eq!(rows.iter().filter(|(_, row)| row.is_core).count(), 1);
        let zones: Vec<u8> = rows.iter().map(|(tile, _)| tile.zone.number).collect();
        assert!(zones.contains(&32) && zones.contains(&33), "{zones:?}");
        for (tile, row) in rows {
            assert_eq!(row.index, 7);
            assert!(tile.holds(row.place, 64.0));
            assert!(!row.is_core || tile.zone.number == 32 && tile.holds(row.place, 0.0));
        }
    }
}
