//! Reads the bottom edits that earlier versions stored in a sidecar file, `LOG.bottom.toml`. They
//! are read when the log is opened and no project has decisions about it; the sidecar file is not
//! changed.

use crate::Error;
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use serde::Deserialize;
use std::fs;
use std::path::Path;

/// Largest size of a file of bottom edits, bytes: this program does not write a longer one.
const LONGEST: u64 = 64 << 20;
/// Contents of the file, in the form of the settings for `bathyscope process --settings`.
#[derive(Deserialize)]
struct BottomFile {
    bottom: BottomSettings,
}

/// Reads the bottom edits of a log; `None` if it has no sidecar file.
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
