//! Writes lines and areas for map programs: shapefiles, and KML in its zipped form.
//!
//! In: lines and areas. Out: shapefiles and KMZ.
//!
//! `*.shp` with its `.shx`, `.dbf`, `.prj` and `.cpg` (ESRI, July 1998) opens in every map program
//! of the last decades; `*.kmz`, KML 2.2 (OGC 07-147r2) in a zip archive, opens in map programs and
//! on phones.
//!
//! A KMZ is only a zip archive of one file (PKWARE APPNOTE 6.3): three headers around a deflated
//! text. The crate `zip` is not used, because it switches features of crates that the GPU and the
//! network runtime are built on.

use super::geojson::{areas, positions};
use super::{ExportError, KML_HEAD, Summary, write_atomically, write_bytes};
use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_log::support::geo::{Crs, LonLat};
use bathyscope_log::support::printable::xml;
use flate2::write::DeflateEncoder;
use flate2::{Compression, CrcWriter};
use shapefile::dbase::{FieldError, FieldName, FieldWriter, TableWriterBuilder, WritableRecord};
use shapefile::{Point, Polyline, ShapeWriter};
use std::fs::File;
use std::io::{self, BufWriter, Seek as _, SeekFrom, Write};
use std::path::Path;

/// Number of digits of a number in the table, and of its decimals.
const DIGITS: (u8, u8) = (14, 3);
/// Largest number of letters of a label.
const LETTERS: u8 = 64;
/// Length above which a line has a label, degrees (some 10 m).
const LABELLED_DEG: f64 = 1e-4;
/// "Version needed": 2.0, deflate.
const VERSION: u16 = 20;
/// Method 8, deflate.
const DEFLATE: u16 = 8;
/// The first of January 1980: a fixed date, so that the same survey gives the same file.
const DATE: u16 = 0x0021;

/// A line with its label, numbers and colour.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LabelledLine {
    /// Corners of the line.
    pub points: Vec<LonLat>,
    /// Text beside the line.
    pub label: String,
    /// Numbers of the line, in the order of the names of their columns.
    pub numbers: Vec<f64>,
    /// Colour: red, green, blue.
    pub colour: [u8; 3],
}

/// Writes lines in a coordinate system. `names` are the headings of the columns of numbers, at most
/// ten letters each, which follow the column `label`. The `.shp` is renamed last: where it exists,
/// its companions are complete.
pub(crate) fn lines_shapefile(
    path: &Path,
    crs: &Crs,
    names: &[&'static str],
    lines: &[LabelledLine],
) -> Result<Summary, ExportError> {
    let beside = |extension: &str| path.with_extension(extension);
    write_bytes(&beside("prj"), crs.wkt())?;
    write_bytes(&beside("cpg"), "UTF-8")?;
    write_atomically(&beside("dbf"), |file| table(file, names, lines))?;
    write_atomically(path, |shp| {
        let index = write_atomically(&beside("shx"), |shx| {
            let mut writer = ShapeWriter::with_shx(BufWriter::new(shp), BufWriter::new(shx));
            let written = shapes(&mut writer, crs, lines).map_err(io::Error::other)?;
            writer.finalize().map_err(io::Error::other)?;
            Ok(written)
        });
        index.map_err(|error| error.source)
    })
}

fn shapes(
    writer: &mut ShapeWriter<BufWriter<File>>,
    crs: &Crs,
    lines: &[LabelledLine],
) -> Result<Summary, shapefile::Error> {
    let mut summary = Summary::default();
    for line in lines {
        let places = line.points.iter().map(|point| crs.place(*point));
        let points: Vec<Point> =
            places.inspect(|place| summary.reach(*place)).map(|[x, y]| Point::new(x, y)).collect();
        // The crate panics on a line of one point.
        if points.len() > 1 {
            summary.count += 1;
            writer.write_shape(&Polyline::new(points))?;
        }
    }
    Ok(summary)
}

fn table(file: File, names: &[&'static str], lines: &[LabelledLine]) -> io::Result<()> {
    let name = |name: &str| FieldName::try_from(name).map_err(io::Error::other);
    let (digits, decimals) = DIGITS;
    let mut fields = TableWriterBuilder::new().add_character_field(name("label")?, LETTERS);
    for field in names {
        fields = fields.add_numeric_field(name(field)?, digits, decimals);
    }
    let mut writer = fields.build_with_dest(BufWriter::new(file));
    for line in lines.iter().filter(|line| line.points.len() > 1) {
        writer.write_record(&ShapefileRow(line)).map_err(io::Error::other)?;
    }
    writer.finalize().map_err(io::Error::other)
}

struct ShapefileRow<'a>(&'a LabelledLine);

impl WritableRecord for ShapefileRow<'_> {
    fn write_using<W: Write>(&self, writer: &mut FieldWriter<'_, W>) -> Result<(), FieldError> {
        writer.write_next_field_value(&self.0.label)?;
        for number in &self.0.numbers {
            let known = number.is_finite().then_some(*number);
            writer.write_next_field_value(&known)?;
        }
        Ok(())
    }
}

