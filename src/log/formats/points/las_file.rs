//! Reads and writes points in LAS, LAZ and COPC, and chooses the scale and offset of their 32-bit
//! coordinates; compares the sizes that a header claims with the size of the file, before the las
//! crate allocates memory by them.

use super::PointFormat;
use super::copc::{remove_packing, write_copc};
use crate::support::catch_panic::catch_panic;
use crate::support::file_error::FaultText;
use crate::support::regular_file;
use las::point::Format;
use las::{Builder, Header, Point, PointData, PointDataBuilder, Reader, Transform, Vector, Writer};
use std::fs::File;
use std::io::{self, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// Most points, and most bytes, that are read at a time, because the header's count and point
/// length are not trusted for one allocation.
const BATCH: u64 = 100_000;
const BATCH_BYTES: u64 = 8 << 20;
/// First version of LAS (bytes 24 and 25) whose header has fields for extended records (LAS 1.4
/// R15, table 3).
const VERSION_14: [u8; 2] = [1, 4];
/// Bytes before the data of an extended record, and offset of the data's length (8 bytes) in the
/// record.
const EXTENDED_HEADER: u64 = 60;
const EXTENDED_LENGTH: u64 = 20;
/// Bit of the point format byte that marks LAZ.
const COMPRESSED: u8 = 0x80;
/// User id and record id of the record that describes the compression of LAZ points.
const PACKING_USER: &[u8] = b"laszip encoded";
const PACKING_RECORD: u16 = 22_204;
/// Bytes before the data of a record that is not extended.
const RECORD_HEADER: u64 = 54;
/// Number of the compressor that compresses a chunk in layers, one for each kind of number in a
/// point.
const LAYERED: u16 = 3;

/// Points of a LAS file as stored, with the header.
#[derive(Debug)]
pub(super) struct LasFile {
    header: Header,
    batches: Vec<PointData>,
}

/// Reads all points. The las crate trusts some claims of a LAZ file: the file is checked first, and
/// a panic of the crate becomes an error.
pub(super) fn read(path: &Path) -> Result<(LasFile, Vec<[f64; 3]>), FaultText> {
    let read = match check_claims(path) {
        Ok(()) => catch_panic(|| read_checked(path)).unwrap_or(Err("it is damaged".to_owned())),
        Err(error) => Err(error.to_string()),
    };
    read.map_err(|what| format!("the LAS file cannot be read: {what}").into())
}

fn read_checked(path: &Path) -> Result<(LasFile, Vec<[f64; 3]>), String> {
    let mut reader = Reader::from_path(path).map_err(|error| error.to_string())?;
    let header = reader.header().clone();
    let (mut batches, mut points) = (Vec::new(), Vec::new());
    let length = u64::from(header.point_format().len()).max(1);
    let batch = (BATCH_BYTES / length).min(BATCH).min(header.number_of_points());
    loop {
        let batch = reader.read_points(batch.max(1));
        let batch = batch.map_err(|error| format!("{error} after {} points", points.len()))?;
        if batch.is_empty() {
            break;
        }
        points.extend(batch.x().zip(batch.y()).zip(batch.z()).map(|((x, y), z)| [x, y, z]));
        batches.push(batch);
    }
    Ok((LasFile { header, batches }, points))
}

impl LasFile {
    /// Returns, for each point, true if it is flagged as withheld: by LAS such points should not be
    /// included in processing.
    pub(super) fn withheld(&self) -> Vec<bool> {
        // Byte 15 of a point has the flag in every point format.
        const FLAGS: usize = 15;
        let bit = if self.header.point_format().is_extended { 0b100 } else { 0b1000_0000 };
        let records = (self.batches.iter())
            .flat_map(|batch| batch.raw_bytes().chunks_exact(batch.record_len()));
        records.map(|record| record.get(FLAGS).is_some_and(|flags| flags & bit != 0)).collect()
    }

    /// Returns the EPSG number of the file's coordinate system: the last number in its WKT, which
    /// belongs to the system as a whole; `None` without WKT.
    pub(super) fn epsg(&self) -> Option<u32> {
        let text = String::from_utf8_lossy(self.header.get_wkt_crs_bytes()?).into_owned();
        let (_, behind) = text.rsplit_once("\"EPSG\"")?;
        let digits = behind.trim_start_matches([',', '"', ' ']);
        let end = digits.find(|c: char| !c.is_ascii_digit())?;
        digits[..end].parse().ok()
    }

    /// Writes the kept points with all their attributes and the header's records.
    pub(super) fn write_kept(
        &self,
        file: File,
        kept: &[bool],
        format: PointFormat,
    ) -> io::Result<()> {
        let mut builder = Builder::from(self.header.clone());
        builder.point_format.is_compressed = format != PointFormat::Las;
        // The records describe the compression of the input; the output is compressed again.
        remove_packing(&mut builder);
        let header = builder.into_header().map_err(io::Error::other)?;
        let form = PointDataBuilder::new().for_header(&header);
        let points = |records| {
            let points = form.clone().build_from_bytes(records);
            points.map_err(io::Error::other)
        };
        let mut flags = kept.iter();
        let mut batches = self.batches.iter().map(|batch| {
            let records = batch.raw_bytes().chunks(batch.record_len());
            let kept = records.zip(flags.by_ref()).filter(|(_, kept)| **kept);
            kept.flat_map(|(record, _)| record.iter().copied()).collect::<Vec<u8>>()
        });
        if format == PointFormat::Copc {
            return write_copc(file, header, &points(batches.flatten().collect())?);
        }
        let mut writer = LasWriter::new(file, header)?;
        batches.try_for_each(|batch| writer.points(&points(batch)?))?;
        writer.finish()
    }
}

/// Resolution of stored coordinates, metres, unless the points are too far apart for it.
const RESOLUTION_M: f64 = 1e-4;
/// Simplest point format that COPC allows.
const COPC_FORMAT: u8 = 6;

/// Writes points that have only coordinates.
pub(super) fn write<'a>(
    file: File,
    points: impl Iterator<Item = &'a [f64; 3]> + Clone,
    format: PointFormat,
) -> io::Result<()> {
    let first = points.clone().next().copied().unwrap_or_default();
    let transforms = transforms(points.clone().copied(), first, [RESOLUTION_M; 3])?;
    let mut builder = Builder::from((1, 4));
    builder.transforms = transforms;
    let bare = |&[x, y, z]: &[f64; 3]| Point { x, y, z, ..Point::default() };
    if format == PointFormat::Copc {
        builder.point_format = Format::new(COPC_FORMAT).map_err(io::Error::other)?;
        let header = builder.into_header().map_err(io::Error::other)?;
        // These formats require a time, which the points do not have.
        let timed = points.map(|point| Point { gps_time: Some(0.0), ..bare(point) });
        let records = PointDataBuilder::new().for_header(&header);
        let records = records.build_from_points(timed).map_err(io::Error::other)?;
        return write_copc(file, header, &records);
    }
    builder.point_format.is_compressed = format == PointFormat::Laz;
    let header = builder.into_header().map_err(io::Error::other)?;
    let mut writer = LasWriter::new(file, header)?;
    points.map(bare).try_for_each(|point| writer.point(point))?;
    writer.finish()
}

