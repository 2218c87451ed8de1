//! Reads the cells of a GeoTIFF as points or as a raster: one band of numbers, in strips or tiles,
//! uncompressed or compressed with deflate or LZW. Their position is in the geo keys and the
//! transform, as OGC 19-008 defines them.

use super::claims::{check_claims, is_jpeg};
use super::metadata::counts_downwards;
use crate::support::catch_panic::catch_panic;
use crate::support::regular_file;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::ops::Range;
use std::path::Path;
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// Cells of a raster, converted to points.
pub struct RasterPoints {
    /// x and y of the middle of each cell that has a value, and the value as stored.
    pub points: Vec<[f64; 3]>,
    /// True if x and y are degrees.
    pub is_degrees: bool,
    /// EPSG number of the projection; `None` where the raster names none.
    pub projected: Option<u16>,
    /// True if the raster's metadata state that its values count downwards, as for the depths of
    /// `bathyscope process`.
    pub downwards: bool,
}

/// Most cells of a raster, with or without a value.
const MOST_CELLS: u64 = 50_000_000;
/// Most cells with a value: more cells, as points and triangles between them, would fill the
/// memory. A compressed file of a few hundred bytes can contain that many.
const MOST_POINTS: usize = 4_000_000;
/// Most bytes of a strip or tile, decompressed.
const LARGEST_BLOCK: usize = 256 << 20;
/// Bytes of a decompressed block that are allowed in a file of any size.
const SMALL_BLOCK: usize = 64 << 20;
/// Fault of a raster with cells of another type of number.
const NO_HEIGHTS: &str =
    "the GeoTIFF holds no heights: its numbers have one or more than four bytes";
/// TIFF tag in which GDAL stores additional data of a band.
const GDAL_METADATA: u16 = 42_112;

/// Cells of a raster in their order, row by row.
pub struct RasterValues {
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from north to south.
    pub rows: usize,
    /// Transform from columns and rows to the coordinates of the system; whole numbers are the
    /// middles of cells.
    pub transform: GeoTransform,
    /// Values as stored, NaN in cells without one.
    pub values: Vec<f32>,
    /// EPSG number of the system; `None` where the raster names none.
    pub epsg: Option<u16>,
    /// True if the values count downwards, as in [`RasterPoints::downwards`].
    pub downwards: bool,
}

/// Reads the cells of the first image of a file as points.
///
/// # Errors
/// When the file cannot be read, or contains no heights or no transform.
pub fn read_cells(path: &Path) -> Result<RasterPoints, CellsError> {
    CellsError::guard(|| points(Open::new(path)?))
}

/// Reads the first image of a file as a raster; its rows must run from west to east, the
/// northernmost row first.
///
/// # Errors
/// As for [`read_cells`], and when the raster is turned or upside down.
pub fn read_values(path: &Path) -> Result<RasterValues, CellsError> {
    CellsError::guard(|| values(Open::new(path)?))
}

