//! `objects.kml` (KML 2.2): a placemark for each object.

use super::describe::{description, elements, titles};
use super::object_places;
use crate::export::{ExportError, Summary, write_bytes};
use bathyscope_log::support::printable::xml;
use bathyscope_objects::objects::ListedObject;
use std::path::Path;

/// Writes objects as placemarks, with the columns of the table of objects as extended data.
pub(crate) fn objects_kml(
    path: &Path,
    name: &str,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{}</name>\n",
        xml(name)
    );
    for (of, title) in objects.iter().zip(titles(objects)) {
        let object = of.object;
        let columns = elements(of, |name, text| {
            format!("<Data name=\"{name}\"><value>{text}</value></Data>")
        });
        let at = object.position;
        // Writing to a string does not fail.
        text += &format!(
            "<Placemark><name>{}</name><description>{}</description><ExtendedData>{columns}</ExtendedData><Point><coordinates>{:.8},{:.8}</coordinates></Point></Placemark>\n",
            xml(&title),
            xml(&description(object)),
            at.lon_deg,
            at.lat_deg,
        );
    }
    text.push_str("</Document>\n</kml>\n");
    write_bytes(path, text)?;
    Ok(object_places(objects))
}
