//! GeoTIFF: rasters with a place on the earth, in tiles, compressed, with overviews, laid out as a
//! Cloud-Optimized GeoTIFF. Written tile by tile, so that memory does not grow with the area.
//!
//! In: cells with a place on the earth, or a file. Out: a file, or the cells of one.
//!
//! TIFF 6.0 with the tiles of its section 15 and deflate; GeoTIFF 1.1 (OGC 19-008) with an EPSG
//! system and pixels that are areas; OGC 21-026 for the order: all directories at the front, the
//! full picture first, then the tiles, the coarsest overview first; nodata, mask, band names, units
//! and statistics as GDAL writes them.
//!
//! ```text
//! draw --pack--> tiles in a scratch file --halve--> coarser tiles there --writer--> directories, then all tiles in order
//! ```
//!
//! `directory` lays out the tags, `metadata` what GDAL adds to a band. `cells` reads a raster of
//! any program back, as points or cell by cell, `tiles` one of our own tile by tile; `geotransform`
//! is where its cells lie, also for the pixels of a base map. `directory_walk` and `jpeg_blocks`
//! look up what a file claims before a decoder allocates by it.

mod cells;
mod directory;
mod directory_walk;
mod geotransform;
mod jpeg_blocks;
mod metadata;
mod pack;
mod tiles;
mod writer;

pub use cells::{CellsError, RasterValues, read_cells, read_values};
pub(crate) use directory_walk::DirectoryWalk;
pub use directory_walk::check_claims;
pub(crate) use geotransform::GeoKeys;
pub use geotransform::GeoTransform;
pub(crate) use jpeg_blocks::JpegBlocks;
pub use tiles::RasterTiles;

use crate::support::geo::Crs;
use crate::support::progress::Progress;
use std::fs::File;
use std::io;
use writer::RasterWriter;

/// Rows and columns of a tile.
pub const RASTER_TILE: usize = 256;
/// Stands for "nothing known" in a raster of metres.
pub const NODATA: f32 = -9999.0;

/// Content of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellFormat {
    /// Red, green, blue, opacity; one byte each.
    Rgba,
    /// A level of one byte, 0 where nothing is known; a mask in the file says so too.
    Level,
    /// The number of a class, one byte, 0 where nothing is known; a mask in the file says so too.
    /// Of four cells the coarser one has the greatest.
    Class,
    /// Metres as f32, little-endian, [`NODATA`] where nothing is known.
    Metres,
}

impl CellFormat {
    /// Bytes of a cell.
    fn bytes(self) -> usize {
        self.empty().len()
    }

    /// The cell of which nothing is known.
    fn empty(self) -> &'static [u8] {
        const METRES: [u8; 4] = NODATA.to_le_bytes();
        match self {
            CellFormat::Rgba => &[0; 4],
            CellFormat::Level | CellFormat::Class => &[0],
            CellFormat::Metres => &METRES,
        }
    }

    /// A tile of which nothing is known.
    fn empty_tile(self) -> Vec<u8> {
        self.empty().repeat(RASTER_TILE * RASTER_TILE)
    }
}

/// Meaning of the values of a raster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Band {
    /// Its name: `depth`.
    pub name: &'static str,
    /// The unit of its values, empty where they have none.
    pub unit: &'static str,
    /// True if greater values lie deeper, as the attribute `positive` of the CF conventions says.
    pub positive_down: bool,
}

impl Band {
    /// Band of a grey mosaic.
    pub const ECHO_LEVEL: Self = Self { name: "echo level", unit: "", positive_down: false };
}

/// A raster and its place.
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
    /// The coordinate system.
    pub crs: Crs,
    /// Content of a cell.
    pub cells: CellFormat,
    /// Meaning of the values; `None` for a picture in colours.
    pub band: Option<Band>,
    /// Description of the raster, for people.
    pub description: String,
}

/// Writes a GeoTIFF into a file that is open for it. `tiles` are those that hold something, as row
/// and column; `draw` makes one, [`RASTER_TILE`] rows of as many cells, and is called from several
/// threads. What lies beyond the raster's edge in the last tiles must be empty. On the way the
/// tiles lie in `scratch`, an empty file that is open for reading and writing.
///
/// # Errors
/// What the system or `draw` says; that the raster passes 4 GB, which is as far as the format
/// reaches; or that the work was cancelled.
pub fn write(
    file: File,
    scratch: File,
    spec: &RasterSpec,
    tiles: &[[usize; 2]],
    draw: impl Fn([usize; 2]) -> io::Result<Vec<u8>> + Sync,
    progress: &Progress,
) -> io::Result<()> {
    // Each overview has a quarter of the tiles of the level before it.
    progress.start((tiles.len() + tiles.len() / 3).max(1) as u64);
    let mut raster = RasterWriter::new(spec, scratch);
    raster.base(tiles, draw, progress)?;
    while raster.overview(progress)? {}
    raster.write(file, progress)
}

#[cfg(test)]
mod tests;
