//! Reads and writes points in LAS, LAZ and COPC.

use super::PointFormat;
use super::copc::{remove_packing, write_copc};
use super::las_claims;
use super::las_writer::{LasWriter, transforms};
use crate::support::catch_panic::catch_panic;
use crate::support::file_error::FaultText;
use las::point::Format;
use las::{Builder, Header, Point, PointData, PointDataBuilder, Reader};
use std::fs::File;
use std::io;
use std::path::Path;

/// Most points, and most bytes, that are read at a time, because the header's count and point
/// length are not trusted for one allocation.
const BATCH: u64 = 100_000;
const BATCH_BYTES: u64 = 8 << 20;

/// Points of a LAS file as stored, with the header.
#[derive(Debug)]
pub(super) struct LasFile {
    header: Header,
    batches: Vec<PointData>,
}

/// Reads all points. The las crate trusts some claims of a LAZ file: the file is checked first, and
/// a panic of the crate becomes an error.
pub(super) fn read(path: &Path) -> Result<(LasFile, Vec<[f64; 3]>), FaultText> {
    let read = match las_claims::check(path) {
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
