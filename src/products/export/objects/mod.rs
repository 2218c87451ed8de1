//! Writes objects and their boxes, of one log or of several, for other programs: tables, and files
//! for maps and plotters (`maps`). `detections.csv` and `targets.csv` have a row for each box,
//! `objects.csv` has one for each object. The boxes that a detector found in a picture of another
//! program have a table too. `shapes.ply` has the solids fitted to objects, as bodies for 3D
//! programs.
//!
//! In: boxes with their places and decisions, and the objects that they show. Out: tables, bodies
//! and files for maps.

mod maps;

pub(crate) use maps::{object_layers, objects_geojson, objects_gpkg, objects_gpx, objects_kml};

use crate::export::{ExportError, Summary, write_atomically, write_summed};
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
/// Number of squares of the grid along the length and across the width of a solid.
const SQUARES: usize = 40;
/// Size of the grid relative to that of the solid: the sides of the solid are in the outermost
/// squares.
const ROOM: f64 = 1.02;
/// Colour of inferred shapes, the same as in Bathyscope and different from those of all sources of
/// points: inferred shapes must not be mistaken for measured ones.
const COLOUR: [u8; 3] = [255, 122, 46];

/// A log whose boxes are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectLog<'a> {
    /// Name of the log in its survey.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
}

/// Returns the number and the extent of the places of objects.
fn object_places(objects: &[ListedObject<'_>]) -> Summary {
    let mut summary = Summary::default();
    for ListedObject { object, .. } in objects {
        summary.add([object.position.lon_deg, object.position.lat_deg], f64::NAN);
    }
    summary
}

/// Writes boxes as a table. `*_to` is the first ping or sample after the box; samples are those of
/// the middle ping. A field is empty where there is no value; a text that a spreadsheet would read
/// as a formula begins with an apostrophe. With several logs the table begins with the column
/// `log`. Shapes belong to whole objects: all boxes of an object have the same shape. Returns the
/// number of boxes and the extent of their places.
pub(crate) fn box_table(
    path: &Path,
    logs: &[ObjectLog<'_>],
    boxes: &[&ObjectBox],
    shapes: &BTreeMap<u32, FittedShape>,
) -> Result<Summary, ExportError> {
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
    })?;
    let mut summary = Summary::default();
    for target in boxes.iter().filter_map(|of| of.target.as_ref()) {
        summary.reach([target.position.lon_deg, target.position.lat_deg]);
    }
    Ok(Summary { count: boxes.len(), ..summary })
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
pub(crate) fn object_table(
    path: &Path,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
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
    })?;
    Ok(object_places(objects))
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

/// The upper surface of a solid as a grid of squares.
struct Body {
    /// Places of the corners, metres east, north and up.
    corners: Vec<[f64; 3]>,
    /// Corners of each square that the solid reaches into, counter-clockwise from above.
    squares: Vec<[u32; 4]>,
}

impl Body {
    fn new(shape: &FittedShape) -> Self {
        let posed = shape.posed;
        let solid = posed.solid;
        let heights = (0..=SQUARES).flat_map(|row| (0..=SQUARES).map(move |column| (row, column)));
        let heights: Vec<([f64; 2], f64)> = heights
            .map(|(row, column)| {
                let share = |index: usize| ROOM * (index as f64 / SQUARES as f64 - 0.5);
                let place_m = [share(row) * solid.length_m, share(column) * solid.width_m];
                (place_m, solid.height_at_m(place_m[0], place_m[1]))
            })
            .collect();
        let mut index_of = vec![None; heights.len()];
        let mut body = Self { corners: Vec::new(), squares: Vec::new() };
        for row in 0..SQUARES {
            for column in 0..SQUARES {
                let first = row * (SQUARES + 1) + column;
                // Along is ahead, across is to starboard; the corners are reversed below to be
                // counter-clockwise.
                let square = [first, first + SQUARES + 1, first + SQUARES + 2, first + 1];
                if square.iter().all(|corner| heights[*corner].1 == 0.0) {
                    continue;
                }
                let mut corners = [0; 4];
                for (corner, into) in square.into_iter().zip(corners.iter_mut().rev()) {
                    let index = index_of[corner].get_or_insert_with(|| {
                        let (place_m, height_m) = heights[corner];
                        let [east_m, north_m] = posed.place_m(place_m);
                        body.corners.push([east_m, north_m, shape.bottom_z_m + height_m]);
                        body.corners.len() as u32 - 1
                    });
                    *into = *index;
                }
                body.squares.push(corners);
            }
        }
        body
    }
}

/// Writes the shapes of objects as binary little-endian PLY, a body for each object: x east, y
/// north, z up, metres from the survey's origin in the local coordinate frame, as doubles; red,
/// green, blue as bytes; the object's number as `object`. Comments name the kind and the size of
/// each solid.
pub(crate) fn shapes_ply(
    path: &Path,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
    let shapes: BTreeMap<u32, &FittedShape> =
        (objects.iter()).filter_map(|of| Some((of.object.number, of.shape?))).collect();
    let bodies: Vec<(u32, Body)> =
        (shapes.iter()).map(|(number, shape)| (*number, Body::new(shape))).collect();
    write_summed(path, |out, summary| {
        out.write_all(
            b"ply\nformat binary_little_endian 1.0\ncomment metres east, north and up of the survey's origin\n\
              comment source inferred: solids fitted to echo and shadow, not measured\n",
        )?;
        for (number, shape) in &shapes {
            let solid = shape.posed.solid;
            writeln!(
                out,
                "comment object {number}: {}, {:.2} x {:.2} x {:.2} m",
                solid.kind.name(),
                solid.length_m,
                solid.width_m,
                solid.height_m
            )?;
        }
        let corners = bodies.iter().map(|(_, body)| body.corners.len());
        let squares = bodies.iter().map(|(_, body)| body.squares.len());
        write!(
            out,
            "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int object\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            corners.sum::<usize>(),
            squares.sum::<usize>()
        )?;
        for (number, body) in &bodies {
            for [east_m, north_m, z_m] in &body.corners {
                summary.add([*east_m, *north_m], *z_m);
                for value in [east_m, north_m, z_m] {
                    out.write_all(&value.to_le_bytes())?;
                }
                out.write_all(&COLOUR)?;
                out.write_all(&i32::try_from(*number).unwrap_or(i32::MAX).to_le_bytes())?;
            }
        }
        let mut first = 0;
        for (_, body) in &bodies {
            for square in &body.squares {
                out.write_all(&[4])?;
                for corner in square {
                    out.write_all(&(first + corner).to_le_bytes())?;
                }
            }
            first += body.corners.len() as u32;
        }
        summary.count = shapes.len();
        Ok(())
    })
}

#[cfg(test)]
mod tests;
