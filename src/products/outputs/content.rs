//! What a file of a run holds, as the manifest says it.

use crate::products::export::Summary;
use crate::support::geo::{Crs, LonLat};

/// What the coordinates of a file are.
#[derive(Clone, Debug)]
pub(super) enum Coordinates {
    /// A coordinate reference system.
    System(Crs),
    /// Longitude and latitude on WGS84.
    Degrees,
    /// Metres east and north of the survey's origin, in the plane that `projection` names.
    Local(LonLat),
    /// None: the file is a table of something else.
    None,
}

/// What a file holds.
#[derive(Clone, Debug)]
pub(super) struct FileContent {
    /// What its coordinates are.
    pub coordinates: Coordinates,
    /// How much it holds.
    pub summary: Summary,
    /// What is to be said of it besides, with the comma before it.
    pub detail: &'static str,
}

impl FileContent {
    /// Content in some coordinates.
    pub(super) fn new(coordinates: Coordinates, summary: Summary) -> Self {
        Self {
            coordinates,
            summary,
            detail: "",
        }
    }
}
