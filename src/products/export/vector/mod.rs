//! Lines and areas for map programs: shapefiles, and KML in its zipped form.
//!
//! In: lines and areas. Out: shapefiles and KMZ.

mod kmz;
mod shapefile;
mod zipped;

pub(crate) use kmz::{areas_kmz, lines_kmz};
pub(crate) use shapefile::lines_shapefile;

use bathyscope_log::support::geo::LonLat;

/// A line with what a map says about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LabelledLine {
    /// Its corners.
    pub points: Vec<LonLat>,
    /// Text beside the line.
    pub label: String,
    /// Numbers, in the order of the names that the file is written with.
    pub numbers: Vec<f64>,
    /// Colour, red to blue.
    pub colour: [u8; 3],
}
