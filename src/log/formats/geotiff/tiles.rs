//! Reads a GeoTIFF of this program tile by tile, so that memory does not grow with its area.

use super::RASTER_TILE;
use super::cells::CellsError;
use super::claims::{check_claims, is_jpeg};
use crate::support::regular_file;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// A raster of one band in tiles of [`RASTER_TILE`]. The file is only open during a read, so that
/// many rasters can be used at once.
#[derive(Clone, Debug)]
pub struct RasterTiles {
    path: PathBuf,
    /// Number of cells from west to east, and from north to south.
    columns: usize,
    rows: usize,
    /// True for each tile that may have known cells, by row and column of the tile.
    filled: Vec<bool>,
}

impl RasterTiles {
    /// Opens a file and finds which of its tiles are not empty.
    ///
    /// # Errors
    /// When the file cannot be read, or is not a raster of this program.
    pub fn open(path: &Path) -> Result<Self, CellsError> {
        CellsError::guard(|| Self::opened(path))
    }

    fn opened(path: &Path) -> Result<Self, CellsError> {
        let mut decoder = decoder(path)?;
        let [columns, rows] = size(&mut decoder)?;
        let places = decoder.get_tag_u64_vec(Tag::TileOffsets)?;
        let [down, across] = [rows, columns].map(|cells| cells.div_ceil(RASTER_TILE));
        if places.len() != down * across {
            return Err(CellsError::Damaged("it lacks tiles"));
        }
        // All empty tiles share one place.
        let mut at: BTreeMap<u64, usize> = BTreeMap::new();
        for place in &places {
            *at.entry(*place).or_default() += 1;
        }
        Ok(Self {
            path: path.to_owned(),
            columns,
            rows,
            filled: places.iter().map(|place| at[place] == 1).collect(),
        })
    }

    /// Returns the number of cells from west to east, and from north to south.
    pub fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// Returns true if a tile, given by row and column, may have known cells.
    pub fn may_hold(&self, [row, column]: [usize; 2]) -> bool {
        let across = self.columns.div_ceil(RASTER_TILE);
        column < across && self.filled.get(row * across + column) == Some(&true)
    }

    /// Returns the row and column of each tile that may have known cells.
    pub fn tiles(&self) -> impl Iterator<Item = [usize; 2]> {
        let across = self.columns.div_ceil(RASTER_TILE).max(1);
        let filled = self.filled.iter().enumerate().filter(|(_, filled)| **filled);
        filled.map(move |(tile, _)| [tile / across, tile % across])
    }

    /// Returns the cells of a tile of bytes: [`RASTER_TILE`] rows of as many cells, 0 beyond the
    /// raster's edge.
    ///
    /// # Errors
    /// When the file cannot be read, or its cells are no bytes.
    pub fn levels(&self, tile: [usize; 2]) -> Result<Vec<u8>, CellsError> {
        self.read(tile, 0, |read| match read {
            DecodingResult::U8(levels) => Some(levels),
            _ => None,
        })
    }

    /// Returns the cells of a tile of 32-bit floating-point numbers, as stored, otherwise like
    /// [`RasterTiles::levels`].
    ///
    /// # Errors
    /// When the file cannot be read, or its cells are no such numbers.
    pub fn values(&self, tile: [usize; 2]) -> Result<Vec<f32>, CellsError> {
        self.read(tile, 0.0, |read| match read {
            DecodingResult::F32(values) => Some(values),
            _ => None,
        })
    }

    /// Returns all cells of the overview after `halvings` halvings, or of the raster itself (0):
    /// rows of bytes, 0 where nothing is known.
    ///
    /// # Errors
    /// When the file cannot be read, its cells are no bytes, or there is no such overview.
    pub fn overview(&self, halvings: usize) -> Result<Vec<u8>, CellsError> {
        let read = || {
            let mut decoder = decoder(&self.path)?;
            // Each level is followed by its mask.
            decoder.seek_to_image(2 * halvings)?;
            let found = <[u32; 2]>::from(decoder.dimensions()?).map(|cells| cells as usize);
            if found != self.overview_size(halvings) {
                return Err(CellsError::Damaged("it lacks an overview"));
            }
            match decoder.read_image()? {
                DecodingResult::U8(levels) => Ok(levels),
                _ => Err(CellsError::Damaged("its cells are of another kind")),
            }
        };
        CellsError::guard(read)
    }

    /// Returns the cells of an overview from west to east, and from north to south.
    pub(crate) fn overview_size(&self, halvings: usize) -> [usize; 2] {
        (0..halvings).fold(self.size(), |size, _| size.map(|cells| cells.div_ceil(2)))
    }

    fn read<T: Copy>(
        &self,
        tile: [usize; 2],
        beyond: T,
        of_kind: impl Fn(DecodingResult) -> Option<Vec<T>>,
    ) -> Result<Vec<T>, CellsError> {
        let read = || {
            let mut decoder = decoder(&self.path)?;
            if size(&mut decoder)? != self.size() {
                return Err(CellsError::Damaged("it changed while it was read"));
            }
            let across = self.columns.div_ceil(RASTER_TILE);
            let chunk = u32::try_from(tile[0] * across + tile[1])
                .map_err(|_| CellsError::Damaged("it has no such tile"))?;
            let shown = decoder.chunk_data_dimensions(chunk).0 as usize;
            let cells = of_kind(decoder.read_chunk(chunk)?)
                .ok_or(CellsError::Damaged("its cells are of another kind"))?;
            Ok(whole(&cells, shown, beyond))
        };
        CellsError::guard(read)
    }
}

/// Returns a tile with all rows and columns, from cells with `shown` columns; the rest is `beyond`.
fn whole<T: Copy>(cells: &[T], shown: usize, beyond: T) -> Vec<T> {
    let mut tile = vec![beyond; RASTER_TILE * RASTER_TILE];
    let rows = cells.chunks(shown.clamp(1, RASTER_TILE));
    for (row, cells) in tile.chunks_mut(RASTER_TILE).zip(rows) {
        row[..cells.len()].copy_from_slice(cells);
    }
    tile
}

fn decoder(path: &Path) -> Result<Decoder<BufReader<File>>, CellsError> {
    let mut file = BufReader::new(regular_file::open(path)?);
    check_claims(&mut file)?;
    let mut limits = Limits::default();
    // A cell has at most eight bytes.
    limits.decoding_buffer_size = 8 * RASTER_TILE * RASTER_TILE;
    let mut decoder = Decoder::new(file)?.with_limits(limits);
    match decoder.colortype()? {
        ColorType::Gray(_) if is_jpeg(&mut decoder) => {
            Err(CellsError::Damaged("its cells are of another kind"))
        }
        ColorType::Gray(_) => Ok(decoder),
        _ => Err(CellsError::Damaged("it has several bands")),
    }
}

fn size(decoder: &mut Decoder<BufReader<File>>) -> Result<[usize; 2], CellsError> {
    let [width, height] = <[u32; 2]>::from(decoder.chunk_dimensions());
    if [width, height].map(|side| side as usize) != [RASTER_TILE; 2] {
        return Err(CellsError::Damaged("its tiles are of another size"));
    }
    Ok(<[u32; 2]>::from(decoder.dimensions()?).map(|cells| cells as usize))
}
