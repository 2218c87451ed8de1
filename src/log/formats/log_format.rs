//! Trait of the readers of formats: each recognises a recording by content, and reads it.

use super::file_source::FileSource;
use super::reading::Reading;
use super::{OpenError, Opened};
use crate::support::progress::Progress;
use crate::survey::Survey;
use std::path::Path;

/// Reads the recording that was recognised.
pub(super) type ReadRecording =
    Box<dyn FnOnce(&Reading<'_>, &Progress) -> Result<Survey, OpenError>>;

/// A format of recorders' logs. Its row in [`super::table::FORMATS`] names it.
pub(super) trait LogFormat: Sync {
    /// Recognises a file by its content, never by its name alone. A format of several files looks
    /// for the others beside it in `files`. `None` when the file is of another format: this says
    /// nothing of damage.
    fn recognise(&self, files: &FileSource, opened: &Opened) -> Option<ReadRecording>;

    /// Recognises the recording in a folder, or the first of several; of use only to formats of
    /// several files.
    fn recognise_folder(&self, _files: &FileSource, _folder: &Path) -> Option<ReadRecording> {
        None
    }

    /// Returns true if all files in a folder are parts of one recording, so that the folder is
    /// opened in their place.
    fn is_recording(&self, _files: &FileSource, _folder: &Path) -> bool {
        false
    }

    /// Returns true if a file is only read where it is named, and not where it lies in a folder of
    /// logs: tables of other kinds look the same, or another file of the recording stands for it.
    fn is_read_by_name_only(&self, _path: &Path) -> bool {
        false
    }
}
