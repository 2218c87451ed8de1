//! Why files could not be written.

use super::mosaic_grid::NoMosaic;
use crate::bottom::bathymetry::isobaths::NoIsobaths;
use crate::detection::DetectError;
use crate::pipeline::{AgreementError, InputError};
use crate::products::export::{ChipError, ExportError, RasterError};
use crate::support::geo::CrsError;
use crate::support::progress::Cancelled;

/// Why there are no isobaths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoContours {
    /// The depths span no surface.
    #[error("there is no depth map")]
    NoDepthMap,
    /// They cannot be drawn as the settings say.
    #[error(transparent)]
    Isobaths(#[from] NoIsobaths),
}

/// Why files could not be written. The folder is then as it was.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A file of text, points or shapes.
    #[error(transparent)]
    File(#[from] ExportError),
    /// A GeoTIFF.
    #[error(transparent)]
    Raster(RasterError),
    /// A picture of a box.
    #[error(transparent)]
    Picture(ChipError),
    /// The search for objects.
    #[error(transparent)]
    Search(DetectError),
    /// The system that `crs` names.
    #[error(transparent)]
    System(#[from] CrsError),
    /// The comparison with a reference.
    #[error(transparent)]
    Reference(AgreementError),
    /// A file that the survey was made from.
    #[error(transparent)]
    Input(InputError),
    /// There is no mosaic.
    #[error(transparent)]
    Mosaic(#[from] NoMosaic),
    /// There are no isobaths.
    #[error(transparent)]
    Contours(#[from] NoContours),
    /// What cannot be done, in a sentence that names the file or the setting.
    #[error("{0}")]
    Refused(String),
}

impl From<RasterError> for OutputError {
    fn from(error: RasterError) -> Self {
        match error {
            RasterError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Raster(other),
        }
    }
}

impl From<ChipError> for OutputError {
    fn from(error: ChipError) -> Self {
        match error {
            ChipError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Picture(other),
        }
    }
}

impl From<DetectError> for OutputError {
    fn from(error: DetectError) -> Self {
        match error {
            DetectError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Search(other),
        }
    }
}

impl From<AgreementError> for OutputError {
    fn from(error: AgreementError) -> Self {
        match error {
            AgreementError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Reference(other),
        }
    }
}

impl From<InputError> for OutputError {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Input(other),
        }
    }
}

impl From<String> for OutputError {
    fn from(sentence: String) -> Self {
        Self::Refused(sentence)
    }
}

impl From<&str> for OutputError {
    fn from(sentence: &str) -> Self {
        Self::Refused(sentence.to_owned())
    }
}

impl From<serde_json::Error> for OutputError {
    fn from(error: serde_json::Error) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<std::io::Error> for OutputError {
    fn from(error: std::io::Error) -> Self {
        Self::Refused(error.to_string())
    }
}
