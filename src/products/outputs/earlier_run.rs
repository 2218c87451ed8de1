//! Reads the manifest of the run whose files are in a folder, and finds the files that are out of
//! date.

use super::registry::{OUTPUT_FILES, OutputFile, row_of};
use crate::pipeline::{Settings, setting_values};
use bathyscope_log::survey::Survey;
use serde::Deserialize;
use std::collections::{BTreeSet, HashSet};
use std::ffi::OsString;
use std::path::Path;

/// Record with the inputs of a run in versions without a separate manifest.
const REPORT: &str = "report.json";

/// Settings, files and inputs of the run that wrote into a folder.
#[derive(Clone, Debug)]
pub struct EarlierRun {
    /// Settings of the run; `None` where this version does not know all of them.
    settings: Option<Settings>,
    /// Names of the files of the run.
    files: Vec<String>,
    /// SHA-256 of the inputs of the run.
    inputs: Vec<String>,
}

#[derive(Deserialize)]
struct Manifest {
    settings: serde_json::Value,
    files: Vec<Named>,
    #[serde(default)]
    inputs: Vec<Hashed>,
}

#[derive(Deserialize)]
struct Named {
    file: String,
}

#[derive(Deserialize)]
struct Hashed {
    sha256: String,
}

impl EarlierRun {
    /// Reads the manifest of a folder, after the run was finished if it was killed at its end;
    /// `None` where there is no readable manifest.
    pub fn read(folder: &Path) -> Option<Self> {
        super::finish_killed_run(folder).ok()?;
        let text = std::fs::read(folder.join(super::MANIFEST)).ok()?;
        let Manifest { settings, files, inputs } = serde_json::from_slice(&text).ok()?;
        let files = files.into_iter().map(|named| named.file);
        Some(Self {
            settings: serde_json::from_value(settings).ok(),
            // The manifest cannot list itself.
            files: files.chain([super::MANIFEST.to_owned()]).collect(),
            inputs: inputs.into_iter().map(|input| input.sha256).collect(),
        })
    }

    /// Returns the written files that would differ with these settings for the same log, in the
    /// order of writing. Readings of the water level and tracks are compared by the names of their
    /// files, the area of the isobaths by its content.
    pub fn out_of_date(&self, settings: &Settings) -> Vec<&'static OutputFile> {
        let written = || {
            let row = |name: &String| row_of(name).map(|row| row.name);
            let rows: BTreeSet<&str> = self.files.iter().filter_map(row).collect();
            OUTPUT_FILES.iter().filter(move |row| rows.contains(row.name))
        };
        let Some(earlier) = &self.settings else {
            return written().collect();
        };
        if earlier == settings {
            return Vec::new();
        }
        let mut words = words_that_differ(earlier, settings);
        let area = settings.isobaths.area.as_deref();
        if area.is_some_and(|area| !self.inputs.contains(&area.sha256)) {
            words.insert("isobaths".to_owned());
        }
        written().filter(|row| row.depends_on(&words)).collect()
    }
}

/// Returns true if the logs of the run in a folder are the same as these by the names and sizes of
/// their files, or all of these and others, or some of these only.
pub fn is_run_of(folder: &Path, surveys: &[&Survey]) -> bool {
    let read = |record: &Path| -> Option<Origin> {
        let origin: Origin = serde_json::from_slice(&std::fs::read(record).ok()?).ok()?;
        origin.program.starts_with("bathyscope ").then_some(origin)
    };
    // Versions without subfolders stored the manifest in the report.
    let mut records = [super::MANIFEST, REPORT].map(|name| folder.join(name)).into_iter();
    let Some(origin) = records.find_map(|record| read(&record)) else {
        return false;
    };
    let name = |path: &Path| path.file_name().unwrap_or_default().to_owned();
    let inputs = origin.inputs.iter();
    let earlier: HashSet<(OsString, usize)> =
        inputs.map(|input| (name(Path::new(&input.file)), input.bytes)).collect();
    let files = surveys.iter().flat_map(|survey| {
        let lengths = survey.bytes.iter().map(|bytes| bytes.len());
        survey.source.files.iter().zip(lengths)
    });
    let now: HashSet<(OsString, usize)> =
        files.map(|(path, length)| (name(path), length)).collect();
    !now.is_empty() && (now.is_subset(&earlier) || earlier.is_subset(&now))
}

/// Program and inputs of a run.
#[derive(Deserialize)]
struct Origin {
    program: String,
    inputs: Vec<InputFile>,
}

#[derive(Deserialize)]
struct InputFile {
    file: String,
    bytes: usize,
}

/// Returns the first words of the keys of the settings that differ.
fn words_that_differ(one: &Settings, other: &Settings) -> BTreeSet<String> {
    let first = |key: &String| key.split('.').next().unwrap_or(key).to_owned();
    let [values, others] = [one, other].map(setting_values);
    let keys = values.keys().chain(others.keys());
    let mut words: BTreeSet<String> =
        keys.filter(|key| values.get(*key) != others.get(*key)).map(first).collect();
    // The choice of point files changes none of their contents.
    words.remove("points");
    if one.bottom != other.bottom {
        words.insert("bottom".to_owned());
    }
    words
}
