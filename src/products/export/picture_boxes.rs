//! Writes the boxes that a detector found in a picture of another program, one line for each box.

use super::{ExportError, write_atomically};
use bathyscope_objects::Scored;
use std::io::{BufWriter, Write as _};
use std::path::Path;

const HEADER: [&str; 9] =
    ["id", "file", "class", "score", "state", "x_from", "x_to", "y_from", "y_to"];

/// Writes the boxes, in the picture's pixels; `file` is the picture's name, `names` are the class
/// names.
pub(crate) fn picture_boxes_csv(
    path: &Path,
    file: &str,
    names: &[String],
    boxes: &[Scored],
) -> Result<(), ExportError> {
    write_atomically(path, |out| {
        let mut out = csv::Writer::from_writer(BufWriter::new(out));
        out.write_record(HEADER)?;
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
