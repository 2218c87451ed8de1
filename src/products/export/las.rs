//! Writes points of any kind in a map's coordinates as COPC or LAS 1.4, and `bottom.copc.laz`: the
//! cells of the depth map as points, for programs that read point clouds and no rasters.
//!
//! The dimensions of points beyond the fields of the standard are described by the Extra Bytes
//! record of LAS 1.4 R15 (section 2.7.1 "Extra Bytes").

use super::{ExportError, Summary, write_atomically};
use bathyscope_bottom::cloud::PointClass;
use bathyscope_log::formats::points::{LasWriter, transforms, write_copc};
use bathyscope_log::support::geo::{Crs, LonLat};
use las::point::{Classification, Format};
use las::{
    Builder, Color, GpsTimeType, Header, Point, PointDataBuilder, Transform, Vector, Version, Vlr,
};
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
pub(super) struct Dimension {
    name: &'static str,
    kind: DimensionType,
    no_data: Option<f64>,
    what: &'static str,
}

impl Dimension {
    /// Creates a dimension from a name, a type, a value for "no data" and a description.
    pub(super) const fn new(
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
pub(super) enum DimensionType {
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
pub(super) struct LasSpec<'a> {
    pub packing: LasPacking,
    /// Coordinate system of x and y; its WKT is in the header.
    pub crs: &'a Crs,
    /// Place near the points; the coordinates are stored relative to it.
    pub origin: Option<LonLat>,
    /// True if times are adjusted standard GPS time.
    pub knows_time: bool,
    /// Dimensions of the points beyond LAS's own fields.
    pub dimensions: &'a [Dimension],
}

/// Writes points; `places` are the x, y and z of the same points.
pub(super) fn write_las(
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
    builder.generating_software = concat!("bathyscope ", env!("CARGO_PKG_VERSION")).to_owned();
    if spec.knows_time {
        builder.gps_time_type = GpsTimeType::Standard;
    }
    builder.point_format = Format::new(FORMAT)?;
    builder.point_format.extra_bytes = extra_bytes_length(spec.dimensions);
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

/// Returns the number of bytes that dimensions add to a point.
fn extra_bytes_length(dimensions: &[Dimension]) -> u16 {
    dimensions.iter().map(|dimension| dimension.kind.bytes()).sum()
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

/// Extra dimensions of a point, in the order of [`extra_bytes_of`].
const DIMENSIONS: [Dimension; 3] = [
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
    /// The source of the depth, by the number of [`bathyscope_bottom::bathymetry::CellSource`].
    pub source: u8,
    /// True if a depth was measured in the cell.
    pub is_measured: bool,
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
        dimensions: &DIMENSIONS,
    };
    let places = cells.iter().map(|cell| {
        let [x, y] = cell.place;
        [x, y, -f64::from(cell.depth_m)]
    });
    write_las(path, &spec, places, cells.iter().map(las_point))
}

fn las_point(cell: &BottomCell) -> las::Result<Point> {
    let [red, green, blue] = cell.rgb.map(|value| u16::from(value) * 257);
    Ok(Point {
        x: cell.place[0],
        y: cell.place[1],
        z: -f64::from(cell.depth_m),
        return_number: 1,
        number_of_returns: 1,
        classification: Classification::new(PointClass::Bottom.code())?,
        is_synthetic: !cell.is_measured,
        user_data: cell.source,
        gps_time: Some(0.0),
        color: Some(Color { red, green, blue }),
        extra_bytes: extra_bytes_of(cell),
        ..Point::default()
    })
}

fn extra_bytes_of(cell: &BottomCell) -> Vec<u8> {
    let sigma_m = if cell.sigma_m.is_nan() { NO_SIGMA } else { cell.sigma_m };
    let mut bytes = vec![cell.source];
    bytes.extend(sigma_m.to_le_bytes());
    bytes.extend(cell.distance_m.to_le_bytes());
    bytes
}
