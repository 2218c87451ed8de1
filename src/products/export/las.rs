//! Writes points of any kind in a map's coordinates as COPC or LAS 1.4: `cloud.copc.laz` and
//! `cloud.las`, all points with their classes, for survey programs, and `bottom.copc.laz`, the
//! cells of the depth map as points, for programs that read point clouds and no rasters.
//!
//! The dimensions of points beyond the fields of the standard are described by the Extra Bytes
//! record of LAS 1.4 R15 (section 2.7.1 "Extra Bytes"). LAS counts in GPS time, which does not stop
//! where UTC inserts a leap second.

use super::{ExportError, LogPoints, Summary, colour, write_atomically};
use crate::PROGRAM;
use bathyscope_bottom::bathymetry::CellSource;
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointSource};
use bathyscope_log::formats::points::{LasWriter, transforms, write_copc};
use bathyscope_log::support::geo::{Crs, LonLat};
use bathyscope_log::survey::{Side, Survey};
use las::point::{Classification, Format};
use las::{
    Builder, Color, GpsTimeType, Header, Point, PointDataBuilder, Transform, Vector, Version, Vlr,
};
use rayon::prelude::*;
use std::io;
use std::path::Path;

/// Resolution of stored coordinates, metres; coarser if the points are too far apart for it.
const RESOLUTION_M: f64 = 0.001;
/// Resolution of stored coordinates in degrees: a millimetre.
const RESOLUTION_DEG: f64 = 1e-8;
/// LAS 1.4 point format with time and colour.
const FORMAT: u8 = 7;
/// Number of bytes of the description of a dimension.
const DESCRIPTION: usize = 192;
/// Largest number of bytes of a name and of a description in the standard.
const LONGEST: usize = 32;

/// Compression of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LasPacking {
    /// LAZ in the order of COPC: a fraction of the size, and programs can read it from coarse to
    /// fine, or only the part on the screen.
    Copc,
    /// LAS, for programs without decompression.
    Plain,
}

/// A dimension of a point beyond the fields of the standard.
#[derive(Clone, Copy)]
struct Dimension {
    name: &'static str,
    kind: DimensionType,
    no_data: Option<f64>,
    what: &'static str,
}

impl Dimension {
    /// Creates a dimension from a name, a type, a value for "no data" and a description.
    const fn new(
        name: &'static str,
        kind: DimensionType,
        no_data: Option<f64>,
        what: &'static str,
    ) -> Self {
        assert!(name.len() <= LONGEST && what.len() <= LONGEST);
        Self { name, kind, no_data, what }
    }
}

/// Type of a dimension; the value is the number of the type in the standard.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
enum DimensionType {
    U8 = 1,
    U32 = 5,
    F32 = 9,
}

