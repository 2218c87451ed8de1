//! Writes the side-scan mosaic.

use super::record::{Coordinates, FileContent};
use super::results::Results;
use crate::bathymetry::Grid;
use crate::export::{RasterError, Summary, geotiff};
use crate::formats::geotiff::{Band, Cells, RASTER_TILE, RasterSpec};
use crate::geo::MapPlane;
use crate::mosaic::{Colours, Layout, TILE_CELLS, gain_table, tile};
use crate::pipeline::mosaic_layout;
use crate::survey::Survey;
use std::path::Path;

/// Most tiles that a mosaic may span, with those that hold nothing: a fix that is far off makes a huge, empty map.
const MOST_TILES: usize = 1_000_000;

/// Echoes at their place on the map.
pub struct Placed {
    layout: Layout,
    grid: Grid,
}

impl Placed {
    /// Where the echoes of a survey lie; why they cannot be drawn.
    pub fn new(results: &Results<'_>) -> Result<Self, String> {
        let layout = mosaic_layout(results.survey, results.products, &results.plane.map);
        let Some(grid) = layout.grid(results.products.settings.mosaic.cell_m) else {
            return Err(
                "no mosaic: no ping has side-scan, a place, a heading and an altitude".to_owned(),
            );
        };
        let [down, across] = [grid.rows, grid.columns].map(|cells| cells.div_ceil(TILE_CELLS));
        if down.saturating_mul(across) > MOST_TILES {
            return Err(format!(
                "no mosaic: it would have {} by {} cells; choose a larger mosaic.cell_m, or look for positions that are far off",
                grid.columns, grid.rows
            ));
        }
        Ok(Self { layout, grid })
    }
}

/// Writes `mosaic.tif`: all side-scan echoes in the system that `crs` names, as a GeoTIFF: one band of levels with a mask, or colours
/// with opacity. Memory does not grow with the area.
pub fn write(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (survey, progress) = (results.survey, results.progress);
    let (settings, map) = (&results.products.settings.mosaic, &results.plane.map);
    let Placed { layout, grid } = results.mosaic()?.as_ref()?;
    let index = layout.index(grid);
    let gain = gain_table(survey, layout, progress).map_err(|error| error.to_string())?;
    let tiles: Vec<[usize; 2]> = index.tiles().map(|(row, column)| [row, column]).collect();
    let draw = |place: [usize; 2]| {
        let drawn = tile(survey, layout, grid, &index, &gain, settings, place);
        let levels = drawn.levels.iter();
        match settings.colours {
            Colours::Grey => drawn.levels,
            Colours::Copper => levels
                .flat_map(|&level| settings.colours.rgba(level))
                .collect(),
        }
    };
    let spec = spec(grid, map, survey, settings.colours);
    geotiff(path, &spec, &tiles, draw, progress).map_err(|error: RasterError| error.to_string())?;
    let system = Coordinates::System(map.crs.clone());
    Ok(FileContent::new(system, summary(grid, map)))
}

fn summary(grid: &Grid, map: &MapPlane) -> Summary {
    let mut summary = Summary {
        count: grid.len(),
        ..Summary::default()
    };
    let (width_m, height_m) = (
        grid.columns as f64 * grid.cell_m,
        grid.rows as f64 * grid.cell_m,
    );
    summary.reach(map.in_crs([grid.west_m, grid.north_m]));
    summary.reach(map.in_crs([grid.west_m + width_m, grid.north_m - height_m]));
    summary
}

/// What a cell of a grey mosaic holds.
const LEVEL: Band = Band {
    name: "echo level",
    unit: "",
    positive_down: false,
};

const _: () = assert!(TILE_CELLS == RASTER_TILE, "a tile is drawn as it is stored");

fn spec(grid: &Grid, map: &MapPlane, survey: &Survey, colours: Colours) -> RasterSpec {
    // Levels are one band, which a map program can stretch; colours are a picture.
    let (cells, band) = match colours {
        Colours::Grey => (Cells::Level, Some(LEVEL)),
        Colours::Copper => (Cells::Rgba, None),
    };
    RasterSpec {
        columns: grid.columns,
        rows: grid.rows,
        west: map.in_crs([grid.west_m, 0.0])[0],
        north: map.in_crs([0.0, grid.north_m])[1],
        cell: map.in_crs([grid.cell_m; 2]),
        crs: map.crs.clone(),
        cells,
        band,
        description: format!("Side-scan mosaic of {}", survey.name()),
    }
}
