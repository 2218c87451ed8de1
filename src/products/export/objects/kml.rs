//! `objects.kml` (KML 2.2): a placemark for each object.

use super::ObjectPoint;
use super::object_point::titles;
use crate::products::export::{ExportError, Summary, write_aside};
use crate::support::printable::xml;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes objects as placemarks.
///
/// # Errors
/// When the file cannot be written.
pub fn objects_kml(
    path: &Path,
    name: &str,
    points: &[ObjectPoint],
) -> Result<Summary, ExportError> {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{}</name>\n",
        xml(name)
    );
    let mut summary = Summary::default();
    for (point, title) in points.iter().zip(titles(points)) {
        let at = point.position;
        summary.add([at.lon_deg, at.lat_deg], f64::NAN);
        // Writing to a string does not fail.
        writeln!(
            text,
            "<Placemark><name>{}</name><description>{}</description><Point><coordinates>{:.8},{:.8}</coordinates></Point></Placemark>",
            xml(&title),
            xml(&point.description()),
            at.lon_deg,
            at.lat_deg,
        )
        .ok();
    }
    text.push_str("</Document>\n</kml>\n");
    write_aside(path, |mut file| file.write_all(text.as_bytes()))?;
    Ok(summary)
}
