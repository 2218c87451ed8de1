//! `objects.kml` (KML 2.2): one placemark a box that has a place.

use super::{ObjectLog, ObjectRow, log_name};
use crate::export::{ExportError, write_aside};
use crate::printable::xml;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes boxes as placemarks, by class in folders of the map program's own sorting. Boxes without a place are left out.
///
/// # Errors
/// When the file cannot be written.
pub fn objects_kml(
    path: &Path,
    name: &str,
    logs: &[ObjectLog<'_>],
    rows: &[ObjectRow<'_>],
) -> Result<(), ExportError> {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{}</name>\n",
        xml(name)
    );
    for row in rows {
        if let Some(target) = &row.target {
            // Writing to a string does not fail.
            writeln!(
                text,
                "<Placemark><name>{}</name><description>{}</description><Point><coordinates>{:.8},{:.8}</coordinates></Point></Placemark>",
                xml(&row.title(log_name(logs, row))),
                xml(&row.description()),
                target.position.lon_deg,
                target.position.lat_deg,
            )
            .ok();
        }
    }
    text.push_str("</Document>\n</kml>\n");
    write_aside(path, |mut file| file.write_all(text.as_bytes()))
}
