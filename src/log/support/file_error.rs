//! Error of a file: the fault and the path.

use std::error::Error;
use std::path::Path;

/// Error of a file that cannot be used; its text is one sentence that ends with the path.
#[derive(Debug, thiserror::Error)]
#[error("{what}: {}", path.display())]
pub struct FileError<Fault: Error + 'static = FaultText> {
    /// Fault, with its line or byte in the file where known.
    #[source]
    pub what: Fault,
    /// Path of the file.
    pub path: Box<Path>,
}

impl<Fault: Error> FileError<Fault> {
    /// Returns the error of a file.
    pub fn new(what: Fault, path: &Path) -> Self {
        let path = path.into();
        Self { what, path }
    }

    /// Returns a function that turns a fault into the error of the file at `path`, for `map_err`.
    pub fn at(path: &Path) -> impl Fn(Fault) -> Self + Copy {
        |what| Self::new(what, path)
    }
}

/// Fault of a file as a sentence without the path, where the program does not tell faults apart.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct FaultText(String);

impl From<String> for FaultText {
    fn from(sentence: String) -> Self {
        Self(sentence)
    }
}

impl From<&str> for FaultText {
    fn from(sentence: &str) -> Self {
        Self(sentence.to_owned())
    }
}
