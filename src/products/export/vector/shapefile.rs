//! `*.shp` with its `.shx`, `.dbf`, `.prj` and `.cpg` (ESRI, July 1998): what every map program of
//! the last decades opens.

use super::LabelledLine;
use crate::export::{ExportError, Summary, write_atomically, write_bytes};
use bathyscope_log::support::geo::Crs;
use shapefile::dbase::{FieldError, FieldName, FieldWriter, TableWriterBuilder, WritableRecord};
use shapefile::{Point, Polyline, ShapeWriter};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Digits of a number in the table, and of these behind the point.
const DIGITS: (u8, u8) = (14, 3);
/// Letters of a label.
const LETTERS: u8 = 64;

/// Writes lines in a system; `names` of their numbers, ten letters each at most, head the columns
/// behind `label`. The `.shp` is in its place last: where it is, its companions are whole.
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
    for one in names {
        fields = fields.add_numeric_field(name(one)?, digits, decimals);
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
