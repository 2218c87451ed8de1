//! Boxes of one log or of several and their places in the world for other programs: tables, and
//! what maps and plotters read.
//!
//! In: boxes with their places and decisions. Out: tables and files for maps.

mod csv_table;
mod describe;
mod geojson;
mod geopackage;
mod gpx;
mod kml;
mod shapes_ply;

pub(crate) use csv_table::objects_csv;
pub(crate) use geojson::objects_geojson;
pub(crate) use geopackage::{object_layers, objects_gpkg};
pub(crate) use gpx::objects_gpx;
pub(crate) use kml::objects_kml;
pub(crate) use shapes_ply::shapes_ply;

use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::ObjectBox;
use bathyscope_objects::review::Confidence;
use bathyscope_objects::targets::FittedShape;

/// A log that boxes are of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectLog<'a> {
    /// What it is called in its survey.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
}

/// What the log of a row is called; `None` where all boxes are of one log, so that nobody asks.
fn log_name<'a>(logs: &[ObjectLog<'a>], row: &ObjectRow<'_>) -> Option<&'a str> {
    let log = logs.get(row.of.log).filter(|_| logs.len() > 1);
    log.map(|log| log.name)
}

/// A box to write.
#[derive(Clone, Debug)]
pub(crate) struct ObjectRow<'a> {
    /// The box in the list of objects.
    pub of: &'a ObjectBox,
    /// Corners of its outline on the ground: length along the track by width across it; `None`
    /// where the size is not known.
    pub outline: Option<[LonLat; 4]>,
    /// The shape of the object that it shows, where one fits.
    pub shape: Option<&'a FittedShape>,
}

impl ObjectRow<'_> {
    /// The surest word of the analyst about the box: `unsure`, `probable` or `certain`; empty where
    /// nobody has said.
    fn confidence(&self) -> &'static str {
        self.of.one.confidence.map_or("", Confidence::name)
    }
}

#[cfg(test)]
mod tests;
