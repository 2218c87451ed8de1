//! Writes `cloud.copc.laz` and `cloud.las`: all points with their classes in a map's coordinates,
//! for survey programs.
//!
//! LAS counts in GPS time, which does not stop where UTC inserts a leap second.

use super::las::{Dimension, DimensionType, LasPacking, LasSpec, write_las};
use super::{ExportError, LogPoints, Summary, colour};
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointSource};
use bathyscope_log::support::geo::Crs;
use bathyscope_log::survey::{Side, Survey};
use las::point::Classification;
use las::{Color, Point};
use rayon::prelude::*;
use std::path::Path;

/// Value of a missing confidence: soundings and the swath have none.
const NO_CONFIDENCE: f32 = -1.0;
/// Description of the dimension of the source, without a swath.
const SOURCES: &str = "0 recorded depth, 1 side-scan";
/// Description of the dimension of the source where there is a swath.
const SOURCES_WITH_SWATH: &str = "0 depth, 1 side-scan, 2 swath";
/// Extra dimensions of a point, in the order of [`extra_bytes_of`].
const DIMENSIONS: [Dimension; 5] = [
    Dimension::new("source", DimensionType::U8, None, SOURCES),
    Dimension::new("ping", DimensionType::U32, None, "side-scan ping, from 0"),
    Dimension::new("side", DimensionType::U8, None, "0 below, 1 port, 2 starboard"),
    Dimension::new(
        "confidence",
        DimensionType::F32,
        Some(NO_CONFIDENCE as f64),
        "of the first return, 0 to 1",
    ),
    Dimension::new("range_m", DimensionType::F32, None, "slant range, metres"),
];
/// Unix seconds of GPS time zero, 1980-01-06.
const GPS_ZERO_UNIX_S: f64 = 315_964_800.0;
/// Seconds that LAS subtracts from GPS time, so that a double keeps the fraction of a second (LAS
/// 1.4 R15, table 3, global encoding bit 0).
const ADJUSTED_S: f64 = 1e9;
/// Unix seconds of the leap seconds, at each of which GPS gained one second on UTC (IERS Bulletin
/// C). `chrono` has no leap seconds, and none has been announced since 2016.
const LEAPS_UNIX_S: [f64; 18] = [
    362_793_600.0,   // 1981-07-01
    394_329_600.0,   // 1982-07-01
    425_865_600.0,   // 1983-07-01
    489_024_000.0,   // 1985-07-01
    567_993_600.0,   // 1988-01-01
    631_152_000.0,   // 1990-01-01
    662_688_000.0,   // 1991-01-01
    709_948_800.0,   // 1992-07-01
    741_484_800.0,   // 1993-07-01
    773_020_800.0,   // 1994-07-01
    820_454_400.0,   // 1996-01-01
    867_715_200.0,   // 1997-07-01
    915_148_800.0,   // 1999-01-01
    1_136_073_600.0, // 2006-01-01
    1_230_768_000.0, // 2009-01-01
    1_341_100_800.0, // 2012-07-01
    1_435_708_800.0, // 2015-07-01
    1_483_228_800.0, // 2017-01-01
];

