//! The record beside a product: `depth.tif.json` tells where `depth.tif` comes from and how far it goes.

use crate::export::{self, Summary};
use crate::geo::{Crs, LonLat};
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

/// A product that was written.
#[derive(Clone, Debug)]
pub struct Made {
    /// Its file.
    pub name: &'static str,
    /// What it is, in a sentence without its full stop.
    pub what: &'static str,
    /// What its coordinates are.
    pub coordinates: Coordinates,
    /// What is counted: `points`.
    pub counted: &'static str,
    /// What is measured, with its unit: `depth_m`; empty where nothing is.
    pub measured: &'static str,
    /// How much it holds.
    pub summary: Summary,
    /// Settings, by their first word, that have nothing to do with it.
    pub regardless_of: &'static [&'static str],
}

#[derive(Serialize)]
struct Record<'a> {
    product: &'static str,
    what: &'static str,
    program: &'a str,
    run: &'a str,
    bytes: Option<u64>,
    sha256: Option<&'a str>,
    inputs: &'a [Input],
    start_unix_s: Option<f64>,
    crs: Value,
    extent: Value,
    count: Map<String, Value>,
    values: Value,
    preset: &'static str,
    settings: Value,
    statement: &'a str,
}

/// Writes the record of a product beside it, as `NAME.json`. The report names the run, and the product among its files.
///
/// # Errors
/// A sentence that names the file.
pub fn write_record(made: &Made, report: &Report, folder: &Path) -> Result<(), String> {
    let Summary {
        count,
        extent,
        values,
    } = made.summary;
    let extent = extent.map(|[[west, east], [south, north]]| {
        json!({ "west": west, "south": south, "east": east, "north": north })
    });
    let values = values.filter(|_| !made.measured.is_empty());
    let file = report.files.iter().find(|file| file.file == made.name);
    let record = Record {
        product: made.name,
        what: made.what,
        program: &report.program,
        run: &report.run,
        bytes: file.map(|file| file.bytes),
        sha256: file.map(|file| file.sha256.as_str()),
        inputs: &report.inputs,
        start_unix_s: report.start_unix_s,
        crs: coordinates(&made.coordinates),
        extent: extent.unwrap_or(Value::Null),
        count: Map::from_iter([(made.counted.to_owned(), json!(count))]),
        values: values.map_or(
            Value::Null,
            |[least, most]| json!({ "of": made.measured, "least": least, "most": most }),
        ),
        preset: report.preset,
        settings: bearing(report, made.regardless_of)?,
        statement: &report.statement,
    };
    export::write_aside(&folder.join(format!("{}.json", made.name)), |mut file| {
        let text = serde_json::to_vec_pretty(&record)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(|error| error.to_string())
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
fn bearing(report: &Report, regardless_of: &[&str]) -> Result<Value, String> {
    // By way of text, which writes 0.3 for a number of 32 bits and not what 64 bits make of it.
    let text = serde_json::to_string(&report.settings);
    let parsed = text.and_then(|text| serde_json::from_str(&text));
    let mut settings: Value = parsed.map_err(|error| error.to_string())?;
    if let Some(table) = settings.as_object_mut() {
        table.retain(|key, _| !regardless_of.contains(&key.as_str()));
    }
    Ok(settings)
}
