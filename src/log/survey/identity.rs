//! Identifies the recording on which a sidecar file was made.

use super::Survey;
use serde::{Deserialize, Serialize};

/// Identifies one log in its sidecar files: decisions about boxes, bottom edits. It depends on the
/// log's own bytes only, whatever is applied to the log. A log that was renamed or moved is still
/// the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// File name of the log, without its folder.
    pub file: String,
    /// Bytes of all its files.
    pub byte_count: u64,
    /// Side-scan pings.
    pub pings: usize,
    /// True if port and starboard are exchanged against the recording: sides that are named with it
    /// are those.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub swapped_sides: bool,
}

impl Identity {
    /// Returns the identity of an open survey.
    pub fn of(survey: &Survey) -> Self {
        let file = survey.source.files.first();
        let name = file.and_then(|file| file.file_name());
        Self {
            file: name.map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            byte_count: survey.source.byte_count,
            pings: survey.side_scan.len(),
            swapped_sides: survey.swapped_sides,
        }
    }

    /// Returns true if both are the same recording.
    pub fn is_same_log(&self, other: &Self) -> bool {
        self.byte_count == other.byte_count && self.pings == other.pings
    }
}
