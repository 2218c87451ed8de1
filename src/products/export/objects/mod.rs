//! Writes objects and their boxes, of one log or of several, for other programs: tables, and files
//! for maps and plotters.
//!
//! In: boxes with their places and decisions, and the objects that they show. Out: tables and files
//! for maps.

mod maps;
mod shapes_ply;
mod tables;

pub(crate) use maps::{object_layers, objects_geojson, objects_gpkg, objects_gpx, objects_kml};
pub(crate) use shapes_ply::shapes_ply;
pub(crate) use tables::{box_table, object_table, picture_boxes_csv};

use crate::export::Summary;
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::ListedObject;

/// A log whose boxes are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectLog<'a> {
    /// Name of the log in its survey.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
}

/// Returns the number and the extent of the places of objects.
pub(crate) fn object_places(objects: &[ListedObject<'_>]) -> Summary {
    let mut summary = Summary::default();
    for ListedObject { object, .. } in objects {
        summary.add([object.position.lon_deg, object.position.lat_deg], f64::NAN);
    }
    summary
}

#[cfg(test)]
mod tests;
