//! Reads pictures of side-scan as surveys: a waterfall as PNG or JPEG with a table of its pings,
//! `NAME.png` and `NAME.csv`. Other programs, papers and old projects often provide nothing else of
//! a recording.
//!
//! In: the bytes of a picture and of a table. Out: a collected log.
//!
//! The picture. A row is a ping, the first at the top. Columns run across the track: port on the
//! left, its outermost sample at the left edge, starboard on the right. Both sides have the same
//! width; the middle column of an odd width belongs to neither. The samples of a side cover slant
//! ranges evenly, from the water column in the middle outward. A picture that is corrected to
//! ground range has no water column: it shows no first return, and its ranges are wrong; this
//! cannot be recognised, so a warning states the assumption. Grey levels of 8 and 16 bits are used
//! unchanged, colours by their luminance.
//!
//! The table. A row is a ping. Its columns are those of tables of soundings (`sounding_table`:
//! position, depth, time, heading), each of which may be missing, and
//! - `range_m`, the slant range of the outermost sample of each side, also as `slant_range` or
//!   `max_range`, or in feet as `range_ft`;
//! - optionally `min_range_m`, the slant range of the innermost sample; 0 without it;
//! - optionally `row`, also as `picture_row` or `line`: the row of the picture, from 0 at the top;
//!   from 1 where the last is the number of rows. Without it the rows of the table are those of the
//!   picture in order, and both must have the same number.
//!
//! Rows without times are spread evenly over the time that a boat of usual speed needs between
//! their positions. Rows with equal times, as in exports in whole seconds, are spread evenly up to
//! the next time.
//!
//! Depth maps are computed from the depths in the table and the first returns in the picture.
//!
//! The layout is defined by this project; there is no standard.

#[cfg(test)]
mod tests;

use super::collected::{Collected, Counted};
use super::log_format::{FileSource, LogFormat, ReadRecording, Reading, has_ending};
use super::sounding_table::{self, Layout, Reader, Recognised, TablePing};
use super::xtf::shift_to_fit;
use super::{OpenError, Opened, assemble};
use crate::support::catch_panic::catch_panic;
use crate::support::picture_file::{PictureFault, bounded_decoder};
use crate::support::progress::Progress;
use crate::survey::{Bytes, ChannelKind, Encoding, SampleOrder, SidePing, SideSpan, Survey};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const NAME: &str = "picture with CSV";
/// Indices of the two files in the log.
const PICTURE: u8 = 0;
const TABLE: usize = 1;
/// Number of the channel of the echoes; the depths have channel 0.
const CHANNEL: u16 = 1;
/// Endings of the other file that are tried, in both cases because some disks are case-sensitive.
const TABLES: [&str; 2] = ["csv", "CSV"];
const PICTURES: [&str; 6] = ["png", "jpg", "jpeg", "PNG", "JPG", "JPEG"];

/// Most bytes that a picture may take while it is decoded.
const LARGEST_UNPACKED: u64 = 1 << 30;
/// Most pixels for each byte of a file: Deflate compresses 1032 bytes into one, and a byte has
/// eight pixels of one bit. A file that states more is damaged.
const MOST_PIXELS_A_BYTE: u64 = 8 * 1032;
/// Marker of the end of a JPEG, and marker before its pixels.
const END_OF_JPEG: [u8; 2] = [0xFF, 0xD9];
const SCAN_OF_JPEG: [u8; 2] = [0xFF, 0xDA];

/// Reader of the format.
pub(super) struct PictureTable;

impl LogFormat for PictureTable {
    fn recognise(&self, files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let pair = Pair::around(files, opened)?;
        Some(Box::new(move |reading, progress| pair.read(reading, progress)))
    }

    /// Returns true for a table, because its picture is opened instead.
    fn is_read_by_name_only(&self, path: &Path) -> bool {
        has_ending(path, "csv")
    }
}

/// A picture and the table beside it.
struct Pair {
    picture: Opened,
    table: Opened,
    layout: Layout,
}

impl Pair {
    /// Returns the pair that a file belongs to; `None` where the other file is missing or of
    /// another kind.
    fn around(files: &FileSource, opened: &Opened) -> Option<Self> {
        if picture_format(&opened.bytes).is_some() {
            let (table, layout) = beside(files, &opened.path, &TABLES, layout_of)?;
            return Some(Self { picture: opened.clone(), table, layout });
        }
        if !has_ending(&opened.path, "csv") {
            return None;
        }
        let layout = layout_of(&opened.bytes)?;
        let (picture, _) = beside(files, &opened.path, &PICTURES, picture_format)?;
        Some(Self { picture, table: opened.clone(), layout })
    }

