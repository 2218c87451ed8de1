//! Boxes of one log or of several and their places in the world for other programs: tables, and what maps and plotters read.

mod csv_table;
mod geojson;
mod geopackage;
mod gpx;
mod kml;
mod object_point;
mod shapes_ply;

pub use csv_table::objects_csv;
pub use geojson::objects_geojson;
pub use geopackage::{object_layers, objects_gpkg};
pub use gpx::objects_gpx;
pub use kml::objects_kml;
pub use object_point::ObjectPoint;
pub use shapes_ply::shapes_ply;

use crate::detection::Mark;
use crate::detection::targets::{FittedShape, Target};
use crate::support::geo::LonLat;
use crate::survey::Survey;
use std::sync::Arc;

/// A log that boxes are of.
#[derive(Clone, Copy, Debug)]
pub struct ObjectLog<'a> {
    /// What it is called in its survey.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
}

/// What the log of a row is called; `None` where all boxes are of one log, so that nobody asks.
fn log_name<'a>(logs: &[ObjectLog<'a>], row: &ObjectRow<'_>) -> Option<&'a str> {
    let log = logs.get(row.log).filter(|_| logs.len() > 1);
    log.map(|log| log.name)
}

/// A box to write.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectRow<'a> {
    /// Which of the logs it is of.
    pub log: usize,
    /// Its number, within its log where somebody reviews them.
    pub id: u32,
    /// Name of its class.
    pub class: &'a str,
    /// Confidence, 0 to 1; `None` for a box drawn by hand.
    pub score: Option<f32>,
    /// `proposed`, `accepted`, `rejected` or `added`.
    pub state: &'a str,
    /// Where in the survey.
    pub mark: &'a Mark,
    /// Where in the world; `None` where that cannot be known.
    pub target: Option<Target>,
    /// Corners of its outline on the ground: length along the track by width across it; `None` where the size is not known.
    pub outline: Option<[LonLat; 4]>,
    /// Number of the object that it is a sighting of; `None` where it is none.
    pub object: Option<usize>,
    /// The shape of that object, where one fits.
    pub shape: Option<Arc<FittedShape>>,
    /// The analyst's remark.
    pub note: &'a str,
    /// What the analyst calls it; empty where it has no name.
    pub name: &'a str,
    /// How sure the analyst is: `unsure`, `probable` or `certain`; empty where nobody has said.
    pub confidence: &'a str,
}

#[cfg(test)]
mod tests;
