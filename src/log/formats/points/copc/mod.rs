//! Writes Cloud Optimized Point Clouds (COPC 1.0, <https://copc.io>): LAZ 1.4 whose chunks are the
//! nodes of an octree, with a table of their places, so that a map program can read only the part
//! that it shows, from a disk or over the network. Any reader of LAZ can read it.
//!
//! In: points in the layout of LAS. Out: a COPC file.
//!
//! The crate `copc-rs` is not used for writing: it chooses the points of a node at random, so that
//! no two files are the same, and depends on other versions of `las` and `laz`.

mod octree;

use las::{Bounds, Builder, Header, PointData, Vector, Vlr, raw};
use laz::laszip::{ChunkTable, ChunkTableEntry};
use laz::record::{LayeredPointRecordCompressor, RecordCompressor};
use laz::{LazVlr, LazVlrBuilder};
use octree::OctreeNode;
use rayon::prelude::*;
use std::fs::File;
use std::io::{self, BufWriter, Seek as _, SeekFrom, Write};
use std::path::Path;

/// User id of the COPC records.
const USER: &str = "copc";
/// Id of the record that describes the octree; it must be the first.
const INFO: u16 = 1;
/// Bytes of that record.
const INFO_LENGTH: usize = 160;
/// Id of the record with the place of the chunk of each node.
const HIERARCHY: u16 = 1000;
/// Number of nodes that are compressed at a time.
const BATCH: usize = 64;

/// Returns true if a file has the ending of COPC, by which map programs recognise it.
pub(super) fn is_named_copc(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.to_lowercase().ends_with(".copc.laz")
}

/// Removes the records from a header that describe the packing and the octree of points; a writer
/// creates them again.
pub(super) fn remove_packing(header: &mut Builder) {
    let says_else = |record: &Vlr| {
        let is_of_copc = record.user_id == USER && [INFO, HIERARCHY].contains(&record.record_id);
        !is_of_copc && !las::laz::is_laszip_vlr(record)
    };
    header.vlrs.retain(says_else);
    header.evlrs.retain(says_else);
}

/// Writes points into an open file. `header` gives the properties that all points share, and its
/// records; counts, bounds and packing are computed.
///
/// # Errors
/// When writing fails, or the points are not of the formats 6 to 8 of LAS 1.4, the only ones of
/// COPC.
pub fn write_copc(file: File, header: Header, points: &PointData) -> io::Result<()> {
    let format = points.format();
    let (number, extra) = (format.to_u8().map_err(io::Error::other)? & 0x3f, format.extra_bytes);
    if !(6..=8).contains(&number) {
        return Err(io::Error::other(format!(
            "COPC holds points of the LAS formats 6 to 8, and these have format {number}; write .laz"
        )));
    }
    let packing = LazVlrBuilder::default()
        .with_point_format(number, extra)
        .map_err(io::Error::other)?
        .with_variable_chunk_size()
        .build();
    let mut header = with_packing(header, &packing, points)?;
    let cube = Cube::around(&header.bounds(), header.transforms().x.scale);
    let places: Vec<[u32; 3]> = (points.x().zip(points.y()).zip(points.z()))
        .map(|((x, y), z)| cube.on_lattice([x, y, z]))
        .collect();
    let nodes = octree::nodes(&places);
    drop(places);

    let mut out = BufWriter::new(file);
    write_header(&mut out, &header, None)?;
    let table = write_chunks(&mut out, &packing, &nodes, points)?;
    let first = out.stream_position()?;
    let hierarchy = record(HIERARCHY, "EPT Hierarchy", hierarchy(&header, &nodes, &table)?);
    let evlrs = std::iter::once(&hierarchy).chain(header.evlrs());
    for evlr in evlrs {
        let raw = evlr.clone().into_raw(true).map_err(io::Error::other)?;
        raw.write_to(&mut out).map_err(io::Error::other)?;
    }
    // The data follow the header of the record.
    let pages =
        [first + (hierarchy.len(true) - hierarchy.data.len()) as u64, hierarchy.data.len() as u64];
    let mut builder = Builder::from(header);
    if let Some(info) = builder.vlrs.first_mut() {
        info.data = cube.info(pages, points);
    }
    header = builder.into_header().map_err(io::Error::other)?;
    out.seek(SeekFrom::Start(0))?;
    write_header(&mut out, &header, Some(first))?;
    out.flush()
}

