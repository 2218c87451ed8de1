//! GeoTIFF: rasters with a place on the earth, in tiles, compressed, with overviews. Written tile by tile, so that memory does
//! not grow with the area.
//!
//! TIFF 6.0 with the tiles of its section 15 and deflate; GeoTIFF 1.1 (OGC 19-008) with an EPSG system and pixels that are
//! areas; nodata as GDAL writes it. `directory` lays out the tags, `overview` halves tiles.

mod directory;
mod overview;

use super::{ExportError, write_aside};
use crate::geo::Crs;
use crate::progress::{Cancelled, Progress};
use directory::{Tag, directory};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// Rows and columns of a tile.
pub const RASTER_TILE: usize = 256;
/// Tiles that are drawn and held at a time.
const BATCH: usize = 32;
/// Stands for "nothing known" in a raster of metres.
pub const NODATA: f32 = -9999.0;

/// What a cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// Red, green, blue, opacity; one byte each.
    Rgba,
    /// Metres as f32, little-endian, [`NODATA`] where nothing is known.
    Metres,
}

impl Cells {
    fn bytes(self) -> usize {
        4
    }

    fn empty(self) -> [u8; 4] {
        match self {
            Cells::Rgba => [0; 4],
            Cells::Metres => NODATA.to_le_bytes(),
        }
    }
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
    /// What a cell holds.
    pub cells: Cells,
    /// What the raster shows, for people.
    pub description: String,
}

/// Why there is no raster.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] ExportError),
    /// Told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Writes a GeoTIFF. `tiles` are those that hold something, as row and column; `draw` makes one, [`RASTER_TILE`] rows of as
/// many cells of four bytes, and is called from several threads. What lies beyond the raster's edge in the last tiles is not
/// shown. Fails beyond 4 GB, which is as far as the format reaches.
pub fn geotiff(
    path: &Path,
    spec: &RasterSpec,
    tiles: &[[usize; 2]],
    draw: impl Fn([usize; 2]) -> Vec<u8> + Sync,
    progress: &Progress,
) -> Result<(), RasterError> {
    // Each overview has a quarter of the tiles of the level before it.
    progress.start((tiles.len() + tiles.len() / 3).max(1) as u64);
    let written = write_aside(path, |file| {
        let mut raster = Writer::new(file, spec)?;
        raster.base(tiles, draw, progress)?;
        while raster.overview(progress)? {}
        raster.finish()
    });
    progress.check()?;
    Ok(written?)
}

/// One resolution of the raster.
struct Level {
    columns: usize,
    rows: usize,
    /// Offset and length in the file, by row and column of the tile.
    tiles: BTreeMap<[usize; 2], [u32; 2]>,
}

impl Level {
    fn across(&self) -> [usize; 2] {
        [self.rows, self.columns].map(|cells| cells.div_ceil(RASTER_TILE))
    }
}

struct Writer<'a> {
    file: File,
    spec: &'a RasterSpec,
    at: u64,
    levels: Vec<Level>,
}

impl<'a> Writer<'a> {
    fn new(mut file: File, spec: &'a RasterSpec) -> io::Result<Self> {
        // Little-endian, TIFF; the first directory's place is filled in at the end.
        file.write_all(b"II\x2a\0\0\0\0\0")?;
        Ok(Self {
            file,
            spec,
            at: 8,
            levels: Vec::new(),
        })
    }

    /// Writes a block at the end, at an even place as the format wants it.
    fn append(&mut self, bytes: &[u8]) -> io::Result<[u32; 2]> {
        let fits = u32::try_from(self.at + bytes.len() as u64 + 1).is_ok();
        if !fits {
            return Err(io::Error::other(
                "the raster would pass 4 GB, which TIFF cannot hold; choose larger cells",
            ));
        }
        let place = [self.at as u32, bytes.len() as u32];
        self.file.write_all(bytes)?;
        self.at += bytes.len() as u64;
        if bytes.len() % 2 == 1 {
            self.file.write_all(&[0])?;
            self.at += 1;
        }
        Ok(place)
    }

    /// The raster itself.
    fn base(
        &mut self,
        tiles: &[[usize; 2]],
        draw: impl Fn([usize; 2]) -> Vec<u8> + Sync,
        progress: &Progress,
    ) -> io::Result<()> {
        let cells = self.spec.cells;
        self.levels.push(Level {
            columns: self.spec.columns,
            rows: self.spec.rows,
            tiles: BTreeMap::new(),
        });
        for batch in tiles.chunks(BATCH) {
            progress.check().map_err(io::Error::other)?;
            let packed = batch.par_iter().map(|&tile| pack(cells, draw(tile)));
            let packed = packed.collect::<io::Result<Vec<_>>>()?;
            self.keep(batch, &packed, progress)?;
        }
        Ok(())
    }

