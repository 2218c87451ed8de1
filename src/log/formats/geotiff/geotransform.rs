//! Reads the position of the cells of a GeoTIFF: its geo keys and its transform, as OGC 19-008
//! defines them.

use std::io::{Read, Seek};
use tiff::decoder::Decoder;
use tiff::tags::Tag;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC: u16 = 2048;
const PROJECTED: u16 = 3072;
/// Value of the model type for degrees, and of the raster type for cells as points.
const IS_GEOGRAPHIC: u16 = 2;
const IS_POINT: u16 = 2;

/// GeoTIFF keys with 16-bit values.
#[derive(Clone, Debug, Default)]
pub(crate) struct GeoKeys(Vec<u16>);

impl GeoKeys {
    /// Reads the keys of the current picture of the decoder; empty where it has none.
    pub(crate) fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Self {
        let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag);
        Self(keys.unwrap_or_default())
    }

    /// Returns the value of a key. Entries are a key, the place of its value (0: in the entry), the
    /// number of values, and the value; the first entry is a header.
    fn value(&self, key: u16) -> Option<u16> {
        let mut entries = self.0.chunks_exact(4).skip(1);
        let found = entries.find(|entry| entry[0] == key && entry[1] == 0);
        found.map(|entry| entry[3])
    }

    /// Returns true if the coordinates are stated to be degrees, or only a system of degrees is
    /// named.
    pub(crate) fn is_geographic(&self) -> bool {
        self.value(MODEL_TYPE) == Some(IS_GEOGRAPHIC)
            || self.projected().is_none() && self.geographic().is_some()
    }

    /// Returns the EPSG number of the geographic coordinate system.
    pub(crate) fn geographic(&self) -> Option<u16> {
        self.value(GEOGRAPHIC)
    }

    /// Returns the EPSG number of the projection.
    pub(crate) fn projected(&self) -> Option<u16> {
        self.value(PROJECTED)
    }
}

/// Transform from columns and rows to the coordinates of a system: `ModelPixelScale` with
/// `ModelTiepoint`, or `ModelTransformation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeoTransform {
    /// Coordinates of column and row 0.
    pub origin: [f64; 2],
    /// Step from one column to the next.
    pub per_column: [f64; 2],
    /// Step from one row to the next.
    pub per_row: [f64; 2],
    /// True if whole numbers are the middles of cells, not their corners.
    is_point: bool,
}

impl GeoTransform {
    /// Reads the transform of the current picture of the decoder; `None` where it has none.
    pub(crate) fn read<R: Read + Seek>(decoder: &mut Decoder<R>, keys: &GeoKeys) -> Option<Self> {
        let mut numbers = |tag| decoder.get_tag_f64_vec(tag).unwrap_or_default();
        let (scale, tie) = (numbers(Tag::ModelPixelScaleTag), numbers(Tag::ModelTiepointTag));
        let matrix = numbers(Tag::ModelTransformationTag);
        let (origin, per_column, per_row) = match (&scale[..], &tie[..], &matrix[..]) {
            ([dx, dy, ..], [column, row, _, x, y, ..], _) => {
                ([x - column * dx, y + row * dy], [*dx, 0.0], [0.0, -dy])
            }
            (_, _, [a, b, _, x, c, d, _, y, ..]) => ([*x, *y], [*a, *c], [*b, *d]),
            _ => return None,
        };
        Some(Self {
            origin,
            per_column,
            per_row,
            is_point: keys.value(RASTER_TYPE) == Some(IS_POINT),
        })
    }

    /// Returns the coordinates of a column and a row.
    pub fn at(&self, [column, row]: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            self.origin[axis] + column * self.per_column[axis] + row * self.per_row[axis]
        })
    }

    /// Returns the transform with whole numbers for the middles of cells.
    pub(crate) fn of_middles(self) -> Self {
        self.moved(if self.is_point { 0.0 } else { 0.5 })
    }

    /// Returns the transform with whole numbers for the upper left corners of cells.
    pub(crate) fn of_corners(self) -> Self {
        self.moved(if self.is_point { -0.5 } else { 0.0 })
    }

    fn moved(self, cells: f64) -> Self {
        Self { origin: self.at([cells; 2]), ..self }
    }
}
