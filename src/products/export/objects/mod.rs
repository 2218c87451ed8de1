//! Writes objects and their boxes, of one log or of several, for other programs: tables, and files
//! for maps and plotters (`maps`). `detections.csv` and `targets.csv` have a row for each box,
//! `objects.csv` has one for each object. The boxes that a detector found in a picture of another
//! program have a table too.
//!
//! In: boxes with their places and decisions, and the objects that they show. Out: tables and files
//! for maps.

mod maps;
mod shapes_ply;

pub(crate) use maps::{object_layers, objects_geojson, objects_gpkg, objects_gpx, objects_kml};
pub(crate) use shapes_ply::shapes_ply;

use crate::export::{ExportError, Summary, write_atomically};
use bathyscope_log::survey::Survey;
use bathyscope_objects::Scored;
use bathyscope_objects::objects::{
    ColumnValue, ListedObject, OBJECT_COLUMNS, ObjectBox, ObjectColumn,
};
use bathyscope_objects::review::Certainty;
use bathyscope_objects::targets::{FittedShape, Target};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Names and texts of the columns of the table of boxes.
const COLUMNS: [(&str, BoxText); 30] = [
    ("id", |row| row.of.one.id.0.to_string()),
    ("file", |row| plain(row.file)),
    ("class", |row| plain(&row.of.class)),
    ("score", |row| row.of.one.score.map_or_else(String::new, |score| format!("{score:.4}"))),
    ("state", |row| row.of.one.state.name().to_owned()),
    ("side", |row| row.of.one.mark.side.name().to_owned()),
    ("ping_from", |row| row.of.one.mark.pings.start.to_string()),
    ("ping_to", |row| row.of.one.mark.pings.end.to_string()),
    ("sample_from", |row| row.of.one.mark.samples(row.survey).start.to_string()),
    ("sample_to", |row| row.of.one.mark.samples(row.survey).end.to_string()),
    ("lon", |row| row.target(|target| target.position.lon_deg, 8)),
    ("lat", |row| row.target(|target| target.position.lat_deg, 8)),
    ("east_m", |row| row.target(|target| target.east_m, 3)),
    ("north_m", |row| row.target(|target| target.north_m, 3)),
    ("length_m", |row| row.target(|target| target.length_m, 3)),
    ("width_m", |row| row.target(|target| target.width_m, 3)),
    ("height_m", |row| row.target(|target| target.height_m, 3)),
    ("depth_m", |row| row.target(|target| target.depth_m, 3)),
    ("sigma_m", |row| row.target(|target| target.sigma_m, 3)),
    ("height_sigma_m", |row| row.target(|target| target.height_sigma_m, 3)),
    ("object", |row| row.of.object.map_or_else(String::new, |object| object.to_string())),
    ("note", |row| plain(&row.of.one.note)),
    ("name", |row| plain(&row.of.one.name)),
    ("confidence", |row| row.of.one.certainty.map_or("", Certainty::name).to_owned()),
    ("shape", |row| row.shape.map_or("", |shape| shape.posed.solid.kind.name()).to_owned()),
    ("shape_length_m", |row| row.solid(|shape| shape.posed.solid.length_m, 2)),
    ("shape_width_m", |row| row.solid(|shape| shape.posed.solid.width_m, 2)),
    ("shape_height_m", |row| row.solid(|shape| shape.posed.solid.height_m, 2)),
    ("shape_heading_deg", |row| row.solid(|shape| shape.posed.shown_heading_rad().to_degrees(), 0)),
    ("shape_explained", |row| row.solid(|shape| shape.explained, 2)),
];
const PICTURE_HEADER: [&str; 9] =
    ["id", "file", "class", "score", "state", "x_from", "x_to", "y_from", "y_to"];

/// A log whose boxes are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectLog<'a> {
    /// Name of the log in its survey.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
}

