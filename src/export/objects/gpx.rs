//! `objects.gpx` (GPX 1.1): one waypoint a box that has a place, as plotters read it.

use super::{ObjectLog, ObjectRow, log_name};
use crate::export::{ExportError, write_aside};
use crate::printable::xml;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes boxes as waypoints. Boxes without a place are left out.
///
/// # Errors
/// When the file cannot be written.
pub fn objects_gpx(
    path: &Path,
    logs: &[ObjectLog<'_>],
    rows: &[ObjectRow<'_>],
) -> Result<(), ExportError> {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"Bathyscope\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n",
    );
    for row in rows {
        if let Some(target) = &row.target {
            // Writing to a string does not fail.
            writeln!(
                text,
                "<wpt lat=\"{:.8}\" lon=\"{:.8}\"><name>{}</name><desc>{}</desc><type>{}</type></wpt>",
                target.position.lat_deg,
                target.position.lon_deg,
                xml(&row.title(log_name(logs, row))),
                xml(&row.description()),
                xml(row.class),
            )
            .ok();
        }
    }
    text.push_str("</gpx>\n");
    write_aside(path, |mut file| file.write_all(text.as_bytes()))
}
