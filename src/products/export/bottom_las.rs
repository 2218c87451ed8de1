//! Writes `bottom.copc.laz`: the cells of the depth map as points, for programs that read point
//! clouds and no rasters.

use super::las::{Dimension, DimensionType, LasPacking, LasSpec, write_las};
use super::{ExportError, Summary};
use bathyscope_bottom::cloud::PointClass;
use bathyscope_log::support::geo::{Crs, LonLat};
use las::point::Classification;
use las::{Color, Point};
use std::path::Path;

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
