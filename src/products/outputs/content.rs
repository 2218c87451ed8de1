//! Describes the content of a file of a run, as in the manifest, and the inputs without which a
//! file cannot be made.

use crate::Error;
use crate::export::Summary;
use bathyscope_log::support::geo::{Crs, LonLat};

/// Coordinate system of a file.
#[derive(Clone, Debug)]
pub(super) enum Coordinates {
    /// A coordinate reference system.
    System(Crs),
    /// Longitude and latitude on WGS84.
    Degrees,
    /// Metres east and north of the survey's origin, in the local coordinate frame by the setting
    /// `projection`.
    Local(LonLat),
    /// No coordinates: the file is a table of other values.
    None,
}

/// Content of a file.
#[derive(Clone, Debug)]
pub(super) struct FileContent {
    /// Coordinate system of the file.
    pub coordinates: Coordinates,
    /// Count, extent and range of values of the file.
    pub summary: Summary,
    /// Text added to the description in the manifest, beginning with a comma.
    pub detail: &'static str,
}

/// Result of writing a file.
pub(super) type FileResult = Result<FileContent, Error>;

impl FileContent {
    fn new(coordinates: Coordinates, summary: Summary) -> Self {
        Self { coordinates, summary, detail: "" }
    }

    /// Creates a content in degrees.
    pub(super) fn in_degrees(summary: Summary) -> Self {
        Self::new(Coordinates::Degrees, summary)
    }

    /// Creates a content in a coordinate reference system.
    pub(super) fn in_system(crs: &Crs, summary: Summary) -> Self {
        Self::new(Coordinates::System(crs.clone()), summary)
    }

    /// Creates a content in metres east and north of the survey's origin.
    pub(super) fn in_metres(origin: LonLat, summary: Summary) -> Self {
        Self::new(Coordinates::Local(origin), summary)
    }

    /// Creates a content without coordinates.
    pub(super) fn of_table(summary: Summary) -> Self {
        Self::new(Coordinates::None, summary)
    }

    /// Creates the content of a number of things without coordinates.
    pub(super) fn count(count: usize) -> Self {
        Self::of_table(Summary { count, ..Summary::default() })
    }
}

/// Input without which a file cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A point that the outlier filter keeps.
    KeptPoints,
    /// The setting `points.las`.
    PlainLas,
    /// A track: a boat that moves, with positions.
    Track,
    /// Ground that the side-scan insonified.
    Footprint,
    /// Depths that span a surface.
    Surface,
    /// Depths from echo levels, from which the brightness of the bottom follows.
    Hardness,
    /// Levels of isobaths, not too many.
    Levels,
    /// A line of equal depth.
    Isobaths,
    /// The area that isobaths end at, if the settings name one. A problem with the area is reported
    /// for the files of isobaths.
    Area,
    /// Side-scan points near soundings, or a track that crosses itself or another.
    Agreement,
    /// Side-scan.
    SideScan,
    /// Side-scan with a place, in a map that is not too large to draw.
    Mosaic,
    /// A box that an analyst accepted or added.
    Targets,
    /// A reference that the depths are compared with.
    Reference,
}

/// Reason why a file cannot be made, in a sentence; `None` where it is not reported.
pub(super) struct Missing(pub Option<String>);
