//! Refuses to write a file over one of the inputs of the run.

use super::MANIFEST;
use super::order::Order;
use super::registry::{OUTPUT_FILES, OutputFile};
use super::run_folder::{RunFolder, has_foreign_manifest, is_stem_of_output};
use crate::Error;
use crate::export::is_same_file;
use crate::pipeline::Reference;
use bathyscope_log::survey::Survey;
use std::path::{Path, PathBuf};

/// Returns the subfolders in which a run may write a file with this name, apart from the ending.
fn folders_of(stem: &str) -> impl Iterator<Item = &'static str> {
    let rows = OUTPUT_FILES.iter().filter(move |row| row.stem().eq_ignore_ascii_case(stem));
    rows.map(OutputFile::folder).filter(|folder| !folder.is_empty())
}

/// Refuses a folder in which a file of a run would be written over an input, such as `track.gpx` of
/// another receiver, or `depth.tif` that the survey is compared with.
///
/// # Errors
/// When an input would be written over; the sentence names the input.
pub(super) fn refuse_overwrite(order: &Order<'_>, folder: &Path) -> Result<(), Error> {
    let reference = order.reference.map(|(reference, _)| reference.path());
    let gauges = order.logs.iter().filter_map(|log| log.products.correction.gauge());
    let gauges = gauges.map(|gauge| gauge.path.as_path());
    let areas = order.logs.iter().filter_map(|log| {
        let area = log.products.settings.isobaths.area.as_deref();
        area.map(|area| area.path.as_path())
    });
    let surveys = order.logs.iter().map(|log| &*log.survey);
    let inputs = files_of(surveys).chain(gauges).chain(areas);
    refuse(inputs.chain(reference), folder)
}

fn files_of<'a>(surveys: impl IntoIterator<Item = &'a Survey>) -> impl Iterator<Item = &'a Path> {
    let files = surveys.into_iter().flat_map(|survey| &survey.source.files);
    files.map(PathBuf::as_path)
}

/// Prepares a folder for the files of a survey of one or several logs. This is done before the long
/// computation, so that it is not wasted on a folder that cannot be written into, or in which a
/// file would be written over the survey or its reference.
///
/// # Errors
/// When the folder cannot be used or an input would be written over; the sentence names the folder
/// or the input.
pub fn begin<'a>(
    folder: &Path,
    surveys: impl IntoIterator<Item = &'a Survey>,
    reference: Option<&'a Reference>,
) -> Result<RunFolder, Error> {
    let reference = reference.map(Reference::path);
    refuse(files_of(surveys).chain(reference), folder)?;
    if has_foreign_manifest(folder) {
        return Err(format!(
            "the folder holds a {MANIFEST} of something else; choose another folder: {}",
            folder.display()
        )
        .into());
    }
    RunFolder::begin(folder)
}

fn refuse<'a>(mut inputs: impl Iterator<Item = &'a Path>, folder: &Path) -> Result<(), Error> {
    let at_risk = |input: &&Path| {
        let stem = input.file_stem().unwrap_or_default().to_string_lossy();
        // The ending of `cloud.copc.laz` has two parts.
        let stem = stem.strip_suffix(".copc").unwrap_or(&stem);
        // Files without a subfolder are those of an old version, which a run removes.
        let name = input.file_name().unwrap_or_default();
        let is_name = |row: &OutputFile| row.name.eq_ignore_ascii_case(&name.to_string_lossy());
        let is_on_top = is_stem_of_output(stem) || OUTPUT_FILES.iter().any(is_name);
        let folders = folders_of(stem).chain(is_on_top.then_some(""));
        let mut there = folders.map(|of| folder.join(of).join(name));
        there.any(|there| is_same_file(&there, input))
    };
    match inputs.find(at_risk) {
        Some(input) => Err(format!(
            "a product might be written over this input; choose another folder, or rename it: {}",
            input.display()
        )
        .into()),
        None => Ok(()),
    }
}
