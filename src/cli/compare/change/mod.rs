//! `bathyscope compare NEW OLD --change DIR`: how the bottom changed between two depth maps.

mod maps;
mod page;
mod record;

use super::CompareArgs;
use crate::bathymetry::Grid;
use crate::bathymetry::change::{CellChange, ChangeErrors, ChangeTotals};
use crate::cli::output;
use crate::cli::status_line::StatusLine;
use crate::export::{metres_raster, qgis_style, write_aside};
use crate::formats::geotiff::{Band, RasterSpec};
use crate::presentation::colours::{difference_colour, difference_reach_m, uncertainty_colour};
use crate::progress::Progress;
use maps::{DepthMaps, DepthPart};
use rayon::prelude::*;
use record::ChangeRecord;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Steps of the colours in a style.
const STEPS: usize = 16;

/// What changed between two surveys.
#[derive(Debug, clap::Args)]
pub struct ChangeArgs {
    /// Compare two depth maps in place of points, the newer one first: a folder of `process`, a lake, or a GeoTIFF. Writes into this folder how
    /// much each cell rose, the level of detection, and the volumes of fill and cut
    #[arg(long, value_name = "DIR", conflicts_with_all = ["output", "by", "radius", "max_gap", "water_level"])]
    change: Option<PathBuf>,
    /// With --change: standard deviation of what is the same in all cells of one map against the other, such as draft and water level, metres
    #[arg(long, value_name = "METRES", default_value_t = 0.03, value_parser = parse_error, requires = "change")]
    systematic: f64,
    /// With --change: depths farther apart than this err independently, metres
    #[arg(long, value_name = "METRES", default_value_t = 20.0, value_parser = parse_error, requires = "change")]
    error_range: f64,
}

fn parse_error(text: &str) -> Result<f64, String> {
    let metres = text.parse().ok();
    metres
        .filter(|metres: &f64| *metres >= 0.0 && metres.is_finite())
        .ok_or_else(|| "an error is a number that is not below 0".to_owned())
}

impl ChangeArgs {
    /// Where the change between maps is to be written; `None` where points are compared.
    pub fn folder(&self) -> Option<&Path> {
        self.change.as_deref()
    }

    fn errors(&self) -> ChangeErrors {
        ChangeErrors {
            systematic_m: self.systematic,
            range_m: self.error_range,
        }
    }
}

/// Compares two depth maps, writes what changed and prints the volumes.
pub fn run(args: &CompareArgs, folder: &Path) -> Result<(), String> {
    let [newer, older] =
        [&args.measured, &args.reference].map(|name| DepthMaps::open(Path::new(name)));
    let (newer, older) = (newer?, older?);
    for map in [&newer, &older] {
        if !map.has_errors() {
            output::notify(format_args!(
                "warning: there is no uncertainty.tif beside the depths, so that only the systematic error counts: {}",
                map.path().display()
            ));
        }
    }
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    status.step("change");
    let errors = args.change.errors();
    let (mut totals, mut written, mut shown) = (ChangeTotals::default(), Vec::new(), None);
    for part in newer.parts() {
        let part = part?;
        let change = PartChange::new(&part, &older.around(&part)?);
        if change.count(&mut totals, &errors) == 0 {
            continue;
        }
        if written.is_empty() {
            fs::create_dir_all(folder).map_err(|error| {
                format!("cannot make the folder: {error}: {}", folder.display())
            })?;
        }
        written.push(change.write(folder, &errors, &progress)?);
        shown.get_or_insert_with(|| page::picture(&change.rise_m, part.size()));
    }
    let Some(shown) = shown else {
        return Err(format!(
            "the two maps have no cell in common: {} and {}",
            newer.path().display(),
            older.path().display()
        ));
    };
    write_styles(&written, &totals)?;
    let record = ChangeRecord::new([newer.path(), older.path()], &totals, errors);
    write_text(&folder.join("change.json"), &record.json()?)?;
    // One picture of many tiles would show a part as if it were all.
    let shown = (written.len() == 1).then_some(shown);
    write_text(
        &folder.join("change.html"),
        &page::of(&record, shown.as_deref()),
    )?;
    drop(status);
    match args.json {
        true => output::json(&record),
        false => output::results(record.table()),
    }
}

fn write_text(path: &Path, text: &str) -> Result<(), String> {
    write_aside(path, |mut file| file.write_all(text.as_bytes())).map_err(|error| error.to_string())
}

