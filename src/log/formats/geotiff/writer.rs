//! Builds all levels of a raster and writes them in the order of a Cloud-Optimized GeoTIFF, behind
//! the directories with their tags.

use super::metadata::{Statistics, gdal_metadata};
use super::pack::{Packed, halve_into, pack, unpack};
use super::{CellFormat, NODATA, RASTER_TILE, RasterSpec};
use crate::support::progress::Progress;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};

/// Number of tiles that are drawn and in memory at a time.
const BATCH: usize = 32;

/// Place of some bytes in the scratch file.
#[derive(Clone, Copy, Debug)]
struct ScratchBlock {
    at: u64,
    /// Number of bytes.
    length: u32,
}

/// Places of a tile and of its mask in the scratch file; the mask is `None` in a raster whose kind
/// of cells has no mask.
#[derive(Clone, Copy, Debug)]
struct ScratchTile {
    image: ScratchBlock,
    mask: Option<ScratchBlock>,
}

/// Temporary file of compressed tiles in the order of drawing, used until the lengths of all tiles
/// are known.
struct Scratch {
    file: File,
    end: u64,
}

impl Scratch {
    /// Appends a tile and its mask; returns their places.
    fn keep(&mut self, packed: &Packed) -> io::Result<ScratchTile> {
        let image = self.append(&packed.image)?;
        let mask = packed.mask.as_deref().map(|mask| self.append(mask)).transpose()?;
        Ok(ScratchTile { image, mask })
    }

    fn append(&mut self, bytes: &[u8]) -> io::Result<ScratchBlock> {
        let length = u32::try_from(bytes.len()).map_err(io::Error::other)?;
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(bytes)?;
        let block = ScratchBlock { at: self.end, length };
        self.end += u64::from(length);
        Ok(block)
    }

    /// Replaces `out` with the bytes of a block.
    fn read(&mut self, block: ScratchBlock, out: &mut Vec<u8>) -> io::Result<()> {
        out.resize(block.length as usize, 0);
        self.file.seek(SeekFrom::Start(block.at))?;
        self.file.read_exact(out)
    }
}

/// One level of resolution of the raster.
struct RasterLevel {
    columns: usize,
    rows: usize,
    /// Tiles by their row and column; missing tiles are empty.
    tiles: BTreeMap<[usize; 2], ScratchTile>,
}

impl RasterLevel {
    /// Returns the number of rows and columns of tiles.
    fn across(&self) -> [usize; 2] {
        [self.rows, self.columns].map(|cells| cells.div_ceil(RASTER_TILE))
    }
}

/// Collects the levels of a raster and writes them to a file.
pub(super) struct RasterWriter<'a> {
    spec: &'a RasterSpec,
    scratch: Scratch,
    /// Levels of resolution, the full resolution first.
    levels: Vec<RasterLevel>,
    statistics: Statistics,
}

impl<'a> RasterWriter<'a> {
    /// Creates a writer without tiles; `scratch` is an empty file.
    pub(super) fn new(spec: &'a RasterSpec, scratch: File) -> Self {
        let scratch = Scratch { file: scratch, end: 0 };
        Self { spec, scratch, levels: Vec::new(), statistics: Statistics::default() }
    }

    /// Draws, compresses and stores the tiles of the full resolution.
    pub(super) fn base(
        &mut self,
        tiles: &[[usize; 2]],
        draw: impl Fn([usize; 2]) -> io::Result<Vec<u8>> + Sync,
        progress: &Progress,
    ) -> io::Result<()> {
        let cells = self.spec.cells;
        self.levels.push(RasterLevel {
            columns: self.spec.columns,
            rows: self.spec.rows,
            tiles: BTreeMap::new(),
        });
        for batch in tiles.chunks(BATCH) {
            progress.check().map_err(io::Error::other)?;
            let drawn = batch.par_iter().map(|&tile| {
                let bytes = draw(tile)?;
                let statistics = Statistics::of(cells, &bytes);
                Ok((statistics, pack(cells, bytes)?))
            });
            let drawn = drawn.collect::<io::Result<Vec<_>>>()?;
            for (tile, (statistics, packed)) in batch.iter().zip(&drawn) {
                self.statistics.join(statistics);
                let blocks = self.scratch.keep(packed)?;
                self.keep(*tile, blocks, progress);
            }
        }
        Ok(())
    }

