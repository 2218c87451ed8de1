//! The files of a simulated survey: the log and its tables of truth.

use bathyscope_products::export::{ExportError, write_atomically};
use bathyscope_simulation::Simulated;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// Writes the three files; returns their names.
pub(super) fn write(survey: &Simulated, prefix: &Path) -> Result<String, ExportError> {
    let log = written(prefix, "sl2", |out| survey.write_sl2(out))?;
    let truth = written(prefix, "truth.csv", |out| survey.write_truth_csv(out))?;
    let objects = written(prefix, "objects.csv", |out| survey.write_objects_csv(out))?;
    Ok(format!("{log}, {truth}, {objects}"))
}

/// Writes `PREFIX.ending` aside and renames it when it is whole.
fn written(
    prefix: &Path,
    ending: &str,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<String, ExportError> {
    let path = with_ending(prefix, ending);
    write_atomically(&path, |file| {
        let mut out = BufWriter::new(file);
        fill(&mut out)?;
        out.flush()
    })?;
    Ok(path.display().to_string())
}

/// `PREFIX.ending`, whatever dots the prefix holds.
pub(super) fn with_ending(prefix: &Path, ending: &str) -> PathBuf {
    let mut name = prefix.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}