impl DimensionType {
    fn bytes(self) -> u16 {
        match self {
            Self::U8 => 1,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Layout of a file of points.
struct LasSpec<'a> {
    packing: LasPacking,
    /// Coordinate system of x and y; its WKT is in the header.
    crs: &'a Crs,
    /// Place near the points; the coordinates are stored relative to it.
    origin: Option<LonLat>,
    /// True if times are adjusted standard GPS time.
    knows_time: bool,
    /// Dimensions of the points beyond LAS's own fields.
    dimensions: &'a [Dimension],
}

/// Writes points; `places` are the x, y and z of the same points.
fn write_las(
    path: &Path,
    spec: &LasSpec<'_>,
    places: impl Iterator<Item = [f64; 3]> + Clone,
    points: impl Iterator<Item = las::Result<Point>>,
) -> Result<Summary, ExportError> {
    write_atomically(path, |file| {
        let resolution = if spec.crs.is_degrees() { RESOLUTION_DEG } else { RESOLUTION_M };
        let [x, y] = spec.origin.map_or([0.0; 2], |origin| spec.crs.place(origin));
        let finest = [resolution, resolution, RESOLUTION_M];
        let transforms = transforms(places.clone(), [x, y, 0.0], finest)?;
        let header = header(spec, transforms).map_err(io::Error::other)?;
        let (format, transforms) = (*header.point_format(), *header.transforms());
        let mut summary = Summary::default();
        places.for_each(|[x, y, z]| summary.add([x, y], z));
        let mut records = Vec::with_capacity(summary.count * usize::from(format.len()));
        for point in points {
            point
                .and_then(|point| point.into_raw(&transforms))
                .and_then(|raw| raw.write_to(&mut records, &format))
                .map_err(io::Error::other)?;
        }
        let data = PointDataBuilder::new().for_header(&header);
        let data = data.build_from_bytes(records).map_err(io::Error::other)?;
        match spec.packing {
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

fn header(spec: &LasSpec<'_>, transforms: Vector<Transform>) -> las::Result<Header> {
    let mut builder = Builder::from(Version::new(1, 4));
    builder.generating_software = PROGRAM.to_owned();
    if spec.knows_time {
        builder.gps_time_type = GpsTimeType::Standard;
    }
    builder.point_format = Format::new(FORMAT)?;
    let added = spec.dimensions.iter().map(|dimension| dimension.kind.bytes());
    builder.point_format.extra_bytes = added.sum();
    builder.vlrs.push(extra_bytes_record(spec.dimensions));
    builder.vlrs.push(class_names());
    builder.transforms = transforms;
    let mut header: Header = builder.into_header()?;
    header.set_wkt_crs(spec.crs.wkt().as_bytes().to_vec())?;
    Ok(header)
}

/// Returns the record "Classification lookup", which names the classes: number and 15 letters for
/// each of 256.
fn class_names() -> Vlr {
    const ENTRY: usize = 16;
    let mut data: Vec<u8> =
        (0..=u8::MAX).flat_map(|code| [&[code][..], &[0; ENTRY - 1]].concat()).collect();
    for class in PointClass::ALL {
        let name = class.name().as_bytes();
        let start = usize::from(class.code()) * ENTRY + 1;
        data[start..start + name.len()].copy_from_slice(name);
    }
    Vlr {
        user_id: "LASF_Spec".to_owned(),
        record_id: 0,
        description: "Classification".to_owned(),
        data,
    }
}

/// Returns the record that describes the dimensions.
fn extra_bytes_record(dimensions: &[Dimension]) -> Vlr {
    Vlr {
        user_id: "LASF_Spec".to_owned(),
        record_id: 4,
        description: "Extra Bytes".to_owned(),
        data: dimensions.iter().flat_map(described).collect(),
    }
}

/// Returns the description of a dimension: two reserved bytes, type, options, name, four unused;
/// "no data", least, most, scale and offset, 24 bytes each; description.
fn described(dimension: &Dimension) -> Vec<u8> {
    let mut bytes = vec![0; DESCRIPTION];
    bytes[2] = dimension.kind as u8;
    bytes[4..4 + dimension.name.len()].copy_from_slice(dimension.name.as_bytes());
    if let Some(no_data) = dimension.no_data {
        // The first option means that the "no data" field is valid; floating types store it in
        // eight bytes.
        bytes[3] = 1;
        bytes[40..48].copy_from_slice(&no_data.to_le_bytes());
    }
    bytes[160..160 + dimension.what.len()].copy_from_slice(dimension.what.as_bytes());
    bytes
}

/// Value of an unknown standard deviation.
const NO_SIGMA: f32 = -1.0;

/// Extra dimensions of a point, in the order of [`bottom_bytes`].
const BOTTOM_DIMENSIONS: [Dimension; 3] = [
    Dimension::new("source", DimensionType::U8, None, "numbers of depth/source.tif"),
    Dimension::new(
        "sigma_m",
        DimensionType::F32,
        Some(NO_SIGMA as f64),
        "standard deviation, metres",
    ),
    Dimension::new("distance_m", DimensionType::F32, None, "to the nearest depth, metres"),
];

/// A cell of the depth map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BottomCell {
    /// Middle of the cell in the coordinates of the file.
    pub place: [f64; 2],
    /// Depth, metres, positive down.
    pub depth_m: f32,
    /// Standard deviation of the depth, metres; NaN where none is known.
    pub sigma_m: f32,
    /// Distance to the nearest measured depth, metres.
    pub distance_m: f32,
    /// The source of the depth.
    pub source: CellSource,
    /// Colour of the cell.
    pub rgb: [u8; 3],
}

/// Writes cells as COPC, in a coordinate system (its WKT is in the header); `origin` is a place
/// near the cells. z is the negative depth. Cells without a measured depth have the flag of
/// synthetic points.
pub(crate) fn bottom_las(
    path: &Path,
    crs: &Crs,
    origin: LonLat,
    cells: &[BottomCell],
) -> Result<Summary, ExportError> {
    let spec = LasSpec {
        packing: LasPacking::Copc,
        crs,
        origin: Some(origin),
        knows_time: false,
        dimensions: &BOTTOM_DIMENSIONS,
    };
    let places = cells.iter().map(|cell| {
        let [x, y] = cell.place;
        [x, y, -f64::from(cell.depth_m)]
    });
    write_las(path, &spec, places, cells.iter().map(bottom_point))
}

fn bottom_point(cell: &BottomCell) -> las::Result<Point> {
    let [red, green, blue] = cell.rgb.map(|value| u16::from(value) * 257);
    Ok(Point {
        x: cell.place[0],
        y: cell.place[1],
        z: -f64::from(cell.depth_m),
        return_number: 1,
        number_of_returns: 1,
        classification: Classification::new(PointClass::Bottom.code())?,
        is_synthetic: !matches!(cell.source, CellSource::Sounding | CellSource::FirstReturn),
        user_data: cell.source as u8,
        gps_time: Some(0.0),
        color: Some(Color { red, green, blue }),
        extra_bytes: bottom_bytes(cell),
        ..Point::default()
    })
}

fn bottom_bytes(cell: &BottomCell) -> Vec<u8> {
    let sigma_m = if cell.sigma_m.is_nan() { NO_SIGMA } else { cell.sigma_m };
    let mut bytes = vec![cell.source as u8];
    bytes.extend(sigma_m.to_le_bytes());
    bytes.extend(cell.distance_m.to_le_bytes());
    bytes
}

/// Value of a missing confidence: soundings and the swath have none.
const NO_CONFIDENCE: f32 = -1.0;
/// Description of the dimension of the source, without a swath.
const SOURCES: &str = "0 recorded depth, 1 side-scan";
/// Description of the dimension of the source where there is a swath.
const SOURCES_WITH_SWATH: &str = "0 depth, 1 side-scan, 2 swath";
/// Extra dimensions of a point, in the order of [`cloud_bytes`].
const CLOUD_DIMENSIONS: [Dimension; 5] = [
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
    let mut dimensions = CLOUD_DIMENSIONS;
    if logs.iter().any(|log| !log.survey.swath.is_empty()) {
        dimensions[0] = Dimension::new("source", DimensionType::U8, None, SOURCES_WITH_SWATH);
    }
    let spec = LasSpec { packing, crs, origin, knows_time, dimensions: &dimensions };
    let places = (points.iter()).map(|(_, _, (point, _), [x, y])| [*x, *y, point.z_m]);
    let records = points.iter().map(|(source, log, point, at)| {
        let start_unix_s = log.survey.start_unix_s.filter(|_| knows_time);
        cloud_point(log, start_unix_s, *source, *point, *at)
    });
    write_las(path, &spec, places, records)
}

/// A point and its class.
type ClassedPoint<'a> = (&'a CloudPoint, PointClass);

fn cloud_point(
    log: &LogPoints<'_>,
    start_unix_s: Option<f64>,
    point_source_id: u16,
    (point, class): ClassedPoint<'_>,
    [x, y]: [f64; 2],
) -> las::Result<Point> {
    let survey = log.survey;
    let range_m = log.reduction.point_range_m(survey, point);
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
        extra_bytes: cloud_bytes(survey, point, range_m),
        ..Point::default()
    })
}

/// Returns the bytes of the extra dimensions of a point, which was measured at a slant range.
fn cloud_bytes(survey: &Survey, point: &CloudPoint, range_m: f64) -> Vec<u8> {
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
