//! Writes and reads the points of a log, a row for each point: `points/tile=.../SHA256.parquet`.

use super::log_rows::{self, LogRows, TileRow};
use crate::Error;
use bathyscope_bottom::bathymetry::DepthPoint;
use bathyscope_bottom::cloud::{CloudPoint, PointClass};
use bathyscope_log::formats::parquet_table::{Column, Values, read_parquet};
use bathyscope_log::survey::Side;
use std::path::Path;

/// Returns the columns of the rows of points in a tile.
pub(super) fn columns(log: &LogRows<'_>, rows: &[TileRow]) -> Vec<Column> {
    let points: Vec<(&CloudPoint, PointClass)> =
        rows.iter().map(|row| log.point(row.index)).collect();
    let times_s: Vec<f64> = points.iter().map(|(point, _)| log.time_of(point)).collect();
    let side = |point: &CloudPoint| point.side(log.survey).map_or("", Side::name);
    let ping = |point: &CloudPoint| {
        let is_known = (point.ping as usize) < log.survey.side_scan.len();
        is_known.then(|| i32::try_from(point.ping).ok()).flatten()
    };
    let sounding =
        |point: &CloudPoint| point.sounding().and_then(|index| i32::try_from(index).ok());
    let each = || points.iter().map(|(point, _)| *point);
    let classes = || points.iter().map(|(_, class)| *class);
    let weights = points.iter().map(|(point, class)| log.weight(point, *class));
    let velocities: Vec<[f32; 2]> = (rows.iter().zip(&times_s))
        .map(|(row, time_s)| log.velocity_mps(*time_s, row.zone).map(|part| part as f32))
        .collect();
    let along = |axis: usize| velocities.iter().map(move |velocity| velocity[axis]);
    let mut columns = vec![
        log_rows::geometry(rows),
        Column::doubles("x", rows.iter().map(|row| row.place[0])),
        Column::doubles("y", rows.iter().map(|row| row.place[1])),
        Column::doubles("depth_m", each().map(|point| -point.z_m)),
        Column::texts("source", each().map(|point| point.source.name())),
        Column::texts("side", each().map(side)),
        Column::wholes("ping", each().map(ping)),
        Column::wholes("sounding", each().map(sounding)),
        Column::floats("sample", each().map(|point| point.sample)),
        Column::floats("confidence", each().map(|point| point.confidence)),
        Column::doubles("weight", weights),
        Column::flags("kept", classes().map(|class| class.is_kept())),
        Column::wholes("class", classes().map(|class| Some(class.code().into()))),
        Column::floats("velocity_x_mps", along(0)),
        Column::floats("velocity_y_mps", along(1)),
    ];
    columns.extend(log.common_columns(rows, times_s));
    columns
}

/// A point of an archive with the values that maps and crossings need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PointRow {
    /// Place in the zone, depth as the log has it, and weight, which is 0 where the point does not
    /// count.
    pub depth: DepthPoint,
    /// True if the point is a sounding: a depth of the recorder under the boat.
    pub is_under_boat: bool,
    /// Time of the point, seconds after the log's time zero.
    pub time_s: f64,
    /// Velocity of the boat, metres a second along the axes of the zone.
    pub velocity_mps: [f64; 2],
}

/// Reads the rows of a file that count for the depth map, in the order of the log.
///
/// # Errors
/// When the file cannot be read, or its columns are not those of points.
pub(super) fn read(path: &Path) -> Result<Vec<PointRow>, Error> {
    const NAMES: [&str; 9] = [
        "x",
        "y",
        "depth_m",
        "weight",
        "sounding",
        "confidence",
        "time_s",
        "velocity_x_mps",
        "velocity_y_mps",
    ];
    let damaged = || log_rows::damaged("its columns are not those of points of an archive", path);
    let columns = read_parquet(path, &NAMES)?;
    let is_even = columns.windows(2).all(|pair| pair[0].row_count() == pair[1].row_count());
    let columns = <[Values; 9]>::try_from(columns).ok().filter(|_| is_even);
    let Some(
        [
            Values::Double(x),
            Values::Double(y),
            Values::Double(depth_m),
            Values::Double(weight),
            Values::Whole(sounding),
            Values::Float(confidence),
            Values::Double(time_s),
            Values::Float(velocity_x),
            Values::Float(velocity_y),
        ],
    ) = columns
    else {
        return Err(damaged());
    };
    let row = |index: usize| PointRow {
        depth: DepthPoint {
            east_m: x[index],
            north_m: y[index],
            depth_m: depth_m[index],
            weight: weight[index],
            // First returns have a confidence; soundings and the swath have none.
            is_sounding: confidence[index].is_nan(),
            // The triangles of tiles are straight.
            slope_end: f32::NAN,
        },
        is_under_boat: sounding[index].is_some(),
        time_s: time_s[index],
        velocity_mps: [velocity_x[index], velocity_y[index]].map(f64::from),
    };
    let rows = (0..x.len()).map(row).filter(|row| {
        let depth = &row.depth;
        depth.weight > 0.0 && (depth.east_m + depth.north_m + depth.depth_m).is_finite()
    });
    Ok(rows.collect())
}
