//! `objects.gpx` (GPX 1.1): a waypoint for each object, as plotters read it.

use super::describe::{description, elements, titles};
use super::object_places;
use crate::export::{ExportError, Summary, write_bytes};
use bathyscope_log::support::printable::xml;
use bathyscope_objects::objects::ListedObject;
use std::path::Path;

/// Writes objects as waypoints: name, remarks (`cmt`), a line of what is known (`desc`), class
/// (`type`), and the columns of the table of objects as extensions.
pub(crate) fn objects_gpx(
    path: &Path,
    objects: &[ListedObject<'_>],
) -> Result<Summary, ExportError> {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"Bathyscope\" xmlns=\"http://www.topografix.com/GPX/1/1\" xmlns:bathyscope=\"urn:bathyscope:object\">\n",
    );
    for (of, title) in objects.iter().zip(titles(objects)) {
        let object = of.object;
        let columns =
            elements(of, |name, text| format!("<bathyscope:{name}>{text}</bathyscope:{name}>"));
        let at = object.position;
        let remarks = if object.remarks.is_empty() {
            String::new()
        } else {
            format!("<cmt>{}</cmt>", xml(&object.remarks))
        };
        // Writing to a string does not fail.
        text += &format!(
            "<wpt lat=\"{:.8}\" lon=\"{:.8}\"><name>{}</name>{remarks}<desc>{}</desc><type>{}</type><extensions>{columns}</extensions></wpt>\n",
            at.lat_deg,
            at.lon_deg,
            xml(&title),
            xml(&description(object)),
            xml(&object.class),
        );
    }
    text.push_str("</gpx>\n");
    write_bytes(path, text)?;
    Ok(object_places(objects))
}