    fn read(self, reading: &Reading<'_>, progress: &Progress) -> Result<Survey, OpenError> {
        let fail = |fault: PictureFault| self.refuse(fault);
        let packed = PackedPicture::open(&self.picture.bytes).map_err(fail)?;
        let [table, picture] = [&self.table, &self.picture];
        let mut log = Collected::new(&[picture, table], NAME, reading);
        let mut rows = Reader::new(self.layout.clone(), TABLE);
        sounding_table::read_rows(&table.bytes, &mut rows, &mut log, reading, progress)?;
        let pings =
            numbered(&mut rows, packed.height()).map_err(|what| picture.unsupported(what))?;
        let grey = packed.unpack().map_err(fail)?;
        progress.check()?;
        collect(&mut log, grey, &pings);
        Ok(assemble::assemble(log, reading))
    }

    fn refuse(&self, fault: PictureFault) -> OpenError {
        match fault {
            PictureFault::TooLarge { .. } => {
                self.picture.unsupported(format!("the picture is too large: {fault}"))
            }
            fault => self.picture.broken(
                NAME,
                format!(
                    "the picture cannot be unpacked ({fault}); export it again, or copy it again from where it is whole"
                ),
            ),
        }
    }
}

/// Returns the pings of a table, with their rows in a picture with `height` rows.
fn numbered(rows: &mut Reader, height: usize) -> Result<Vec<TablePing>, String> {
    let mut pings = std::mem::take(&mut rows.pings);
    if rows.names_rows() {
        number_rows(&mut pings, height)?;
    } else if rows.rows != height {
        return Err(format!(
            "the picture has {height} rows and the table beside it {}; give every row of the picture a row of the table, from the top, or write its number into a column named row",
            rows.rows
        ));
    }
    if pings.is_empty() {
        return Err("no row of the table beside the picture has a range that a sonar can have; write the slant range of the outermost sample, in metres, into the column range_m".to_owned());
    }
    Ok(pings)
}

/// Converts the rows of the picture to count from 0, where the table counts from 1, and checks
/// them.
fn number_rows(pings: &mut [TablePing], height: usize) -> Result<(), String> {
    let first = pings.iter().map(|ping| ping.row).min().unwrap_or(0);
    let last = pings.iter().map(|ping| ping.row).max().unwrap_or(0);
    let zero = usize::from(first > 0 && last == height);
    let mut named: Vec<(usize, usize)> = Vec::with_capacity(pings.len());
    for ping in pings {
        let (row, (at, _)) = (ping.row, ping.place);
        ping.row -= zero;
        if ping.row >= height {
            return Err(format!(
                "the table beside the picture names row {row} of it (at byte {at}), and the picture has {height} rows; correct the column of the rows, which counts from 0 at the top"
            ));
        }
        named.push((row, at));
    }
    named.sort_unstable();
    match named.windows(2).find(|two| two[0].0 == two[1].0) {
        Some(&[(row, at), (_, other)]) => Err(format!(
            "the table beside the picture names row {row} of it twice (at bytes {at} and {other}); correct the column of the rows, or give it another name if it holds something else"
        )),
        _ => Ok(()),
    }
}

/// Adds the pings to the log, with the samples of their rows of the picture.
fn collect(log: &mut Collected, grey: GreyPicture, pings: &[TablePing]) {
    let encoding = if grey.is_wide { Encoding::U16 { shift: 0 } } else { Encoding::U8 };
    let half = grey.width / 2;
    let mut sides: Vec<[SideSpan; 2]> = Vec::with_capacity(pings.len());
    for ping in pings {
        let span = |order, column: usize| SideSpan {
            file: PICTURE,
            encoding,
            order,
            offset: ((ping.row * grey.width + column) * encoding.width()) as u64,
            count: half as u32,
            near_m: ping.range_m.0,
            far_m: ping.range_m.1,
        };
        let port = span(SampleOrder::FarToNear, 0);
        sides.push([port, span(SampleOrder::NearToFar, grey.width - half)]);
    }
    if grey.is_wide {
        let spans: Vec<&SideSpan> = sides.iter().flatten().collect();
        let shift = shift_to_fit(&grey.samples, &spans);
        for span in sides.iter_mut().flatten() {
            span.encoding = Encoding::U16 { shift };
        }
    }
    if !pings.is_empty() {
        log.report.log("the picture is taken as slant ranges, with the water column in its middle; if it was corrected to ground range, its first returns and ranges are wrong: set surface.side_scan_weight to 0 and surface.swath to off");
    }
    for (ping, [port, starboard]) in pings.iter().zip(sides) {
        let counted = Counted {
            record: (TABLE, ping.place.1),
            time_s: ping.time_s,
            samples: half,
            range_m: Some(ping.range_m),
        };
        log.count(CHANNEL, counted, || (ChannelKind::Composite, "picture".to_owned(), None));
        log.composite.push(SidePing {
            port: Some(port),
            starboard: Some(starboard),
            ..SidePing::with_depth(ping.time_s, f32::NAN)
        });
    }
    if let Some(file) = log.bytes.get_mut(usize::from(PICTURE)) {
        *file = Bytes::Packed { file: Box::new(file.clone()), samples: Arc::new(grey.samples) };
    }
}

