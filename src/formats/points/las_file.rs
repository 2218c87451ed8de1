//! Points in LAS and LAZ.

use super::las_claims;
use super::las_writer::{LasWriter, transforms};
use crate::catch_panic::catch_panic;
use las::{Builder, Header, Point, PointData, PointDataBuilder, Reader};
use std::fs::File;
use std::io;
use std::path::Path;

/// Points read at a time: the header's count is not trusted with one allocation.
const BATCH: u64 = 100_000;

/// The points of a LAS file, as they were stored.
#[derive(Debug)]
pub(super) struct LasFile {
    header: Header,
    batches: Vec<PointData>,
}

/// Reads all points. The crate trusts some of what a LAZ file says of itself: the file is checked first, and a panic becomes an error.
pub(super) fn read(path: &Path) -> Result<(LasFile, Vec<[f64; 3]>), String> {
    las_claims::check(path).map_err(|error| format!("the LAS file cannot be read: {error}"))?;
    catch_panic(|| read_checked(path))
        .unwrap_or_else(|| Err("the LAS file cannot be read: it is damaged".to_owned()))
}

fn read_checked(path: &Path) -> Result<(LasFile, Vec<[f64; 3]>), String> {
    let unusable = |error: las::Error| format!("the LAS file cannot be read: {error}");
    let mut reader = Reader::from_path(path).map_err(unusable)?;
    let header = reader.header().clone();
    let (mut batches, mut points) = (Vec::new(), Vec::new());
    loop {
        let batch = reader
            .read_points(BATCH)
            .map_err(|error| format!("{} after {} points", unusable(error), points.len()))?;
        if batch.is_empty() {
            break;
        }
        points.extend(
            batch
                .x()
                .zip(batch.y())
                .zip(batch.z())
                .map(|((x, y), z)| [x, y, z]),
        );
        batches.push(batch);
    }
    Ok((LasFile { header, batches }, points))
}

impl LasFile {
    /// The EPSG number of the file's system: the last that its WKT names, which is that of the whole.
    pub(super) fn epsg(&self) -> Option<u32> {
        let text = String::from_utf8_lossy(self.header.get_wkt_crs_bytes()?).into_owned();
        let (_, behind) = text.rsplit_once("\"EPSG\"")?;
        let digits = behind.trim_start_matches([',', '"', ' ']);
        let end = digits.find(|c: char| !c.is_ascii_digit())?;
        digits[..end].parse().ok()
    }

    /// Writes the kept points with all their attributes and the header's records.
    pub(super) fn write_kept(&self, file: File, kept: &[bool], compressed: bool) -> io::Result<()> {
        let mut flags = kept.iter();
        let mut builder = Builder::from(self.header.clone());
        builder.point_format.is_compressed = compressed;
        let header = builder.into_header().map_err(io::Error::other)?;
        let mut writer = LasWriter::new(file, header)?;
        for batch in &self.batches {
            let records = batch.raw_bytes().chunks(batch.record_len());
            let kept: Vec<u8> = records
                .zip(flags.by_ref())
                .filter(|(_, kept)| **kept)
                .flat_map(|(record, _)| record.iter().copied())
                .collect();
            let kept = PointDataBuilder::new()
                .with_format(*writer.header()?.point_format())
                .with_transforms(*writer.header()?.transforms())
                .build_from_bytes(kept)
                .map_err(io::Error::other)?;
            writer.points(&kept)?;
        }
        writer.finish()
    }
}

/// Coordinates are stored to a tenth of a millimetre, unless they lie too far apart for it.
const RESOLUTION_M: f64 = 1e-4;

/// Writes bare coordinates.
pub(super) fn write<'a>(
    file: File,
    points: impl Iterator<Item = &'a [f64; 3]> + Clone,
    compressed: bool,
) -> io::Result<()> {
    let first = points.clone().next().copied().unwrap_or_default();
    let transforms = transforms(points.clone().copied(), first, [RESOLUTION_M; 3])?;
    let mut builder = Builder::from((1, 4));
    builder.point_format.is_compressed = compressed;
    builder.transforms = transforms;
    let header = builder.into_header().map_err(io::Error::other)?;
    let mut writer = LasWriter::new(file, header)?;
    for &[x, y, z] in points {
        writer.point(Point {
            x,
            y,
            z,
            ..Point::default()
        })?;
    }
    writer.finish()
}
