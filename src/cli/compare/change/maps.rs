//! Reads the two depth maps of a change: of a run, of an archive, or of any program.

use crate::cli::Failure;
use bathyscope_bottom::bathymetry::CellSource;
use bathyscope_log::formats::geotiff::{
    CellFormat, CellsError, RasterSpec, RasterTiles, RasterValues, read_values,
};
use bathyscope_log::support::geo::{Crs, MapPlane, bounds_deg, boxes_meet};
use bathyscope_products::outputs::finish_killed_run;
use std::fs;
use std::path::{Path, PathBuf};

/// Names of the files that `process` and `archive` write: the depths, and in the same folder the
/// standard deviations and the sources of the depths.
const DEPTH: &str = "depth.tif";
const UNCERTAINTY: &str = "uncertainty.tif";
const SOURCE: &str = "source.tif";

/// Depth map in one file, or in many.
pub(super) struct DepthMaps {
    /// Path that the argument names.
    pub path: PathBuf,
    files: Vec<PathBuf>,
}

impl DepthMaps {
    /// Opens the map that an argument names: a GeoTIFF, the folder of a run, or an archive.
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        finish_killed_run(path)?;
        let of_run = path.join("depth").join(DEPTH);
        let files = match (path.is_dir(), of_run.is_file()) {
            (false, _) => vec![path.to_owned()],
            (true, true) => vec![of_run],
            (true, false) => tiles(path)?,
        };
        if files.is_empty() {
            return Err(format!(
                "there is no depth map in this folder; give a folder of `bathyscope process`, an archive with maps, or a GeoTIFF: {}",
                path.display()
            ).into());
        }
        Ok(Self { path: path.to_owned(), files })
    }

    /// Returns true if every file of the map has a file of standard deviations.
    pub(super) fn has_errors(&self) -> bool {
        self.files.iter().all(|file| beside(file, UNCERTAINTY).is_some())
    }

    /// Reads the parts of the map, one after the other.
    pub(super) fn parts(&self) -> impl Iterator<Item = Result<DepthPart, Failure>> {
        self.files.iter().map(|file| DepthPart::read(file))
    }

    /// Reads the parts whose bounds meet those of a part of another map.
    pub(super) fn around(&self, other: &DepthPart) -> Result<Vec<DepthPart>, Failure> {
        let own = other.bounds_deg();
        let is_near = |part: &Result<DepthPart, Failure>| {
            part.as_ref().map_or(true, |part| boxes_meet(own, part.bounds_deg()))
        };
        self.parts().filter(is_near).collect()
    }
}

/// Returns the paths of the depth maps of an archive's tiles, sorted by path; empty if there is no
/// folder `tiles`.
fn tiles(archive: &Path) -> Result<Vec<PathBuf>, Failure> {
    let folder = archive.join("tiles");
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let fail = |error| format!("cannot read the folder: {error}: {}", folder.display());
    let entries = fs::read_dir(&folder).map_err(fail)?;
    let files = entries.map(|entry| Ok(entry.map_err(fail)?.path().join(DEPTH)));
    let mut files: Vec<PathBuf> = files.collect::<Result<_, Failure>>()?;
    files.retain(|file| file.is_file());
    files.sort_unstable();
    Ok(files)
}

/// Returns the path of a raster in the folder of the depths; `None` if that raster is missing or
/// Bathyscope did not write the depths.
fn beside(depths: &Path, name: &str) -> Option<PathBuf> {
    let beside = depths.with_file_name(name);
    (depths.file_name()? == DEPTH && beside.is_file()).then_some(beside)
}

/// Reads the cells of a raster in the folder of the depths, whose size must be `size`; `None` if
/// there is no such raster.
fn cells_beside<T>(
    depths: &Path,
    name: &str,
    size: [usize; 2],
    read: impl Fn(&Path) -> Result<([usize; 2], Vec<T>), CellsError>,
) -> Result<Option<Vec<T>>, Failure> {
    let Some(path) = beside(depths, name) else {
        return Ok(None);
    };
    match read(&path) {
        Err(error) => Err(format!("{error}: {}", path.display()).into()),
        Ok((found, cells)) if found == size => Ok(Some(cells)),
        Ok(_) => {
            Err(format!("it has other cells than the depths beside it: {}", path.display()).into())
        }
    }
}

/// Depths of one file, with their standard deviations and sources.
pub(super) struct DepthPart {
    raster: RasterValues,
    sigma_m: Option<Vec<f32>>,
    /// Sources of the depths, as numbers of [`CellSource`]; `None` without them.
    sources: Option<Vec<u8>>,
    crs: Crs,
    /// Name of the tile in an archive, with which the names of its results begin; otherwise empty.
    pub name: String,
}

/// Depth at a place, with its uncertainty.
#[derive(Clone, Copy)]
pub(super) struct Depth {
    /// Depth, metres, positive down.
    pub depth_m: f64,
    /// Standard deviation of the depth, metres.
    pub sigma_m: f64,
    /// True if the depth was measured there, or inferred from echoes at that place; also true if
    /// the map has no sources.
    pub is_measured: bool,
}

