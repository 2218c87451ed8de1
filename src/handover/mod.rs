//! `report.html`: one page that an analyst attaches to an e-mail, with pictures, figures, settings and warnings in it.
//!
//! ```text
//! Survey, Products, Report, Surface --summary--> what was surveyed, how deep, how sure
//! Surface, isobaths, mosaic --plan--> maps with scale, graticule and legend, as SVG around a raster
//! Survey, FirstReturns --strip--> the log at a glance
//! all --page--> one HTML file that asks for nothing from elsewhere
//! ```
//!
//! Everything is drawn on the processor, so that a machine without a graphics adapter writes the same page.

mod chart;
mod depth_plan;
mod frame;
mod mosaic_plan;
mod objects;
mod page;
mod raster;
mod strip;
mod summary;
mod tables;
mod text;

pub use page::page;

use crate::bathymetry::Surface;
use crate::detection::Raster;
use crate::export::{ObjectRow, write_aside};
use crate::geo::MapPlane;
use crate::pipeline::{NamedComparison, Products, Report, Written};
use crate::progress::Progress;
use crate::survey::Survey;
use std::io::Write as _;
use std::path::Path;

/// The page's name in the folder of the products.
pub const NAME: &str = "report.html";

/// What the page tells of. Everything but the survey and its products may be missing: the page then says so.
pub struct Handover<'a> {
    /// The log.
    pub survey: &'a Survey,
    /// What the pipeline made of it.
    pub products: &'a Products,
    /// The record, with the warnings of every product.
    pub report: &'a Report,
    /// The plane of `surface`.
    pub map: &'a MapPlane,
    /// The depth map; `None` where the depths span none.
    pub surface: Option<&'a Surface>,
    /// How measured depths agree.
    pub comparisons: &'a [NamedComparison],
    /// Boxes with their places, and the raster that they were found in; `None` where nobody searched.
    pub objects: Option<Objects<'a>>,
    /// Files written beside the page.
    pub files: &'a [&'static str],
}

/// What lies there.
pub struct Objects<'a> {
    /// A line for each box.
    pub rows: &'a [ObjectRow<'a>],
    /// Where chips are cut from.
    pub raster: &'a Raster,
    /// How they came about: `proposed by the detector, not reviewed`.
    pub origin: String,
}

/// Writes `report.html` beside the products that were written into a folder. The error is one sentence; a cancelled run leaves
/// an old page as it was.
pub fn write_page(
    survey: &Survey,
    products: &Products,
    written: &Written,
    objects: Option<Objects<'_>>,
    folder: &Path,
    progress: &Progress,
) -> Result<(), String> {
    let from = Handover {
        survey,
        products,
        report: &written.report,
        map: &written.map,
        surface: written.surface.as_ref(),
        comparisons: &written.comparisons,
        objects,
        files: &written.files,
    };
    let html = page(&from, progress).map_err(|error| error.to_string())?;
    write_aside(&folder.join(NAME), |mut file| {
        file.write_all(html.as_bytes())
    })
    .map_err(|error| error.to_string())
}
