//! No file is written over one that it is made from.

use super::run_folder::STEMS;
use crate::export::is_same_file;
use crate::pipeline::Products;
use crate::survey::Survey;
use std::path::{Path, PathBuf};

/// Refuses a folder in which a file of a run would be written over an input: `track.gpx` of another receiver, `depth.tif` that the
/// survey is compared with.
///
/// # Errors
/// A sentence that names the input.
pub fn refuse_overwrite<'a>(
    mut inputs: impl Iterator<Item = &'a Path>,
    folder: &Path,
) -> Result<(), String> {
    let at_risk = |input: &&Path| {
        let stem = input.file_stem().unwrap_or_default();
        STEMS.iter().any(|name| stem.eq_ignore_ascii_case(name))
            && (input.file_name()).is_some_and(|name| is_same_file(&folder.join(name), input))
    };
    match inputs.find(at_risk) {
        Some(input) => Err(format!(
            "a product might be written over this input; choose another folder, or rename it: {}",
            input.display()
        )),
        None => Ok(()),
    }
}

/// The files that a survey and its corrections were read from.
pub(super) fn inputs<'a>(
    survey: &'a Survey,
    products: &'a Products,
) -> impl Iterator<Item = &'a Path> {
    let gauge = products.correction.gauge().map(|gauge| &gauge.path);
    let files = survey.source.files.iter().chain(gauge);
    files.map(PathBuf::as_path)
}
