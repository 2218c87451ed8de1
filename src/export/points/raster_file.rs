//! The cells of a GeoTIFF as points: one band of numbers, in strips or tiles, plain or packed with deflate or LZW.

use super::elevations::Plane;
use crate::contained::contained;
use crate::export::geotiff;
use crate::regular_file;
use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// What a raster holds.
pub(super) struct RasterPoints {
    /// x and y of the middle of each cell that has a value, and the value as stored.
    pub points: Vec<[f64; 3]>,
    pub plane: Plane,
    /// Whether the raster says of itself that its values count downwards, as the depths of `bathyscope process` do.
    pub downwards: bool,
}

/// More cells than this are refused, known or not.
const MOST_CELLS: u64 = 50_000_000;
/// More known cells than this are refused: as points, and triangles between them, they would fill the memory. A few hundred bytes of
/// a packed file are enough to ask for as many.
const MOST_POINTS: usize = 4_000_000;
/// Bytes of a strip or tile, unpacked.
const LARGEST_BLOCK: usize = 256 << 20;
/// Geo keys: kind of system, whether a value stands for a cell or its corner, and the systems' EPSG numbers.
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC: u16 = 2048;
const PROJECTED: u16 = 3072;
const IS_GEOGRAPHIC: u16 = 2;
/// Tag in which GDAL keeps what it adds to a band.
const GDAL_METADATA: u16 = 42_112;
const IS_POINT: u16 = 2;

/// Reads the first image of a file. The error is a sentence without the path.
pub(super) fn read(path: &Path) -> Result<RasterPoints, String> {
    contained(|| read_open(path))
        .unwrap_or_else(|| Err("the GeoTIFF cannot be read: it is damaged".to_owned()))
}

fn unusable(error: impl std::fmt::Display) -> String {
    format!("the GeoTIFF cannot be read: {error}")
}

fn read_open(path: &Path) -> Result<RasterPoints, String> {
    let file = regular_file::open(path).map_err(unusable)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = LARGEST_BLOCK;
    let decoder = Decoder::new(BufReader::new(file)).map_err(unusable)?;
    let mut decoder = decoder.with_limits(limits);
    let (columns, rows) = decoder.dimensions().map_err(unusable)?;
    if u64::from(columns) * u64::from(rows) > MOST_CELLS {
        return Err(format!(
            "the GeoTIFF has {columns} by {rows} cells, more than {MOST_CELLS}; make a coarser one"
        ));
    }
    let colours = decoder.colortype().map_err(unusable)?;
    if !matches!(colours, tiff::ColorType::Gray(_)) {
        return Err("the GeoTIFF is a picture, not one band of heights or depths".to_owned());
    }
    let keys = GeoKeys::of(&mut decoder);
    let place = Place::of(&mut decoder, keys.value(RASTER_TYPE) == Some(IS_POINT))?;
    let nodata = decoder.get_tag_ascii_string(Tag::GdalNodata).ok();
    let nodata = nodata.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
    let downwards = counts_downwards(&mut decoder);
    let known = |value: f64| value.is_finite() && nodata != Some(value);
    let mut points = Vec::new();
    each_block(
        &mut decoder,
        [columns, rows],
        |[column, row], width, values| {
            for (index, value) in values.iter().enumerate() {
                if known(*value) {
                    let at = [column + index % width, row + index / width];
                    let [x, y] = place.of_cell(at[0] as f64, at[1] as f64);
                    points.push([x, y, *value]);
                }
            }
            match points.len() > MOST_POINTS {
                true => Err(format!(
                    "the GeoTIFF has more than {MOST_POINTS} cells with a value; cut it to the survey, or make it coarser"
                )),
                false => Ok(()),
            }
        },
    )?;
    Ok(RasterPoints {
        points,
        plane: keys.plane(),
        downwards,
    })
}

/// Whether values are depths: an item in GDAL's tag says so, or the description that older rasters of `bathyscope process` have.
fn counts_downwards(decoder: &mut Tiff) -> bool {
    let metadata = decoder.get_tag_ascii_string(Tag::Unknown(GDAL_METADATA));
    let description = decoder.get_tag_ascii_string(Tag::ImageDescription);
    metadata.is_ok_and(|text| geotiff::counts_downwards(&text))
        || description.is_ok_and(|text| text.starts_with("Depth in metres, positive down"))
}

