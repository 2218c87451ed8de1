//! `comparison.json` and `comparison.csv`: a survey against a reference, in figures and point by point.

use super::record::{Coordinates, FileContent, write_json};
use super::results::Results;
use crate::bathymetry::compare::Comparison;
use crate::export::{self, Summary};
use crate::pipeline::{
    Agreement, Input, NamedComparison, Products, ResidualTables, Settings, matching_in_words,
};
use crate::survey::Survey;
use serde::Serialize;
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
    inputs: &'a [Input],
    notes: &'a [String],
}

const NO_REFERENCE: &str = "the survey was not held against a reference";
const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";
const MISSION: &str = "The reference is another mission, processed with the same settings.";
const POINTS: &str = "The reference is taken as it stands in its file.";
impl<'a> ComparisonRecord<'a> {
    /// Of an agreement with a reference, and the files that the reference was read from. The error is one sentence.
    pub fn new(
        survey: &Survey,
        products: &'a Products,
        agreement: &'a Agreement,
        inputs: &'a [Input],
    ) -> Result<Self, String> {
        let Some(reference) = &agreement.reference else {
            return Err(NO_REFERENCE.to_owned());
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
                inputs,
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

/// Writes `comparison.json`.
pub fn json(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (survey, products) = (results.survey, results.products);
    let agreement = results.agreement()?.ok_or(NO_REFERENCE)?;
    let inputs = results.reference_inputs()?;
    let record = ComparisonRecord::new(survey, products, agreement, inputs)?;
    write_json(path, &record)?;
    let summary = Summary {
        count: agreement.differences.len(),
        ..Summary::default()
    };
    Ok(FileContent::new(Coordinates::None, summary))
}

/// Writes `comparison.csv`.
pub fn csv(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let agreement = results.agreement()?.ok_or(NO_REFERENCE)?;
    write_differences(path, results.survey, results.products, agreement)
        .map(|points| FileContent::new(Coordinates::Degrees, points))
}
