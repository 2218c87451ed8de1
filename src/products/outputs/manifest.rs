//! Writes `manifest.json`: every file of a run, with its origin, coordinate system, extent and
//! hash.

use super::content::{Coordinates, FileContent, Need};
use super::registry::{OutputFile, row_of};
use super::report_page::OutputRun;
use crate::Error;
use crate::export::{Summary, write_json};
use crate::pipeline::{Fingerprint, Settings};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::Path;

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
