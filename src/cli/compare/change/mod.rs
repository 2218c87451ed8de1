//! `bathyscope compare NEW OLD --change DIR`: computes how the bottom changed between two depth
//! maps.
//!
//! In: two depth maps: folders of `process`, archives or GeoTIFFs. Out: files of the difference,
//! and lines of text.

mod maps;
mod record;

use super::CompareArgs;
use crate::cli::status_line::StatusLine;
use crate::cli::{Failure, output};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::bathymetry::change::{
    CellChange, ChangeErrors, ChangeField, ChangeRegion, ChangeTotals,
};
use bathyscope_bottom::presentation::colours::{
    difference_colour, difference_reach_m, uncertainty_colour,
};
use bathyscope_log::formats::geotiff::{Band, RasterSpec};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::statistics::median;
use bathyscope_products::Error;
use bathyscope_products::export::{
    ExportError, make_folder, metres_raster, qgis_style, write_bytes, write_json,
};
use maps::{DepthMaps, DepthPart};
use rayon::prelude::*;
use record::ChangeRecord;
use std::path::{Path, PathBuf};

/// Number of colour steps in a style.
const STEPS: usize = 16;

/// Options of a comparison of two depth maps.
#[derive(Debug, clap::Args)]
pub(super) struct ChangeArgs {
    /// Compare two depth maps in place of points, the newer one first: a folder of `process`, an
    /// archive, or a GeoTIFF. Writes into this folder how much each cell rose, the level of
    /// detection, and the volumes of fill and cut
    #[arg(long, value_name = "DIR", conflicts_with_all = ["output", "by", "radius", "max_gap", "water_level"])]
    change: Option<PathBuf>,
    /// Standard deviation of the error that all cells of one map share against the other, such as
    /// draft and water level, metres (with --change)
    #[arg(long, value_name = "METRES", default_value_t = 0.03, value_parser = parse_error, requires = "change")]
    systematic: f64,
    /// Distance from which on the errors of two depths are independent, metres; less where cells
    /// without a change show it (with --change)
    #[arg(long, value_name = "METRES", default_value_t = 20.0, value_parser = parse_error, requires = "change")]
    error_range: f64,
}

fn parse_error(text: &str) -> Result<f64, &'static str> {
    let metres = text.parse().ok();
    metres
        .filter(|metres: &f64| *metres >= 0.0 && metres.is_finite())
        .ok_or("an error is a number that is not below 0")
}

impl ChangeArgs {
    /// Returns the folder for the change between maps; `None` where points are compared.
    pub(super) fn folder(&self) -> Option<&Path> {
        self.change.as_deref()
    }

    fn errors(&self) -> ChangeErrors {
        ChangeErrors { systematic_m: self.systematic, range_m: self.error_range }
    }
}

/// Compares two depth maps, writes the files of the change and prints the volumes.
pub(super) fn run(args: &CompareArgs, folder: &Path) -> Result<(), Failure> {
    let [newer, older] =
        [&args.measured, &args.reference].map(|name| DepthMaps::open(Path::new(name)));
    let (newer, older) = (newer?, older?);
    for map in [&newer, &older] {
        if !map.has_errors() {
            output::notify(format_args!(
                "warning: there is no uncertainty.tif beside the depths, so that only the systematic error counts: {}",
                map.path.display()
            ));
        }
    }
    let status = StatusLine::at("change");
    let assumed = args.change.errors();
    let (mut totals, mut written, mut shown) = (ChangeTotals::default(), Vec::new(), None);
    let mut observed = Observed::default();
    for part in newer.parts() {
        let part = part?;
        let mut change = PartChange::new(&part, &older.around(&part)?);
        if change.rise_m.iter().all(|rise_m| rise_m.is_nan()) {
            continue;
        }
        let errors = observed.put_into(&mut change, &assumed);
        let field = change.field();
        let regions = field.regions(&errors);
        totals.add(&field, &regions, &errors);
        if written.is_empty() {
            make_folder(folder)?;
        }
        written.push(change.write(folder, &errors, &regions, &status.progress)?);
        shown.get_or_insert_with(|| record::picture(&change.rise_m, part.size()));
    }
    let Some(shown) = shown else {
        return Err(format!(
            "the two maps have no cell in common: {} and {}",
            newer.path.display(),
            older.path.display()
        )
        .into());
    };
    write_styles(&written, &totals)?;
    let errors = observed.errors(&assumed);
    let record = ChangeRecord::new([&newer.path, &older.path], &totals, errors, observed.share());
    write_json(&folder.join("change.json"), &record)?;
    // With many tiles, one picture would show a part as if it were all.
    let shown = (written.len() == 1).then_some(shown);
    let page = record::page(&record, shown.as_deref())?;
    write_bytes(&folder.join("change.html"), page)?;
    drop(status);
    if args.json { output::json(&record) } else { output::results(record.table()) }
}

