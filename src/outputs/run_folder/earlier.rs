//! What an earlier run wrote into a folder.

use super::journal::is_plain;
use super::{Fingerprint, MANIFESTS};
use crate::export::remove_leftovers;
use crate::outputs::OutputError;
use crate::outputs::overwrite::is_stem_of_output;
use crate::outputs::registry::row_of;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// What the manifest of a run calls the list of its files.
const FILES: &str = "files";
/// The one file of a version that did not list them without a record.
const PAGE: &str = "report.html";

/// Names of the files that an earlier run wrote and nobody has changed since, its manifests among them, as far as they `go`.
pub(super) fn files(folder: &Path, goes: impl Fn(&str) -> bool) -> Vec<String> {
    let mut names = Vec::new();
    for manifest in MANIFESTS {
        let Some(record) = read(folder, manifest) else {
            continue;
        };
        match listed(&record) {
            Some(files) => {
                // Only these are read: what gives way to a new file may be long.
                let going = files.into_iter().filter(|file| goes(&file.file));
                let unchanged = going.filter(|file| file.is_unchanged(folder));
                names.extend(unchanged.map(|file| file.file));
            }
            None => {
                let page = is_our_page(folder).then(|| PAGE.to_owned());
                let recorded = recorded(folder).into_iter().chain(page);
                names.extend(recorded.filter(|name| goes(name)));
            }
        }
    }
    names
}

/// Writes the manifest of `folder` into `new` without the files of a group, unless it names none of them; gives back its name.
pub(super) fn without_group(
    folder: &Path,
    new: &Path,
    group: &impl Fn(&str) -> bool,
) -> Result<Option<&'static str>, OutputError> {
    for manifest in MANIFESTS {
        let Some(mut record) = read(folder, manifest) else {
            continue;
        };
        let Some(files) = record.get_mut(FILES).and_then(Value::as_array_mut) else {
            continue;
        };
        let before = files.len();
        files.retain(|file| !file["file"].as_str().is_some_and(group));
        if files.len() == before {
            continue;
        }
        let text = serde_json::to_string_pretty(&record)?;
        let path = new.join(manifest);
        fs::write(&path, text + "\n").map_err(|error| format!("{error}: {}", path.display()))?;
        return Ok(Some(manifest));
    }
    Ok(None)
}

/// Removes what killed runs of a version left that wrote each file by itself: `cloud.csv.PID.part`.
pub(super) fn remove_parts(folder: &Path) {
    remove_leftovers(folder, |name| {
        let stem = name.split('.').next()?;
        is_stem_of_output(stem).then(|| name.strip_suffix(".part"))?
    });
}

/// A manifest of ours; somebody else's file of that name is none.
fn read(folder: &Path, name: &str) -> Option<Value> {
    let record: Value = serde_json::from_slice(&fs::read(folder.join(name)).ok()?).ok()?;
    let program = record.get("program")?.as_str()?;
    program.starts_with("bathyscope ").then_some(record)
}

fn listed(record: &Value) -> Option<Vec<Fingerprint>> {
    let files: Vec<Fingerprint> = serde_json::from_value(record.get(FILES)?.clone()).ok()?;
    let own = files.into_iter().filter(|file| is_plain(&file.file));
    Some(own.collect())
}

fn is_our_page(folder: &Path) -> bool {
    let page = fs::read_to_string(folder.join(PAGE));
    page.is_ok_and(|page| page.contains("Made with bathyscope "))
}

/// What a version that did not list its files wrote: files with a record beside them that names them.
fn recorded(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let record = entry.file_name().to_string_lossy().into_owned();
        let Some(product) = record.strip_suffix(".json") else {
            continue;
        };
        if read(folder, &record).is_none_or(|record| record["product"] != product) {
            continue;
        }
        let companions = row_of(product).map_or(&[][..], |row| row.companions);
        names.extend(companions.iter().map(|name| (*name).to_owned()));
        names.extend([product.to_owned(), record]);
    }
    names.retain(|name| folder.join(name).is_file());
    names
}
