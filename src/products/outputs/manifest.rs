//! Writes `manifest.json`: every file of a run, with its origin, coordinate system, extent and
//! hash. Reads the manifest of the run whose files are in a folder, and finds the files that are
//! out of date.

use super::MANIFEST;
use super::content::{Coordinates, FileContent, Need};
use super::registry::{OUTPUT_FILES, OutputFile, row_of};
use super::report_page::OutputRun;
use super::run_folder::{finish_killed_run, read_manifest};
use crate::Error;
use crate::export::{Summary, write_json};
use crate::pipeline::{Fingerprint, Settings, setting_values};
use bathyscope_log::survey::Survey;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::{BTreeSet, HashSet};
use std::ffi::OsString;
use std::fs;
use std::path::Path;

/// Record with the inputs of a run in versions without a separate manifest.
const REPORT: &str = "report.json";

/// Content of `manifest.json`: values that all files of a run share, and an entry for each file.
#[derive(Serialize)]
struct Manifest<'a> {
    program: &'a str,
    run: &'a str,
    inputs: &'a [Fingerprint],
    /// Number of logs of the survey; absent for a single log.
    #[serde(skip_serializing_if = "Option::is_none")]
    logs: Option<usize>,
    start_unix_s: Option<f64>,
    preset: &'static str,
    settings: &'a Settings,
    statement: &'a str,
    files: Vec<ManifestEntry<'a>>,
}

/// A file of a run: its name, size, hash and content. Unknown values are absent.
#[derive(Serialize)]
struct ManifestEntry<'a> {
    #[serde(flatten)]
    file: &'a Fingerprint,
    #[serde(skip_serializing_if = "Option::is_none")]
    what: Option<String>,
    /// Main file of a file that accompanies another one.
    #[serde(skip_serializing_if = "Option::is_none")]
    belongs_to: Option<&'static str>,
    #[serde(flatten)]
    content: Option<ContentEntry<'a>>,
}

#[derive(Serialize)]
struct ContentEntry<'a> {
    crs: Value,
    extent: Value,
    count: Map<String, Value>,
    values: Value,
    /// Input files besides those of the logs.
    #[serde(skip_serializing_if = "<[Fingerprint]>::is_empty")]
    more_inputs: &'a [Fingerprint],
    /// Groups of settings, by the first word of the key, that the file does not depend on.
    regardless_of: &'static [&'static str],
}

/// Writes `manifest.json`: the fingerprints of all other files of the run, in the order of their
/// names, with the content of the files that were made from results.
///
/// # Errors
/// When a file cannot be read or the manifest cannot be written; the sentence names the file.
pub(super) fn write(run: &OutputRun<'_>, path: &Path) -> Result<(), Error> {
    let files = (run.folder).files(&run.hashed, run.results.progress)?;
    let compared = run.made.iter().any(|(row, _)| row.needs.contains(&Need::Reference));
    let more_inputs = if compared { run.results.reference_inputs()? } else { &[] };
    let entry = |file| entry(file, &run.made, more_inputs);
    let report = &run.report;
    let manifest = Manifest {
        program: &report.program,
        run: &report.run,
        inputs: &report.inputs,
        logs: report.logs.as_ref().map(|all| all.logs.len()),
        start_unix_s: report.start_unix_s,
        preset: report.preset,
        settings: &report.settings,
        statement: &report.statement,
        files: files.iter().map(entry).collect(),
    };
    Ok(write_json(path, &manifest)?)
}

fn entry<'a>(
    file: &'a Fingerprint,
    made: &[(&'static OutputFile, FileContent)],
    more_inputs: &'a [Fingerprint],
) -> ManifestEntry<'a> {
    let bare = |what, belongs_to| ManifestEntry { file, what, belongs_to, content: None };
    let Some(row) = row_of(&file.file) else {
        return bare(None, None);
    };
    if row.name != file.file {
        return bare(None, Some(row.name));
    }
    let content = made.iter().find(|(other, _)| other.name == row.name);
    let Some((described, (_, content))) = row.described.zip(content) else {
        return bare(Some(row.brief.to_owned()), None);
    };
    let of_reference = row.needs.contains(&Need::Reference);
    let Summary { count, extent, values } = content.summary;
    let extent = extent.map(|[[west, east], [south, north]]| {
        json!({ "west": west, "south": south, "east": east, "north": north })
    });
    let values = values.filter(|_| !described.measured.is_empty());
    let entry = ContentEntry {
        crs: coordinates(&content.coordinates),
        extent: extent.unwrap_or(Value::Null),
        count: Map::from_iter([(described.counted.to_owned(), json!(count))]),
        values: values.map_or(
            Value::Null,
            |[least, most]| json!({ "of": described.measured, "least": least, "most": most }),
        ),
        more_inputs: if of_reference { more_inputs } else { &[] },
        regardless_of: row.regardless_of,
    };
    ManifestEntry {
        what: Some(format!("{}{}", described.what, content.detail)),
        content: Some(entry),
        ..bare(None, None)
    }
}

fn coordinates(coordinates: &Coordinates) -> Value {
    match coordinates {
        Coordinates::System(crs) => {
            let unit = if crs.is_degrees() { "degree" } else { "metre" };
            json!({ "epsg": crs.epsg(), "name": crs.name(), "unit": unit })
        }
        Coordinates::Degrees => json!({ "epsg": 4326, "name": "WGS 84", "unit": "degree" }),
        Coordinates::Local(origin) => json!({
            "epsg": null,
            "name": "metres east and north of the origin",
            "unit": "metre",
            "origin": { "lon": origin.lon_deg, "lat": origin.lat_deg },
        }),
        Coordinates::None => Value::Null,
    }
}

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
struct EarlierManifest {
    settings: Value,
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
        finish_killed_run(folder).ok()?;
        let text = fs::read(folder.join(MANIFEST)).ok()?;
        let EarlierManifest { settings, files, inputs } = serde_json::from_slice(&text).ok()?;
        let files = files.into_iter().map(|named| named.file);
        Some(Self {
            settings: serde_json::from_value(settings).ok(),
            // The manifest cannot list itself.
            files: files.chain([MANIFEST.to_owned()]).collect(),
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
    let inputs_in = |name: &str| -> Option<Vec<InputFile>> {
        let mut record = read_manifest(folder, name)?;
        serde_json::from_value(record.get_mut("inputs")?.take()).ok()
    };
    // Versions without subfolders stored the manifest in the report.
    let Some(inputs) = [MANIFEST, REPORT].into_iter().find_map(inputs_in) else {
        return false;
    };
    let name = |path: &Path| path.file_name().unwrap_or_default().to_owned();
    let inputs = inputs.iter();
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

/// An input of a run.
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