/// Writer that returns an error where the writer of the crate panics: if dropped before the end,
/// the crate's writer writes its header again, which fails where the disk is full or a point is
/// outside the range of LAS.
pub struct LasWriter(Option<Writer<BufWriter<File>>>);

impl LasWriter {
    /// Creates a writer of an open file and writes the header.
    pub fn new(file: File, header: Header) -> io::Result<Self> {
        let writer = Writer::new(BufWriter::new(file), header).map_err(failed)?;
        Ok(Self(Some(writer)))
    }

    /// Writes a point.
    pub fn point(&mut self, point: Point) -> io::Result<()> {
        let writer = self.0.as_mut().ok_or_else(closed)?;
        writer.write_point(point).map_err(failed)
    }

    /// Writes points in their stored form, as read from another file.
    pub fn points(&mut self, points: &PointData) -> io::Result<()> {
        let writer = self.0.as_mut().ok_or_else(closed)?;
        writer.write_points(points).map_err(failed)
    }

    /// Writes the remaining points, and the header with the count and bounds of the points.
    pub fn finish(mut self) -> io::Result<()> {
        let writer = self.0.as_mut().ok_or_else(closed)?;
        writer.close().map_err(failed)?;
        let writer = self.0.take().ok_or_else(closed)?;
        let file = writer.into_inner().map_err(failed)?;
        file.into_inner().map_err(|error| error.into_error())?.flush()
    }
}