    fn keep(&mut self, tile: [usize; 2], blocks: ScratchTile, progress: &Progress) {
        if let Some(level) = self.levels.last_mut() {
            level.tiles.insert(tile, blocks);
        }
        progress.advance(1);
    }

    /// Adds a level of half the resolution, computed from the level before; returns false when the
    /// level before fits one tile.
    pub(super) fn overview(&mut self, progress: &Progress) -> io::Result<bool> {
        let Some(finer) = self.levels.last() else {
            return Ok(false);
        };
        if finer.columns <= RASTER_TILE && finer.rows <= RASTER_TILE {
            return Ok(false);
        }
        let (columns, rows) = (finer.columns.div_ceil(2), finer.rows.div_ceil(2));
        let halved = finer.tiles.keys().map(|tile| tile.map(|index| index / 2));
        let mut tiles: Vec<[usize; 2]> = halved.collect();
        tiles.sort_unstable();
        tiles.dedup();
        let finer = self.levels.len() - 1;
        self.levels.push(RasterLevel { columns, rows, tiles: BTreeMap::new() });
        let cells = self.spec.cells;
        for batch in tiles.chunks(BATCH / 4) {
            progress.check().map_err(io::Error::other)?;
            let parts = batch.iter().map(|tile| self.parts(finer, *tile));
            let parts = parts.collect::<io::Result<Vec<_>>>()?;
            let packed = parts.into_par_iter().map(|parts| {
                let mut tile = cells.empty_tile();
                for (quarter, bytes) in parts {
                    halve_into(cells, &unpack(cells, &bytes)?, quarter, &mut tile);
                }
                pack(cells, tile)
            });
            let packed = packed.collect::<io::Result<Vec<_>>>()?;
            for (tile, packed) in batch.iter().zip(&packed) {
                let blocks = self.scratch.keep(packed)?;
                self.keep(*tile, blocks, progress);
            }
        }
        Ok(true)
    }

    /// Returns the compressed tiles of the finer level that cover the area of a tile: for each, the
    /// quarter that it covers (row and column, 0 or 1) and its bytes.
    fn parts(
        &mut self,
        finer: usize,
        [row, column]: [usize; 2],
    ) -> io::Result<Vec<([usize; 2], Vec<u8>)>> {
        let mut parts = Vec::with_capacity(4);
        for quarter in [[0, 0], [0, 1], [1, 0], [1, 1]] {
            let tile = [2 * row + quarter[0], 2 * column + quarter[1]];
            if let Some(blocks) = self.levels[finer].tiles.get(&tile) {
                let mut bytes = Vec::new();
                self.scratch.read(blocks.image, &mut bytes)?;
                parts.push((quarter, bytes));
            }
        }
        Ok(parts)
    }

    /// Writes the directories, the full resolution first, then the tiles, the coarsest level first,
    /// row by row.
    pub(super) fn write(mut self, file: File, progress: &Progress) -> io::Result<()> {
        let nothing = self.scratch.keep(&pack(self.spec.cells, self.spec.cells.empty_tile())?)?;
        let levels = std::mem::take(&mut self.levels);
        let mut pages = self.pages(&levels, nothing);
        let start = directories(self.spec, &self.statistics, &pages).len() as u64;
        let copied = place(&levels, &mut pages, nothing, start)?;
        let mut out = BufWriter::with_capacity(1 << 20, file);
        out.write_all(&directories(self.spec, &self.statistics, &pages))?;
        let mut bytes = Vec::new();
        for block in copied {
            progress.check().map_err(io::Error::other)?;
            self.scratch.read(block, &mut bytes)?;
            out.write_all(&bytes)?;
        }
        out.flush()
    }

    /// Returns the directories in their order, each mask after the level that it masks, without the
    /// places of their tiles.
    fn pages(&self, levels: &[RasterLevel], nothing: ScratchTile) -> Vec<Page> {
        let of_level = |(index, level): (usize, &RasterLevel)| {
            let kinds: &[bool] = match nothing.mask {
                Some(_) => &[false, true],
                None => &[false],
            };
            let [down, across] = level.across();
            let page = |&is_mask: &bool| Page {
                columns: level.columns,
                rows: level.rows,
                is_overview: index > 0,
                is_mask,
                places: vec![[0; 2]; down * across],
            };
            kinds.iter().map(page).collect::<Vec<_>>()
        };
        levels.iter().enumerate().flat_map(of_level).collect()
    }
}