/// What changed in the cells of a part of the newer map.
struct PartChange<'a> {
    part: &'a DepthPart,
    cell_area_m2: f64,
    /// How much the bottom rose, metres; NaN where one of the maps knows nothing.
    rise_m: Vec<f32>,
    /// Standard deviation of that by the depths' own errors, metres.
    sigma_m: Vec<f32>,
}

impl<'a> PartChange<'a> {
    fn new(part: &'a DepthPart, older: &[DepthPart]) -> Self {
        let [columns, rows] = part.size();
        let cells = (0..columns * rows).into_par_iter().map(|cell| {
            let [new_m, new_sigma_m] = part.cell(cell)?;
            let at = [cell % columns, cell / columns];
            let [old_m, old_sigma_m] = older.iter().find_map(|old| old.at_cell_of(part, at))?;
            Some((
                (old_m - new_m) as f32,
                new_sigma_m.hypot(old_sigma_m) as f32,
            ))
        });
        let (rise_m, sigma_m) = cells
            .map(|cell| cell.unwrap_or((f32::NAN, f32::NAN)))
            .unzip();
        Self {
            part,
            cell_area_m2: part.cell_area_m2(),
            rise_m,
            sigma_m,
        }
    }

    fn cells(&self) -> impl Iterator<Item = Option<CellChange>> {
        let cells = self.rise_m.iter().zip(&self.sigma_m);
        cells.map(|(&rise_m, &sigma_m)| {
            (!rise_m.is_nan()).then(|| CellChange {
                rise_m: f64::from(rise_m),
                sigma_m: f64::from(sigma_m),
                area_m2: self.cell_area_m2,
            })
        })
    }

    /// Adds its cells to those of other parts; gives back how many they are.
    fn count(&self, totals: &mut ChangeTotals, errors: &ChangeErrors) -> usize {
        let before = totals.all.cells;
        self.cells()
            .flatten()
            .for_each(|cell| totals.add(&cell, errors));
        totals.all.cells - before
    }

    /// Writes `difference.tif` and `detection_level.tif`, of a lake behind the name of the tile; gives back where they lie.
    fn write(
        &self,
        folder: &Path,
        errors: &ChangeErrors,
        progress: &Progress,
    ) -> Result<[PathBuf; 2], String> {
        let named = |what: &str| match self.part.name.as_str() {
            "" => folder.join(format!("{what}.tif")),
            tile => folder.join(format!("{tile}_{what}.tif")),
        };
        let levels_m = self
            .cells()
            .map(|cell| cell.map_or(f32::NAN, |cell| cell.detection_level_m(errors) as f32));
        let levels_m: Vec<f32> = levels_m.collect();
        let paths = [named("difference"), named("detection_level")];
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
        ];
        for (path, (name, description, values_m)) in paths.iter().zip(layers) {
            let spec = RasterSpec {
                band: Some(Band {
                    name,
                    unit: "metre",
                    positive_down: false,
                }),
                description: description.to_owned(),
                ..self.part.spec()
            };
            metres_raster(path, &spec, &cells_of(&spec), values_m, progress)
                .map_err(|error| error.to_string())?;
        }
        Ok(paths)
    }
}

/// The cells of a raster by their numbers alone: where they lie is said by the raster.
fn cells_of(spec: &RasterSpec) -> Grid {
    Grid {
        west_m: 0.0,
        north_m: 0.0,
        cell_m: 1.0,
        columns: spec.columns,
        rows: spec.rows,
    }
}

/// Colours for QGIS, the same for all parts of a map: blue where the bottom sank, red where it rose.
fn write_styles(written: &[[PathBuf; 2]], totals: &ChangeTotals) -> Result<(), String> {
    let reach_m = difference_reach_m(totals.reach_m());
    let level_m = totals.median_level_m().unwrap_or_default();
    for [rise, level] in written {
        let ends_m = [-reach_m, reach_m];
        qgis_style(
            &rise.with_extension("qml"),
            ends_m,
            STEPS,
            difference_colour,
        )
        .and_then(|()| {
            let ends_m = [0.0, 2.0 * level_m];
            qgis_style(
                &level.with_extension("qml"),
                ends_m,
                STEPS,
                uncertainty_colour,
            )
        })
        .map_err(|error| error.to_string())?;
    }
    Ok(())
}
