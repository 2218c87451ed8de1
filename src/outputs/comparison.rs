//! `comparison.json` and `comparison.csv`: a survey against a reference, in figures and point by point.

use super::record::{Coordinates, Made};
use crate::bathymetry::compare::Comparison;
use crate::export::{self, Summary};
use crate::pipeline::{
    Agreement, Input, NamedComparison, Products, ResidualTables, Settings, matching_in_words,
};
use crate::progress::Progress;
use crate::survey::Survey;
use serde::Serialize;
use std::io::Write as _;
use std::path::Path;

/// What is written and printed about a survey against a reference.
#[derive(Debug, Serialize)]
pub struct ComparisonRecord<'a> {
    program: String,
    sign: &'static str,
    statement: String,
    measured_file: String,
    reference_file: String,
    reference: ReferenceRecord<'a>,
    by: String,
    #[serde(flatten)]
    comparison: &'a Comparison,
    /// The same for each source of points.
    sources: Vec<NamedComparison>,
    #[serde(flatten)]
    tables: &'a ResidualTables,
    settings: &'a Settings,
}

#[derive(Debug, Serialize)]
struct ReferenceRecord<'a> {
    /// `mission` or `points`.
    kind: &'static str,
    inputs: Vec<Input>,
    notes: &'a [String],
}

const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";
const MISSION: &str = "The reference is another mission, processed with the same settings.";
const POINTS: &str = "The reference is taken as it stands in its file.";
/// What a comparison does not depend on.
const REGARDLESS_OF: [&str; 3] = ["detector", "isobaths", "mosaic"];

impl<'a> ComparisonRecord<'a> {
    /// Of an agreement with a reference; reads every byte of the reference once for its hash. The error is one sentence.
    pub fn new(
        survey: &Survey,
        products: &'a Products,
        agreement: &'a Agreement,
        progress: &Progress,
    ) -> Result<Self, String> {
        let Some(reference) = &agreement.reference else {
            return Err("the survey was not held against a reference".to_owned());
        };
        let (kind, how) = match reference.is_mission() {
            true => ("mission", MISSION),
            false => ("points", POINTS),
        };
        let log = survey.source.files.first();
        Ok(Self {
            program: format!("bathyscope {}", env!("CARGO_PKG_VERSION")),
            sign: SIGN,
            statement: format!("{} {how}", products.correction.statement()),
            measured_file: log.map_or_else(String::new, |log| log.display().to_string()),
            reference_file: reference.path().display().to_string(),
            reference: ReferenceRecord {
                kind,
                inputs: reference.inputs(progress)?,
                notes: &reference.notes,
            },
            by: matching_in_words(agreement.matching),
            comparison: &agreement.comparison,
            sources: agreement.by_source(products),
            tables: &agreement.tables,
            settings: &products.settings,
        })
    }

    /// How a point found its reference, in words.
    pub fn by(&self) -> &str {
        &self.by
    }
}

/// Writes the points and how they differ, as CSV. The error is one sentence.
pub fn write_differences(
    path: &Path,
    survey: &Survey,
    products: &Products,
    agreement: &Agreement,
) -> Result<Summary, String> {
    let (navigation, cloud) = (&products.navigation, &agreement.cloud);
    export::differences_csv(path, survey, navigation, cloud, &agreement.differences)
        .map_err(|error| error.to_string())
}

/// Writes `comparison.json` and `comparison.csv` into a folder that exists; gives back what they are, and the files that the reference
/// was read from.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled.
pub fn write_comparison(
    survey: &Survey,
    products: &Products,
    agreement: &Agreement,
    folder: &Path,
    progress: &Progress,
) -> Result<(Vec<Made>, Vec<Input>), String> {
    let record = ComparisonRecord::new(survey, products, agreement, progress)?;
    let (json, csv) = ("comparison.json", "comparison.csv");
    export::write_aside(&folder.join(json), |mut file| {
        let text = serde_json::to_vec_pretty(&record)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(|error| error.to_string())?;
    let points = write_differences(&folder.join(csv), survey, products, agreement)?;
    let made = vec![
        Made {
            name: json,
            what: "The survey against a reference",
            coordinates: Coordinates::None,
            counted: "points",
            measured: "",
            summary: Summary {
                count: points.count,
                ..Summary::default()
            },
            regardless_of: &REGARDLESS_OF,
        },
        Made {
            name: csv,
            what: "Points of the survey with the elevation of the reference there; measured minus reference, positive is shallower",
            coordinates: Coordinates::Degrees,
            counted: "points",
            measured: "difference_m",
            summary: points,
            regardless_of: &REGARDLESS_OF,
        },
    ];
    Ok((made, record.reference.inputs))
}