/// Errors of the maps, observed in the parts of the newer map.
#[derive(Default)]
struct Observed {
    range_m: f64,
    /// Share of the stated errors that is found in the difference, one value for each part.
    shares: Vec<f64>,
}

impl Observed {
    /// Replaces the errors that the maps state for a part by the errors observed in it; returns the
    /// errors with the observed range.
    fn put_into(&mut self, change: &mut PartChange<'_>, assumed: &ChangeErrors) -> ChangeErrors {
        let found = change.field().observed_errors(assumed);
        change.sigma_m = found.sigma_m;
        self.range_m = self.range_m.max(found.range_m);
        self.shares.push(found.share);
        ChangeErrors { range_m: found.range_m, ..*assumed }
    }

    /// Returns the errors for all parts together, with the largest observed range.
    fn errors(&self, assumed: &ChangeErrors) -> ChangeErrors {
        ChangeErrors { range_m: self.range_m, ..*assumed }
    }

    /// Returns the median over all parts of the share of the stated errors that is found in the
    /// difference.
    fn share(&self) -> f64 {
        median(&mut self.shares.clone())
    }
}

/// Change of the depths in the cells of a part of the newer map.
struct PartChange<'a> {
    part: &'a DepthPart,
    cell_area_m2: f64,
    /// Rise of the bottom, metres; NaN where it is unknown in one of the maps.
    rise_m: Vec<f32>,
    /// Standard deviation of the rise by the errors of the depths alone, metres: as observed in the
    /// difference, and as stated by the maps.
    sigma_m: Vec<f32>,
    stated_m: Vec<f32>,
    /// True if the depth was measured in that cell: in the newer map, in the older map.
    is_measured: Vec<[bool; 2]>,
}

impl<'a> PartChange<'a> {
    fn new(part: &'a DepthPart, older: &[DepthPart]) -> Self {
        let [columns, rows] = part.size();
        let cells = (0..columns * rows).into_par_iter().map(|cell| {
            let new = part.cell(cell)?;
            let at = [cell % columns, cell / columns];
            let old = older.iter().find_map(|old| old.at_cell_of(part, at))?;
            let rise_m = (old.depth_m - new.depth_m) as f32;
            let sigma_m = new.sigma_m.hypot(old.sigma_m) as f32;
            Some(((rise_m, sigma_m), [new.is_measured, old.is_measured]))
        });
        let unknown = ((f32::NAN, f32::NAN), [false; 2]);
        let ((rise_m, stated_m), is_measured): ((Vec<_>, Vec<_>), _) =
            cells.map(|cell| cell.unwrap_or(unknown)).unzip();
        let (cell_area_m2, sigma_m) = (part.cell_area_m2(), stated_m.clone());
        Self { part, cell_area_m2, rise_m, sigma_m, stated_m, is_measured }
    }

