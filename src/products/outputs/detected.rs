//! A search for objects by itself, into a folder that may hold the files of a run.

use super::detections::Proposed;
use super::error::OutputError;
use super::order::{Order, When, check_logs};
use super::registry::{row_of, row_of_beside};
use super::results::Results;
use super::run_folder::{Replaced, RunFolder};
use super::write::write_rows;
use crate::export;
use crate::pipeline::{Derived, ProcessedLog};
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_objects::{DetectorSettings, Model, Picture, Scored, find_in_picture};

/// Searches a survey and writes what is found, in the place of what an earlier search wrote there;
/// gives back what became of that, too.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled; the folder is then as it
/// was.
pub fn write_detected(
    log: &ProcessedLog,
    model: &Model,
    run: RunFolder,
    progress: &Progress,
) -> Result<(Proposed, Replaced), OutputError> {
    let order = Order {
        logs: std::slice::from_ref(log),
        derived: &Derived::default(),
        requested: &[],
        reference: None,
        search: Some(model),
        review: &SurveyReview::default(),
        corrections: &[],
    };
    let results = Results::new(&order, progress)?;
    write_rows(&results, &run.path(), is_asked, &mut |_| ())?;
    let found = Proposed::of(&results)?;
    let found = found.ok_or("nothing searched for objects")?;
    check_logs(order.logs)?;
    Ok((found, run.commit_group(is_of_search)?))
}

/// Does the same for a picture of another program, by its name in the table.
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
) -> Result<(Vec<Scored>, Replaced), OutputError> {
    let found = find_in_picture(picture, model, settings, progress)?;
    let folder = run.path().join("objects");
    // The chips come first, and make the folder.
    export::picture_chips(&folder, picture, model.names(), &found).and_then(|_| {
        let table = folder.join("detections.csv");
        export::picture_boxes_csv(&table, name, model.names(), &found)
    })?;
    Ok((found, run.commit_group(is_of_search)?))
}

/// Returns true if a file is of a search, in whatever version's layout.
fn is_of_search(name: &str) -> bool {
    let row = row_of(name).or_else(|| row_of_beside(name));
    row.is_some_and(|row| is_asked(row.when))
}

/// Returns true for files that a search alone writes.
fn is_asked(when: When) -> bool {
    matches!(when, When::Searched | When::Listed)
}
