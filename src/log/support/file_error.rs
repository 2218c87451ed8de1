//! Error of a file: the fault and the path.

use std::error::Error;
use std::path::Path;

/// A file that cannot be used: one sentence, the path last.
#[derive(Debug, thiserror::Error)]
#[error("{what}: {}", path.display())]
pub struct FileError<Fault: Error + 'static> {
    /// Fault, with the line or the byte where it is known.
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

    /// Names the file in which something is wrong.
    pub fn at(path: &Path) -> impl Fn(Fault) -> Self + Copy {
        |what| Self::new(what, path)
    }
}