fn record(number: u16, description: &str, data: Vec<u8>) -> Vlr {
    Vlr { user_id: USER.to_owned(), record_id: number, description: description.to_owned(), data }
}

/// Returns the header with the records of the octree (still empty) and the packing at the front,
/// and the counts and bounds of the points.
fn with_packing(header: Header, packing: &LazVlr, points: &PointData) -> io::Result<Header> {
    let mut builder = Builder::from(header);
    builder.point_format = *points.format();
    builder.point_format.is_compressed = true;
    remove_packing(&mut builder);
    let mut data = Vec::new();
    packing.write_to(&mut data)?;
    let packing = Vlr {
        user_id: LazVlr::USER_ID.to_owned(),
        record_id: LazVlr::RECORD_ID,
        description: LazVlr::DESCRIPTION.to_owned(),
        data,
    };
    let info = record(INFO, "COPC info", vec![0; INFO_LENGTH]);
    builder.vlrs.splice(0..0, [info, packing]);
    let mut header = builder.into_header().map_err(io::Error::other)?;
    header.clear();
    header.add_point_data(points);
    Ok(header)
}

/// Writes the header and its records; `evlrs` is the offset of the extended records, if known.
fn write_header(out: &mut impl Write, header: &Header, evlrs: Option<u64>) -> io::Result<()> {
    let mut raw = header.clone().into_raw().map_err(io::Error::other)?;
    raw.evlr = evlrs.map(|start_of_first_evlr| raw::header::Evlr {
        start_of_first_evlr,
        number_of_evlrs: header.evlrs().len() as u32 + 1,
    });
    raw.write_to(&mut *out).map_err(io::Error::other)?;
    for vlr in header.vlrs() {
        let raw = vlr.clone().into_raw(false).map_err(io::Error::other)?;
        raw.write_to(&mut *out).map_err(io::Error::other)?;
    }
    out.write_all(header.vlr_padding())
}

/// Writes the points node by node, then the table of the chunks, whose offset is stored before
/// them. Returns the table.
fn write_chunks(
    out: &mut BufWriter<File>,
    packing: &LazVlr,
    nodes: &[OctreeNode],
    points: &PointData,
) -> io::Result<Vec<ChunkTableEntry>> {
    let start = out.stream_position()?;
    out.write_all(&(-1_i64).to_le_bytes())?;
    let mut entries = Vec::with_capacity(nodes.len());
    for batch in nodes.chunks(BATCH) {
        let packed = batch.par_iter().map(|node| packed(packing, node, points));
        for (node, bytes) in batch.iter().zip(packed.collect::<io::Result<Vec<_>>>()?) {
            out.write_all(&bytes)?;
            entries.push(ChunkTableEntry {
                point_count: node.points.len() as u64,
                byte_count: bytes.len() as u64,
            });
        }
    }
    let mut table = ChunkTable::default();
    let filled = entries.iter().filter(|entry| entry.point_count > 0);
    filled.for_each(|entry| table.push(*entry));
    let end = out.stream_position()?;
    table.write_to(&mut *out, packing)?;
    out.seek(SeekFrom::Start(start))?;
    out.write_all(&end.to_le_bytes())?;
    out.seek(SeekFrom::End(0))?;
    Ok(entries)
}

/// Returns the compressed chunk of a node; empty for a node without points.
fn packed(packing: &LazVlr, node: &OctreeNode, points: &PointData) -> io::Result<Vec<u8>> {
    if node.points.is_empty() {
        return Ok(Vec::new());
    }
    let (records, length) = (points.raw_bytes(), points.record_len());
    let mut compressor = LayeredPointRecordCompressor::new(Vec::new());
    compressor.set_fields_from(packing.items()).map_err(io::Error::other)?;
    for &point in &node.points {
        compressor.compress_next(&records[point * length..(point + 1) * length])?;
    }
    compressor.done()?;
    Ok(compressor.into_inner())
}

