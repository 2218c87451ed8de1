//! Defines the error of this crate: a sentence.

use bathyscope_bottom::bathymetry::isobaths::NoIsobaths;
use bathyscope_bottom::presentation::page::TemplateFault;
use bathyscope_log::formats::OpenError;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::CrsError;
use bathyscope_log::support::progress::Cancelled;
use bathyscope_objects::DetectError;
use std::io;

/// Reason why work failed or was cancelled, in a sentence that names the problem, the place and the
/// remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Error(String);

impl From<String> for Error {
    fn from(sentence: String) -> Self {
        Self(sentence)
    }
}

impl<Fault: std::error::Error + 'static> From<FileError<Fault>> for Error {
    fn from(error: FileError<Fault>) -> Self {
        Self(error.to_string())
    }
}

/// Takes the sentences of other errors.
macro_rules! from_sentences {
    ($($error:ty),+) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self(error.to_string())
            }
        }
    )+};
}

from_sentences!(&str, Cancelled, CrsError, DetectError, NoIsobaths, OpenError);
from_sentences!(TemplateFault, io::Error, serde_json::Error);
