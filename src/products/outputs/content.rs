//! Content of a file of a run, as the manifest describes it.

use super::error::OutputError;
use crate::export::Summary;
use bathyscope_log::support::geo::{Crs, LonLat};

/// Coordinate system of a file.
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

/// Content of a file.
#[derive(Clone, Debug)]
pub(super) struct FileContent {
    /// Coordinate system of the file.
    pub coordinates: Coordinates,
    /// Count, extent and range of values.
    pub summary: Summary,
    /// Addition to the description in the manifest, with the comma before it.
    pub detail: &'static str,
}

/// Result of a writer of a file.
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

    /// Content that is a number of things, without coordinates.
    pub(super) fn count(count: usize) -> Self {
        Self::of_table(Summary { count, ..Summary::default() })
    }
}
