//! Writes tables of objects: `detections.csv` and `targets.csv` have a row for each box,
//! `objects.csv` has one for each object. The boxes that a detector found in a picture of another
//! program have a table too.

use super::ObjectLog;
use crate::export::{ExportError, write_atomically};
use bathyscope_log::survey::Survey;
use bathyscope_objects::Scored;
use bathyscope_objects::objects::{
    ColumnValue, ListedObject, OBJECT_COLUMNS, ObjectBox, ObjectColumn,
};
use bathyscope_objects::review::Certainty;
use bathyscope_objects::targets::{FittedShape, Target};
use std::collections::BTreeMap;
use std::io::{BufWriter, Write as _};
use std::path::Path;

const HEADER: [&str; 30] = [
    "id",
    "file",
    "class",
    "score",
    "state",
    "side",
    "ping_from",
    "ping_to",
    "sample_from",
    "sample_to",
    "lon",
    "lat",
    "east_m",
    "north_m",
    "length_m",
    "width_m",
    "height_m",
    "depth_m",
    "sigma_m",
    "height_sigma_m",
    "object",
    "note",
    "name",
    "confidence",
    "shape",
    "shape_length_m",
    "shape_width_m",
    "shape_height_m",
    "shape_heading_deg",
    "shape_explained",
];
const PICTURE_HEADER: [&str; 9] =
    ["id", "file", "class", "score", "state", "x_from", "x_to", "y_from", "y_to"];

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
    write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(BufWriter::new(out));
        table.write_record(column.into_iter().chain(HEADER))?;
        for of in boxes {
            let (Some(log), Some(file)) = (logs.get(of.log), files.get(of.log)) else {
                continue;
            };
            // With a single log the column is not needed.
            let name = column.map(|_| plain(log.name));
            let shape = of.object.and_then(|number| shapes.get(&number));
            let fields = record(of, shape, file, log.survey);
            table.write_record(name.into_iter().chain(fields))?;
        }
        table.flush()?;
        table.into_inner().map_err(|error| error.into_error())?.flush()
    })
}

fn record(
    of: &ObjectBox,
    shape: Option<&FittedShape>,
    file: &str,
    survey: &Survey,
) -> [String; 30] {
    let one = &of.one;
    let samples = one.mark.samples(survey);
    let target = of.target.as_ref();
    let number = |value: f64, decimals: usize| {
        if value.is_finite() { format!("{value:.decimals$}") } else { String::new() }
    };
    let of_target = |value: fn(&Target) -> f64, decimals| {
        target.map_or_else(String::new, |target| number(value(target), decimals))
    };
    let of_shape = |value: fn(&FittedShape) -> f64, decimals| {
        shape.map_or_else(String::new, |shape| number(value(shape), decimals))
    };
    [
        one.id.0.to_string(),
        plain(file),
        plain(&of.class),
        one.score.map_or_else(String::new, |score| format!("{score:.4}")),
        one.state.name().to_owned(),
        one.mark.side.name().to_owned(),
        one.mark.pings.start.to_string(),
        one.mark.pings.end.to_string(),
        samples.start.to_string(),
        samples.end.to_string(),
        of_target(|target| target.position.lon_deg, 8),
        of_target(|target| target.position.lat_deg, 8),
        of_target(|target| target.east_m, 3),
        of_target(|target| target.north_m, 3),
        of_target(|target| target.length_m, 3),
        of_target(|target| target.width_m, 3),
        of_target(|target| target.height_m, 3),
        of_target(|target| target.depth_m, 3),
        of_target(|target| target.sigma_m, 3),
        of_target(|target| target.height_sigma_m, 3),
        of.object.map_or_else(String::new, |object| object.to_string()),
        plain(&one.note),
        plain(&one.name),
        one.certainty.map_or("", Certainty::name).to_owned(),
        shape.map_or_else(String::new, |shape| shape.posed.solid.kind.name().to_owned()),
        of_shape(|shape| shape.posed.solid.length_m, 2),
        of_shape(|shape| shape.posed.solid.width_m, 2),
        of_shape(|shape| shape.posed.solid.height_m, 2),
        of_shape(|shape| shape.posed.shown_heading_rad().to_degrees(), 0),
        of_shape(|shape| shape.explained, 2),
    ]
}

/// Returns a text that no spreadsheet reads as a formula.
fn plain(text: &str) -> String {
    if text.starts_with(['=', '+', '-', '@']) { format!("'{text}") } else { text.to_owned() }
}

/// Writes objects as a table of all columns. A field is empty where there is no value; a text that
/// a spreadsheet would read as a formula begins with an apostrophe.
pub(crate) fn object_table(path: &Path, objects: &[ListedObject<'_>]) -> Result<(), ExportError> {
    write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(BufWriter::new(out));
        table.write_record(OBJECT_COLUMNS.iter().map(|column| column.name))?;
        for object in objects {
            let field = |column: &ObjectColumn| match column.value(object) {
                Some(ColumnValue::Text(words)) => plain(&words),
                _ => column.text(object),
            };
            table.write_record(OBJECT_COLUMNS.iter().map(field))?;
        }
        table.flush()?;
        table.into_inner().map_err(|error| error.into_error())?.flush()
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
    write_atomically(path, |out| {
        let mut out = csv::Writer::from_writer(BufWriter::new(out));
        out.write_record(PICTURE_HEADER)?;
        for (index, found) in boxes.iter().enumerate() {
            let edges = [found.rect.x0, found.rect.x1, found.rect.y0, found.rect.y1];
            let class = names.get(found.class).map_or("", String::as_str);
            let mut fields = vec![(index + 1).to_string(), file.to_owned(), class.to_owned()];
            fields.extend([format!("{:.4}", found.score), "proposed".to_owned()]);
            fields.extend(edges.map(|edge| format!("{edge:.2}")));
            out.write_record(fields)?;
        }
        out.flush()?;
        out.into_inner().map_err(|error| error.into_error())?.flush()
    })
}
