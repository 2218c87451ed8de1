//! Writes what the depths give: the map and its uncertainty, isobaths and depth areas, storage, and the agreement of side-scan
//! with soundings. All in the system that `crs` names.

mod cells;
mod contours;
mod rasters;

use super::record::Made;
use super::{Product, residuals};
use crate::bathymetry::Surface;
use crate::pipeline::{NamedComparison, Plane, Products, comparisons, depth_surface};
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::Path;

/// What was written, and why the rest was not.
#[derive(Clone, Debug, Default)]
pub struct DepthWritten {
    /// Files, in the order of writing.
    pub made: Vec<Made>,
    /// Why something is missing, in sentences.
    pub warnings: Vec<String>,
    /// The depth map in the plane of the map, where something wanted shows it and there is one.
    pub surface: Option<Surface>,
    /// How side-scan agrees with the soundings, where that was wanted.
    pub comparisons: Vec<NamedComparison>,
}

/// Writes the wanted products of the depths into a folder that exists.
///
/// The error is one sentence. A cancelled run leaves whole files only.
pub fn write_depth(
    survey: &Survey,
    products: &Products,
    wanted: &[Product],
    folder: &Path,
    progress: &Progress,
) -> Result<DepthWritten, String> {
    let mut written = DepthWritten::default();
    let wants = |product| wanted.contains(&product);
    let plane = Plane::of(survey, products)?;
    let of_surface = [
        Product::Depth,
        Product::Xyz,
        Product::Isobaths,
        Product::Report,
    ];
    if of_surface.into_iter().any(wants) {
        let made = depth_surface(&plane, products, progress);
        match made.map_err(|error| error.to_string())? {
            Some(surface) => {
                if wants(Product::Depth) {
                    rasters::write(&surface, &plane, products, folder, progress, &mut written)?;
                }
                if wants(Product::Xyz) {
                    cells::write(&surface, &plane, folder, progress, &mut written)?;
                }
                if wants(Product::Isobaths) {
                    contours::write(&surface, &plane, products, folder, progress, &mut written)?;
                }
                written.surface = Some(surface);
            }
            None => written.warnings.push(
                "no depth map: the depths span no surface (a single straight line, or none near another within surface.max_gap_m)"
                    .to_owned(),
            ),
        }
    }
    if wants(Product::Residuals) || wants(Product::Report) {
        written.comparisons =
            comparisons(products, &plane, progress).map_err(|error| error.to_string())?;
    }
    if wants(Product::Residuals) {
        let comparisons = written.comparisons.clone();
        residuals::write(
            survey,
            products,
            &comparisons,
            folder,
            progress,
            &mut written,
        )?;
    }
    Ok(written)
}
