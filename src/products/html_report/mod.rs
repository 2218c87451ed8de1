//! Makes `report.html`: one page that an analyst attaches to an e-mail, with pictures, figures,
//! settings and warnings in it.
//!
//! In: results of the logs, and their report. Out: the text of one HTML file.
//!
//! ```text
//! Survey, Products, Report, Surface --summary--> what was surveyed, how deep, how sure
//! Surface, isobaths, mosaic --plan--> maps with scale, graticule and legend around a raster
//! Survey, FirstReturns --strip--> each log at a glance
//! LogsReport --summary--> the logs of a survey of several, and how they agree
//! all --templates--> one HTML file that loads nothing from elsewhere
//! ```
//!
//! The code returns values: numbers with their decimals, places on the page in pixels. What the
//! page says, its order and its style are in the folder `templates`.
//!
//! Everything is drawn on the processor, so that a machine without a graphics adapter writes the
//! same page.

mod frame;
mod maps;
mod objects;
mod strip;
mod summary;
mod tables;

use crate::Error;
use crate::pipeline::{
    DepthMap, Isobaths, LogLatency, Mosaic, NamedComparison, ProcessedLog, Products, Report,
};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bathyscope_bottom::presentation::page::{Template, Value, context, fill};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use bathyscope_objects::Raster;
use bathyscope_objects::objects::{ListedObject, ObjectBox, ObjectList};
use bathyscope_objects::targets::PassCount;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};
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
    pub rasters: Vec<Option<Raster>>,
    /// Numbers of passes of the boat that saw each target and that covered its place, by the number
    /// of the target.
    pub passes: BTreeMap<u32, PassCount>,
    /// Origin of the boxes: `proposed by the detector, not reviewed`.
    pub origin: String,
}

/// Makes a template of a file in the folder `templates`.
macro_rules! template {
    ($name:literal) => {
        ($name, include_str!(concat!("templates/", $name)))
    };
}

/// The page and what it includes.
const TEMPLATES: [Template<'static>; 13] = [
    template!("report.html"),
    template!("report.css"),
    template!("summary.html"),
    template!("logs.html"),
    template!("map.html"),
    template!("strips.html"),
    template!("strip.html"),
    template!("objects.html"),
    template!("targets.html"),
    template!("picture.html"),
    template!("trust.html"),
    template!("method.html"),
    template!("files.html"),
];

/// Largest number of logs that are drawn one by one: with more, the page would be too large to
/// send.
const MOST_STRIPS: usize = 12;
/// JPEG quality of noisy pictures: speckle hides the losses.
const JPEG_QUALITY: u8 = 82;

/// Returns the self-contained document: it loads no script, font or picture from elsewhere.
///
/// # Errors
/// When a template names a value that is not given, or the work was cancelled.
pub(crate) fn page(from: &ReportData<'_>, progress: &Progress) -> Result<String, Error> {
    let sections = context! {
        ..summary::values(from),
        ..tables::trust(from),
        ..tables::method(from),
        ..tables::files(from),
    };
    let values = context! {
        title => &from.title,
        warnings => &from.report.warnings,
        logs => summary::logs(from),
        depth_plan => maps::depth_plan(from, progress)?,
        storage => summary::levels(from),
        mosaic_plan => maps::mosaic_plan(from, progress)?,
        strips => strips(from, progress)?,
        strips_left_out => from.logs.len().saturating_sub(MOST_STRIPS),
        objects => objects::values(from, progress)?,
        targets => objects::sections(from, progress)?,
        ..sections
    };
    Ok(fill(&TEMPLATES, values)?)
}

/// Draws the pictures of the logs.
fn strips(from: &ReportData<'_>, progress: &Progress) -> Result<Vec<Value>, Cancelled> {
    let mut strips = Vec::new();
    for (log, name) in from.logs.iter().zip(from.names).take(MOST_STRIPS) {
        strips.extend(strip::strip(log, name, progress)?);
    }
    Ok(strips)
}

/// Encodes pixels of 4 bytes, row by row, as the address of a PNG.
fn png_address(pixels: &[u8], width: usize, height: usize) -> String {
    let mut png = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive);
    let written =
        encoder.write_image(pixels, width as u32, height as u32, ExtendedColorType::Rgba8);
    address("image/png", written.is_ok().then_some(png))
}

/// Encodes pixels of one byte, row by row, as the address of a JPEG.
fn jpeg_address(pixels: &[u8], width: usize, height: usize) -> String {
    let mut jpeg = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY);
    let written = encoder.write_image(pixels, width as u32, height as u32, ExtendedColorType::L8);
    address("image/jpeg", written.is_ok().then_some(jpeg))
}

/// Returns the address of a picture; empty where encoding failed, so that the page shows the
/// description instead.
fn address(kind: &str, picture: Option<Vec<u8>>) -> String {
    picture.map_or_else(String::new, |picture| {
        format!("data:{kind};base64,{}", STANDARD.encode(picture))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_from_its_address() {
        let pixels: Vec<u8> = (0..6 * 5 * 4).map(|byte| byte as u8 * 2).collect();
        let text = png_address(&pixels, 6, 5);
        let encoded = text.strip_prefix("data:image/png;base64,").unwrap();
        let back = image::load_from_memory(&STANDARD.decode(encoded).unwrap()).unwrap();
        assert_eq!(back.to_rgba8().into_raw(), pixels);
    }

    #[test]
    fn a_picture_that_cannot_be_made_has_no_address() {
        assert_eq!(address("image/png", None), "");
    }
}
