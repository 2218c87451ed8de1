//! `objects.gpx` (GPX 1.1): a waypoint for each object, as plotters read it.

use super::describe::{description, titles};
use crate::export::{ExportError, Summary, write_bytes};
use bathyscope_log::support::printable::xml;
use bathyscope_objects::objects::SurveyObject;
use std::path::Path;

/// Writes objects as waypoints: name, remarks (`cmt`), all that is known (`desc`) and class
/// (`type`).
pub(crate) fn objects_gpx(path: &Path, objects: &[&SurveyObject]) -> Result<Summary, ExportError> {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"Bathyscope\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n",
    );
    let mut summary = Summary::default();
    for (object, title) in objects.iter().zip(titles(objects)) {
        let at = object.position;
        summary.add([at.lon_deg, at.lat_deg], f64::NAN);
        let remarks = match object.summary.notes.is_empty() {
            true => String::new(),
            false => format!("<cmt>{}</cmt>", xml(&object.summary.notes)),
        };
        // Writing to a string does not fail.
        text += &format!(
            "<wpt lat=\"{:.8}\" lon=\"{:.8}\"><name>{}</name>{remarks}<desc>{}</desc><type>{}</type></wpt>\n",
            at.lat_deg,
            at.lon_deg,
            xml(&title),
            xml(&description(object)),
            xml(&object.joint.class),
        );
    }
    text.push_str("</gpx>\n");
    write_bytes(path, text)?;
    Ok(summary)
}
