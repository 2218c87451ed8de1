//! `report.html`: what was made, on one page.

use super::boxes::reviewed_rows;
use super::detections::proposed_rows;
use super::registry::When;
use super::write::Run;
use crate::detection::Raster;
use crate::detection::review::{Review, State};
use crate::export::{ObjectRow, write_aside};
use crate::html_report::{self, FileLine, Objects, ReportData};
use std::io::Write as _;
use std::path::Path;

/// Writes the page.
pub fn write(run: &mut Run<'_>, path: &Path) -> Result<(), String> {
    let results = &run.results;
    let (survey, products, order) = (results.survey, results.products, results.order);
    let searched: Raster;
    let model = order.search.filter(|_| order.asks_for(When::Searched));
    let found = model.zip(results.found()?);
    let boxes: Option<(Vec<ObjectRow<'_>>, &Raster, String)> = match (order.review, found) {
        (Some((review, raster)), _) => {
            let rows = reviewed_rows(survey, products, review, results.progress)?;
            Some((rows, raster, summary(review)))
        }
        (None, Some((model, found))) => {
            let rows = proposed_rows(survey, products, model.names(), found);
            searched = Raster::new(survey, &products.navigation, model.pixel_m());
            let origin = "Proposed by the detector, not reviewed".to_owned();
            Some((rows, &searched, origin))
        }
        (None, None) => None,
    };
    let objects = boxes.as_ref().map(|(rows, raster, origin)| Objects {
        rows,
        raster,
        origin: origin.clone(),
    });
    let mut comparisons = results.comparisons()?.to_vec();
    if let Some(agreement) = results.agreement()? {
        comparisons.extend(agreement.by_source(order.logs));
    }
    // Too many levels were refused with a warning when the isobaths were written.
    let isobaths = results.isobaths()?.unwrap_or_default();
    let mosaic = results.mosaic()?;
    let files: Vec<FileLine> = run.listed().map(|row| (row.name, row.brief)).collect();
    let from = ReportData {
        survey,
        products,
        report: &run.report,
        map: &results.plane.map,
        depth_map: results.depth_map()?.map(AsRef::as_ref),
        isobaths: &isobaths,
        mosaic: mosaic.as_deref(),
        comparisons: &comparisons,
        objects,
        files: &files,
    };
    let html = html_report::document(&from, results.progress).map_err(|error| error.to_string())?;
    write_aside(path, |mut file| file.write_all(html.as_bytes())).map_err(|error| error.to_string())
}

/// How far a review has come: `Boxes of the review: 12 accepted, 1 added, 3 rejected, 4 undecided`.
fn summary(review: &Review) -> String {
    let count = |state: State| review.boxes().filter(|one| one.state == state).count();
    let part = match review.coverage() {
        Some(part) => format!(". The search was stopped: it covers {part}"),
        None => String::new(),
    };
    if count(State::Proposed) == review.boxes().len() {
        return format!("Proposed by the detector, not reviewed{part}");
    }
    format!(
        "Boxes of the review: {} accepted, {} added, {} rejected, {} undecided{part}",
        count(State::Accepted),
        count(State::Added),
        count(State::Rejected),
        count(State::Proposed)
    )
}