impl Drop for LasWriter {
    fn drop(&mut self) {
        let left = self.0.take();
        // The error that matters was returned earlier.
        catch_panic(|| drop(left));
    }
}

/// Returns the operating system's error where the crate wraps it.
fn failed(error: las::Error) -> io::Error {
    match error {
        las::Error::Io(error) => error,
        error => io::Error::other(error),
    }
}

fn closed() -> io::Error {
    io::Error::other("the LAS file is closed already")
}

/// Multiples of the finest resolution that are tried where points are too far apart for it.
const COARSER: [f64; 3] = [1.0, 10.0, 100.0];
/// Most steps between a coordinate and the offset, a little less than 32 bits allow.
const MOST_STEPS: f64 = 2_147_483_000.0;

/// Returns the scale and offset of every axis: the finest resolution, with an offset near `near`,
/// if all points are within its range; otherwise an offset in the middle of the points, at the
/// finest resolution, or at ten or a hundred times that.
///
/// The error is a sentence without the path: a coordinate is no number, or the points are too far
/// apart even then.
pub fn transforms(
    points: impl Iterator<Item = [f64; 3]>,
    near: [f64; 3],
    finest: [f64; 3],
) -> io::Result<Vector<Transform>> {
    let nothing = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut are_numbers = true;
    let (low, high) = points.fold(nothing, |(low, high), point| {
        are_numbers &= point.iter().all(|value| value.is_finite());
        (
            [0, 1, 2].map(|axis| low[axis].min(point[axis])),
            [0, 1, 2].map(|axis| high[axis].max(point[axis])),
        )
    });
    if !are_numbers {
        return Err(io::Error::other(
            "a point has a coordinate that is no number, which LAS cannot hold",
        ));
    }
    let axis = |axis: usize| {
        let span = [low[axis], high[axis]];
        let found = transform(span, near[axis], finest[axis]);
        found.ok_or_else(|| {
            let name = ["x", "y", "z"][axis];
            let [from, to] = span.map(short);
            let most = short(2.0 * MOST_STEPS * COARSER[2] * finest[axis]);
            io::Error::other(format!(
                "the points reach from {from} to {to} along {name}, and LAS holds {most} at most; remove what lies far off, or write .csv or .ply"
            ))
        })
    };
    Ok(Vector { x: axis(0)?, y: axis(1)?, z: axis(2)? })
}

fn transform([low, high]: [f64; 2], near: f64, finest: f64) -> Option<Transform> {
    let near = near.round();
    let middle = (0.5 * low + 0.5 * high).round();
    let fits = |transform: &Transform| {
        // Without points, the bounds are infinite with the wrong signs, and every transform fits.
        let reach = MOST_STEPS * transform.scale;
        !(transform.offset - low > reach || high - transform.offset > reach)
    };
    let finest = [near, middle].map(|offset| Transform { scale: finest, offset });
    let coarser = COARSER[1..]
        .iter()
        .map(|times| Transform { scale: finest[0].scale * times, offset: middle });
    finest.into_iter().chain(coarser).find(fits)
}