/// Writes lines and, in a folder of their own, the labels of the longer lines: map programs draw no
/// label for a line alone, so each label is a point in the middle of its line. A mixture of lines
/// and points in one folder would be no layer of lines for QGIS.
pub(crate) fn lines_kmz(
    path: &Path,
    name: &str,
    lines: &[LabelledLine],
) -> Result<Summary, ExportError> {
    archive(path, name, |out| {
        let mut summary = Summary::default();
        let mut labels = String::new();
        for line in lines {
            let points = positions(line.points.iter().copied());
            summary.count += 1;
            points.iter().for_each(|at| summary.reach(*at));
            let [red, green, blue] = line.colour;
            let label = xml(&line.label);
            writeln!(
                out,
                "<Placemark><name>{label}</name><Style><LineStyle><color>ff{blue:02x}{green:02x}{red:02x}</color><width>2</width></LineStyle>\
                 </Style><LineString><tessellate>1</tessellate><coordinates>{}</coordinates></LineString></Placemark>",
                coordinates(&points)
            )?;
            if let Some(at) = anchor(&points) {
                labels += &format!(
                    "<Placemark><name>{label}</name><Style><IconStyle><scale>0</scale></IconStyle></Style><Point><coordinates>{}</coordinates></Point></Placemark>\n",
                    coordinates(&[at])
                );
            }
        }
        if !labels.is_empty() {
            write!(out, "<Folder><name>Labels</name>\n{labels}</Folder>\n")?;
        }
        Ok(summary)
    })
}

/// Returns the middle of a line that is long enough for a label; `None` for a shorter one.
fn anchor(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let steps = points.windows(2);
    let length: f64 =
        steps.map(|step| (step[1][0] - step[0][0]).hypot(step[1][1] - step[0][1])).sum();
    let middle = points.get(points.len() / 2);
    middle.copied().filter(|_| length > LABELLED_DEG)
}

/// Writes areas as one placemark; `place` returns the position of a corner.
pub(crate) fn areas_kmz(
    path: &Path,
    name: &str,
    shapes: &[Polygon],
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    archive(path, name, |out| {
        let mut summary = Summary { count: 1, ..Summary::default() };
        write!(
            out,
            "<Placemark><name>{}</name><Style><LineStyle><color>ff00d7ff</color><width>2</width></LineStyle>\
             <PolyStyle><color>4000d7ff</color></PolyStyle></Style><MultiGeometry>",
            xml(name)
        )?;
        for polygon in areas(shapes, &place) {
            write!(out, "<Polygon><tessellate>1</tessellate>")?;
            for (index, ring) in polygon.iter().enumerate() {
                ring.iter().for_each(|at| summary.reach(*at));
                let border = if index == 0 { "outer" } else { "inner" };
                write!(
                    out,
                    "<{border}BoundaryIs><LinearRing><coordinates>{}</coordinates></LinearRing></{border}BoundaryIs>",
                    coordinates(ring)
                )?;
            }
            write!(out, "</Polygon>")?;
        }
        writeln!(out, "</MultiGeometry></Placemark>")?;
        Ok(summary)
    })
}

