//! Sizes of the files that the export dialog states before they are written.

use crate::truth::{KnownSurvey, results};
use crate::written;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::{Amounts, Product, When, about_bytes, row_of};
use bathyscope_products::pipeline::{DepthMap, ProcessedLog, Settings};
use bathyscope_simulation::Scene;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// Returns the bytes of the files in a folder and below it whose rows in the table of files meet a
/// condition.
fn bytes_of(folder: &Path, below: &str, is_one: &impl Fn(When) -> bool) -> u64 {
    let entries = fs::read_dir(folder.join(below)).expect("a folder").flatten();
    let bytes = entries.map(|entry| {
        let name = entry.file_name().into_string().expect("a plain name");
        let name = if below.is_empty() { name } else { format!("{below}/{name}") };
        if entry.path().is_dir() {
            return bytes_of(folder, &name, is_one);
        }
        let is_one = row_of(&name).is_some_and(|row| is_one(row.when));
        if is_one { entry.metadata().expect("a file").len() } else { 0 }
    });
    bytes.sum()
}

/// A new product whose bytes nobody has measured fails here. Lines that cross and the even bottom
/// of a simulation make a mosaic smaller than the coefficients, which are those of real surveys.
#[test]
fn no_file_is_much_larger_or_smaller_than_stated() {
    let survey = KnownSurvey::new(&Scene::default(), 1).survey;
    let products = results(&survey, &Settings::default());
    let logs = [ProcessedLog { survey: Arc::new(survey), products }];
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path().join("out");
    written(&logs, &Product::ALL, &SurveyReview::default(), &folder);
    let depth_map = DepthMap::new(&logs, &Progress::new()).expect("nobody cancels");
    let amounts = Amounts::of(&logs, depth_map.as_ref());
    let mut wrong = Vec::new();
    for product in std::iter::once(None).chain(Product::ALL.map(Some)) {
        let stated = about_bytes(product, &amounts);
        let when = product.map_or(When::Always, When::Chosen);
        if product == Some(Product::Targets) {
            // Without a review there are none.
            continue;
        }
        let written = bytes_of(&folder, "", &|of_row| of_row == when);
        if stated > 5 * written || written > 2 * stated {
            wrong.push(format!("{product:?}: {stated} stated, {written} written"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