/// Returns the number and the extent of the places of objects.
pub(crate) fn object_places(objects: &[ListedObject<'_>]) -> Summary {
    let mut summary = Summary::default();
    for ListedObject { object, .. } in objects {
        summary.add([object.position.lon_deg, object.position.lat_deg], f64::NAN);
    }
    summary
}

/// Writes boxes as a table. `*_to` is the first ping or sample after the box; samples are those of
/// the middle ping. A field is empty where there is no value; a text that a spreadsheet would read
/// as a formula begins with an apostrophe. With several logs the table begins with the column
/// `log`. Shapes belong to whole objects: all boxes of an object have the same shape.
pub(crate) fn box_table(
    path: &Path,
    logs: &[ObjectLog<'_>],
    boxes: &[&ObjectBox],
    shapes: &BTreeMap<u32, FittedShape>,
) -> Result<(), ExportError> {
    let column = (logs.len() > 1).then_some("log");
    let files: Vec<String> = logs.iter().map(|log| log.survey.name()).collect();
    write_table(path, |table| {
        table.write_record(column.into_iter().chain(COLUMNS.map(|(name, _)| name)))?;
        for of in boxes {
            let (Some(log), Some(file)) = (logs.get(of.log), files.get(of.log)) else {
                continue;
            };
            // With a single log the column is not needed.
            let name = column.map(|_| plain(log.name));
            let shape = of.object.and_then(|number| shapes.get(&number));
            let row = BoxRow { of, shape, file, survey: log.survey };
            let fields = COLUMNS.iter().map(|(_, text)| text(&row));
            table.write_record(name.into_iter().chain(fields))?;
        }
        Ok(())
    })
}

/// Returns the text of a box in one column.
type BoxText = fn(&BoxRow<'_>) -> String;

/// A box, and what its row is made from.
struct BoxRow<'a> {
    of: &'a ObjectBox,
    shape: Option<&'a FittedShape>,
    file: &'a str,
    survey: &'a Survey,
}

impl BoxRow<'_> {
    fn target(&self, value: fn(&Target) -> f64, decimals: usize) -> String {
        let target = self.of.target.as_ref();
        target.map_or_else(String::new, |target| number(value(target), decimals))
    }

    fn solid(&self, value: fn(&FittedShape) -> f64, decimals: usize) -> String {
        self.shape.map_or_else(String::new, |shape| number(value(shape), decimals))
    }
}

fn number(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { String::new() }
}

/// Writes a table whose records `write` adds.
fn write_table(
    path: &Path,
    write: impl FnOnce(&mut csv::Writer<BufWriter<File>>) -> csv::Result<()>,
) -> Result<(), ExportError> {
    write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(BufWriter::new(out));
        write(&mut table)?;
        table.flush()?;
        table.into_inner().map_err(|error| error.into_error())?.flush()
    })
}

/// Returns a text that no spreadsheet reads as a formula.
fn plain(text: &str) -> String {
    if text.starts_with(['=', '+', '-', '@']) { format!("'{text}") } else { text.to_owned() }
}

/// Writes objects as a table of all columns. A field is empty where there is no value; a text that
/// a spreadsheet would read as a formula begins with an apostrophe.
pub(crate) fn object_table(path: &Path, objects: &[ListedObject<'_>]) -> Result<(), ExportError> {
    write_table(path, |table| {
        table.write_record(OBJECT_COLUMNS.iter().map(|column| column.name))?;
        for object in objects {
            let field = |column: &ObjectColumn| match column.value(object) {
                Some(ColumnValue::Text(words)) => plain(&words),
                _ => column.text(object),
            };
            table.write_record(OBJECT_COLUMNS.iter().map(field))?;
        }
        Ok(())
    })
}

/// Writes boxes in pixels of the picture; `file` is the name of the picture, `names` are the names
/// of the classes.
pub(crate) fn picture_boxes_csv(
    path: &Path,
    file: &str,
    names: &[String],
    boxes: &[Scored],
) -> Result<(), ExportError> {
    write_table(path, |out| {
        out.write_record(PICTURE_HEADER)?;
        for (index, found) in boxes.iter().enumerate() {
            let edges = [found.rect.x0, found.rect.x1, found.rect.y0, found.rect.y1];
            let class = names.get(found.class).map_or("", String::as_str);
            let mut fields = vec![(index + 1).to_string(), file.to_owned(), class.to_owned()];
            fields.extend([format!("{:.4}", found.score), "proposed".to_owned()]);
            fields.extend(edges.map(|edge| format!("{edge:.2}")));
            out.write_record(fields)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests;
