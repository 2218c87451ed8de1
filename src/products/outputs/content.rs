//! Content of a file of a run, as the manifest describes it, and what it cannot be made without.

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

/// Input without which a file cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A point that the outlier filter keeps.
    KeptPoints,
    /// `points.las`.
    PlainLas,
    /// A boat that moves, with positions.
    Track,
    /// Ground that the side-scan covers.
    Footprint,
    /// Depths that span a surface.
    Surface,
    /// Depths from echo levels, which tell how bright the bed is.
    Hardness,
    /// Levels for isobaths that are not too many.
    Levels,
    /// A line of equal depth.
    Isobaths,
    /// The area that isobaths end at, where one is named: their own files say what is wrong with
    /// it.
    Area,
    /// Side-scan points over soundings, or a track that crosses itself.
    Agreement,
    /// Side-scan.
    SideScan,
    /// Side-scan with a place, in a map of a size that can be drawn.
    Mosaic,
    /// A box that an analyst accepted or added.
    Targets,
    /// A reference that the depths are compared with.
    Reference,
}

/// Reason why a file cannot be made, in a sentence; `None` where nobody needs to know it.
pub(super) struct Missing(pub Option<String>);
