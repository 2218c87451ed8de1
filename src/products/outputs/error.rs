//! Defines the errors of writing files.

use super::ground::NoMosaic;
use crate::export::{ChipError, ExportError, NoFolder, RasterError};
use crate::pipeline::{AgreementError, InputError};
use bathyscope_bottom::bathymetry::isobaths::NoIsobaths;
use bathyscope_bottom::presentation::page::TemplateFault;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::CrsError;
use bathyscope_log::support::mapped_file::FileFault;
use bathyscope_log::support::progress::Cancelled;
use bathyscope_objects::DetectError;

/// Reason why there are no isobaths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoContours {
    /// The depths span no surface.
    #[error("there is no depth map")]
    NoDepthMap,
    /// The isobaths cannot be drawn with the settings.
    #[error(transparent)]
    Isobaths(#[from] NoIsobaths),
}

/// Error of writing files. The folder is then unchanged.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A file of text, points or shapes cannot be written.
    #[error(transparent)]
    File(#[from] ExportError),
    /// A folder cannot be made.
    #[error(transparent)]
    Folder(#[from] FileError<NoFolder>),
    /// A file of a log was cut or has changed meanwhile.
    #[error(transparent)]
    Log(#[from] FileError<FileFault>),
    /// A GeoTIFF cannot be written.
    #[error(transparent)]
    Raster(RasterError),
    /// A picture of a box cannot be written.
    #[error(transparent)]
    Picture(ChipError),
    /// The search for objects failed.
    #[error(transparent)]
    Search(DetectError),
    /// The coordinate system of the setting `crs` cannot be used.
    #[error(transparent)]
    System(#[from] CrsError),
    /// The comparison with a reference failed.
    #[error(transparent)]
    Reference(AgreementError),
    /// A file that the survey was made from cannot be read.
    #[error(transparent)]
    Input(InputError),
    /// There is no mosaic.
    #[error(transparent)]
    Mosaic(#[from] NoMosaic),
    /// There are no isobaths.
    #[error(transparent)]
    Contours(#[from] NoContours),
    /// The page cannot be made.
    #[error(transparent)]
    Page(#[from] TemplateFault),
    /// Any other refusal, in a sentence that names the file or the setting.
    #[error("{0}")]
    Refused(String),
}

/// Converts errors so that a cancellation is always [`OutputError::Cancelled`].
macro_rules! from_cancellable {
    ($($error:ident => $variant:ident,)*) => {$(
        impl From<$error> for OutputError {
            fn from(error: $error) -> Self {
                match error {
                    $error::Cancelled(cancelled) => Self::Cancelled(cancelled),
                    other => Self::$variant(other),
                }
            }
        }
    )*};
}

from_cancellable! {
    RasterError => Raster,
    ChipError => Picture,
    DetectError => Search,
    AgreementError => Reference,
    InputError => Input,
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
