//! Opens the user's own picture under the map, a GeoTIFF, and reads it block by block as parts are
//! shown.
//!
//! In: a GeoTIFF, and the part of it that is shown. Out: the colours of that part.
//!
//! `colours` decodes the colours and masks of its pixels. Files are untrusted: a block larger than
//! [`MOST_BLOCK_BYTES`] is refused, and the memory of a [`Window`] is bounded by [`MOST_PIXELS`].

mod colours;

pub use colours::RgbaPixel;

use crate::formats::geotiff::{GeoKeys, GeoTransform, JpegBlocks};
use crate::support::catch_panic::catch_panic;
use crate::support::file_error::FileError;
use crate::support::geo::{Crs, LonLat};
use crate::support::progress::{Cancelled, Progress};
use crate::support::regular_file;
use colours::{AsGrey, Coding, hide, masked_size};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use tiff::TiffError;
use tiff::decoder::{Decoder, Limits};
use tiff::tags::Tag;

/// Most bytes of a block that is read.
const MOST_BLOCK_BYTES: u64 = 64 << 20;
/// Most pixels of a [`Window`].
const MOST_PIXELS: u64 = 16 << 20;
/// Most pixels of a picture without overviews from which an overview is made.
const MOST_WITHOUT_OVERVIEWS: u64 = 1 << 30;
/// Most pixels along the longer side of the coarsest level, so that the whole level can be shown.
const COARSE_SIDE: u32 = 2048;
/// Most directories of a file that are searched for overviews.
const MOST_LEVELS: usize = 32;
/// Most bytes of colours in the cache of blocks.
const BUDGET: usize = 96 << 20;

/// EPSG code of WGS84, and the codes in degrees that are read as WGS84: WGS84, ETRS89 and NAD83.
const WGS84: u16 = 4326;
const DEGREES: [u16; 3] = [WGS84, 4258, 4269];

/// A decoder of the file.
type Tiff = Decoder<AsGrey>;