/// Hands over one strip or tile after the other, so that the picture is never unpacked as a whole: column and row of its first cell,
/// its width, and pieces of whole rows of it.
fn each_block(
    decoder: &mut Tiff,
    [columns, rows]: [u32; 2],
    mut take: impl FnMut([usize; 2], usize, &[f64]) -> Result<(), String>,
) -> Result<(), String> {
    let (width, height) = decoder.chunk_dimensions();
    if width == 0 || height == 0 {
        return Err("the GeoTIFF cannot be read: it is cut into pieces without a cell".to_owned());
    }
    for row in 0..rows.div_ceil(height) {
        let across = columns.div_ceil(width);
        for column in 0..across {
            let block = row * across + column;
            let (shown, _) = decoder.chunk_data_dimensions(block);
            let shown = shown.max(1) as usize;
            let values = decoder.read_chunk(block).map_err(unusable)?;
            let first = [(column * width) as usize, (row * height) as usize];
            // Few rows at a time: as f64 a block may be twice its size.
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

/// Cells that become f64 at a time.
const PIECE: usize = 1 << 20;

/// Some of a block's numbers; `None` beyond its end.
fn numbers(block: &DecodingResult, range: Range<usize>) -> Result<Option<Vec<f64>>, String> {
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
        _ => {
            return Err(
                "the GeoTIFF holds no heights: its numbers have one or more than four bytes"
                    .to_owned(),
            );
        }
    })
}

/// Where cells lie: `ModelPixelScale` with `ModelTiepoint`, or `ModelTransformation`.
struct Place {
    origin: [f64; 2],
    per_column: [f64; 2],
    per_row: [f64; 2],
}

type Tiff = Decoder<BufReader<File>>;

impl Place {
    /// `is_point`: the numbers place the middle of a cell, not its corner.
    fn of(decoder: &mut Tiff, is_point: bool) -> Result<Self, String> {
        let mut numbers = |tag| decoder.get_tag_f64_vec(tag).unwrap_or_default();
        let (scale, tie) = (
            numbers(Tag::ModelPixelScaleTag),
            numbers(Tag::ModelTiepointTag),
        );
        let matrix = numbers(Tag::ModelTransformationTag);
        let mut made = match (scale.as_slice(), tie.as_slice(), matrix.as_slice()) {
            ([dx, dy, ..], [column, row, _, x, y, ..], _) => Self {
                origin: [x - column * dx, y + row * dy],
                per_column: [*dx, 0.0],
                per_row: [0.0, -dy],
            },
            (_, _, [a, b, _, x, c, d, _, y, ..]) => Self {
                origin: [*x, *y],
                per_column: [*a, *c],
                per_row: [*b, *d],
            },
            _ => return Err("the TIFF does not say where it lies; write a GeoTIFF".to_owned()),
        };
        if !is_point {
            made.origin = made.of_cell(0.5, 0.5);
        }
        Ok(made)
    }

    fn of_cell(&self, column: f64, row: f64) -> [f64; 2] {
        [0, 1].map(|axis| {
            self.origin[axis] + column * self.per_column[axis] + row * self.per_row[axis]
        })
    }
}

/// The keys of the system that have short values.
struct GeoKeys(Vec<u16>);

impl GeoKeys {
    fn of(decoder: &mut Tiff) -> Self {
        let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag);
        Self(keys.unwrap_or_default())
    }

    /// Entries are a key, where its value lies (0: here), how many, and the value.
    fn value(&self, key: u16) -> Option<u16> {
        let entries = self.0.chunks_exact(4).skip(1);
        let found = entries
            .into_iter()
            .find(|entry| entry[0] == key && entry[1] == 0);
        found.map(|entry| entry[3])
    }

    fn plane(&self) -> Plane {
        let is_geographic = self.value(MODEL_TYPE) == Some(IS_GEOGRAPHIC)
            || self.value(PROJECTED).is_none() && self.value(GEOGRAPHIC).is_some();
        match is_geographic {
            true => Plane::Degrees,
            false => Plane::of_epsg(self.value(PROJECTED).map(u32::from), Plane::Metres),
        }
    }
}