/// Writes all points as COPC or LAS 1.4 in a coordinate system (its WKT is in the header), whatever
/// the local coordinate frame of the cloud; `place` returns the x and y of a point in this system.
/// z is elevation in metres above the transducer, so negative.
///
/// Points that do not count for the map have the flag "withheld"; their class gives the reason, and
/// the header names the classes. Intensity is the echo level of the first return, 0 to 255 times
/// 257; 0 for soundings and the swath, whose level is not known. Colours are those of the paper;
/// the extra dimensions are source, ping, side, confidence of the first return and slant range; the
/// user data are 0 for soundings, 1 for port, 2 for starboard, 3 for the swath. If all logs have a
/// known time, the GPS time field holds adjusted standard GPS time, which the header states;
/// otherwise seconds after each log's time zero.
///
/// With several logs the point source is the number of the log, from 1 on; with one log it is 0.
pub(crate) fn cloud_las(
    path: &Path,
    packing: LasPacking,
    crs: &Crs,
    place: impl Fn(&LogPoints<'_>, &CloudPoint) -> [f64; 2] + Sync,
    logs: &[LogPoints<'_>],
) -> Result<Summary, ExportError> {
    let mut points: Vec<(u16, &LogPoints<'_>, ClassedPoint<'_>, [f64; 2])> = Vec::new();
    for (number, log) in (1..).zip(logs) {
        let classed: Vec<ClassedPoint<'_>> = log.points().collect();
        let source = if logs.len() > 1 { number } else { 0 };
        points.par_extend(
            (classed.into_par_iter()).map(|point| (source, log, point, place(log, point.0))),
        );
    }
    let knows_time = logs.iter().all(|log| log.survey.start_unix_s.is_some());
    let origin = logs.first().map(|log| log.survey.track.frame.origin());
    let mut dimensions = DIMENSIONS;
    if logs.iter().any(|log| !log.survey.swath.is_empty()) {
        dimensions[0] = Dimension::new("source", DimensionType::U8, None, SOURCES_WITH_SWATH);
    }
    let spec = LasSpec { packing, crs, origin, knows_time, dimensions: &dimensions };
    let places = (points.iter()).map(|(_, _, (point, _), [x, y])| [*x, *y, point.z_m]);
    let records = points.iter().map(|(source, log, point, at)| {
        let start_unix_s = log.survey.start_unix_s.filter(|_| knows_time);
        las_point(log, start_unix_s, *source, *point, *at)
    });
    write_las(path, &spec, places, records)
}

/// A point and its class.
type ClassedPoint<'a> = (&'a CloudPoint, PointClass);

fn las_point(
    log: &LogPoints<'_>,
    start_unix_s: Option<f64>,
    point_source_id: u16,
    (point, class): ClassedPoint<'_>,
    [x, y]: [f64; 2],
) -> las::Result<Point> {
    let survey = log.survey;
    let range_m = log.reduction().point_range_m(survey, point);
    let time_s = point.record().time_s(survey).unwrap_or(0.0);
    let gps_time_s =
        start_unix_s.map_or(time_s, |start_unix_s| adjusted_standard_s(start_unix_s + time_s));
    let [red, green, blue] = colour(point.source).map(|value| u16::from(value) * 257);
    Ok(Point {
        x,
        y,
        z: point.z_m,
        intensity: u16::from(point.level) * 257,
        return_number: 1,
        number_of_returns: 1,
        classification: Classification::new(class.code())?,
        is_withheld: !class.is_kept(),
        user_data: point.source as u8,
        point_source_id,
        gps_time: Some(gps_time_s),
        color: Some(Color { red, green, blue }),
        extra_bytes: extra_bytes_of(survey, point, range_m),
        ..Point::default()
    })
}

/// Returns the bytes of the extra dimensions of a point, which was measured at a slant range.
fn extra_bytes_of(survey: &Survey, point: &CloudPoint, range_m: f64) -> Vec<u8> {
    let source = match point.source {
        PointSource::DownScan => 0,
        PointSource::Port | PointSource::Starboard => 1,
        PointSource::Swath => 2,
    };
    let side = match point.side(survey) {
        None => 0,
        Some(Side::Port) => 1,
        Some(Side::Starboard) => 2,
    };
    let confidence = if point.confidence.is_nan() { NO_CONFIDENCE } else { point.confidence };
    let mut bytes = Vec::with_capacity(14);
    bytes.push(source);
    bytes.extend(point.ping.to_le_bytes());
    bytes.push(side);
    bytes.extend(confidence.to_le_bytes());
    bytes.extend((range_m as f32).to_le_bytes());
    bytes
}

/// Converts Unix seconds to adjusted standard GPS time: seconds of GPS time less 1e9.
fn adjusted_standard_s(unix_s: f64) -> f64 {
    let leaps = LEAPS_UNIX_S.partition_point(|begins_s| *begins_s <= unix_s) as f64;
    unix_s - GPS_ZERO_UNIX_S + leaps - ADJUSTED_S
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gps_time_is_that_of_the_published_conversions() {
        // UTC as printed by `date -u -d TEXT +%s`, GPS seconds as printed by the converters of LIGO
        // and NOAA.
        for (unix_s, gps_s) in [
            (315_964_800.0, 0.0),
            (362_793_599.0, 46_828_799.0),
            (362_793_600.0, 46_828_801.0),
            (1_315_964_785.0, 1_000_000_000.0),
            (1_483_228_799.5, 1_167_264_016.5),
            (1_483_228_800.0, 1_167_264_018.0),
            (1_634_000_000.0, 1_318_035_218.0),
        ] {
            assert_eq!(adjusted_standard_s(unix_s), gps_s - 1e9, "{unix_s}");
        }
    }
}