/// Assigns a place in the file to every tile, from `start` on; returns the blocks to copy, in
/// order. The empty tile is stored once in each level that needs it.
fn place(
    levels: &[RasterLevel],
    pages: &mut [Page],
    nothing: ScratchTile,
    start: u64,
) -> io::Result<Vec<ScratchBlock>> {
    let mut at = start;
    let mut copied = Vec::new();
    let mut copy = |block: ScratchBlock| -> io::Result<[u32; 2]> {
        let place = u32::try_from(at).ok();
        at += u64::from(block.length);
        let (Some(place), Ok(_)) = (place, u32::try_from(at)) else {
            return Err(io::Error::other(
                "the raster would pass 4 GB, which TIFF cannot hold; choose larger cells",
            ));
        };
        copied.push(block);
        Ok([place, block.length])
    };
    let masks = 1 + usize::from(nothing.mask.is_some());
    for (level, pages) in levels.iter().zip(pages.chunks_mut(masks)).rev() {
        let [_, across] = level.across();
        let mut empty: Option<[[u32; 2]; 2]> = None;
        let mut both = |blocks: ScratchTile| -> io::Result<[[u32; 2]; 2]> {
            let image = copy(blocks.image)?;
            Ok([image, blocks.mask.map_or(Ok([0; 2]), &mut copy)?])
        };
        let count = pages.first().map_or(0, |page| page.places.len());
        for index in 0..count {
            let tile = [index / across, index % across];
            let found = match (level.tiles.get(&tile), empty) {
                (Some(blocks), _) => both(*blocks)?,
                (None, Some(empty)) => empty,
                (None, None) => *empty.insert(both(nothing)?),
            };
            for (page, found) in pages.iter_mut().zip(found) {
                page.places[index] = found;
            }
        }
    }
    Ok(copied)
}

/// The values of a tag.
enum TagValues {
    /// Text in ASCII; a zero byte is added when it is stored.
    Text(String),
    /// Numbers of 16 bits.
    Short(Vec<u16>),
    /// Numbers of 32 bits.
    Long(Vec<u32>),
    /// Floating-point numbers of 64 bits.
    Double(Vec<f64>),
}

/// Number and values of a tag.
struct Tag(u16, TagValues);

impl TagValues {
    /// Returns the type number of TIFF, the number of values, and their bytes.
    fn stored(&self) -> (u16, u32, Vec<u8>) {
        fn numbers<T: Copy, const N: usize>(
            kind: u16,
            values: &[T],
            bytes: fn(T) -> [u8; N],
        ) -> (u16, u32, Vec<u8>) {
            let stored = values.iter().flat_map(|value| bytes(*value));
            (kind, values.len() as u32, stored.collect())
        }
        match self {
            TagValues::Text(text) => numbers(2, &[text.as_bytes(), &[0]].concat(), |byte| [byte]),
            TagValues::Short(values) => numbers(3, values, u16::to_le_bytes),
            TagValues::Long(values) => numbers(4, values, u32::to_le_bytes),
            TagValues::Double(values) => numbers(12, values, f64::to_le_bytes),
        }
    }
}

/// One directory of the file: a level of resolution, or the mask of a level.
struct Page {
    columns: usize,
    rows: usize,
    is_overview: bool,
    is_mask: bool,
    /// Offset and length of each tile, row by row.
    places: Vec<[u32; 2]>,
}

/// Returns the head of the file and all directories, each followed by its values. The number of
/// bytes does not depend on the places of the tiles.
fn directories(spec: &RasterSpec, statistics: &Statistics, pages: &[Page]) -> Vec<u8> {
    // Little-endian, TIFF, and the offset of the first directory, which follows directly.
    let mut all = b"II\x2a\0\x08\0\0\0".to_vec();
    for (index, page) in pages.iter().enumerate() {
        let is_last = index + 1 == pages.len();
        directory(&tags(spec, statistics, page), is_last, &mut all);
    }
    all
}

