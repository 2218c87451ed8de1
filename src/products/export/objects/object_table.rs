//! `objects.csv`: a row for each object.

use super::plain;
use crate::export::{ExportError, write_atomically};
use bathyscope_objects::objects::{ColumnValue, ListedObject, OBJECT_COLUMNS, ObjectColumn};
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Writes objects as a table of all columns. A field is empty where there is no value; words that a
/// spreadsheet would take for a formula begin with an apostrophe.
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
