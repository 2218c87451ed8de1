//! What a file of a run holds, as the manifest says it.

use super::error::OutputError;
use crate::export::Summary;
use bathyscope_log::support::geo::{Crs, LonLat};

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

/// What a writer of a file returns.
pub(super) type FileResult = Result<FileContent, OutputError>;

impl FileContent {
    fn new(coordinates: Coordinates, summary: Summary) -> Self {
        Self { coordinates, summary, detail: "" }
    }

    /// Content in degrees.
    pub(super) fn in_degrees(summary: Summary) -> Self {
        Self::new(Coordinates::Degrees, summary)
    }

    /// Content in a coordinate reference system.
    pub(super) fn in_system(crs: &Crs, summary: Summary) -> Self {
        Self::new(Coordinates::System(crs.clone()), summary)
    }

    /// Content in metres east and north of the survey's origin.
    pub(super) fn in_metres(origin: LonLat, summary: Summary) -> Self {
        Self::new(Coordinates::Local(origin), summary)
    }

    /// Content without coordinates.
    pub(super) fn of_table(summary: Summary) -> Self {
        Self::new(Coordinates::None, summary)
    }

    /// So many of something, without coordinates.
    pub(super) fn count(count: usize) -> Self {
        Self::of_table(Summary { count, ..Summary::default() })
    }
}
