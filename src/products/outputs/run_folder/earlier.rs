//! Finds the files that an earlier run wrote into a folder.

use super::{EARLIER_MANIFESTS, Fingerprint, is_plain};
use crate::Error;
use crate::export::remove_leftovers;
use crate::outputs::MANIFEST;
use crate::outputs::registry::{OUTPUT_FILES, OutputFile, file_part, row_of, row_of_beside};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Key of the list of files in the manifest of a run.
const FILES: &str = "files";
/// The only file without a record in versions that wrote a record for each file instead of a list.
const PAGE: &str = "report.html";

/// Names of files that an earlier run wrote.
#[derive(Debug, Default)]
pub(super) struct EarlierFiles {
    /// Files that have not changed since.
    pub unchanged: Vec<String>,
    /// Files that have changed since, or that no manifest lists.
    pub changed: Vec<String>,
}

/// Returns true if a run may write a file with this name, apart from its ending. New data files
/// without a subfolder are ignored: the versions that wrote all files into the folder itself did
/// not write them, so `survey.gpkg` is no danger to `survey.sl2`.
pub(in crate::outputs) fn is_stem_of_output(stem: &str) -> bool {
    let is_new = |row: &&OutputFile| row.folder().is_empty() && row.described.is_some();
    let rows = OUTPUT_FILES.iter().filter(|row| !is_new(row));
    let stems = rows.map(OutputFile::stem);
    let manifests = EARLIER_MANIFESTS.iter().map(|name| name.trim_end_matches(".json"));
    stems.chain(manifests).any(|known| known.eq_ignore_ascii_case(stem))
}

/// Returns the files that an earlier run wrote into a folder, if `goes` is true for their names.
pub(super) fn files(folder: &Path, goes: impl Fn(&str) -> bool) -> EarlierFiles {
    let mut found = EarlierFiles::default();
    for (_, record) in manifests(folder) {
        match listed(&record) {
            Some(files) => {
                // Only these files are read for comparison: files that are replaced may be large.
                let going = files.into_iter().filter(|file| goes(&file.file));
                let there = going.filter(|file| folder.join(&file.file).is_file());
                for file in there {
                    if file.is_unchanged(folder) {
                        found.unchanged.push(file.file)
                    } else {
                        found.changed.push(file.file)
                    }
                }
            }
            None => {
                let page = is_our_page(folder).then(|| PAGE.to_owned());
                let recorded = recorded(folder).into_iter().chain(page);
                found.unchanged.extend(recorded.filter(|name| goes(name)));
            }
        }
    }
    let mut beside = beside(folder);
    beside.retain(|name| goes(name) && !found.unchanged.contains(name));
    found.changed.extend(beside);
    found.changed.sort_unstable();
    found.changed.dedup();
    found
}

/// Returns the files without a subfolder that have the name of a file of a version without
/// subfolders: they may belong to a run without a manifest.
fn beside(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let names = files.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| row_of(name).is_none() && row_of_beside(name).is_some()).collect()
}

/// Returns the names of the manifests of the run in a folder.
pub(super) fn manifest_names(folder: &Path) -> Vec<String> {
    let names = manifests(folder).into_iter();
    names.map(|(name, _)| name.to_owned()).collect()
}

/// Returns true if a folder has a file with the name of the manifest that no run of Bathyscope
/// wrote.
pub(in crate::outputs) fn has_foreign_manifest(folder: &Path) -> bool {
    folder.join(MANIFEST).exists() && read_manifest(folder, MANIFEST).is_none()
}

/// Returns the manifests of a folder: that of this version, or else those of versions without a
/// separate manifest.
fn manifests(folder: &Path) -> Vec<(&'static str, Value)> {
    let ours = |name| read_manifest(folder, name).map(|record| (name, record));
    match ours(MANIFEST) {
        Some(manifest) => vec![manifest],
        None => EARLIER_MANIFESTS.into_iter().filter_map(ours).collect(),
    }
}

/// Writes the manifest of `folder` into `new` without the files of a group. Returns its name;
/// `None`, and nothing is written, if it lists none of them.
pub(super) fn without_group(
    folder: &Path,
    new: &Path,
    group: &impl Fn(&str) -> bool,
) -> Result<Option<&'static str>, Error> {
    for (manifest, mut record) in manifests(folder) {
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

/// Removes the remains of killed runs of versions that wrote each file by itself:
/// `cloud.csv.PID.part`.
pub(super) fn remove_parts(folder: &Path) {
    remove_leftovers(folder, |name| {
        let stem = name.split('.').next()?;
        is_stem_of_output(stem).then(|| name.strip_suffix(".part"))?
    });
}

/// Reads a manifest of Bathyscope; `None` for a file of another program.
pub(in crate::outputs) fn read_manifest(folder: &Path, name: &str) -> Option<Value> {
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

/// Returns the files of a version that did not list its files: files that have a record of their
/// name beside them.
fn recorded(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let record = entry.file_name().to_string_lossy().into_owned();
        let Some(product) = record.strip_suffix(".json") else {
            continue;
        };
        if read_manifest(folder, &record).is_none_or(|record| record["product"] != product) {
            continue;
        }
        let companions = row_of_beside(product).map_or(&[][..], |row| row.companions);
        names.extend(companions.iter().map(|name| file_part(name).to_owned()));
        names.extend([product.to_owned(), record]);
    }
    names.retain(|name| folder.join(name).is_file());
    names
}
