//! Writes what the depths give: the map and its uncertainty, isobaths and depth areas, storage, and the agreement of side-scan
//! with soundings. All in the UTM zone of the survey's first fix.

mod chart;
mod plane;
mod rasters;
mod residuals;

use super::Products;
use crate::bathymetry::Surface;
use crate::bathymetry::isobaths::{depth_areas, isobaths, storage};
use crate::export::{self, ExportError};
use crate::progress::Progress;
use crate::survey::Survey;
use plane::Plane;
pub use residuals::NamedComparison;
use std::path::Path;

pub use chart::DepthChart;

/// A group of files that `bathyscope process --products` chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Product {
    /// depth.tif, uncertainty.tif, distance.tif
    Depth,
    /// isobaths.geojson, depth_areas.geojson, storage.csv
    Isobaths,
    /// mosaic.tif
    Mosaic,
    /// residuals.json
    Residuals,
    /// report.html, which shows what was made
    Report,
}

impl Product {
    /// All of them.
    pub const ALL: [Product; 5] = [
        Product::Depth,
        Product::Isobaths,
        Product::Mosaic,
        Product::Residuals,
        Product::Report,
    ];
}

/// What was written, and why the rest was not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthWritten {
    /// File names, in the order of writing.
    pub files: Vec<&'static str>,
    /// Why something is missing, in sentences.
    pub warnings: Vec<String>,
    /// The depth map in the UTM zone of the survey's first fix, where something wanted shows it and there is one.
    pub surface: Option<Surface>,
    /// How side-scan agrees with the soundings, where that was wanted.
    pub comparisons: Vec<NamedComparison>,
}

/// Writes the wanted products of the depths into a folder that exists; mosaics are left to [`super::write_mosaic`].
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
    let plane = Plane::of(survey, products);
    if wants(Product::Depth) || wants(Product::Isobaths) || wants(Product::Report) {
        let made = chart::depth_surface(&plane, products, progress);
        match made.map_err(|error| error.to_string())? {
            Some(surface) => {
                if wants(Product::Depth) {
                    rasters::write(&surface, &plane, products, folder, progress, &mut written)?;
                }
                if wants(Product::Isobaths) {
                    write_isobaths(&surface, &plane, products, folder, progress, &mut written)?;
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
        written.comparisons = residuals::comparisons(products, &plane, progress)
            .map_err(|error| error.to_string())?;
    }
    if wants(Product::Residuals) {
        let comparisons = written.comparisons.clone();
        residuals::write(products, &comparisons, folder, &mut written)?;
    }
    Ok(written)
}

fn write_isobaths(
    surface: &Surface,
    plane: &Plane<'_>,
    products: &Products,
    folder: &Path,
    progress: &Progress,
    written: &mut DepthWritten,
) -> Result<(), String> {
    let settings = &products.settings.isobaths;
    let range_m = surface.range_m();
    let levels_m = match settings.levels_m(range_m) {
        Ok(levels_m) => levels_m,
        Err(error) => {
            written.warnings.push(error.to_string());
            return Ok(());
        }
    };
    let lines = isobaths(surface, &levels_m, progress).map_err(|error| error.to_string())?;
    let areas = depth_areas(surface, &with_ends(&levels_m, range_m), progress)
        .map_err(|error| error.to_string())?;
    let table = storage(surface, &with_ends(&levels_m, range_m));
    let place = |at| plane.to_lon_lat(at);
    // A map's square metres are not quite those of the ground.
    let ground = plane
        .scale_at(
            surface
                .grid
                .centre(surface.grid.rows / 2, surface.grid.columns / 2),
        )
        .powi(-2);
    let fail = |error: ExportError| error.to_string();
    export::isobaths_geojson(
        &folder.join("isobaths.geojson"),
        &lines,
        settings.smooth,
        place,
    )
    .map_err(fail)?;
    export::depth_areas_geojson(&folder.join("depth_areas.geojson"), &areas, ground, place)
        .map_err(fail)?;
    export::storage_csv(&folder.join("storage.csv"), &table, ground).map_err(fail)?;
    written
        .files
        .extend(["isobaths.geojson", "depth_areas.geojson", "storage.csv"]);
    Ok(())
}

/// The levels, with the shallowest and what is just beyond the deepest depth around them, so that the areas cover all.
fn with_ends(levels_m: &[f64], [least_m, most_m]: [f64; 2]) -> Vec<f64> {
    let within = levels_m
        .iter()
        .copied()
        .filter(|level| *level > least_m && *level <= most_m);
    let beyond_m = most_m.next_up();
    std::iter::once(least_m)
        .chain(within)
        .chain([beyond_m])
        .collect()
}
