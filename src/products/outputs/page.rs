//! `report.html`: what was made, on one page.

use super::detections::known_rows;
use super::objects::{ObjectRows, pass_log};
use super::registry::When;
use super::results::Results;
use super::write::Run;
use crate::detection::Raster;
use crate::detection::review::{PIXEL_M, Review, State};
use crate::detection::targets::PassLog;
use crate::pipeline::Crosslines;
use crate::pipeline::joint::JointObject;
use crate::products::export::write_aside;
use crate::products::html_report::{self, FileLine, Objects, ReportData, SeenObject};
use crate::products::outputs::OutputError;
use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::Path;

/// Writes the page.
pub fn write(run: &mut Run<'_>, path: &Path) -> Result<(), OutputError> {
    let results = &run.results;
    let (products, order) = (results.products, results.order);
    let boxes = Boxes::of(results)?;
    let objects = boxes.as_ref().map(|boxes| Objects {
        rows: &boxes.all.rows,
        rasters: &boxes.rasters,
        seen: &boxes.seen,
        origin: boxes.origin.clone(),
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
        logs: order.logs,
        names: &results.names,
        title: results.name(),
        survey: results.survey,
        products,
        report: &run.report,
        map: &results.plane.map,
        depth_map: results.depth_map()?.map(AsRef::as_ref),
        isobaths: &isobaths,
        mosaic: mosaic.as_deref(),
        comparisons: &comparisons,
        latencies: results.crossings()?.map_or(&[], Crosslines::latencies),
        objects,
        files: &files,
    };
    let html = html_report::document(&from, results.progress)?;
    write_aside(path, |mut file| file.write_all(html.as_bytes())).map_err(OutputError::from)
}

/// The boxes of all logs, as the page shows them.
struct Boxes<'a> {
    all: ObjectRows<'a>,
    /// Of each log that has boxes, what its pictures are cut from.
    rasters: Vec<Option<Raster>>,
    seen: Vec<SeenObject>,
    origin: String,
}

impl<'a> Boxes<'a> {
    /// Of each log those that were decided about, or else those that a search found; `None` where nobody looked.
    fn of(results: &'a Results<'_>) -> Result<Option<Self>, OutputError> {
        let order = results.order;
        let model = order.search.filter(|_| order.asks_for(When::Searched));
        let Some(mut all) = known_rows(results)? else {
            return Ok(None);
        };
        let mut rasters = Vec::with_capacity(order.logs.len());
        let mut reviews: Vec<(&str, &Review)> = Vec::new();
        for (index, log) in order.logs.iter().enumerate() {
            let raster = |pixel_m| Raster::new(&log.survey, &log.products.navigation, pixel_m);
            rasters.push(match (order.review(index), model) {
                (Some(review), _) => {
                    reviews.push((&results.names[index], review));
                    Some(raster(PIXEL_M))
                }
                (None, Some(model)) => Some(raster(model.pixel_m())),
                (None, None) => None,
            });
        }
        let shapes = match reviews.is_empty() {
            // The same boxes as in the tables of the search.
            true => results.found_shapes(&all)?.clone(),
            false => all.find_shapes(order.logs, results.progress)?,
        };
        all.set_shapes(&shapes);
        let seen = all.objects.iter().map(|object| seen(results, &all, object));
        Ok(Some(Self {
            seen: seen.collect(),
            origin: origin(&reviews, order.logs.len(), model.is_some()),
            all,
            rasters,
        }))
    }
}

/// What is known of an object from all its sightings.
fn seen(results: &Results<'_>, all: &ObjectRows<'_>, object: &JointObject) -> SeenObject {
    let track = &results.survey.track;
    let pass_logs: Vec<PassLog<'_>> = results.order.logs.iter().map(pass_log).collect();
    let [east_m, north_m] = object.place_m;
    let logs: BTreeSet<usize> = (object.members.iter())
        .map(|member| all.rows[*member].log)
        .collect();
    SeenObject {
        class: object.class.clone(),
        position: (results.products.navigation).to_lon_lat(track, east_m, north_m),
        sigma_m: object.sigma_m,
        height: object.height,
        passes: object.passes(&pass_logs),
        logs: logs.len(),
    }
}

/// Where the boxes come from: `Boxes of the review: 12 accepted, 1 added, 3 rejected, 4 undecided`.
fn origin(reviews: &[(&str, &Review)], logs: usize, is_searched: bool) -> String {
    let boxes = || reviews.iter().flat_map(|(_, review)| review.boxes());
    let count = |state: State| boxes().filter(|one| one.state == state).count();
    let mut parts = String::new();
    for (name, review) in reviews {
        if let Some(part) = review.coverage() {
            let of_log = match logs {
                1 => String::new(),
                _ => format!(" of {name}"),
            };
            parts += &format!(". The search{of_log} was stopped: it covers {part}");
        }
    }
    if count(State::Proposed) == boxes().count() {
        return format!("Proposed by the detector, not reviewed{parts}");
    }
    let rest = match logs - reviews.len() {
        0 => String::new(),
        1 if is_searched => ". The boxes of one log are not reviewed".to_owned(),
        rest if is_searched => format!(". The boxes of {rest} logs are not reviewed"),
        1 => ". One log has no boxes".to_owned(),
        rest => format!(". {rest} logs have no boxes"),
    };
    format!(
        "Boxes of the review: {} accepted, {} added, {} rejected, {} undecided{rest}{parts}",
        count(State::Accepted),
        count(State::Added),
        count(State::Rejected),
        count(State::Proposed)
    )
}
