//! Log of a project: its file, its identity, and the decisions about it.

use super::paths;
use crate::Error;
use crate::pipeline::{LogSettings, sha256_of};
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_objects::NAMELESS_CLASS;
use bathyscope_objects::objects::LogNumbers;
use bathyscope_objects::review::Review;
use serde::Deserialize;
use std::fmt;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most letters of a log's name in its key.
const LONGEST_STEM: usize = 32;
/// Number of digits of the hash in a log's key.
const HASH_DIGITS: usize = 8;

/// Largest size of a file of bottom edits, bytes: this program does not write a longer one.
const LONGEST: u64 = 64 << 20;
/// Contents of the file, in the form of the settings for `bathyscope process --settings`.
#[derive(Deserialize)]
struct BottomFile {
    bottom: BottomSettings,
}

/// Permanent key of a log within a project: its first file name and the start of its hash,
/// `chart_1-3f9a2c41`. Two people who add the same log get the same key, and two logs of the same
/// name have different keys.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LogKey(String);

impl LogKey {
    /// Creates the key of a log that is added to a project.
    pub fn of(file: &LogFile) -> Self {
        let hash = file.sha256.get(..HASH_DIGITS).unwrap_or(&file.sha256);
        Self(format!("{}{hash}", Self::start_of(&file.path)))
    }

    /// Returns the start of the keys of all logs with this file name, up to the hash.
    pub(super) fn start_of(path: &Path) -> String {
        let stem = path.file_stem().unwrap_or_default();
        let stem = stem.to_string_lossy().to_lowercase();
        let plain = stem.chars().map(|letter| match letter {
            'a'..='z' | '0'..='9' | '_' | '-' => letter,
            _ => '_',
        });
        let plain: String = plain.take(LONGEST_STEM).collect();
        format!("{plain}-")
    }

    /// Creates a key from its text in a file.
    pub(crate) fn from_text(text: &str) -> Self {
        Self(text.to_owned())
    }

    /// Returns the key as its text in a file.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for LogKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Recording on disk, which the program only reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogFile {
    /// Absolute path of the file to open; for a recording in several files, the first.
    pub path: PathBuf,
    /// SHA-256 of the log's files, one after the other, hexadecimal: equal to `cat FILES |
    /// sha256sum`.
    pub sha256: String,
    /// Sum of the bytes of the log's files.
    pub byte_count: u64,
    /// Number of side-scan pings.
    pub pings: usize,
}

impl LogFile {
    /// Describes an open log. Reads the whole log once: about a second per gigabyte.
    pub fn of(survey: &Survey, progress: &Progress) -> Result<Self, Cancelled> {
        let identity = Identity::of(survey);
        let path = survey.source.files.first().cloned().unwrap_or_default();
        Ok(Self {
            path: paths::placed(&path),
            sha256: sha256_of_first(survey, u64::MAX, progress)?,
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

    /// Returns true if an open log is this one, by its bytes, whatever the name of its file.
    pub fn is_of(&self, survey: &Survey, progress: &Progress) -> Result<bool, Cancelled> {
        let may_be = self.identity().is_same_log(&Identity::of(survey));
        Ok(may_be && sha256_of_first(survey, u64::MAX, progress)? == self.sha256)
    }

    /// Returns true if an open log has the file name and the bytes of this one, or begins with its
    /// bytes because more was recorded since. A recording in several files is not recognised after
    /// it has grown.
    pub(super) fn is_or_was_of(
        &self,
        survey: &Survey,
        progress: &Progress,
    ) -> Result<bool, Cancelled> {
        let identity = Identity::of(survey);
        let is_longer = identity.byte_count > self.byte_count;
        let may_be = self.identity().file == identity.file
            && identity.byte_count >= self.byte_count
            && !(is_longer && survey.source.files.len() > 1);
        Ok(may_be && sha256_of_first(survey, self.byte_count, progress)? == self.sha256)
    }
}

/// Returns the SHA-256 of the first `count` bytes of the log's own files; the track of another
/// receiver, the last of the survey's files, is not included.
fn sha256_of_first(survey: &Survey, count: u64, progress: &Progress) -> Result<String, Cancelled> {
    let track = usize::from(survey.track.external.is_some());
    let own = survey.bytes.len().saturating_sub(track);
    let none: Box<dyn Read> = Box::new(io::empty());
    let all = (survey.bytes[..own].iter()).fold(none, |all, bytes| Box::new(all.chain(&bytes[..])));
    // Reading memory cannot fail; the only error is a cancellation.
    let hashed = sha256_of(all.take(count), progress).map_err(|_| Cancelled)?;
    Ok(hashed.1)
}

/// Log and the decisions about it.
#[derive(Clone, Debug)]
pub struct ProjectLog {
    /// Key of the log within the project.
    pub key: LogKey,
    /// Recording on disk.
    pub file: LogFile,
    /// Name of the log that is shown.
    pub name: String,
    /// Colour of the log on the map and in lists, red, green and blue; `None` for a colour by its
    /// place in the list.
    pub colour: Option<[u8; 3]>,
    /// True if the log is part of maps, clouds and products.
    pub is_visible: bool,
    /// Sort key in the list of logs, the lowest first.
    pub order: f64,
    /// Settings of this log, with its bottom edits.
    pub settings: LogSettings,
    /// Boxes of the log and the decisions about them.
    pub review: Arc<Review>,
    /// Numbers of the objects in the log's boxes. They follow from the decisions and the earlier
    /// numbers, and are not a decision.
    pub object_numbers: LogNumbers,
}

/// Equality of the decisions: `object_numbers` are not compared.
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
    /// Creates a log without decisions; [`super::Project::with_log`] sets its place in the list.
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

    /// Returns the message that a file of the same length with other bytes is at the log's place
    /// ([`super::LogLocation::Changed`]).
    pub fn is_changed(&self) -> String {
        format!(
            "the log {} is not the file that the project was made of: it is as long, but its bytes differ, so that edits and boxes may not fit; put the file back, or remove the log and add it again: {}",
            quoted(&self.name),
            self.file.path.display()
        )
    }

    /// Returns the log with another path of its file; the key stays.
    pub fn at(&self, path: &Path) -> Self {
        let mut moved = self.clone();
        moved.file.path = paths::placed(path);
        moved
    }
}

/// Reads the bottom edits that earlier versions stored in a sidecar file, `LOG.bottom.toml`, which
/// is not changed; `None` if there is no such file. They are read when the log is opened and no
/// project has decisions about it.
pub fn read_bottom(log: &Path, survey: &Survey) -> Option<Result<BottomSettings, Error>> {
    let path = log.with_extension(BottomSettings::SIDECAR);
    let found = fs::metadata(&path).ok();
    found.filter(|found| found.is_file())?;
    let parsed = || -> Result<BottomSettings, String> {
        let text = regular_file::read_text(&path, LONGEST).map_err(|error| error.to_string())?;
        let kept: BottomFile = toml::from_str(&text).map_err(|error| error.message().to_owned())?;
        kept.bottom.check()?;
        kept.bottom.adopted(survey).map_err(|other| other.to_string())
    };
    let refused = |why| format!("cannot use the bottom edits: {why}: {}", path.display());
    Some(parsed().map_err(|why| refused(why).into()))
}
