//! What a search alone writes: `detections.*` and `chips`, into a folder that may hold the files of a run.

use super::detections::{Proposed, write_detections};
use super::run_folder::RunFolder;
use crate::detection::{DetectorSettings, Model, Picture, Scored, find_in_picture};
use crate::export;
use crate::pipeline::Products;
use crate::progress::Progress;
use crate::survey::Survey;

/// Searches a survey and writes what is found.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled; the folder is then as it was.
pub fn write_detected(
    survey: &Survey,
    products: &Products,
    model: &Model,
    run: RunFolder,
    progress: &Progress,
) -> Result<Proposed, String> {
    let settings = &products.settings.detector;
    let found = write_detections(survey, products, model, settings, &run.path(), progress)?;
    run.commit_group(is_of_search)?;
    Ok(found)
}

/// The same for a picture of another program, by its name in the table.
///
/// # Errors
/// As [`write_detected`].
pub fn write_detected_in_picture(
    name: &str,
    picture: &Picture,
    model: &Model,
    settings: &DetectorSettings,
    run: RunFolder,
    progress: &Progress,
) -> Result<Vec<Scored>, String> {
    let found =
        find_in_picture(picture, model, settings, progress).map_err(|error| error.to_string())?;
    let folder = run.path();
    export::picture_chips(&folder, picture, model.names(), &found)
        .and_then(|_| {
            let table = folder.join("detections.csv");
            export::picture_boxes_csv(&table, name, model.names(), &found)
        })
        .map_err(|error| error.to_string())?;
    run.commit_group(is_of_search)?;
    Ok(found)
}

fn is_of_search(name: &str) -> bool {
    name.starts_with("detections.") || name.starts_with("chips/")
}
