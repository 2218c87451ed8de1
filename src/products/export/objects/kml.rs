//! `objects.kml` (KML 2.2): a placemark for each object.

use super::describe::{description, titles};
use crate::export::{ExportError, Summary, write_bytes};
use bathyscope_log::support::printable::xml;
use bathyscope_objects::objects::SurveyObject;
use std::path::Path;

/// Writes objects as placemarks.
pub(crate) fn objects_kml(
    path: &Path,
    name: &str,
    objects: &[&SurveyObject],
) -> Result<Summary, ExportError> {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{}</name>\n",
        xml(name)
    );
    let mut summary = Summary::default();
    for (object, title) in objects.iter().zip(titles(objects)) {
        let at = object.position;
        summary.add([at.lon_deg, at.lat_deg], f64::NAN);
        // Writing to a string does not fail.
        text += &format!(
            "<Placemark><name>{}</name><description>{}</description><Point><coordinates>{:.8},{:.8}</coordinates></Point></Placemark>\n",
            xml(&title),
            xml(&description(object)),
            at.lon_deg,
            at.lat_deg,
        );
    }
    text.push_str("</Document>\n</kml>\n");
    write_bytes(path, text)?;
    Ok(summary)
}
