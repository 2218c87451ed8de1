//! Makes `report.html`: one page that an analyst attaches to an e-mail, with pictures, figures,
//! settings and warnings in it.
//!
//! In: results of the logs, and their report. Out: the text of one HTML file.
//!
//! ```text
//! Survey, Products, Report, Surface --summary--> what was surveyed, how deep, how sure
//! Surface, isobaths, mosaic --plan--> maps with scale, graticule and legend around a raster
//! Survey, FirstReturns --strip--> each log at a glance
//! LogsReport --logs--> the logs of a survey of several, and how they agree
//! all --templates--> one HTML file that loads nothing from elsewhere
//! ```
//!
//! The code returns values: numbers with their decimals, places on the page in pixels. What the
//! page says, its order and its style are in the folder `templates`.
//!
//! Everything is drawn on the processor, so that a machine without a graphics adapter writes the
//! same page.

mod chart;
mod depth_plan;
mod document;
mod frame;
mod logs;
mod map;
mod mosaic_plan;
mod objects;
mod raster;
mod strip;
mod summary;
mod tables;
mod targets;

pub(crate) use document::{document, values};

use crate::pipeline::LogLatency;
use crate::pipeline::{
    DepthMap, Isobaths, Mosaic, NamedComparison, ProcessedLog, Products, Report,
};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::survey::Survey;
use bathyscope_objects::Raster;
use bathyscope_objects::objects::{ListedObject, ObjectBox, ObjectList};
use bathyscope_objects::targets::PassCount;
use std::collections::BTreeMap;

/// Content of the report. Everything but the survey and its results may be missing; the report then
/// states this.
pub(crate) struct ReportData<'a> {
    /// The logs, one or all of a survey, with their results of the pipeline.
    pub logs: &'a [ProcessedLog],
    /// Name of each log.
    pub names: &'a [String],
    /// Name of the survey.
    pub title: String,
    /// The first log, whose local coordinate frame all logs share.
    pub survey: &'a Survey,
    /// Results of the pipeline for the first log; its settings are those that all logs share.
    pub products: &'a Products,
    /// The record, with the warnings of every product.
    pub report: &'a Report,
    /// The plane of the depth map and the mosaic.
    pub map: &'a MapPlane,
    /// The depth map; `None` where the depths span no surface.
    pub depth_map: Option<&'a DepthMap>,
    /// Isobaths of the depth map.
    pub isobaths: &'a Isobaths,
    /// The mosaic; `None` where no log has echoes with a place.
    pub mosaic: Option<&'a Mosaic>,
    /// Comparisons of measured depths with each other.
    pub comparisons: &'a [NamedComparison],
    /// Latency of the positions of each log; empty where no track crosses another, `None` for a log
    /// whose crossings do not determine it.
    pub latencies: &'a [Option<LogLatency>],
    /// Boxes with their places, and the rasters that they were found in; `None` without a search or
    /// a review.
    pub objects: Option<ReportObjects<'a>>,
    /// Files of the same run with short descriptions.
    pub files: &'a [FileLine],
}

/// Name and short description of a file.
pub(crate) type FileLine = (&'static str, &'static str);

/// Objects on the bottom, as the report shows them.
pub(crate) struct ReportObjects<'a> {
    /// All boxes and objects.
    pub list: &'a ObjectList,
    /// The boxes of targets.
    pub boxes: Vec<&'a ObjectBox>,
    /// The targets.
    pub listed: Vec<ListedObject<'a>>,
    /// Rasters from which chips of each log are cut; `None` for a log without boxes.
    pub rasters: &'a [Option<Raster>],
    /// Numbers of passes of the boat that saw each target and that covered its place, by the number
    /// of the target.
    pub passes: &'a BTreeMap<u32, PassCount>,
    /// Origin of the boxes: `proposed by the detector, not reviewed`.
    pub origin: String,
}