/// Reason why no cells can be read from a raster, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum CellsError {
    /// The operating system cannot read the file.
    #[error("the GeoTIFF cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The file is no TIFF, or a TIFF of a kind that is not supported.
    #[error("the GeoTIFF cannot be read: {0}")]
    Tiff(#[from] TiffError),
    /// The file contradicts itself.
    #[error("the GeoTIFF cannot be read: {0}")]
    Damaged(&'static str),
    /// The raster is none that is read; the field is the sentence.
    #[error("{0}")]
    Unsuitable(String),
}

impl CellsError {
    fn unsuitable(what: impl Into<String>) -> Self {
        Self::Unsuitable(what.into())
    }

    /// Runs `read`; turns a panic of the decoder, which a damaged file can cause, into an error.
    pub(super) fn guard<T>(read: impl FnOnce() -> Result<T, Self>) -> Result<T, Self> {
        catch_panic(read).unwrap_or(Err(Self::Damaged("it is damaged")))
    }
}

/// Returns the memory limits of the decoder: blocks of at most [`LARGEST_BLOCK`] bytes, and for
/// small files less, by the size of the file.
fn limits(file: &File) -> io::Result<Limits> {
    let packed = usize::try_from(file.metadata()?.len()).unwrap_or(LARGEST_BLOCK);
    let mut limits = Limits::default();
    limits.decoding_buffer_size =
        packed.saturating_mul(4).saturating_add(SMALL_BLOCK).min(LARGEST_BLOCK);
    Ok(limits)
}

/// A raster that was opened and whose cells are not read yet.
struct Open {
    decoder: Decoder<BufReader<File>>,
    size: [u32; 2],
    keys: GeoKeys,
    place: GeoTransform,
    nodata: Option<f64>,
    downwards: bool,
}

impl Open {
    fn new(path: &Path) -> Result<Self, CellsError> {
        let file = regular_file::open(path)?;
        let limits = limits(&file)?;
        let mut file = BufReader::new(file);
        check_claims(&mut file)?;
        let decoder = Decoder::new(file)?;
        let mut decoder = decoder.with_limits(limits);
        let (columns, rows) = decoder.dimensions()?;
        if u64::from(columns) * u64::from(rows) > MOST_CELLS {
            return Err(CellsError::unsuitable(format!(
                "the GeoTIFF has {columns} by {rows} cells, more than {MOST_CELLS}; make a coarser one"
            )));
        }
        let colours = decoder.colortype()?;
        if !matches!(colours, tiff::ColorType::Gray(_)) {
            let what = "the GeoTIFF is a picture, not one band of heights or depths";
            return Err(CellsError::unsuitable(what));
        }
        if is_jpeg(&mut decoder) {
            return Err(CellsError::unsuitable(NO_HEIGHTS));
        }
        let keys = GeoKeys::read(&mut decoder);
        let nowhere =
            || CellsError::unsuitable("the TIFF does not say where it lies; write a GeoTIFF");
        let place = GeoTransform::read(&mut decoder, &keys).ok_or_else(nowhere)?.of_middles();
        let nodata = decoder.get_tag_ascii_string(Tag::GdalNodata).ok();
        let nodata = nodata.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
        let metadata = decoder.get_tag_ascii_string(Tag::Unknown(GDAL_METADATA));
        Ok(Self {
            decoder,
            size: [columns, rows],
            keys,
            place,
            nodata,
            downwards: metadata.is_ok_and(|text| counts_downwards(&text)),
        })
    }

    /// Calls `take` with the column, the row and the value of every cell that has a value.
    fn each_known(
        &mut self,
        mut take: impl FnMut([usize; 2], f64) -> Result<(), CellsError>,
    ) -> Result<(), CellsError> {
        let nodata = self.nodata;
        let known = |value: f64| value.is_finite() && nodata != Some(value);
        each_block(&mut self.decoder, self.size, |[column, row], width, values| {
            let cells = values.iter().enumerate();
            let mut cells = cells.filter(|(_, value)| known(**value));
            cells.try_for_each(|(index, value)| {
                take([column + index % width, row + index / width], *value)
            })
        })
    }
}

fn points(mut raster: Open) -> Result<RasterPoints, CellsError> {
    let mut points = Vec::new();
    let place = raster.place;
    raster.each_known(|at, value| {
        let [x, y] = place.at(at.map(|index| index as f64));
        points.push([x, y, value]);
        if points.len() > MOST_POINTS {
            return Err(CellsError::unsuitable(format!(
                "the GeoTIFF has more than {MOST_POINTS} cells with a value; cut it to the survey, or make it coarser"
            )));
        }
        Ok(())
    })?;
    Ok(RasterPoints {
        points,
        is_degrees: raster.keys.is_geographic(),
        projected: raster.keys.projected(),
        downwards: raster.downwards,
    })
}

fn values(mut raster: Open) -> Result<RasterValues, CellsError> {
    let [columns, rows] = raster.size.map(|count| count as usize);
    let is_upright = raster.place.per_column[0] > 0.0 && raster.place.per_row[1] < 0.0;
    if !is_upright || raster.place.per_column[1] != 0.0 || raster.place.per_row[0] != 0.0 {
        let what = "the GeoTIFF is turned or upside down; bring it into rows from west to east, north first";
        return Err(CellsError::unsuitable(what));
    }
    let mut values = vec![f32::NAN; columns * rows];
    raster.each_known(|[column, row], value| {
        let cell = values.get_mut(row * columns + column);
        *cell.ok_or(CellsError::Damaged("it has cells beyond its edge"))? = value as f32;
        Ok(())
    })?;
    let keys = &raster.keys;
    Ok(RasterValues {
        columns,
        rows,
        transform: raster.place,
        values,
        epsg: keys.projected().or_else(|| keys.geographic()),
        downwards: raster.downwards,
    })
}

/// Reads one strip or tile after the other, so that the picture is never decompressed as a whole,
/// and calls `take` with pieces of whole rows: the column and row of the first cell, the width, and
/// the values.
fn each_block(
    decoder: &mut Decoder<BufReader<File>>,
    [columns, rows]: [u32; 2],
    mut take: impl FnMut([usize; 2], usize, &[f64]) -> Result<(), CellsError>,
) -> Result<(), CellsError> {
    let (width, height) = decoder.chunk_dimensions();
    if width == 0 || height == 0 {
        return Err(CellsError::Damaged("it is cut into pieces without a cell"));
    }
    for row in 0..rows.div_ceil(height) {
        let across = columns.div_ceil(width);
        for column in 0..across {
            let block = row * across + column;
            let (shown, _) = decoder.chunk_data_dimensions(block);
            let shown = shown.max(1) as usize;
            let values = decoder.read_chunk(block)?;
            let first = [(column * width) as usize, (row * height) as usize];
            // Only a few rows at a time: as f64, a block may take several times its size.
            let step = (PIECE / shown).max(1) * shown;
            let mut start = 0;
            while let Some(piece) = numbers(&values, start..start + step)? {
                let below = start / shown;
                take([first[0], first[1] + below], shown, &piece)?;
                start += step;
            }
        }
    }
    Ok(())
}

/// Cells that are converted to f64 at a time.
const PIECE: usize = 1 << 20;

/// Returns a range of a block's numbers; `None` beyond the end of the block.
fn numbers(block: &DecodingResult, range: Range<usize>) -> Result<Option<Vec<f64>>, CellsError> {
    fn wide<T: Copy + Into<f64>>(values: &[T], range: Range<usize>) -> Option<Vec<f64>> {
        let values = values.get(range.start..range.end.min(values.len()))?;
        let wide = values.iter().map(|value| (*value).into()).collect();
        (!values.is_empty()).then_some(wide)
    }
    Ok(match block {
        DecodingResult::F32(values) => wide(values, range),
        DecodingResult::F64(values) => wide(values, range),
        DecodingResult::I16(values) => wide(values, range),
        DecodingResult::I32(values) => wide(values, range),
        DecodingResult::U16(values) => wide(values, range),
        DecodingResult::U32(values) => wide(values, range),
        _ => return Err(CellsError::unsuitable(NO_HEIGHTS)),
    })
}

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