impl DepthPart {
    fn read(path: &Path) -> Result<Self, Failure> {
        let fail = |error: &dyn std::fmt::Display| format!("{error}: {}", path.display());
        let mut raster = read_values(path).map_err(|error| fail(&error))?;
        if !raster.downwards {
            raster.values.iter_mut().for_each(|value| *value = -*value);
        }
        let epsg = raster
            .epsg
            .ok_or_else(|| fail(&"the raster does not name its system by an EPSG number"))?;
        let crs = Crs::from_epsg(epsg).map_err(|error| fail(&error))?;
        let size = [raster.columns, raster.rows];
        let sigma_m = cells_beside(path, UNCERTAINTY, size, |path| {
            read_values(path).map(|read| ([read.columns, read.rows], read.values))
        })?;
        let sources = cells_beside(path, SOURCE, size, |path| {
            let raster = RasterTiles::open(path)?;
            Ok((raster.size(), raster.overview(0)?))
        })?;
        let folder = path.parent().and_then(Path::file_name).unwrap_or_default();
        let is_tile = path.ancestors().nth(2).is_some_and(|up| up.ends_with("tiles"));
        Ok(Self {
            raster,
            sigma_m,
            sources,
            crs,
            name: if is_tile { folder.to_string_lossy().into_owned() } else { String::new() },
        })
    }

    /// Returns the numbers of cells from west to east and from north to south.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.raster.columns, self.raster.rows]
    }

    fn bounds_deg(&self) -> [f64; 4] {
        let [columns, rows] = self.size().map(|count| count as f64 - 0.5);
        let corners = [[-0.5, -0.5], [columns, -0.5], [-0.5, rows], [columns, rows]];
        let corners = corners.into_iter();
        bounds_deg(corners.map(|at| self.crs.to_lon_lat(self.raster.transform.at(at))))
    }

    /// Returns the area of a cell on the ground, square metres, in the middle of the map.
    pub(super) fn cell_area_m2(&self) -> f64 {
        let middle = self.size().map(|count| 0.5 * count as f64);
        let middle = self.crs.to_lon_lat(self.raster.transform.at(middle));
        let plane = MapPlane::new(self.crs.clone(), middle);
        let transform = &self.raster.transform;
        let cell_m2 =
            transform.per_column[0] * -transform.per_row[1] / (plane.units[0] * plane.units[1]);
        cell_m2 / plane.area_scale_at(plane.place(middle))
    }

    /// Returns the depth in a cell; `None` where the depth or its standard deviation is unknown.
    pub(super) fn cell(&self, cell: usize) -> Option<Depth> {
        let depth_m = *self.raster.values.get(cell)?;
        let sigma_m =
            self.sigma_m.as_ref().map_or(Some(0.0), |sigmas| sigmas.get(cell).copied())?;
        let is_measured = |sources: &Vec<u8>| {
            let source = sources.get(cell);
            source.is_some_and(|source| *source > CellSource::Interpolated as u8)
        };
        (!(depth_m + sigma_m).is_nan()).then(|| Depth {
            depth_m: f64::from(depth_m),
            sigma_m: f64::from(sigma_m),
            is_measured: self.sources.as_ref().is_none_or(is_measured),
        })
    }

    /// Returns the depth at the middle of a cell of another map, interpolated between the middles
    /// of this map's cells; `None` if a cell with a weight above 0 is unknown.
    pub(super) fn at_cell_of(&self, other: &Self, [column, row]: [usize; 2]) -> Option<Depth> {
        let there = other.raster.transform.at([column as f64, row as f64]);
        let place =
            if other.crs == self.crs { there } else { self.crs.place(other.crs.to_lon_lat(there)) };
        let transform = &self.raster.transform;
        let at = [
            (place[0] - transform.origin[0]) / transform.per_column[0],
            (place[1] - transform.origin[1]) / transform.per_row[1],
        ];
        self.between(at)
    }

    /// Interpolates bilinearly between cells; in the outer half of the outermost cells, with the
    /// values of these cells.
    fn between(&self, at: [f64; 2]) -> Option<Depth> {
        let about = |axis: usize| {
            let count = self.size()[axis];
            let inside = (-0.5..count as f64 - 0.5).contains(&at[axis]);
            let held = at[axis].clamp(0.0, count.saturating_sub(1) as f64);
            // A place very close to the middle of a cell counts as the middle.
            let held = if (held - held.round()).abs() < 1e-6 { held.round() } else { held };
            inside.then(|| (held as usize, held.fract()))
        };
        let ((column, right), (row, down)) = (about(0)?, about(1)?);
        let mut sum = Depth { depth_m: 0.0, sigma_m: 0.0, is_measured: false };
        for (row, down) in [(row, 1.0 - down), (row + 1, down)] {
            for (column, right) in [(column, 1.0 - right), (column + 1, right)] {
                let share = down * right;
                if share > 0.0 {
                    let cell = self.cell(row * self.raster.columns + column)?;
                    sum.depth_m += share * cell.depth_m;
                    // The errors of neighbouring cells are correlated: their deviations add
                    // linearly.
                    sum.sigma_m += share * cell.sigma_m;
                    sum.is_measured |= cell.is_measured;
                }
            }
        }
        Some(sum)
    }

    /// Returns the grid of a raster with the same cells; band and description are still empty.
    pub(super) fn spec(&self) -> RasterSpec {
        let transform = &self.raster.transform;
        let [west, north] = transform.at([-0.5, -0.5]);
        RasterSpec {
            columns: self.raster.columns,
            rows: self.raster.rows,
            west,
            north,
            cell: [transform.per_column[0], -transform.per_row[1]],
            crs: self.crs.clone(),
            cells: CellFormat::Metres,
            band: None,
            description: String::new(),
        }
    }
}
