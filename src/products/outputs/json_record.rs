//! Records for scripts, as JSON.

use super::error::OutputError;
use crate::products::export;
use serde::Serialize;
use std::io::Write as _;
use std::path::Path;

/// Writes a record, indented, with a line's end.
///
/// # Errors
/// A sentence that names the file.
pub(super) fn write_json(path: &Path, record: &impl Serialize) -> Result<(), OutputError> {
    export::write_atomically(path, |mut file| {
        let text = serde_json::to_vec_pretty(record)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(OutputError::from)
}
