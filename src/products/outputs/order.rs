//! Describes requests for the files of a run: the products of `bathyscope process --products`, the
//! conditions under which each file is written, and the logs whose files are written.

use crate::Error;
use crate::export::{LogPoints, ObjectLog};
use crate::pipeline::joint::RequestedCorrection;
use crate::pipeline::{Derived, ProcessedLog, Reference};
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_log::survey::distinct_names;
use bathyscope_objects::Model;
use bathyscope_objects::objects::SurveyReview;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

bathyscope_log::listed! {
    /// All products.
    const ALL;

    /// A group of files that `bathyscope process --products` chooses.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Product {
        /// The points.
        Cloud,
        /// The track of the boat, and the insonified ground.
        Track,
        /// The depth map as rasters.
        Depth,
        /// The depth map as text.
        Xyz,
        /// The depth map as a body and as points for 3D programs.
        Bottom,
        /// Isobaths, the areas between them, and area and volume below each level.
        Isobaths,
        /// The depth map as tiles for plotters and the web, and as a page.
        MapTiles,
        /// The side-scan mosaic.
        Mosaic,
        /// The differences between depths of different sources and passes.
        Residuals,
        /// The objects of the review.
        Targets,
        /// All lines, areas and objects in one file.
        Geopackage,
        /// The page that shows the results.
        Report,
    }
}

impl Product {
    /// Returns the name in `--products`.
    pub fn name(self) -> &'static str {
        self.description().0
    }

    /// Returns the name for people.
    pub fn title(self) -> &'static str {
        self.description().1
    }

    /// Returns the name in `--products`, the title, and the bytes of the files: in all, and for
    /// each point, ping, cell of the depth map and cell of the mosaic.
    pub(super) fn description(self) -> (&'static str, &'static str, [f64; 5]) {
        match self {
            Product::Cloud => ("cloud", "Point cloud", [0.0, 75.0, 0.0, 0.0, 0.0]),
            Product::Track => ("track", "Track and coverage", [20e3, 0.0, 45.0, 0.0, 0.0]),
            Product::Depth => ("depth", "Depth map (GeoTIFF)", [40e3, 0.0, 0.0, 12.0, 0.0]),
            Product::Xyz => ("xyz", "Depth grid as text (XYZ)", [0.0, 0.0, 0.0, 29.0, 0.0]),
            Product::Bottom => ("bottom", "Bottom for 3D programs", [0.0, 0.0, 0.0, 90.0, 1.2]),
            Product::Isobaths => {
                ("isobaths", "Isobaths, depth areas, volumes", [60e3, 0.0, 0.0, 15.0, 0.0])
            }
            Product::MapTiles => {
                ("map-tiles", "Depth map for plotters and the web", [170e3, 0.0, 0.0, 8.0, 0.0])
            }
            Product::Mosaic => ("mosaic", "Side-scan mosaic (GeoTIFF)", [0.0, 0.0, 0.0, 0.0, 1.0]),
            Product::Residuals => ("residuals", "Residuals", [25e3, 0.0, 0.0, 0.0, 0.0]),
            Product::Targets => {
                ("targets", "Objects that were accepted", [20e3, 0.0, 0.0, 0.0, 0.0])
            }
            Product::Geopackage => {
                ("geopackage", "All lines and areas (GeoPackage)", [200e3, 0.0, 5.0, 10.0, 0.0])
            }
            Product::Report => ("report", "Report (HTML)", [250e3, 0.0, 0.0, 0.0, 0.1]),
        }
    }
}

/// Condition under which a run writes a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// The file is written by every run.
    Always,
    /// The file belongs to a chosen product.
    Chosen(Product),
    /// The file is written by a run that compares with a reference.
    Compared,
    /// The file is written by a run that searches for objects.
    Searched,
    /// The file is written by a run that searches for objects or has a review of them.
    Listed,
}

/// Request for the files of a run: logs, products, and an optional comparison and search.
pub struct Order<'a> {
    /// The logs whose files are written, with their results of the pipeline: one log, or all logs
    /// of a survey in the local coordinate frame of the first.
    pub logs: &'a [ProcessedLog],
    /// Results that are computed from all logs together, each once.
    pub derived: &'a Derived,
    /// Products to write in addition to the tables of pings and points, `report.json` and the
    /// manifest.
    pub requested: &'a [Product],
    /// Reference that the depths are compared with, and how a point finds its reference.
    pub reference: Option<(&'a Arc<Reference>, Matching)>,
    /// Model that searches for objects: these are written as `detections.*` and `chips`.
    pub search: Option<&'a Model>,
    /// Boxes of each log that were found before and decided about: the report shows them, before
    /// those of a search.
    pub review: &'a SurveyReview,
    /// Results of the requested corrections of positions and heights: the report lists them.
    pub corrections: &'a [RequestedCorrection],
}

impl Order<'_> {
    /// Returns true if files that are written at such a time are to be written.
    pub(super) fn asks_for(&self, when: When) -> bool {
        match when {
            When::Always => true,
            When::Chosen(product) => self.requested.contains(&product),
            When::Compared => self.reference.is_some(),
            // Without side-scan there is nothing to search.
            When::Searched => {
                let mut surveys = self.logs.iter().map(|log| &log.survey);
                self.search.is_some() && surveys.any(|survey| survey.has_side_scan())
            }
            When::Listed => self.review.has_boxes() || self.asks_for(When::Searched),
        }
    }
}

/// Checks that the logs still hold what files were made of: done when all files are made, before
/// they are put in place.
///
/// # Errors
/// Names a log that does not.
pub(super) fn check_logs(logs: &[ProcessedLog]) -> Result<(), Error> {
    let mut surveys = logs.iter().map(|log| &log.survey);
    Ok(surveys.try_for_each(|survey| survey.check_files())?)
}

/// Returns the names of the logs: [`distinct_names`].
pub fn log_names(logs: &[ProcessedLog]) -> Vec<String> {
    distinct_names(logs.iter().map(|log| &*log.survey))
}

/// Returns the name of a survey: the names of its logs, or the first and the last of more than
/// three.
pub(super) fn survey_name(names: &[String]) -> String {
    match names {
        [first, .., last] if names.len() > 3 => format!("{first} to {last} ({} logs)", names.len()),
        names => names.join(", "),
    }
}

/// Returns the points of each log, from which tables and clouds are written.
pub(super) fn log_points<'a>(logs: &'a [ProcessedLog], names: &'a [String]) -> Vec<LogPoints<'a>> {
    let points = |(name, log): (&'a String, &'a ProcessedLog)| {
        let products = &log.products;
        LogPoints {
            name,
            survey: &log.survey,
            navigation: &products.navigation,
            returns: &products.returns,
            calibration: &products.calibration,
            reduction: products.reduction(),
            exclusions: &products.exclusions,
            cloud: &products.cloud,
            classes: &products.classes,
        }
    };
    names.iter().zip(logs).map(points).collect()
}

/// Returns the logs with the names that tables of boxes use.
pub(super) fn object_logs<'a>(logs: &'a [ProcessedLog], names: &'a [String]) -> Vec<ObjectLog<'a>> {
    let named = names.iter().zip(logs);
    named.map(|(name, log)| ObjectLog { name, survey: &log.survey }).collect()
}