    fn keep(
        &mut self,
        tiles: &[[usize; 2]],
        packed: &[Vec<u8>],
        progress: &Progress,
    ) -> io::Result<()> {
        for (tile, bytes) in tiles.iter().zip(packed) {
            let place = self.append(bytes)?;
            if let Some(level) = self.levels.last_mut() {
                level.tiles.insert(*tile, place);
            }
            progress.advance(1);
        }
        Ok(())
    }

    /// Adds a level of half the resolution, read back from the one before; false when that fits one tile.
    fn overview(&mut self, progress: &Progress) -> io::Result<bool> {
        let Some(finer) = self.levels.last() else {
            return Ok(false);
        };
        if finer.columns <= RASTER_TILE && finer.rows <= RASTER_TILE {
            return Ok(false);
        }
        let (columns, rows) = (finer.columns.div_ceil(2), finer.rows.div_ceil(2));
        let mut tiles: Vec<[usize; 2]> = finer
            .tiles
            .keys()
            .map(|tile| tile.map(|index| index / 2))
            .collect();
        tiles.sort_unstable();
        tiles.dedup();
        let finer = finer.tiles.clone();
        self.levels.push(Level {
            columns,
            rows,
            tiles: BTreeMap::new(),
        });
        for batch in tiles.chunks(BATCH / 4) {
            progress.check().map_err(io::Error::other)?;
            let mut parts = Vec::with_capacity(batch.len());
            for tile in batch {
                parts.push(self.parts(&finer, *tile)?);
            }
            let cells = self.spec.cells;
            let packed = parts.into_par_iter().map(|parts| {
                let mut tile = cells.empty().repeat(RASTER_TILE * RASTER_TILE);
                for (quarter, bytes) in parts {
                    overview::halve_into(cells, &unpack(cells, &bytes)?, quarter, &mut tile);
                }
                pack(cells, tile)
            });
            let packed = packed.collect::<io::Result<Vec<_>>>()?;
            self.keep(batch, &packed, progress)?;
        }
        Ok(true)
    }

    /// The compressed finer tiles that make a tile: which quarter, and the bytes.
    fn parts(
        &mut self,
        finer: &BTreeMap<[usize; 2], [u32; 2]>,
        [row, column]: [usize; 2],
    ) -> io::Result<Vec<([usize; 2], Vec<u8>)>> {
        let mut parts = Vec::with_capacity(4);
        for quarter in [[0, 0], [0, 1], [1, 0], [1, 1]] {
            let tile = [2 * row + quarter[0], 2 * column + quarter[1]];
            if let Some(&[offset, length]) = finer.get(&tile) {
                let mut bytes = vec![0; length as usize];
                self.file.seek(SeekFrom::Start(u64::from(offset)))?;
                self.file.read_exact(&mut bytes)?;
                parts.push((quarter, bytes));
            }
        }
        self.file.seek(SeekFrom::Start(self.at))?;
        Ok(parts)
    }

    /// Writes the directories, the full resolution first, and links them.
    fn finish(mut self) -> io::Result<()> {
        let empty = self.spec.cells.empty().repeat(RASTER_TILE * RASTER_TILE);
        let nothing = pack(self.spec.cells, empty)?;
        let nothing = self.append(&nothing)?;
        let levels = std::mem::take(&mut self.levels);
        let mut link = 4;
        for (index, level) in levels.iter().enumerate() {
            let [down, across] = level.across();
            let places = (0..down).flat_map(|row| (0..across).map(move |column| [row, column]));
            let places: Vec<[u32; 2]> = places
                .map(|tile| level.tiles.get(&tile).copied().unwrap_or(nothing))
                .collect();
            let tags: Vec<Tag> =
                directory::tags(self.spec, [level.columns, level.rows], index > 0, &places);
            let start = self.at;
            let (bytes, next) = directory(&tags, start);
            self.append(&bytes)?;
            self.file.seek(SeekFrom::Start(link))?;
            self.file.write_all(&(start as u32).to_le_bytes())?;
            self.file.seek(SeekFrom::Start(self.at))?;
            link = next;
        }
        self.file.flush()
    }
}

/// Compresses a tile; bytes of colour as differences to the cell before (predictor 2).
fn pack(cells: Cells, mut bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    if cells == Cells::Rgba {
        for row in bytes.chunks_exact_mut(RASTER_TILE * cells.bytes()) {
            for at in (cells.bytes()..row.len()).rev() {
                row[at] = row[at].wrapping_sub(row[at - cells.bytes()]);
            }
        }
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(5));
    encoder.write_all(&bytes)?;
    encoder.finish()
}

/// Inverse of [`pack`].
fn unpack(cells: Cells, packed: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(RASTER_TILE * RASTER_TILE * cells.bytes());
    ZlibDecoder::new(packed).read_to_end(&mut bytes)?;
    if cells == Cells::Rgba {
        for row in bytes.chunks_exact_mut(RASTER_TILE * cells.bytes()) {
            for at in cells.bytes()..row.len() {
                row[at] = row[at].wrapping_add(row[at - cells.bytes()]);
            }
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests;