/// Writes a document with this name and the content from `write` as `doc.kml` of a zip archive.
fn archive(
    path: &Path,
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> io::Result<Summary>,
) -> Result<Summary, ExportError> {
    write_atomically(path, |file| {
        one_file(file, "doc.kml", |out| {
            writeln!(out, "{KML_HEAD}<name>{}</name>", xml(name))?;
            let summary = write(out)?;
            out.write_all(b"</Document>\n</kml>\n")?;
            Ok(summary)
        })
    })
}

fn coordinates(points: &[[f64; 2]]) -> String {
    let texts = points.iter().map(|at| {
        let [lon, lat] = at;
        format!("{lon:.8},{lat:.8}")
    });
    texts.collect::<Vec<_>>().join(" ")
}

/// Writes a zip archive of one file, whose content is written by `write`.
fn one_file<T>(
    file: File,
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> io::Result<T> {
    let mut out = BufWriter::new(file);
    // Checksum and sizes are filled in at the end.
    out.write_all(&local_header(name, [0; 3]))?;
    let start = out.stream_position()?;
    let mut counted = ByteCounter {
        inner: CrcWriter::new(DeflateEncoder::new(out, Compression::default())),
        bytes: 0,
    };
    let made = write(&mut counted)?;
    let (crc, bytes) = (counted.inner.crc().sum(), counted.bytes);
    let mut out = counted.inner.into_inner().finish()?;
    let end = out.stream_position()?;
    let [packed, bytes, place] = [end - start, bytes, end].map(u32::try_from);
    let too_large = |_| io::Error::other("the archive would pass 4 GB, which zip cannot hold");
    let (packed, bytes) = (packed.map_err(too_large)?, bytes.map_err(too_large)?);
    let sizes = [crc, packed, bytes];
    let directory = directory(name, sizes);
    out.write_all(&directory)?;
    out.write_all(&end_record(directory.len() as u32, place.map_err(too_large)?))?;
    out.seek(SeekFrom::Start(0))?;
    out.write_all(&local_header(name, sizes))?;
    out.flush()?;
    Ok(made)
}

struct ByteCounter<W> {
    inner: W,
    bytes: u64,
}

impl<W: Write> Write for ByteCounter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Returns the fields that both headers of a file share: version, flags, method, time, date,
/// checksum, sizes, length of the name, extra fields.
fn shared(name: &str, sizes: [u32; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for value in [VERSION, 0, DEFLATE, 0, DATE] {
        bytes.extend(value.to_le_bytes());
    }
    for value in sizes {
        bytes.extend(value.to_le_bytes());
    }
    for value in [name.len() as u16, 0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

fn local_header(name: &str, sizes: [u32; 3]) -> Vec<u8> {
    [b"PK\x03\x04", shared(name, sizes).as_slice(), name.as_bytes()].concat()
}

/// Returns the entry of the directory: version that made it, the shared part, then comment, disk,
/// attributes and place, all 0.
fn directory(name: &str, sizes: [u32; 3]) -> Vec<u8> {
    let made_by = VERSION.to_le_bytes();
    let parts =
        [b"PK\x01\x02", made_by.as_slice(), &shared(name, sizes), &[0; 14], name.as_bytes()];
    parts.concat()
}

/// Returns the end record of the archive: one entry, on one disk; length and place of the
/// directory; no comment.
fn end_record(length: u32, place: u32) -> Vec<u8> {
    let mut bytes = b"PK\x05\x06\0\0\0\0\x01\0\x01\0".to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend(place.to_le_bytes());
    bytes.extend([0, 0]);
    bytes
}
