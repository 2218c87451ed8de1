//! `cloud.copc.laz` and `cloud.las`: kept points in a map's coordinates, for survey programs.

use super::gps_time::adjusted_standard_s;
use super::{ExportError, LogPoints, Summary, colour, extra_bytes, write_aside};
use crate::cloud::CloudPoint;
use crate::formats::points::{LasWriter, transforms, write_copc};
use crate::geo::Crs;
use las::point::{Classification, Format};
use las::{
    Builder, Color, GpsTimeType, Header, Point, PointDataBuilder, Transform, Vector, Version,
};
use rayon::prelude::*;
use std::io;
use std::path::Path;

/// Coordinates are stored to this many metres, unless they lie too far apart for it.
const RESOLUTION_M: f64 = 0.001;
/// Or degrees: a millimetre.
const RESOLUTION_DEG: f64 = 1e-8;
/// LAS 1.4 point format with time and colour.
const FORMAT: u8 = 7;
/// ASPRS class of a bathymetric point.
const BATHYMETRIC: u8 = 40;

/// Whether points are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LasPacking {
    /// LAZ in the order of COPC: a fraction of the size, and read from coarse to fine, or where somebody looks.
    Copc,
    /// LAS, for programs that cannot unpack.
    Plain,
}

/// Writes the kept points as COPC or LAS 1.4 in a system (its WKT in the header), whatever the plane of the cloud; `place` gives where
/// a point lies there. z is elevation in metres above the transducer, so negative.
///
/// Intensity is the echo level of the first return, 0 to 255 times 257; 0 for soundings, of which the level is not known. Colours are
/// the paper's; the extra dimensions are source, ping, side, confidence of the first return and slant range; the user data are 0
/// for soundings, 1 for port, 2 for starboard. The GPS time field holds adjusted standard GPS time, and the header says so, where
/// the log knows when it was; otherwise seconds after the log's time zero.
///
/// Of several logs the point source is the number of the log, from 1 on; of one it is 0. Times are seconds after each log's time zero
/// where one of them does not know when it was.
pub fn cloud_las(
    path: &Path,
    packing: LasPacking,
    crs: &Crs,
    place: impl Fn(&LogPoints<'_>, &CloudPoint) -> [f64; 2] + Sync,
    logs: &[LogPoints<'_>],
) -> Result<Summary, ExportError> {
    let mut points: Vec<(u16, &LogPoints<'_>, &CloudPoint, [f64; 2])> = Vec::new();
    for (number, log) in (1..).zip(logs) {
        let kept: Vec<&CloudPoint> = log.kept_points().collect();
        let source = if logs.len() > 1 { number } else { 0 };
        points.par_extend(
            kept.into_par_iter()
                .map(|point| (source, log, point, place(log, point))),
        );
    }
    let knows_time = logs.iter().all(|log| log.survey.start_unix_s.is_some());
    write_aside(path, |file| {
        let places = (points.iter()).map(|(_, _, point, [x, y])| [*x, *y, point.z_m]);
        let resolution = match crs.is_degrees() {
            true => RESOLUTION_DEG,
            false => RESOLUTION_M,
        };
        let origin = logs.first().map(|log| log.survey.track.frame.origin());
        let [x, y] = origin.map_or([0.0; 2], |origin| crs.place(origin));
        let finest = [resolution, resolution, RESOLUTION_M];
        let transforms = transforms(places, [x, y, 0.0], finest)?;
        let header = las_header(knows_time, crs, transforms).map_err(io::Error::other)?;
        let (format, transforms) = (*header.point_format(), *header.transforms());
        let mut summary = Summary::default();
        let mut records = Vec::with_capacity(points.len() * usize::from(format.len()));
        for (source, log, point, at) in points {
            summary.add(at, point.z_m);
            let start_unix_s = log.survey.start_unix_s.filter(|_| knows_time);
            las_point(log, start_unix_s, source, point, at)
                .and_then(|point| point.into_raw(&transforms))
                .and_then(|raw| raw.write_to(&mut records, &format))
                .map_err(io::Error::other)?;
        }
        let data = PointDataBuilder::new().for_header(&header);
        let data = data.build_from_bytes(records).map_err(io::Error::other)?;
        match packing {
            LasPacking::Copc => write_copc(file, header, &data)?,
            LasPacking::Plain => {
                let mut writer = LasWriter::new(file, header)?;
                writer.points(&data)?;
                writer.finish()?;
            }
        }
        Ok(summary)
    })
}

fn las_header(knows_time: bool, crs: &Crs, transforms: Vector<Transform>) -> las::Result<Header> {
    let mut builder = Builder::from(Version::new(1, 4));
    builder.generating_software = concat!("bathyscope ", env!("CARGO_PKG_VERSION")).to_owned();
    if knows_time {
        builder.gps_time_type = GpsTimeType::Standard;
    }
    builder.point_format = Format::new(FORMAT)?;
    builder.point_format.extra_bytes = extra_bytes::LENGTH;
    builder.vlrs.push(extra_bytes::record());
    builder.transforms = transforms;
    let mut header: Header = builder.into_header()?;
    header.set_wkt_crs(crs.wkt().as_bytes().to_vec())?;
    Ok(header)
}

fn las_point(
    log: &LogPoints<'_>,
    start_unix_s: Option<f64>,
    point_source_id: u16,
    point: &CloudPoint,
    [x, y]: [f64; 2],
) -> las::Result<Point> {
    let survey = log.survey;
    let range_m = log.reduction().point_range_m(survey, point);
    let time_s = match point.sounding {
        Some(sounding) => survey.soundings.get(sounding.get()).map(|s| s.time_s),
        None => survey
            .side_scan
            .get(point.ping as usize)
            .map(|ping| ping.time_s),
    };
    let time_s = time_s.unwrap_or(0.0);
    let gps_time_s = start_unix_s.map_or(time_s, |start_unix_s| {
        adjusted_standard_s(start_unix_s + time_s)
    });
    let [red, green, blue] = colour(point.source).map(|value| u16::from(value) * 257);
    Ok(Point {
        x,
        y,
        z: point.z_m,
        intensity: u16::from(point.level) * 257,
        return_number: 1,
        number_of_returns: 1,
        classification: Classification::new(BATHYMETRIC)?,
        user_data: point.source as u8,
        point_source_id,
        gps_time: Some(gps_time_s),
        color: Some(Color { red, green, blue }),
        extra_bytes: extra_bytes::values(point, range_m),
        ..Point::default()
    })
}
