//! The depth map of a tile, from the rows of all logs in it.

use super::error::LakeError;
use super::index::tile_bounds_deg;
use super::log_record::LogRecord;
use super::offsets::Offsets;
use super::point_rows::{self, POINTS};
use super::record::{Lake, MOST_MOVED_M};
use super::tile::{TILE_M, TileId};
use crate::bathymetry::isobaths::{
    Isobath, IsobathSettings, clipped, isobaths, smoothed, with_shoalest,
};
use crate::bathymetry::{DepthPoint, Grid, LOCAL_MARGIN_CELLS, Surface, local_surface};
use crate::geo::UtmZone;
use crate::pipeline::clip_area;
use crate::progress::Progress;

/// Metres from one isobath to the next where the settings name none: the same in all tiles, so that lines meet.
const USUAL_INTERVAL_M: f64 = 0.5;

/// The depth map of a tile.
pub struct TileMap {
    /// The cells of the tile, none of its halo.
    pub surface: Surface,
    /// Lines of equal depth, cut at its edges and at those of the area of the lake's isobaths.
    pub isobaths: Vec<Isobath>,
}

/// The points that count in a tile and its halo, the logs in the order of their hashes, with their offsets and their positions corrected.
///
/// # Errors
/// When rows cannot be read, or the work was cancelled.
pub(super) fn depth_points(
    lake: &Lake,
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<Vec<DepthPoint>, LakeError> {
    let mut points = Vec::new();
    for log in logs {
        progress.check()?;
        if log.rows_in(tile).is_none_or(|rows| rows.points == 0) {
            continue;
        }
        let offset_m = offsets.of(&log.log);
        let name = Lake::rows_name(POINTS, tile, &log.log);
        let rows = point_rows::read(&lake.folder().join(name))?.into_iter();
        let shift = offsets.shift_of(&log.log);
        points.extend(rows.map(|row| {
            let [x, y] = within(shift.at(row.velocity_mps), MOST_MOVED_M);
            DepthPoint {
                east_m: row.depth.east_m + x,
                north_m: row.depth.north_m + y,
                // What is added to an elevation is taken off the depth.
                depth_m: row.depth.depth_m - offset_m,
                ..row.depth
            }
        }));
    }
    Ok(points)
}

/// A vector, no longer than some metres.
fn within([x, y]: [f64; 2], most_m: f64) -> [f64; 2] {
    let share = (most_m / x.hypot(y).max(most_m)).min(1.0);
    [share * x, share * y]
}

/// The map of a tile by linear triangles, whatever `surface.method` says: the other methods reach farther than a halo. Neighbouring tiles
/// are the parts of one map, to the bit. `None` where nothing is known.
///
/// # Errors
/// When rows cannot be read, or the work was cancelled.
pub fn tile_map(
    lake: &Lake,
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<Option<TileMap>, LakeError> {
    let settings = lake.settings()?;
    let points = depth_points(lake, tile, logs, offsets, progress)?;
    let grid = with_margin(tile, lake.record.cell_m);
    let mut window = local_surface(&points, grid, settings.surface.max_gap_m, progress)?;
    blank_other_zones(&mut window, tile);
    let surface = core_of(&window);
    if surface.depth_m.iter().all(|depth| depth.is_nan()) {
        return Ok(None);
    }
    if settings.isobaths.shoal_safe {
        window = with_shoalest(&window, &points);
    }
    let isobaths = lines(&window, &settings.isobaths, tile, progress)?;
    Ok(Some(TileMap { surface, isobaths }))
}

/// The cells of a tile, and those beyond its edges that its lines depend on.
fn with_margin(tile: TileId, cell_m: f64) -> Grid {
    let [west_m, _, _, north_m] = tile.bounds_m();
    let margin_m = LOCAL_MARGIN_CELLS as f64 * cell_m;
    let side = (TILE_M / cell_m) as usize + 2 * LOCAL_MARGIN_CELLS;
    Grid {
        west_m: west_m - margin_m,
        north_m: north_m + margin_m,
        cell_m,
        columns: side,
        rows: side,
    }
}

/// Where a tile reaches across the edge of its zone, cells beyond belong to the other zone.
fn blank_other_zones(surface: &mut Surface, tile: TileId) {
    if tile.is_within_zone() {
        return;
    }
    let grid = surface.grid;
    for cell in 0..grid.len() {
        let at = tile
            .zone
            .to_lon_lat(grid.centre(cell / grid.columns, cell % grid.columns));
        if UtmZone::of(at) != tile.zone {
            surface.depth_m[cell] = f32::NAN;
            surface.spread_m[cell] = f32::NAN;
            surface.distance_m[cell] = f32::NAN;
            surface.source[cell] = Default::default();
        }
    }
}

/// The surface without its margin.
fn core_of(window: &Surface) -> Surface {
    let grid = window.grid;
    let margin_m = LOCAL_MARGIN_CELLS as f64 * grid.cell_m;
    let core = Grid {
        west_m: grid.west_m + margin_m,
        north_m: grid.north_m - margin_m,
        columns: grid.columns - 2 * LOCAL_MARGIN_CELLS,
        rows: grid.rows - 2 * LOCAL_MARGIN_CELLS,
        ..grid
    };
    let start = |row: usize| (row + LOCAL_MARGIN_CELLS) * grid.columns + LOCAL_MARGIN_CELLS;
    let cut = |values: &[f32]| -> Vec<f32> {
        let rows = (0..core.rows).map(|row| &values[start(row)..start(row) + core.columns]);
        rows.flatten().copied().collect()
    };
    let sources = (0..core.rows).map(|row| &window.source[start(row)..start(row) + core.columns]);
    Surface {
        grid: core,
        depth_m: cut(&window.depth_m),
        spread_m: cut(&window.spread_m),
        distance_m: cut(&window.distance_m),
        source: sources.flatten().copied().collect(),
        hardness_db: window.hardness_db.as_deref().map(cut),
        ..*window
    }
}

/// The settings of the isobaths with an interval that is the same in all tiles.
pub(super) fn isobath_settings(settings: &IsobathSettings) -> IsobathSettings {
    IsobathSettings {
        interval_m: settings.interval_m.or(Some(USUAL_INTERVAL_M)),
        ..settings.clone()
    }
}

fn lines(
    window: &Surface,
    settings: &IsobathSettings,
    tile: TileId,
    progress: &Progress,
) -> Result<Vec<Isobath>, LakeError> {
    let levels_m = isobath_settings(settings)
        .levels_m(window.range_m())
        .map_err(|error| error.to_string())?;
    let area = clip_area(settings, tile_bounds_deg(&[tile]), |at| {
        tile.zone.to_metres(at)
    });
    let area = area.map_err(|error| error.to_string())?;
    let drawn = isobaths(window, &levels_m, progress)?;
    let cut = drawn.into_iter().flat_map(|line| {
        let rounded = Isobath {
            points: smoothed(&line.points, settings.smoothing()),
            ..line
        };
        let parts = match &area {
            Some(area) => area.parts_of(&rounded),
            None => vec![rounded],
        };
        let in_tile = parts.into_iter();
        in_tile.flat_map(|part| clipped(&part, tile.bounds_m()))
    });
    let mut lines: Vec<Isobath> = cut.collect();
    // In one order, however the rows of the window were walked.
    lines.sort_by(|a, b| {
        let first = |line: &Isobath| line.points.first().copied().unwrap_or_default();
        let (one, other) = (first(a), first(b));
        (a.depth_m.total_cmp(&b.depth_m))
            .then(one[0].total_cmp(&other[0]))
            .then(one[1].total_cmp(&other[1]))
    });
    Ok(lines)
}