/// Formats a number in few characters at any size.
fn short(value: f64) -> String {
    match value.abs() {
        1e-3..1e5 => format!("{value:.3}"),
        1e5..1e12 => format!("{value:.0}"),
        _ => format!("{value:e}"),
    }
}

/// Refuses a file whose header claims an extended record, a table of LAZ chunks, or layers of a
/// chunk that are larger than the file, or compressed points whose length differs from that of the
/// points: the crate would allocate memory for all of these before it reads them.
fn check_claims(path: &Path) -> io::Result<()> {
    let mut file = regular_file::open(path)?;
    let len = file.metadata()?.len();
    let mut at = |offset: u64| Field::at(&mut file, offset);
    // The las crate uses the version and ignores the header's stated length; it reads only the
    // first extended record.
    let [major, minor, ..] = at(24)?.0;
    if [major, minor] >= VERSION_14 && at(243)?.u32() > 0 {
        let start = at(235)?.u64();
        let data = start.saturating_add(EXTENDED_HEADER);
        if data > len || at(start + EXTENDED_LENGTH)?.u64() > len - data {
            return Err(io::Error::other("its extended record reaches beyond the end of the file"));
        }
    }
    if at(104)?.0[0] & COMPRESSED != 0 {
        let points = u64::from(at(96)?.u32());
        let mut table = at(points)?.i64();
        if table <= points as i64 {
            // The writer could not seek back: the offset of the table is at the end of the file.
            table = at(len.saturating_sub(8))?.i64();
        }
        let table = u64::try_from(table).unwrap_or(len).min(len);
        let chunks = table.checked_add(4);
        if let Some(chunks) = chunks.filter(|&chunks| chunks < len)
            && u64::from(at(chunks)?.u32()) > len
        {
            return Err(io::Error::other("its table claims more chunks than it has bytes"));
        }
        if let Some(layers) = layers(&mut at, len)? {
            let record = u64::from(at(105)?.u16());
            check_layers(&mut at, points + 8, table, record, layers)?;
        }
    }
    Ok(())
}

/// Returns the number of layers in every chunk, from the record for the compression; `None` where
/// points are compressed one after the other, or there is no such record.
fn layers(at: &mut impl FnMut(u64) -> io::Result<Field>, len: u64) -> io::Result<Option<u64>> {
    let Some(data) = packing(at, len)? else {
        return Ok(None);
    };
    let (mut layers, mut bytes) = (0, 0);
    for item in 0..u64::from(at(data + 32)?.u16()) {
        let (kind, size) = (at(data + 34 + 6 * item)?.u16(), at(data + 36 + 6 * item)?.u16());
        bytes += u64::from(size);
        layers += match kind {
            10 => 9,
            12 => 2,
            // Each extra byte has its own layer.
            14 => u64::from(size),
            _ => 1,
        };
    }
    if bytes != u64::from(at(105)?.u16()) {
        return Err(io::Error::other("its points are packed with another length than they have"));
    }
    Ok((at(data)?.u16() == LAYERED).then_some(layers))
}

/// Returns the offset of the data of the record for the compression, which is one of the records,
/// or the first extended one; `None` where there is none.
fn packing(at: &mut impl FnMut(u64) -> io::Result<Field>, len: u64) -> io::Result<Option<u64>> {
    let [major, minor, ..] = at(24)?.0;
    // The records begin after the fields of this version; the header's stated length is ignored.
    let fields = match [major, minor] {
        version if version >= VERSION_14 => 375,
        [1, 3] => 235,
        _ => 227,
    };
    let mut record = u64::from(at(94)?.u16()).max(fields);
    for _ in 0..at(100)?.u32() {
        if record >= len {
            break;
        }
        let data = record + RECORD_HEADER;
        if is_packing(at, record)? {
            return Ok(Some(data));
        }
        record = data + u64::from(at(record + 20)?.u16());
    }
    if [major, minor] < VERSION_14 || at(243)?.u32() == 0 {
        return Ok(None);
    }
    let record = at(235)?.u64();
    Ok(is_packing(at, record)?.then(|| record.saturating_add(EXTENDED_HEADER)))
}