/// Returns the table of the nodes: level, cell, offset and bytes of the chunk, and number of
/// points.
fn hierarchy(
    header: &Header,
    nodes: &[OctreeNode],
    chunks: &[ChunkTableEntry],
) -> io::Result<Vec<u8>> {
    let too_large = |_| io::Error::other("a node of the octree is too large for COPC");
    let raw = header.clone().into_raw().map_err(io::Error::other)?;
    let mut at = u64::from(raw.offset_to_point_data) + ChunkTable::OFFSET_SIZE as u64;
    let mut bytes = Vec::new();
    for (node, chunk) in nodes.iter().zip(chunks) {
        let [x, y, z] = node.cell;
        for number in [node.level, x, y, z] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(if chunk.point_count > 0 { at } else { 0 }.to_le_bytes());
        for size in [chunk.byte_count, chunk.point_count] {
            bytes.extend(i32::try_from(size).map_err(too_large)?.to_le_bytes());
        }
        at += chunk.byte_count;
    }
    Ok(bytes)
}

/// Root node of the octree; all nodes are cubes.
struct Cube {
    centre: [f64; 3],
    half: f64,
}

impl Cube {
    /// Returns a cube slightly larger than the bounds, so that no point is on its sides; for a
    /// single place, as large as a step of the coordinates.
    fn around(bounds: &Bounds, step: f64) -> Self {
        let array = |at: Vector<f64>| [at.x, at.y, at.z];
        let (least, most) = (array(bounds.min), array(bounds.max));
        let is_empty = least[0] > most[0];
        let middle = |axis: usize| 0.5 * (least[axis] + most[axis]);
        let sides = [0, 1, 2].map(|axis| most[axis] - least[axis]);
        let longest = sides.into_iter().fold(step, f64::max);
        Self {
            centre: if is_empty { [0.0; 3] } else { [0, 1, 2].map(middle) },
            half: 0.5 * (1.0 + 1e-6) * longest,
        }
    }

    fn on_lattice(&self, place: [f64; 3]) -> [u32; 3] {
        let share = |axis: usize| (place[axis] - self.centre[axis]) / (2.0 * self.half) + 0.5;
        [0, 1, 2].map(|axis| octree::on_lattice(share(axis)))
    }

    /// Returns the record that describes the octree: centre, half the side, distance of the points
    /// in the root, offset and length of the table of the nodes, first and last time; the rest is
    /// reserved.
    fn info(&self, pages: [u64; 2], points: &PointData) -> Vec<u8> {
        let spacing = 2.0 * self.half / f64::from(octree::GRID);
        let mut bytes = Vec::with_capacity(INFO_LENGTH);
        for number in self.centre.into_iter().chain([self.half, spacing]) {
            bytes.extend(number.to_le_bytes());
        }
        pages.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        let times = || points.gps_time().into_iter().flatten();
        let ends = if points.is_empty() {
            [0.0; 2]
        } else {
            [times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max)]
        };
        ends.iter().for_each(|time| bytes.extend(time.to_le_bytes()));
        bytes.resize(INFO_LENGTH, 0);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use las::point::Format;
    use las::{
        BoundsSelection, CopcReader, LodSelection, Point, PointDataBuilder, Reader, Transform,
    };

    fn header(format: u8) -> Header {
        let mut builder = Builder::from((1, 4));
        builder.point_format = Format::new(format).unwrap();
        let millimetres = Transform { scale: 0.001, offset: 0.0 };
        builder.transforms = Vector { x: millimetres, y: millimetres, z: millimetres };
        builder.into_header().unwrap()
    }

    /// Returns a bed of `side` by `side` points, 0.25 m apart, a metre deeper every 32 m.
    fn bed(side: usize) -> Vec<Point> {
        let point = |index: usize| {
            let [x, y] = [index % side, index / side].map(|at| 0.25 * at as f64);
            let mut point = Point { x, y, z: (-x / 32.0 * 1e3).round() / 1e3, ..Point::default() };
            point.gps_time = Some(index as f64);
            point.return_number = 1;
            point
        };
        (0..side * side).map(point).collect()
    }

