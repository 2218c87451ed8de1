//! Writes the side-scan mosaic.

use super::record::{Coordinates, FileContent};
use super::results::Results;
use crate::bathymetry::Grid;
use crate::export::{RasterError, Summary, geotiff};
use crate::formats::geotiff::{Band, Cells, RASTER_TILE, RasterSpec};
use crate::geo::MapPlane;
use crate::mosaic::{
    Colours, Layout, MosaicLog, TILE_CELLS, Tile, TileIndex, gain_table, joint_grid, joint_tile,
    tile,
};
use crate::pipeline::joint::mosaic_logs;
use crate::pipeline::mosaic_layout;
use crate::progress::Cancelled;
use std::collections::BTreeSet;
use std::path::Path;

/// Most tiles that a mosaic may span, with those that hold nothing: a fix that is far off makes a huge, empty map.
const MOST_TILES: usize = 1_000_000;

/// Echoes at their place on the map.
pub struct Placed {
    echoes: Echoes,
    grid: Grid,
}

/// Of a log alone, or of several brought to each other's levels.
enum Echoes {
    One(Box<Layout>),
    Several(Vec<MosaicLog>),
}

impl Placed {
    /// Where the echoes of a survey lie; why they cannot be drawn.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(results: &Results<'_>) -> Result<Result<Self, String>, Cancelled> {
        let (map, settings) = (&results.plane.map, &results.products.settings.mosaic);
        let (echoes, grid) = match results.order.logs {
            [log] => {
                let layout = mosaic_layout(&log.survey, &log.products, map);
                let grid = layout.grid(settings.cell_m);
                (Echoes::One(Box::new(layout)), grid)
            }
            logs => {
                let logs = mosaic_logs(logs, map, settings, results.progress)?;
                let grid = joint_grid(&logs, settings.cell_m);
                (Echoes::Several(logs), grid)
            }
        };
        let Some(grid) = grid else {
            let why = "no mosaic: no ping has side-scan, a place, a heading and an altitude";
            return Ok(Err(why.to_owned()));
        };
        let [down, across] = [grid.rows, grid.columns].map(|cells| cells.div_ceil(TILE_CELLS));
        if down.saturating_mul(across) > MOST_TILES {
            return Ok(Err(format!(
                "no mosaic: it would have {} by {} cells; choose a larger mosaic.cell_m, or look for positions that are far off",
                grid.columns, grid.rows
            )));
        }
        Ok(Ok(Self { echoes, grid }))
    }
}

/// Writes `mosaic.tif`: all side-scan echoes in the system that `crs` names, as a GeoTIFF: one band of levels with a mask, or colours
/// with opacity. Memory does not grow with the area.
pub fn write(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (survey, progress) = (results.survey, results.progress);
    let (settings, map) = (&results.products.settings.mosaic, &results.plane.map);
    let Placed { echoes, grid } = results.mosaic()?.as_ref()?;
    let system = || FileContent::new(Coordinates::System(map.crs.clone()), summary(grid, map));
    let save = |tiles: BTreeSet<[usize; 2]>, draw: &(dyn Fn([usize; 2]) -> Tile + Sync)| {
        let tiles: Vec<[usize; 2]> = tiles.into_iter().collect();
        let drawn = |place: [usize; 2]| {
            let levels = draw(place).levels;
            match settings.colours {
                Colours::Grey => levels,
                Colours::Copper => (levels.iter())
                    .flat_map(|&level| settings.colours.rgba(level))
                    .collect(),
            }
        };
        let spec = spec(grid, map, &results.name(), settings.colours);
        geotiff(path, &spec, &tiles, drawn, progress)
            .map_err(|error: RasterError| error.to_string())
    };
    let places = |index: &TileIndex| -> Vec<[usize; 2]> {
        index.tiles().map(|(row, column)| [row, column]).collect()
    };
    match echoes {
        Echoes::One(layout) => {
            let index = layout.index(grid);
            let gain = gain_table(survey, layout, progress).map_err(|error| error.to_string())?;
            let draw = |place| tile(survey, layout, grid, &index, &gain, settings, place);
            save(places(&index).into_iter().collect(), &draw)?;
        }
        Echoes::Several(logs) => {
            let indices: Vec<TileIndex> = logs.iter().map(|log| log.layout.index(grid)).collect();
            let parts: Vec<(&MosaicLog, &TileIndex)> = logs.iter().zip(&indices).collect();
            let draw = |place| joint_tile(&parts, grid, settings, place);
            save(indices.iter().flat_map(places).collect(), &draw)?;
        }
    }
    Ok(system())
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

fn spec(grid: &Grid, map: &MapPlane, name: &str, colours: Colours) -> RasterSpec {
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
        description: format!("Side-scan mosaic of {name}"),
    }
}
