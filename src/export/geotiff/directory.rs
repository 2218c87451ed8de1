//! Directories of a TIFF: tags in order, their values behind them.

use super::{Cells, NODATA, RASTER_TILE, RasterSpec};

/// The values of a tag.
pub enum Values {
    /// ASCII, its zero added.
    Text(String),
    /// 16 bit.
    Short(Vec<u16>),
    /// 32 bit.
    Long(Vec<u32>),
    /// 64 bit floating point.
    Double(Vec<f64>),
}

/// Number and values.
pub struct Tag(u16, Values);

impl Values {
    /// The format's number of the type, how many values, their bytes.
    fn stored(&self) -> (u16, u32, Vec<u8>) {
        match self {
            Values::Text(text) => {
                let bytes = [text.as_bytes(), &[0]].concat();
                (2, bytes.len() as u32, bytes)
            }
            Values::Short(values) => (
                3,
                values.len() as u32,
                values
                    .iter()
                    .flat_map(|value| value.to_le_bytes())
                    .collect(),
            ),
            Values::Long(values) => (
                4,
                values.len() as u32,
                values
                    .iter()
                    .flat_map(|value| value.to_le_bytes())
                    .collect(),
            ),
            Values::Double(values) => (
                12,
                values.len() as u32,
                values
                    .iter()
                    .flat_map(|value| value.to_le_bytes())
                    .collect(),
            ),
        }
    }
}

/// A directory that starts at a place in the file, and the place of its link to the next one.
pub fn directory(tags: &[Tag], start: u64) -> (Vec<u8>, u64) {
    let head = 2 + 12 * tags.len() + 4;
    let (mut entries, mut behind) = (Vec::with_capacity(head), Vec::new());
    entries.extend((tags.len() as u16).to_le_bytes());
    for Tag(number, values) in tags {
        let (kind, count, mut bytes) = values.stored();
        entries.extend(number.to_le_bytes());
        entries.extend(kind.to_le_bytes());
        entries.extend(count.to_le_bytes());
        if bytes.len() <= 4 {
            bytes.resize(4, 0);
            entries.extend(bytes);
        } else {
            let place = start as u32 + (head + behind.len()) as u32;
            entries.extend(place.to_le_bytes());
            bytes.resize(bytes.len().next_multiple_of(2), 0);
            behind.extend(bytes);
        }
    }
    let link = start + entries.len() as u64;
    entries.extend([0; 4]);
    entries.extend(behind);
    (entries, link)
}

/// The tags of one level of `columns` x `rows` cells whose tiles lie at `places` (offset and length).
pub fn tags(
    spec: &RasterSpec,
    [columns, rows]: [usize; 2],
    overview: bool,
    places: &[[u32; 2]],
) -> Vec<Tag> {
    let (samples, bits, format, colours) = match spec.cells {
        Cells::Rgba => (4, 8, 1, 2),
        Cells::Metres => (1, 32, 3, 1),
    };
    let short = |value: u16| Values::Short(vec![value]);
    let long = |value: usize| Values::Long(vec![value as u32]);
    let mut tags = vec![
        Tag(254, long(usize::from(overview))),
        Tag(256, long(columns)),
        Tag(257, long(rows)),
        Tag(258, Values::Short(vec![bits; samples])),
        // Deflate, as Adobe numbers it.
        Tag(259, short(8)),
        Tag(262, short(colours)),
        Tag(
            270,
            Values::Text(
                spec.description
                    .replace(|c: char| !c.is_ascii() || c == '\0', "?"),
            ),
        ),
        Tag(277, short(samples as u16)),
        Tag(284, short(1)),
        Tag(
            305,
            Values::Text(concat!("Bathyscope ", env!("CARGO_PKG_VERSION")).to_owned()),
        ),
        Tag(317, short(if spec.cells == Cells::Rgba { 2 } else { 1 })),
        Tag(322, long(RASTER_TILE)),
        Tag(323, long(RASTER_TILE)),
        Tag(
            324,
            Values::Long(places.iter().map(|place| place[0]).collect()),
        ),
        Tag(
            325,
            Values::Long(places.iter().map(|place| place[1]).collect()),
        ),
    ];
    if spec.cells == Cells::Rgba {
        // The fourth sample is opacity, the colours not multiplied by it.
        tags.push(Tag(338, short(2)));
    }
    tags.push(Tag(339, Values::Short(vec![format; samples])));
    if !overview {
        tags.extend(georeference(spec));
    }
    if spec.cells == Cells::Metres {
        tags.push(Tag(42_113, Values::Text(format!("{NODATA}"))));
    }
    tags
}

/// Cell size, the north-west corner, and the coordinate system: projected (1) or in degrees (2), cells are areas (1), its EPSG
/// number.
fn georeference(spec: &RasterSpec) -> [Tag; 3] {
    let (model, system) = match spec.crs.is_degrees() {
        true => (2, 2048),
        false => (1, 3072),
    };
    let keys = [
        [1, 1, 1, 3],
        [1024, 0, 1, model],
        [1025, 0, 1, 1],
        [system, 0, 1, spec.crs.epsg()],
    ];
    let [width, height] = spec.cell;
    [
        Tag(33_550, Values::Double(vec![width, height, 0.0])),
        Tag(
            33_922,
            Values::Double(vec![0.0, 0.0, 0.0, spec.west, spec.north, 0.0]),
        ),
        Tag(34_735, Values::Short(keys.concat())),
    ]
}