    fn write(path: &Path, points: Vec<Point>) -> io::Result<()> {
        let header = header(6);
        let points = PointDataBuilder::new().for_header(&header).build_from_points(points);
        write_copc(File::create(path)?, header, &points.unwrap())
    }

    #[test]
    fn a_file_is_read_as_copc_and_as_laz() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bed.copc.laz");
        let points = bed(400);
        write(&path, points.clone()).unwrap();

        let times = |read: &PointData| {
            let mut times: Vec<u64> = read.gps_time().unwrap().map(|time| time as u64).collect();
            times.sort_unstable();
            times
        };
        let all: Vec<u64> = (0..points.len() as u64).collect();
        let plain = Reader::from_path(&path).unwrap().read_points(u64::MAX).unwrap();
        assert_eq!(times(&plain), all);
        let mut reader = CopcReader::from_path(&path).unwrap();
        let every = reader.query(LodSelection::All, BoundsSelection::All).unwrap();
        assert_eq!(times(&every), all);
        // 128 cells along 100 m: a point in each cell of 0.78 m, and half that distance on the next
        // level.
        let coarse = reader.query(LodSelection::Level(0), BoundsSelection::All).unwrap();
        assert_eq!(coarse.len(), 128 * 128);
        let finer = reader.query(LodSelection::LevelMinMax(0, 2), BoundsSelection::All).unwrap();
        assert!((3 * coarse.len()..6 * coarse.len()).contains(&finer.len()), "{}", finer.len());
        let bounds = Bounds {
            min: Vector { x: 10.0, y: 20.0, z: -9.0 },
            max: Vector { x: 12.0, y: 21.0, z: 0.0 },
        };
        let found = reader.query(LodSelection::All, BoundsSelection::Within(bounds)).unwrap();
        assert_eq!(found.len(), 9 * 5);
        let header = Reader::from_path(&path).unwrap().header().clone();
        let info = header.copc_info_vlr().unwrap();
        assert_eq!([info.gpstime_minimum, info.gpstime_maximum], [0.0, (points.len() - 1) as f64]);
        assert_eq!(header.number_of_points(), points.len() as u64);
        for entry in reader.hierarchy_entries().collect::<Vec<_>>() {
            let bounds = entry.key.bounds(&info);
            let read = reader.read_entry(&entry).unwrap();
            let inside = |at: f64, least: f64, most: f64| (least..=most).contains(&at);
            assert!(read.x().all(|x| inside(x, bounds.min.x, bounds.max.x)));
            assert!(read.y().all(|y| inside(y, bounds.min.y, bounds.max.y)));
            assert!(read.z().all(|z| inside(z, bounds.min.z, bounds.max.z)));
        }
    }

    #[test]
    fn one_point_many_in_one_place_and_none_are_files_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("few.copc.laz");
        let at = Point { x: 5e5, y: 4e6, z: -2.5, gps_time: Some(7.0), ..Point::default() };
        for count in [0, 1, 40_000] {
            // The second writing gives the same bytes.
            let bytes = [0, 1].map(|_| {
                write(&path, vec![Point { x: 5e2, y: 4e2, ..at.clone() }; count]).unwrap();
                std::fs::read(&path).unwrap()
            });
            assert_eq!(bytes[0], bytes[1]);
            let mut reader = CopcReader::from_path(&path).unwrap();
            let read = reader.query(LodSelection::All, BoundsSelection::All).unwrap();
            assert_eq!(read.len(), count);
            let plain = Reader::from_path(&path).unwrap().read_points(u64::MAX).unwrap();
            assert_eq!(plain.len(), count);
        }
    }

    #[test]
    fn points_of_old_formats_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = File::create(folder.path().join("old.copc.laz")).unwrap();
        let header = header(1);
        let none = PointDataBuilder::new().for_header(&header).build();
        let refused = write_copc(file, header, &none).unwrap_err().to_string();
        assert!(refused.contains("format 1; write .laz"), "{refused}");
    }
}
