//! The record of a product: `depth.tif.json` states where `depth.tif` comes from and its extent.

use super::registry::OutputFile;
use crate::export::{self, Summary};
use crate::geo::{Crs, LonLat};
use crate::outputs::OutputError;
use crate::pipeline::{Input, Report};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::io::Write as _;
use std::path::Path;

/// What the coordinates of a file are.
#[derive(Clone, Debug)]
pub enum Coordinates {
    /// A coordinate reference system.
    System(Crs),
    /// Longitude and latitude on WGS84.
    Degrees,
    /// Metres east and north of the survey's origin, in the plane that `projection` names.
    Local(LonLat),
    /// None: the file is a table of something else.
    None,
}

/// What a file holds.
#[derive(Clone, Debug)]
pub struct FileContent {
    /// What its coordinates are.
    pub coordinates: Coordinates,
    /// How much it holds.
    pub summary: Summary,
    /// What is to be said of it besides, with the comma before it.
    pub detail: &'static str,
}

impl FileContent {
    /// Content in some coordinates.
    pub fn new(coordinates: Coordinates, summary: Summary) -> Self {
        Self {
            coordinates,
            summary,
            detail: "",
        }
    }
}

#[derive(Serialize)]
struct Record<'a> {
    product: &'static str,
    what: String,
    program: &'a str,
    run: &'a str,
    bytes: Option<u64>,
    sha256: Option<&'a str>,
    inputs: Vec<Input>,
    /// How many logs of one survey it is of; absent of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    logs: Option<usize>,
    start_unix_s: Option<f64>,
    crs: Value,
    extent: Value,
    count: Map<String, Value>,
    values: Value,
    preset: &'static str,
    settings: Value,
    statement: &'a str,
}

/// Writes the record of a file beside it, as `NAME.json`; nothing for a file that has none. The report names the run, and the file
/// among its files.
///
/// # Errors
/// A sentence that names the file.
pub fn write_record(
    row: &OutputFile,
    content: &FileContent,
    report: &Report,
    more_inputs: &[Input],
    folder: &Path,
) -> Result<(), OutputError> {
    let (Some(described), Some(name)) = (row.record, row.record_name()) else {
        return Ok(());
    };
    let Summary {
        count,
        extent,
        values,
    } = content.summary;
    let extent = extent.map(|[[west, east], [south, north]]| {
        json!({ "west": west, "south": south, "east": east, "north": north })
    });
    let values = values.filter(|_| !described.measured.is_empty());
    let file = report.files.iter().find(|file| file.file == row.name);
    let record = Record {
        product: row.name,
        what: format!("{}{}", described.what, content.detail),
        program: &report.program,
        run: &report.run,
        bytes: file.map(|file| file.bytes),
        sha256: file.map(|file| file.sha256.as_str()),
        inputs: [report.inputs.as_slice(), more_inputs].concat(),
        logs: report.logs.as_ref().map(|all| all.logs.len()),
        start_unix_s: report.start_unix_s,
        crs: coordinates(&content.coordinates),
        extent: extent.unwrap_or(Value::Null),
        count: Map::from_iter([(described.counted.to_owned(), json!(count))]),
        values: values.map_or(
            Value::Null,
            |[least, most]| json!({ "of": described.measured, "least": least, "most": most }),
        ),
        preset: report.preset,
        settings: bearing(report, row.regardless_of)?,
        statement: &report.statement,
    };
    write_json(&folder.join(name), &record)
}

/// Writes a record, indented, with a line's end.
///
/// # Errors
/// A sentence that names the file.
pub fn write_json(path: &Path, record: &impl Serialize) -> Result<(), OutputError> {
    export::write_aside(path, |mut file| {
        let text = serde_json::to_vec_pretty(record)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(OutputError::from)
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

/// The settings that bear on a product.
fn bearing(report: &Report, regardless_of: &[&str]) -> Result<Value, OutputError> {
    // By way of text, which writes 0.3 for a number of 32 bits and not what 64 bits make of it.
    let text = serde_json::to_string(&report.settings);
    let parsed = text.and_then(|text| serde_json::from_str(&text));
    let mut settings: Value = parsed?;
    if let Some(table) = settings.as_object_mut() {
        table.retain(|key, _| !regardless_of.contains(&key.as_str()));
    }
    Ok(settings)
}
