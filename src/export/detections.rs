//! `detections.csv`: what a detector found, one line a box.

use super::{ExportError, write_aside};
use crate::detection::{Detection, Scored};
use crate::survey::Survey;
use std::io::{BufWriter, Write};
use std::path::Path;

const SURVEY_HEADER: [&str; 18] = [
    "id",
    "file",
    "class",
    "score",
    "state",
    "side",
    "ping_from",
    "ping_to",
    "sample_from",
    "sample_to",
    "lon",
    "lat",
    "east_m",
    "north_m",
    "length_m",
    "width_m",
    "height_m",
    "depth_m",
];
const PICTURE_HEADER: [&str; 9] = [
    "id", "file", "class", "score", "state", "x_from", "x_to", "y_from", "y_to",
];

/// Writes what was found in a survey; `names` are the class names. `*_to` is the first ping or sample after the box; samples
/// are those of the middle ping. A field is empty where there is no value.
pub fn detections_csv(
    path: &Path,
    survey: &Survey,
    names: &[String],
    detections: &[Detection],
) -> Result<(), ExportError> {
    let file = survey.name();
    let rows = detections.iter().enumerate().map(|(index, found)| {
        let samples = found.mark.samples(survey);
        let mut row = beginning(index, &file, names, found.class, found.score);
        row.push(found.mark.side.name().to_owned());
        row.extend([found.mark.pings.start, found.mark.pings.end].map(|ping| ping.to_string()));
        row.extend([samples.start, samples.end].map(|sample| sample.to_string()));
        row.resize(SURVEY_HEADER.len(), String::new());
        row
    });
    table(path, &SURVEY_HEADER, rows)
}

/// Writes what was found in a picture of another program, in its pixels; `file` is the picture's name.
pub fn picture_detections_csv(
    path: &Path,
    file: &str,
    names: &[String],
    boxes: &[Scored],
) -> Result<(), ExportError> {
    let rows = boxes.iter().enumerate().map(|(index, found)| {
        let edges = [found.rect.x0, found.rect.x1, found.rect.y0, found.rect.y1];
        let mut row = beginning(index, file, names, found.class, found.score);
        row.extend(edges.map(|edge| format!("{edge:.2}")));
        row
    });
    table(path, &PICTURE_HEADER, rows)
}

/// The columns that every table begins with. Numbers count from 1; nobody has looked at a box yet.
fn beginning(index: usize, file: &str, names: &[String], class: usize, score: f32) -> Vec<String> {
    let class = names.get(class).map_or("", String::as_str);
    [
        &(index + 1).to_string(),
        file,
        class,
        &format!("{score:.4}"),
        "proposed",
    ]
    .map(str::to_owned)
    .to_vec()
}

fn table(
    path: &Path,
    header: &[&str],
    rows: impl Iterator<Item = Vec<String>>,
) -> Result<(), ExportError> {
    write_aside(path, |file| {
        let mut out = csv::Writer::from_writer(BufWriter::new(file));
        out.write_record(header)?;
        for row in rows {
            out.write_record(row)?;
        }
        out.flush()?;
        out.into_inner()
            .map_err(|error| error.into_error())?
            .flush()
    })
}