    fn field(&self) -> ChangeField<'_> {
        ChangeField {
            columns: self.part.size()[0],
            cell_area_m2: self.cell_area_m2,
            rise_m: &self.rise_m,
            sigma_m: &self.sigma_m,
            stated_m: &self.stated_m,
            is_measured: &self.is_measured,
        }
    }

    /// Returns the value of a function for each cell; NaN where the change is unknown.
    fn layer(&self, value: impl Fn(usize, &CellChange) -> f64) -> Vec<f32> {
        let field = self.field();
        let cells = 0..self.rise_m.len();
        let values =
            cells.map(|index| (field.cell(index)).map_or(f64::NAN, |cell| value(index, &cell)));
        values.map(|value| value as f32).collect()
    }

    /// Returns the standard deviation of each cell's rise, metres: of the errors of both maps, and
    /// of the depths interpolated between measured places.
    fn uncertainty_m(&self, errors: &ChangeErrors, regions: &[ChangeRegion]) -> Vec<f32> {
        let mut between_m = vec![0.0; self.rise_m.len()];
        for region in regions {
            for (cell, sigma_m) in region.cells.iter().zip(&region.between_m) {
                between_m[*cell] = *sigma_m;
            }
        }
        self.layer(|index, cell| {
            let own_m = cell.sigma_m.hypot(errors.systematic_m);
            own_m.hypot(between_m[index])
        })
    }

    /// Writes `difference.tif`, `detection_level.tif` and `uncertainty.tif`, for an archive with
    /// the name of the tile and `_` before each name; returns their paths.
    fn write(
        &self,
        folder: &Path,
        errors: &ChangeErrors,
        regions: &[ChangeRegion],
        progress: &Progress,
    ) -> Result<[PathBuf; 3], Error> {
        let named = |what: &str| match self.part.name.as_str() {
            "" => folder.join(format!("{what}.tif")),
            tile => folder.join(format!("{tile}_{what}.tif")),
        };
        let levels_m = self.layer(|_, cell| cell.detection_level_m(errors));
        let uncertainty_m = self.uncertainty_m(errors, regions);
        let paths = ["difference", "detection_level", "uncertainty"].map(named);
        let layers = [
            (
                "rise of the bottom",
                "How much the bottom rose, metres; negative where it sank",
                &self.rise_m,
            ),
            (
                "level of detection",
                "A change below it cannot be told from errors (95 %), metres",
                &levels_m,
            ),
            (
                "standard deviation of the rise",
                "Standard deviation in metres of the rise, with what is drawn between measured places",
                &uncertainty_m,
            ),
        ];
        for (path, (name, description, values_m)) in paths.iter().zip(layers) {
            let spec = RasterSpec {
                band: Some(Band { name, unit: "metre", positive_down: false }),
                description: description.to_owned(),
                ..self.part.spec()
            };
            metres_raster(path, &spec, &cells_of(&spec), values_m, progress)?;
        }
        Ok(paths)
    }
}

/// Returns a grid with the columns and rows of a raster, cells of 1 m and its corner at 0: the
/// position of the cells is in the raster.
fn cells_of(spec: &RasterSpec) -> Grid {
    Grid { west_m: 0.0, north_m: 0.0, cell_m: 1.0, columns: spec.columns, rows: spec.rows }
}

/// Writes colour styles for QGIS, the same for all parts of a map: blue where the bottom sank, red
/// where it rose.
fn write_styles(written: &[[PathBuf; 3]], totals: &ChangeTotals) -> Result<(), ExportError> {
    let reach_m = difference_reach_m(totals.reach_m());
    let level_m = totals.median_level_m().unwrap_or_default();
    for [rise, level, uncertainty] in written {
        let style = |raster: &Path, ends_m, colour: fn(f32) -> [u8; 3]| {
            let path = raster.with_extension("qml");
            qgis_style(&path, ends_m, STEPS, colour)
        };
        style(rise, [-reach_m, reach_m], difference_colour)?;
        style(level, [0.0, 2.0 * level_m], uncertainty_colour)?;
        style(uncertainty, [0.0, level_m], uncertainty_colour)?;
    }
    Ok(())
}
