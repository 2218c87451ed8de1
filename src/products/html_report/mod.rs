//! `report.html`: one page that an analyst attaches to an e-mail, with pictures, figures, settings
//! and warnings in it.
//!
//! In: results of the logs, and their report. Out: the text of one HTML file.
//!
//! ```text
//! Survey, Products, Report, Surface --summary--> what was surveyed, how deep, how sure
//! Surface, isobaths, mosaic --plan--> maps with scale, graticule and legend, as SVG around a raster
//! Survey, FirstReturns --strip--> each log at a glance
//! LogsReport --logs--> the logs of a survey of several, and how they agree
//! all --page--> one HTML file that asks for nothing from elsewhere
//! ```
//!
//! Everything is drawn on the processor, so that a machine without a graphics adapter writes the
//! same page.

mod chart;
mod depth_plan;
mod document;
mod frame;
mod logs;
mod mosaic_plan;
mod objects;
mod raster;
mod strip;
mod summary;
mod tables;
mod targets;

pub(crate) use document::document;

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
/// says so.
pub(crate) struct ReportData<'a> {
    /// The logs, one or all of a survey, with what the pipeline made of them.
    pub logs: &'a [ProcessedLog],
    /// Name of each log.
    pub names: &'a [String],
    /// Name of the survey.
    pub title: String,
    /// The first log, in whose frame all lie.
    pub survey: &'a Survey,
    /// Results of the pipeline for the first log; its settings are those that all share.
    pub products: &'a Products,
    /// The record, with the warnings of every product.
    pub report: &'a Report,
    /// The plane of depth map and mosaic.
    pub map: &'a MapPlane,
    /// The depth map; `None` where the depths span none.
    pub depth_map: Option<&'a DepthMap>,
    /// Its isobaths.
    pub isobaths: &'a Isobaths,
    /// The mosaic; `None` where nothing is shown.
    pub mosaic: Option<&'a Mosaic>,
    /// Comparisons of measured depths with each other.
    pub comparisons: &'a [NamedComparison],
    /// Latency of the positions of each log; empty where no track crosses another, `None` for a log
    /// whose crossings do not determine it.
    pub latencies: &'a [Option<LogLatency>],
    /// Boxes with their places, and the raster that they were found in; `None` where nobody
    /// searched.
    pub objects: Option<ReportObjects<'a>>,
    /// Files of the same run, and what they are in a few words.
    pub files: &'a [FileLine],
}

/// The name of a file, and what it is.
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
    /// Passes of the boat that saw each target, and that covered its place, by its number.
    pub passes: &'a BTreeMap<u32, PassCount>,
    /// Origin of the boxes: `proposed by the detector, not reviewed`.
    pub origin: String,
}