/// Returns true if a record, extended or not, is the record for the compression.
fn is_packing(at: &mut impl FnMut(u64) -> io::Result<Field>, record: u64) -> io::Result<bool> {
    let mut user = Vec::new();
    for part in [2, 10] {
        user.extend(at(record.saturating_add(part))?.0);
    }
    let number = at(record.saturating_add(18))?.u16();
    Ok(user.starts_with(PACKING_USER) && number == PACKING_RECORD)
}

/// Checks the layers of each chunk in turn. A chunk has one uncompressed point, the number of
/// points, the size of every layer, and the layers.
fn check_layers(
    at: &mut impl FnMut(u64) -> io::Result<Field>,
    mut chunk: u64,
    table: u64,
    record: u64,
    layers: u64,
) -> io::Result<()> {
    while chunk < table {
        let sizes = chunk + record + 4;
        let mut next = sizes + 4 * layers;
        for layer in 0..layers {
            next += u64::from(at(sizes + 4 * layer)?.u32());
            if next > table {
                return Err(io::Error::other("a chunk of its points reaches beyond their end"));
            }
        }
        chunk = next;
    }
    Ok(())
}

/// Eight bytes at an offset; zeros beyond the end of the file.
struct Field([u8; 8]);

impl Field {
    fn at(file: &mut File, offset: u64) -> io::Result<Self> {
        file.seek(SeekFrom::Start(offset))?;
        let mut read = Vec::with_capacity(8);
        file.take(8).read_to_end(&mut read)?;
        let mut bytes = [0; 8];
        for (to, from) in bytes.iter_mut().zip(read) {
            *to = from;
        }
        Ok(Self(bytes))
    }

    fn u16(&self) -> u16 {
        self.u64() as u16
    }

    fn u32(&self) -> u32 {
        self.u64() as u32
    }

    fn u64(&self) -> u64 {
        u64::from_le_bytes(self.0)
    }

    fn i64(&self) -> i64 {
        i64::from_le_bytes(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(points: &[[f64; 3]]) -> io::Result<Vector<Transform>> {
        transforms(points.iter().copied(), [5e5, 4e6, 0.0], [1e-3; 3])
    }

    #[test]
    fn the_resolution_follows_the_extent_and_what_does_not_fit_is_said() {
        let usual = made(&[[500_010.0, 4_000_020.0, -3.0]]).unwrap();
        assert_eq!((usual.x.offset, usual.x.scale), (5e5, 1e-3));
        let nothing = made(&[]).unwrap();
        assert_eq!((nothing.z.offset, nothing.z.scale), (0.0, 1e-3));
        let far = made(&[[9.5e9, 0.0, 1e9], [9.5e9, 0.0, 1e9]]).unwrap();
        assert_eq!((far.x.offset, far.z.offset), (9.5e9, 1e9));
        let wide = made(&[[-9e6, 0.0, 0.0], [9e6, 0.0, 0.0]]).unwrap();
        assert_eq!((wide.x.offset, wide.x.scale), (0.0, 1e-2));
        for transform in [usual.x, far.x, wide.x] {
            let reach = f64::from(i32::MAX) * transform.scale;
            assert!(transform.offset.abs() < 1e10 && reach > 2e6);
        }
        let apart = made(&[[0.0, 0.0, -1e300], [0.0, 0.0, 1e300]]).unwrap_err().to_string();
        assert!(apart.contains("-1e300 to 1e300 along z"), "{apart}");
        let none = made(&[[0.0, f64::NAN, 0.0]]).unwrap_err().to_string();
        assert!(none.contains("no number"), "{none}");
    }
}
