//! Reads and writes GeoTIFF: rasters with a position on Earth, in tiles, compressed, with
//! overviews, laid out as a Cloud-Optimized GeoTIFF. Files are written tile by tile, so that memory
//! does not grow with the area.
//!
//! In: cells with a position on Earth, or a file. Out: a file, or the cells of a file.
//!
//! Follows TIFF 6.0 with the tiles of its section 15 and deflate; GeoTIFF 1.1 (OGC 19-008) with an
//! EPSG system and pixels that are areas; OGC 21-026 for the order: all directories at the front,
//! the full picture first, then the tiles, the coarsest overview first; nodata, mask, band names,
//! units and statistics as GDAL writes them.
//!
//! ```text
//! draw --pack--> tiles in a scratch file --halve--> coarser tiles there --writer--> directories, then all tiles in order
//! ```
//!
//! `writer` also lays out the tags, `metadata` writes GDAL's data of a band. `cells` reads a raster
//! of any program, as points or cell by cell, and gives the position of cells, also for the pixels
//! of a base map; `tiles` reads a raster of this program tile by tile. `claims` checks the sizes
//! that a file claims before a decoder allocates memory by them.

mod cells;
mod claims;
mod metadata;
mod pack;
mod tiles;
mod writer;

pub(crate) use cells::GeoKeys;
pub use cells::{CellsError, GeoTransform, RasterValues, read_cells, read_values};
pub use claims::check_claims;
pub(crate) use claims::{DirectoryWalk, JpegBlocks};
pub use tiles::RasterTiles;

use crate::support::geo::Crs;
use crate::support::progress::Progress;
use std::fs::File;
use std::io;
use writer::RasterWriter;

/// Rows and columns of a tile.
pub const RASTER_TILE: usize = 256;
/// Value for "nothing known" in a raster of metres.
pub const NODATA: f32 = -9999.0;

/// Content of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellFormat {
    /// Red, green, blue, opacity; one byte each.
    Rgba,
    /// A level of one byte, 0 where nothing is known; a mask in the file marks the same cells.
    Level,
    /// The number of a class, one byte, 0 where nothing is known; a mask in the file marks the same
    /// cells. A coarser cell has the greatest class of its four cells.
    Class,
    /// Metres as f32, little-endian, [`NODATA`] where nothing is known.
    Metres,
}

impl CellFormat {
    /// Returns the bytes of a cell.
    fn bytes(self) -> usize {
        self.empty().len()
    }

    /// Returns a cell without a known value.
    fn empty(self) -> &'static [u8] {
        const METRES: [u8; 4] = NODATA.to_le_bytes();
        match self {
            CellFormat::Rgba => &[0; 4],
            CellFormat::Level | CellFormat::Class => &[0],
            CellFormat::Metres => &METRES,
        }
    }

    /// Returns a tile without a known value.
    fn empty_tile(self) -> Vec<u8> {
        self.empty().repeat(RASTER_TILE * RASTER_TILE)
    }
}

/// Meaning of the values of a raster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Band {
    /// Name of the band, as `depth`.
    pub name: &'static str,
    /// Unit of the values; empty where they have none.
    pub unit: &'static str,
    /// True if greater values are deeper, as in the attribute `positive` of the CF conventions.
    pub positive_down: bool,
}

impl Band {
    /// Band of a mosaic in grey levels.
    pub const ECHO_LEVEL: Self = Self { name: "echo level", unit: "", positive_down: false };
}

/// Content and position of a raster.
#[derive(Clone, Debug)]
pub struct RasterSpec {
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from north to south.
    pub rows: usize,
    /// West edge, in the unit of the coordinate system.
    pub west: f64,
    /// North edge, in the unit of the coordinate system.
    pub north: f64,
    /// Width and height of a cell, in the unit of the coordinate system.
    pub cell: [f64; 2],
    /// Coordinate system of the edges and the cell size.
    pub crs: Crs,
    /// Content of a cell.
    pub cells: CellFormat,
    /// Meaning of the values; `None` for a picture in colours.
    pub band: Option<Band>,
    /// Description of the raster for its readers.
    pub description: String,
}

/// Writes a GeoTIFF into an open file. `tiles` are the row and column of each tile that is not
/// empty; `draw` returns the cells of a tile, [`RASTER_TILE`] rows of as many cells, and is called
/// from several threads. Cells beyond the raster's edge in the last tiles must be empty. `scratch`
/// is an empty file, open for reading and writing, that stores the tiles in between.
///
/// # Errors
/// When the operating system or `draw` reports an error, the raster exceeds 4 GB, the limit of the
/// format, or the work was cancelled.
pub fn write(
    file: File,
    scratch: File,
    spec: &RasterSpec,
    tiles: &[[usize; 2]],
    draw: impl Fn([usize; 2]) -> io::Result<Vec<u8>> + Sync,
    progress: &Progress,
) -> io::Result<()> {
    // Each overview has about a quarter of the tiles of the level before it.
    progress.start((tiles.len() + tiles.len() / 3).max(1) as u64);
    let mut raster = RasterWriter::new(spec, scratch);
    raster.base(tiles, draw, progress)?;
    while raster.overview(progress)? {}
    raster.write(file, progress)
}

#[cfg(test)]
mod tests;
