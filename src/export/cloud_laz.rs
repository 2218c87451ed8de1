//! `cloud.laz`: kept points in UTM, for survey programs.

use super::{ExportError, colour, write_aside};
use crate::cloud::{CloudPoint, PointCloud};
use crate::geo::UtmZone;
use crate::survey::{Navigation, Survey};
use las::point::{Classification, Format};
use las::{Builder, Color, Header, Point, Transform, Vector, Version, Writer};
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Coordinates are stored to this many metres.
const RESOLUTION_M: f64 = 0.001;
/// LAS 1.4 point format with time and colour.
const FORMAT: u8 = 7;
/// ASPRS class of a bathymetric point.
const BATHYMETRIC: u8 = 40;

/// Writes the kept points as LAZ 1.4 in the UTM zone of the survey's first fix (WGS84, its WKT in the header), whatever
/// the plane of the cloud; z is elevation in metres above the transducer, so negative.
///
/// Colours are the paper's; the user data are 0 for soundings, 1 for port, 2 for starboard; the GPS time field holds
/// seconds after the log's time zero.
pub fn cloud_laz(
    path: &Path,
    survey: &Survey,
    navigation: &Navigation,
    cloud: &PointCloud,
    kept: &[bool],
) -> Result<(), ExportError> {
    let zone = UtmZone::of(survey.track.frame.origin());
    let georeferenced = |point: &CloudPoint| {
        zone.to_metres(navigation.to_lon_lat(&survey.track, point.east_m, point.north_m))
    };
    let points = cloud.points.iter().zip(kept).filter(|(_, kept)| **kept);
    write_aside(path, |file| {
        let origin = zone.to_metres(survey.track.frame.origin());
        let mut writer = las_writer(file, zone, origin).map_err(io::Error::other)?;
        for (point, _) in points {
            let at = georeferenced(point);
            let las_point = las_point(survey, point, at).map_err(io::Error::other)?;
            writer.write_point(las_point).map_err(io::Error::other)?;
        }
        writer.into_inner().map_err(io::Error::other)?.flush()
    })
}

fn las_writer(file: File, zone: UtmZone, origin: [f64; 2]) -> las::Result<Writer<BufWriter<File>>> {
    let axis = |offset: f64| Transform {
        scale: RESOLUTION_M,
        offset: offset.round(),
    };
    let mut builder = Builder::from(Version::new(1, 4));
    builder.generating_software = concat!("bathyscope ", env!("CARGO_PKG_VERSION")).to_owned();
    builder.point_format = Format::new(FORMAT)?;
    builder.point_format.is_compressed = true;
    builder.transforms = Vector {
        x: axis(origin[0]),
        y: axis(origin[1]),
        z: axis(0.0),
    };
    let mut header: Header = builder.into_header()?;
    header.set_wkt_crs(zone.wkt().into_bytes())?;
    Writer::new(BufWriter::new(file), header)
}

fn las_point(survey: &Survey, point: &CloudPoint, [x, y]: [f64; 2]) -> las::Result<Point> {
    let time_s = match point.sounding {
        Some(sounding) => survey.soundings.get(sounding.get()).map(|s| s.time_s),
        None => survey
            .side_scan
            .get(point.ping as usize)
            .map(|ping| ping.time_s),
    };
    let [red, green, blue] = colour(point.source).map(|value| u16::from(value) * 257);
    Ok(Point {
        x,
        y,
        z: point.z_m,
        return_number: 1,
        number_of_returns: 1,
        classification: Classification::new(BATHYMETRIC)?,
        user_data: point.source as u8,
        gps_time: Some(time_s.unwrap_or(0.0)),
        color: Some(Color { red, green, blue }),
        ..Point::default()
    })
}