/// Returns the layout of a table of pings; `None` for any other table, and for bytes that are no
/// table.
fn layout_of(bytes: &[u8]) -> Option<Layout> {
    match sounding_table::sniff(bytes)? {
        Recognised::Table(layout) => Some(layout).filter(Layout::has_pings),
        Recognised::Own => None,
    }
}

/// Returns the first file with the same name and one of these endings for which `find` has a
/// result.
fn beside<T>(
    files: &FileSource,
    path: &Path,
    endings: &[&str],
    find: impl Fn(&[u8]) -> Option<T>,
) -> Option<(Opened, T)> {
    let look = |path: PathBuf| {
        let bytes = files.read(&path).ok()?;
        let found = find(&bytes)?;
        Some((Opened { path, bytes }, found))
    };
    let mut paths = endings.iter().map(|ending| path.with_extension(ending));
    paths.find_map(look)
}

/// Returns the format of a picture, PNG or JPEG, by its first bytes; `None` for other files.
fn picture_format(bytes: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(bytes).ok()?;
    matches!(format, ImageFormat::Png | ImageFormat::Jpeg).then_some(format)
}

/// A picture whose header was read.
struct PackedPicture<'a> {
    decoder: Box<dyn ImageDecoder + 'a>,
}

/// A picture decoded to grey levels.
struct GreyPicture {
    /// Number of columns.
    width: usize,
    /// True if a level has two bytes, the low byte first.
    is_wide: bool,
    /// Levels, row by row.
    samples: Vec<u8>,
}

impl<'a> PackedPicture<'a> {
    /// Reads the header of a picture.
    ///
    /// # Errors
    /// When the picture is damaged, or states more pixels than its bytes can contain or than are
    /// decoded.
    fn open(bytes: &'a [u8]) -> Result<Self, PictureFault> {
        let open = || bounded_decoder(Cursor::new(bytes), LARGEST_UNPACKED, bytes_copied);
        let decoder = catch_panic(open).unwrap_or(Err(PictureFault::Damaged))?;
        let (width, height) = decoder.dimensions();
        let most = MOST_PIXELS_A_BYTE.saturating_mul(bytes.len() as u64);
        let is_whole = picture_format(bytes) != Some(ImageFormat::Jpeg) || is_whole_jpeg(bytes);
        if width < 2 || u64::from(width) * u64::from(height) > most || !is_whole {
            return Err(PictureFault::Damaged);
        }
        Ok(Self { decoder: Box::new(decoder) })
    }

    /// Returns the number of rows.
    fn height(&self) -> usize {
        self.decoder.dimensions().1 as usize
    }

    /// Decodes the picture to grey levels.
    ///
    /// # Errors
    /// When the picture is truncated or damaged.
    fn unpack(self) -> Result<GreyPicture, PictureFault> {
        catch_panic(|| unpack(self.decoder)).unwrap_or(Err(PictureFault::Damaged))
    }
}

fn unpack(decoder: Box<dyn ImageDecoder + '_>) -> Result<GreyPicture, PictureFault> {
    let picture = DynamicImage::from_decoder(decoder)?;
    let width = picture.width() as usize;
    let is_wide = is_wide(picture.color());
    let samples = if is_wide {
        // The bytes have the machine's byte order, which is that of the samples.
        bytemuck::cast_slice(picture.into_luma16().as_raw()).to_vec()
    } else {
        picture.into_luma8().into_raw()
    };
    Ok(GreyPicture { width, is_wide, samples })
}

fn is_wide(colours: ColorType) -> bool {
    colours.bytes_per_pixel() > colours.channel_count()
}

/// Returns the bytes for each pixel of the copies that [`unpack`] makes in addition to the picture.
fn bytes_copied(colours: ColorType) -> u64 {
    match colours {
        ColorType::L8 => 0,
        colours if is_wide(colours) => 4,
        _ => 1,
    }
}

/// Returns true if the pixels of a JPEG are followed by its end marker: the decoder would fill
/// missing pixels with grey. Neither marker can occur among pixels.
fn is_whole_jpeg(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|two| two == marker);
    last(END_OF_JPEG) > last(SCAN_OF_JPEG)
}
