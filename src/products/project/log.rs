//! A log of a project: where it lies, what tells it from another, and what was decided about it.

use super::paths;
use crate::pipeline::{LogSettings, sha256_of};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_objects::NAMELESS_CLASS;
use bathyscope_objects::objects::LogNumbers;
use bathyscope_objects::review::Review;
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Letters of a log's name in its key.
const LONGEST_STEM: usize = 32;
/// Digits of the hash in a log's key.
const HASH_DIGITS: usize = 8;

/// Names a log within a project, for ever: its first file name and the start of its hash,
/// `chart_1-3f9a2c41`. Two people who add the same log give it the same key, and two logs of one
/// name have different ones.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LogKey(String);

impl LogKey {
    /// The key of a log that is added now.
    pub fn of(file: &LogFile) -> Self {
        let stem = file.path.file_stem().unwrap_or_default();
        let stem = stem.to_string_lossy().to_lowercase();
        let plain = stem.chars().map(|letter| match letter {
            'a'..='z' | '0'..='9' | '_' | '-' => letter,
            _ => '_',
        });
        let plain: String = plain.take(LONGEST_STEM).collect();
        let hash = file.sha256.get(..HASH_DIGITS).unwrap_or(&file.sha256);
        Self(format!("{plain}-{hash}"))
    }

    /// A key as it stands in a file.
    pub(crate) fn from_text(text: &str) -> Self {
        Self(text.to_owned())
    }

    /// The key as it stands in a file.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for LogKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A recording on disk. The program only ever reads it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogFile {
    /// The file to open, absolute; of a recording in several files the first.
    pub path: PathBuf,
    /// SHA-256 of its files, one after the other, hexadecimal: `cat FILES | sha256sum` says the
    /// same.
    pub sha256: String,
    /// Bytes of all its files.
    pub byte_count: u64,
    /// Side-scan pings.
    pub pings: usize,
}

impl LogFile {
    /// Describes an open log. Reads all of it once: about a second a gigabyte.
    pub fn of(survey: &Survey, progress: &Progress) -> Result<Self, Cancelled> {
        let identity = Identity::of(survey);
        let path = survey.source.files.first().cloned().unwrap_or_default();
        Ok(Self {
            path: paths::placed(&path),
            sha256: sha256(survey, progress)?,
            byte_count: identity.byte_count,
            pings: identity.pings,
        })
    }

    /// Returns the identity by which sidecars name the log as it was recorded.
    pub fn identity(&self) -> Identity {
        let name = self.path.file_name().unwrap_or_default();
        Identity {
            file: name.to_string_lossy().into_owned(),
            byte_count: self.byte_count,
            pings: self.pings,
            swapped_sides: false,
        }
    }

    /// Returns true if an open log is this one. The bytes count, whatever the file is called.
    pub fn is_of(&self, survey: &Survey, progress: &Progress) -> Result<bool, Cancelled> {
        let may_be = self.identity().is_same_log(&Identity::of(survey));
        Ok(may_be && sha256(survey, progress)? == self.sha256)
    }
}

/// Returns the SHA-256 of the log's own files: a track that was applied to it comes last among the
/// bytes, and does not count.
fn sha256(survey: &Survey, progress: &Progress) -> Result<String, Cancelled> {
    let track = usize::from(survey.track.external.is_some());
    let own = survey.bytes.len().saturating_sub(track);
    let none: Box<dyn Read> = Box::new(io::empty());
    let all = (survey.bytes[..own].iter()).fold(none, |all, bytes| Box::new(all.chain(&bytes[..])));
    // Memory can be read, unless somebody says to stop.
    let hashed = sha256_of(all, progress).map_err(|_| Cancelled)?;
    Ok(hashed.1)
}

/// A log and what was decided about it.
#[derive(Clone, Debug)]
pub struct ProjectLog {
    /// Names it within the project.
    pub key: LogKey,
    /// The recording.
    pub file: LogFile,
    /// Its name for people.
    pub name: String,
    /// Its colour on the map and in lists, red, green and blue; `None` for one by its place in the
    /// list.
    pub colour: Option<[u8; 3]>,
    /// True if it takes part in maps, clouds and products.
    pub is_visible: bool,
    /// Position among the logs: the lower, the higher in the list.
    pub order: f64,
    /// Its own settings and its bottom edits.
    pub settings: LogSettings,
    /// The boxes on it and the decisions about them.
    pub review: Arc<Review>,
    /// Numbers of the objects that its boxes show. They follow from the decisions and from the
    /// numbers before: none of them is one.
    pub object_numbers: LogNumbers,
}

/// Equality of the decisions: `object_numbers` do not count.
impl PartialEq for ProjectLog {
    fn eq(&self, other: &Self) -> bool {
        let Self {
            key,
            file,
            name,
            colour,
            is_visible,
            order,
            settings,
            review,
            object_numbers: _,
        } = self;
        *key == other.key
            && *file == other.file
            && *name == other.name
            && *colour == other.colour
            && *is_visible == other.is_visible
            && *order == other.order
            && *settings == other.settings
            && (Arc::ptr_eq(review, &other.review) || *review == other.review)
    }
}

impl ProjectLog {
    /// A log with nothing decided yet; [`super::Project::with_log`] gives it its place.
    pub fn new(file: LogFile) -> Self {
        let identity = file.identity();
        let stem = file.path.file_stem().unwrap_or_default();
        Self {
            key: LogKey::of(&file),
            name: stem.to_string_lossy().into_owned(),
            colour: None,
            is_visible: true,
            order: 0.0,
            settings: LogSettings::default(),
            review: Arc::new(Review::new(identity, vec![NAMELESS_CLASS.to_owned()])),
            object_numbers: LogNumbers::default(),
            file,
        }
    }

    /// Returns the message where a file of the same length with other bytes lies at its place
    /// ([`super::LogLocation::Changed`]).
    pub fn is_changed(&self) -> String {
        format!(
            "the log {} is not the file that the project was made of: it is as long, but its bytes differ, so that edits and boxes may not fit; put the file back, or remove the log and add it again: {}",
            quoted(&self.name),
            self.file.path.display()
        )
    }

    /// The same log where it lies now. Its key stays.
    pub fn at(&self, path: &Path) -> Self {
        let mut moved = self.clone();
        moved.file.path = paths::placed(path);
        moved
    }
}