/// Adds a directory, the link to the next directory, which follows directly, and the values.
fn directory(tags: &[Tag], is_last: bool, all: &mut Vec<u8>) {
    let start = all.len();
    let head = 2 + 12 * tags.len() + 4;
    let mut behind = Vec::new();
    all.extend((tags.len() as u16).to_le_bytes());
    for Tag(number, values) in tags {
        let (kind, count, mut bytes) = values.stored();
        all.extend(number.to_le_bytes());
        all.extend(kind.to_le_bytes());
        all.extend(count.to_le_bytes());
        if bytes.len() <= 4 {
            bytes.resize(4, 0);
            all.extend(bytes);
        } else {
            let place = (start + head + behind.len()) as u32;
            all.extend(place.to_le_bytes());
            bytes.resize(bytes.len().next_multiple_of(2), 0);
            behind.extend(bytes);
        }
    }
    let next = if is_last { 0 } else { (start + head + behind.len()) as u32 };
    all.extend(next.to_le_bytes());
    all.extend(behind);
}

/// Returns the tags of a directory, in ascending order as TIFF requires.
fn tags(spec: &RasterSpec, statistics: &Statistics, page: &Page) -> Vec<Tag> {
    let is_full = !page.is_overview && !page.is_mask;
    let cells = (!page.is_mask).then_some(spec.cells);
    // Number of samples, bits of each, and photometric interpretation (1 grey, 2 colours, 4 a
    // mask).
    let (samples, bits, colours) = match cells {
        Some(CellFormat::Rgba) => (4, 8, 2),
        Some(CellFormat::Level | CellFormat::Class) => (1, 8, 1),
        Some(CellFormat::Metres) => (1, 32, 1),
        None => (1, 1, 4),
    };
    let short = |value: u16| TagValues::Short(vec![value]);
    let long = |value: usize| TagValues::Long(vec![value as u32]);
    let mut tags = vec![
        Tag(254, long(usize::from(page.is_overview) + 4 * usize::from(page.is_mask))),
        Tag(256, long(page.columns)),
        Tag(257, long(page.rows)),
        Tag(258, TagValues::Short(vec![bits; samples])),
        // Deflate, by Adobe's number.
        Tag(259, short(8)),
        Tag(262, short(colours)),
    ];
    if is_full {
        let ascii = |c: char| !c.is_ascii() || c == '\0';
        tags.push(Tag(270, TagValues::Text(spec.description.replace(ascii, "?"))));
    }
    tags.extend([Tag(277, short(samples as u16)), Tag(284, short(1))]);
    if is_full {
        let program = concat!("Bathyscope ", env!("CARGO_PKG_VERSION"));
        tags.push(Tag(305, TagValues::Text(program.to_owned())));
    }
    // Predictor: 2 is differences to the cell before, 1 is none.
    let is_differences = cells == Some(CellFormat::Rgba);
    tags.extend([
        Tag(317, short(if is_differences { 2 } else { 1 })),
        Tag(322, long(RASTER_TILE)),
        Tag(323, long(RASTER_TILE)),
        Tag(324, TagValues::Long(page.places.iter().map(|place| place[0]).collect())),
        Tag(325, TagValues::Long(page.places.iter().map(|place| place[1]).collect())),
    ]);
    if cells == Some(CellFormat::Rgba) {
        // The fourth sample is opacity; the colours are not multiplied by it.
        tags.push(Tag(338, short(2)));
    }
    // Sample format: 3 is floating point, 1 is unsigned.
    let format = if cells == Some(CellFormat::Metres) { 3 } else { 1 };
    tags.push(Tag(339, TagValues::Short(vec![format; samples])));
    if is_full {
        tags.extend(georeference(spec));
    }
    if let Some(band) = spec.band.filter(|_| is_full) {
        let text = gdal_metadata(spec, &band, statistics);
        tags.push(Tag(42_112, TagValues::Text(text)));
    }
    if cells == Some(CellFormat::Metres) {
        tags.push(Tag(42_113, TagValues::Text(format!("{NODATA}"))));
    }
    tags
}

/// Returns the tags of the cell size, the north-west corner, and the coordinate system: projected
/// (1) or in degrees (2), cells as areas (1), and the EPSG number.
fn georeference(spec: &RasterSpec) -> [Tag; 3] {
    let (model, system) = if spec.crs.is_degrees() { (2, 2048) } else { (1, 3072) };
    let keys =
        [[1, 1, 1, 3], [1024, 0, 1, model], [1025, 0, 1, 1], [system, 0, 1, spec.crs.epsg()]];
    let [width, height] = spec.cell;
    [
        Tag(33_550, TagValues::Double(vec![width, height, 0.0])),
        Tag(33_922, TagValues::Double(vec![0.0, 0.0, 0.0, spec.west, spec.north, 0.0])),
        Tag(34_735, TagValues::Short(keys.concat())),
    ]
}
