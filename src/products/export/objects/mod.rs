//! Objects and their boxes, of one log or of several, for other programs: tables, and what maps and
//! plotters read.
//!
//! In: boxes with their places and decisions, and the objects that they show. Out: tables and files
//! for maps.

mod box_table;
mod describe;
mod geojson;
mod geopackage;
mod gpx;
mod kml;
mod object_table;
mod shapes_ply;

pub(crate) use box_table::box_table;
pub(crate) use geojson::objects_geojson;
pub(crate) use geopackage::{object_layers, objects_gpkg};
pub(crate) use gpx::objects_gpx;
pub(crate) use kml::objects_kml;
pub(crate) use object_table::object_table;
pub(crate) use shapes_ply::shapes_ply;

use crate::export::Summary;
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::ListedObject;

/// A log that boxes are of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectLog<'a> {
    /// Name in its survey.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
}

/// Text that no spreadsheet takes for a formula.
fn plain(text: &str) -> String {
    if text.starts_with(['=', '+', '-', '@']) { format!("'{text}") } else { text.to_owned() }
}

/// The places of objects, counted.
pub(crate) fn object_places(objects: &[ListedObject<'_>]) -> Summary {
    let mut summary = Summary::default();
    for ListedObject { object, .. } in objects {
        summary.add([object.position.lon_deg, object.position.lat_deg], f64::NAN);
    }
    summary
}

#[cfg(test)]
mod tests;