/// Reason why a file is not opened as a base map.
#[derive(Debug, thiserror::Error)]
pub enum BaseMapError {
    /// The file cannot be read or shown.
    #[error(transparent)]
    Unusable(#[from] FileError<BaseMapFault>),
    /// The user cancelled the opening.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Fault of a base map, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum BaseMapFault {
    /// The operating system cannot read the file.
    #[error("the base map cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The file is no TIFF, or a TIFF of a kind that is not supported.
    #[error("the base map cannot be read: {0}")]
    Tiff(#[from] TiffError),
    /// The file contradicts itself, or has no pixels.
    #[error("the base map cannot be read: {0}")]
    Damaged(&'static str),
    /// The file is no base map that can be shown; the field is the sentence.
    #[error("{0}")]
    Unsuitable(String),
}

impl BaseMapFault {
    fn unsuitable(what: impl Into<String>) -> Self {
        Self::Unsuitable(what.into())
    }
}

/// Place of the pixels of a picture, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// Coordinate system of the corner and the pixel size.
    pub crs: Crs,
    /// x and y of the upper left corner of the upper left pixel, in units of the system.
    pub corner: [f64; 2],
    /// Width and height of a pixel, in units of the system.
    pub pixel: [f64; 2],
}

impl Georeference {
    /// Returns the column and row of a position, counted from the upper left corner of the picture,
    /// with fractions of a pixel.
    pub fn to_pixels(&self, at: LonLat) -> [f64; 2] {
        let [x, y] = self.crs.place(at);
        [(x - self.corner[0]) / self.pixel[0], (self.corner[1] - y) / self.pixel[1]]
    }

    /// Returns the position of a column and row; the inverse of [`Georeference::to_pixels`].
    pub fn to_position(&self, [column, row]: [f64; 2]) -> LonLat {
        let x = self.corner[0] + column * self.pixel[0];
        let y = self.corner[1] - row * self.pixel[1];
        self.crs.to_lon_lat([x, y])
    }

    /// Reads the GeoTIFF keys and the transform of the current picture of the decoder.
    ///
    /// # Errors
    /// When the picture has no EPSG number or no transform, its system is not supported, or it is
    /// not north up.
    fn read(decoder: &mut Tiff) -> Result<Self, BaseMapFault> {
        let keys = GeoKeys::read(decoder);
        let code = if keys.is_geographic() { keys.geographic() } else { keys.projected() };
        let nowhere = |what: &str| {
            let what = format!("the picture does not say where on Earth it lies; {what}");
            BaseMapFault::unsuitable(what)
        };
        let epsg = code.ok_or_else(|| nowhere("a GeoTIFF with an EPSG number does"))?;
        // Coordinates in NAD83 and ETRS89 differ from WGS84 by less than 2 m.
        let known = if DEGREES.contains(&epsg) { WGS84 } else { epsg };
        let crs = Crs::from_epsg(known).map_err(|_| {
            BaseMapFault::unsuitable(format!(
                "the base map is in EPSG:{epsg}, which is not known here; turn it into WGS84, web Mercator or a UTM zone with gdalwarp"
            ))
        })?;
        let transform = GeoTransform::read(decoder, &keys);
        let transform = transform.ok_or_else(|| nowhere("it has no transform"))?;
        let ([width, down], [across, height]) = (transform.per_column, transform.per_row);
        let is_turned = down != 0.0 || across != 0.0;
        let pixel = [width, -height];
        let place = Self { crs, corner: transform.of_corners().origin, pixel };
        let numbers = [place.corner, place.pixel].concat();
        let usable =
            numbers.iter().all(|number| number.is_finite()) && pixel.iter().all(|side| *side > 0.0);
        if usable && !is_turned {
            return Ok(place);
        }
        Err(BaseMapFault::unsuitable("the base map is not north up; turn it with gdalwarp"))
    }
}

/// A base map.
pub struct BaseMap {
    /// Path of the file.
    pub path: PathBuf,
    /// Position of the pixels on Earth.
    pub place: Georeference,
    /// Columns and rows of the full picture.
    pub size: [u32; 2],
    levels: Vec<PictureLevel>,
    coding: Coding,
    reader: Mutex<Reader>,
}

/// The picture at full size, or an overview of it.
struct PictureLevel {
    size: [u32; 2],
    /// Columns and rows of a block.
    block: [u32; 2],
    kept: Kept,
    /// Number of the directory with the mask of this level; `None` without a mask.
    mask: Option<usize>,
}

/// Storage of the pixels of a level.
enum Kept {
    /// Number of a directory of the file.
    Directory(usize),
    /// Pixels in memory.
    Memory(Vec<RgbaPixel>),
}

struct Reader {
    tiff: Tiff,
    /// Number of the current directory of the decoder; `None` while it is unknown.
    directory: Option<usize>,
    /// Blocks of the current directory where they are JPEG streams.
    jpegs: Option<JpegBlocks>,
    blocks: BlockCache,
}

/// Number of a directory of the file, and number of a block in it.
type BlockKey = (usize, u32);

/// Blocks of the map that were used last; the most recently used is at the end.
#[derive(Default)]
struct BlockCache {
    kept: Vec<(BlockKey, Arc<Vec<RgbaPixel>>)>,
    bytes: usize,
}

impl BlockCache {
    /// Returns a block of the cache and marks it as the most recently used.
    fn get(&mut self, key: BlockKey) -> Option<Arc<Vec<RgbaPixel>>> {
        let index = self.kept.iter().rposition(|(other, _)| *other == key)?;
        let found = self.kept.remove(index);
        let block = found.1.clone();
        self.kept.push(found);
        Some(block)
    }

    /// Adds a block; drops blocks that were not used for the longest time where the cache is full.
    fn keep(&mut self, key: BlockKey, block: Vec<RgbaPixel>) -> Arc<Vec<RgbaPixel>> {
        let block = Arc::new(block);
        self.bytes += size_of_val(&block[..]);
        self.kept.push((key, block.clone()));
        let mut gone = 0;
        while self.bytes > BUDGET && gone + 1 < self.kept.len() {
            self.bytes -= size_of_val(&self.kept[gone].1[..]);
            gone += 1;
        }
        self.kept.drain(..gone);
        block
    }
}

/// A rectangular part of a level, with its pixels.
pub struct Window {
    /// Pixels of the full picture along the width and the height of a pixel of this window.
    pub scale: [f64; 2],
    /// First column and row, in pixels of the level.
    pub first: [u32; 2],
    /// Columns and rows of the window.
    pub size: [u32; 2],
    /// Colours row by row.
    pub pixels: Vec<RgbaPixel>,
}

impl Window {
    /// Returns the colour at a column and row of the full picture; transparent outside the window.
    pub fn at(&self, full: [f64; 2]) -> RgbaPixel {
        let cell = |axis: usize| {
            let here = (full[axis] / self.scale[axis]).floor() - f64::from(self.first[axis]);
            (here >= 0.0 && here < f64::from(self.size[axis])).then_some(here as usize)
        };
        let index = cell(1).zip(cell(0)).map(|(row, column)| row * self.size[0] as usize + column);
        index.and_then(|index| self.pixels.get(index).copied()).unwrap_or_default()
    }
}

/// Opens a GeoTIFF with 8 bits a colour, north up, in degrees or metres of a system that
/// [`crate::support::geo::Crs`] supports. Reads the whole file once if it is large and has no
/// overviews.
///
/// # Errors
/// When the file cannot be read or shown, or the user cancelled the opening.
pub fn open(path: &Path, progress: &Progress) -> Result<BaseMap, BaseMapError> {
    let opening = || -> Result<BaseMap, BaseMapError> {
        let mut map = open_file(path).map_err(|fault| FileError::new(fault, path))?;
        map.add_coarse_level(progress)?;
        Ok(map)
    };
    let damaged = || Err(FileError::new(BaseMapFault::Damaged("it is damaged"), path).into());
    catch_panic(opening).unwrap_or_else(damaged)
}

fn open_file(path: &Path) -> Result<BaseMap, BaseMapFault> {
    let file = regular_file::open(path)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MOST_BLOCK_BYTES as usize;
    // Room for the offsets and lengths of a million blocks.
    limits.ifd_value_size = 16 << 20;
    let mut tiff = Decoder::new(AsGrey::new(file)?)?.with_limits(limits);
    let place = Georeference::read(&mut tiff)?;
    let coding = Coding::read(&mut tiff)?;
    let levels = levels(&mut tiff, &coding)?;
    let full = &levels[0];
    Ok(BaseMap {
        path: path.to_path_buf(),
        place,
        size: full.size,
        coding,
        reader: Mutex::new(Reader {
            directory: None,
            tiff,
            jpegs: None,
            blocks: BlockCache::default(),
        }),
        levels,
    })
}

/// Returns the full picture and its overviews, finest first.
fn levels(tiff: &mut Tiff, coding: &Coding) -> Result<Vec<PictureLevel>, BaseMapFault> {
    let mut found: Vec<PictureLevel> = Vec::new();
    for directory in 0..MOST_LEVELS {
        // Masks and pages of another kind are no overviews.
        let subfile = tiff.find_tag_unsigned::<u32>(Tag::NewSubfileType).ok().flatten();
        let is_overview =
            subfile == Some(1) && Coding::read(tiff).is_ok_and(|other| other.bytes == coding.bytes);
        if directory == 0 || is_overview {
            let level = level(tiff, coding, directory)?;
            if found.iter().all(|finer| finer.size[0] > level.size[0]) {
                found.push(level);
            }
        }
        if let Some(of) = masked_size(tiff, subfile) {
            let is_like = |level: &&mut PictureLevel| (level.size, level.block) == of;
            if let Some(level) = found.iter_mut().find(is_like) {
                level.mask = Some(directory);
            }
        }
        if !tiff.more_images() || tiff.next_image().is_err() {
            break;
        }
    }
    Ok(found)
}

fn level(tiff: &mut Tiff, coding: &Coding, directory: usize) -> Result<PictureLevel, BaseMapFault> {
    let (columns, rows) = tiff.dimensions()?;
    let (across, down) = tiff.chunk_dimensions();
    let bytes = u64::from(across) * u64::from(down.min(rows)) * coding.bytes as u64;
    if columns == 0 || rows == 0 || across == 0 || down == 0 {
        return Err(BaseMapFault::Damaged("it is empty"));
    }
    if bytes > MOST_BLOCK_BYTES {
        return Err(BaseMapFault::unsuitable(format!(
            "the base map holds blocks of {} MB, more than is read at once; write it with TILED=YES",
            bytes >> 20
        )));
    }
    Ok(PictureLevel {
        size: [columns, rows],
        block: [across, down.min(rows)],
        kept: Kept::Directory(directory),
        mask: None,
    })
}

impl BaseMap {
    /// Returns the width on the ground of the pixel in the middle of the map, metres.
    pub fn pixel_m(&self) -> f64 {
        let middle = self.size.map(|cells| 0.5 * f64::from(cells));
        let from = self.place.to_position(middle);
        let to = self.place.to_position([middle[0] + 1.0, middle[1]]);
        crate::support::geo::distance_m(from, to)
    }

    /// Returns true if a position is on the picture.
    pub fn covers(&self, at: LonLat) -> bool {
        let pixel = self.place.to_pixels(at);
        (0..2).all(|axis| (0.0..=f64::from(self.size[axis])).contains(&pixel[axis]))
    }

    /// Returns the part of the picture between two corners, given as columns and rows of the full
    /// picture, from the level whose pixels are as large as `pixels` of the full picture or a
    /// little smaller. `None` where the part is outside the picture, cannot be read, or the work
    /// was cancelled.
    pub fn window(
        &self,
        low: [f64; 2],
        high: [f64; 2],
        pixels: f64,
        progress: &Progress,
    ) -> Option<Window> {
        let scale = |level: &PictureLevel| {
            [0, 1].map(|axis| f64::from(self.size[axis]) / f64::from(level.size[axis]))
        };
        let span = |level: &PictureLevel| {
            let scale = scale(level);
            [0, 1].map(|axis| {
                let cells = f64::from(level.size[axis]);
                // One pixel more on each side, for interpolation between pixels.
                let first = (low[axis] / scale[axis] - 1.0).floor().clamp(0.0, cells);
                let end = (high[axis] / scale[axis] + 1.0).ceil().clamp(0.0, cells);
                [first as u32, end as u32]
            })
        };
        let count = |level: &PictureLevel| {
            let [across, down] =
                span(level).map(|[first, end]| u64::from(end.saturating_sub(first)));
            across * down
        };
        let fine_enough = |level: &&PictureLevel| scale(level)[0] <= pixels.max(1.0) * 1.001;
        let small_enough = |level: &&PictureLevel| count(level) <= MOST_PIXELS;
        let (index, level) = {
            let coarse_first = || self.levels.iter().enumerate().rev();
            let requested =
                coarse_first().find(|(_, level)| fine_enough(level) && small_enough(level));
            let possible = || self.levels.iter().enumerate().find(|(_, level)| small_enough(level));
            requested.or_else(possible)?
        };
        if count(level) == 0 {
            return None;
        }
        let [[left, right], [top, bottom]] = span(level);
        let mut window = Window {
            scale: scale(level),
            first: [left, top],
            size: [right - left, bottom - top],
            pixels: vec![
                RgbaPixel::default();
                ((right - left) as usize) * ((bottom - top) as usize)
            ],
        };
        self.fill(index, &mut window, progress)?;
        Some(window)
    }

    /// Copies the blocks of a level that overlap the window into the window; `None` if the work was
    /// cancelled or a block cannot be read.
    fn fill(&self, index: usize, window: &mut Window, progress: &Progress) -> Option<()> {
        let level = &self.levels[index];
        if let Kept::Memory(pixels) = &level.kept {
            copy([0, 0], level.size, pixels, window);
            return Some(());
        }
        let [across, down] = level.block;
        let end = [0, 1].map(|axis| window.first[axis] + window.size[axis]);
        for row in window.first[1] / down..end[1].div_ceil(down) {
            for column in window.first[0] / across..end[0].div_ceil(across) {
                progress.check().ok()?;
                let block = self.block(index, [column, row])?;
                let first = [column * across, row * down];
                let size = [0, 1].map(|axis| level.block[axis].min(level.size[axis] - first[axis]));
                copy(first, size, &block, window);
            }
        }
        Some(())
    }

    /// Returns the colours of a block from the cache or the file; `None` where the block cannot be
    /// read.
    fn block(&self, index: usize, [column, row]: [u32; 2]) -> Option<Arc<Vec<RgbaPixel>>> {
        let level = &self.levels[index];
        let Kept::Directory(directory) = level.kept else {
            return None;
        };
        let across = level.size[0].div_ceil(level.block[0]);
        let number = row.checked_mul(across)?.checked_add(column)?;
        // A reader that failed during a read can be used again: every read seeks first.
        let mut reader = self.reader.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(block) = reader.blocks.get((directory, number)) {
            return Some(block);
        }
        let bytes = catch_panic(|| reader.read(directory, number)).flatten()?;
        let mut colours = self.coding.colours(&bytes);
        if let Some(mask) = level.mask {
            let mask = catch_panic(|| reader.read(mask, number)).flatten()?;
            let wide = level.block[0].min(level.size[0].saturating_sub(column * level.block[0]));
            hide(&mut colours, &mask, wide as usize);
        }
        Some(reader.blocks.keep((directory, number), colours))
    }

    /// Adds a level that is small enough to be shown as a whole, in one pass over the file, if the
    /// coarsest level is too large.
    fn add_coarse_level(&mut self, progress: &Progress) -> Result<(), BaseMapError> {
        let index = self.levels.len() - 1;
        let level = &self.levels[index];
        let [columns, rows] = level.size;
        let factor = columns.max(rows).div_ceil(COARSE_SIDE);
        if factor <= 1 {
            return Ok(());
        }
        if u64::from(columns) * u64::from(rows) > MOST_WITHOUT_OVERVIEWS {
            let what = BaseMapFault::unsuitable(format!(
                "the base map has {columns} by {rows} pixels and no overviews of them; add some with gdaladdo"
            ));
            return Err(FileError::new(what, &self.path).into());
        }
        let size = level.size.map(|cells| cells.div_ceil(factor));
        let mut sums = vec![[0u32; 4]; size[0] as usize * size[1] as usize];
        let [across, down] = level.block;
        progress.start(u64::from(rows.div_ceil(down)));
        for row in 0..rows.div_ceil(down) {
            for column in 0..columns.div_ceil(across) {
                progress.check()?;
                let block = self.block(index, [column, row]);
                let block = block.ok_or_else(|| {
                    let what = BaseMapFault::Damaged("a block of it is damaged");
                    FileError::new(what, &self.path)
                })?;
                let first = [column * across, row * down];
                let wide = across.min(columns - first[0]) as usize;
                for (at, colour) in block.iter().enumerate() {
                    let x = first[0] + (at % wide) as u32;
                    let y = first[1] + (at / wide) as u32;
                    let sum = &mut sums[(y / factor * size[0] + x / factor) as usize];
                    for (sum, value) in sum.iter_mut().zip(weighted(*colour)) {
                        *sum += value;
                    }
                }
            }
            progress.advance(1);
        }
        // The last cell of a row and of a column may cover fewer pixels.
        let wide = |cell: u32, all: u32| u64::from(factor.min(all - cell * factor));
        let means = sums.into_iter().enumerate().map(|(at, sum)| {
            let (x, y) = (at as u32 % size[0], at as u32 / size[0]);
            mean(sum, wide(x, columns) * wide(y, rows))
        });
        let pixels = means.collect();
        self.levels.push(PictureLevel {
            size,
            block: size,
            kept: Kept::Memory(pixels),
            mask: None,
        });
        Ok(())
    }
}

/// Returns the colour multiplied by its opacity, and the opacity.
fn weighted([r, g, b, a]: RgbaPixel) -> [u32; 4] {
    let share = |value: u8| u32::from(value) * u32::from(a) / 255;
    [share(r), share(g), share(b), u32::from(a)]
}

fn mean([r, g, b, a]: [u32; 4], cells: u64) -> RgbaPixel {
    let opaque = a.max(1);
    let colour = |sum: u32| (u64::from(sum) * 255 / u64::from(opaque)).min(255) as u8;
    match a {
        0 => RgbaPixel::default(),
        _ => [colour(r), colour(g), colour(b), (u64::from(a) / cells.max(1)).clamp(1, 255) as u8],
    }
}

/// Copies the pixels that a block and a window have in common.
fn copy(first: [u32; 2], size: [u32; 2], pixels: &[RgbaPixel], window: &mut Window) {
    let low = [0, 1].map(|axis| first[axis].max(window.first[axis]));
    let high =
        [0, 1].map(|axis| (first[axis] + size[axis]).min(window.first[axis] + window.size[axis]));
    if low[0] >= high[0] {
        return;
    }
    for row in low[1]..high[1] {
        let from = (row - first[1]) as usize * size[0] as usize + (low[0] - first[0]) as usize;
        let into = (row - window.first[1]) as usize * window.size[0] as usize
            + (low[0] - window.first[0]) as usize;
        let wide = (high[0] - low[0]) as usize;
        if let (Some(from), Some(into)) =
            (pixels.get(from..from + wide), window.pixels.get_mut(into..into + wide))
        {
            into.copy_from_slice(from);
        }
    }
}

impl Reader {
    fn read(&mut self, directory: usize, number: u32) -> Option<Vec<u8>> {
        if self.directory != Some(directory) {
            self.directory = None;
            self.tiff.seek_to_image(directory).ok()?;
            self.jpegs = JpegBlocks::read(&mut self.tiff);
            self.directory = Some(directory);
        }
        if let Some(jpegs) = &self.jpegs
            && !jpegs.is_sound(number, self.tiff.inner())
        {
            return None;
        }
        match self.tiff.read_chunk(number).ok()? {
            tiff::decoder::DecodingResult::U8(bytes) => Some(bytes),
            _ => None,
        }
    }
}
