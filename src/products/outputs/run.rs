//! A run while its files are written.

use super::content::FileContent;
use super::order::When;
use super::registry::{FileWriter, OUTPUT_FILES, OutputFile};
use super::results::Results;
use super::run_folder::RunFolder;
use crate::pipeline::{Fingerprint, Report};

/// A run whose files are being written.
pub(super) struct OutputRun<'a> {
    pub results: Results<'a>,
    pub report: Report,
    /// Files that have been made of the results so far.
    pub made: Vec<(&'static OutputFile, FileContent)>,
    /// Fingerprints of the files that were made of the results.
    pub hashed: Vec<Fingerprint>,
    pub folder: &'a RunFolder,
}

impl OutputRun<'_> {
    /// Returns the files that are in the folder at the end besides the page, as the page lists
    /// them: folders last.
    pub(super) fn listed(&self) -> impl Iterator<Item = &'static OutputFile> {
        let of_run = |row: &&OutputFile| {
            row.when == When::Always && matches!(row.writer, FileWriter::Run(_))
        };
        let (folders, files): (Vec<_>, Vec<_>) =
            (self.made.iter().map(|(row, _)| *row)).partition(|row| !row.file_name().contains('.'));
        let of_run = OUTPUT_FILES.iter().filter(of_run);
        files.into_iter().chain(of_run).chain(folders)
    }
}
