//! Writes the directories of a TIFF: their tags in order, and the values after them.

use super::metadata::{Statistics, gdal_metadata};
use super::{CellFormat, NODATA, RASTER_TILE, RasterSpec};

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
pub(super) struct Page {
    pub columns: usize,
    pub rows: usize,
    pub is_overview: bool,
    pub is_mask: bool,
    /// Offset and length of each tile, row by row.
    pub places: Vec<[u32; 2]>,
}

/// Returns the head of the file and all directories, each followed by its values. The number of
/// bytes does not depend on the places of the tiles.
pub(super) fn bytes(spec: &RasterSpec, statistics: &Statistics, pages: &[Page]) -> Vec<u8> {
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
