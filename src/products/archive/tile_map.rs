//! Makes the depth map of a tile from the rows of all logs in it, with the height offset and the
//! corrected positions of each log.
//!
//! Depths from echo levels also depend on the eight neighbours of the tile.

use super::echo_rows::StoredEchoes;
use super::log_record::LogRecord;
use super::offsets::{Offsets, moved};
use super::point_rows::{self, PointRow};
use super::record::Archive;
use super::tile::{TileId, beside, is_within, tile_bounds_deg, tiles_read};
use super::{ECHOES, POINTS};
use crate::Error;
use crate::pipeline::clip_area;
use bathyscope_bottom::bathymetry::isobaths::{
    DepthExtent, Isobath, IsobathSettings, clipped, isobaths, smoothed, with_shoalest,
};
use bathyscope_bottom::bathymetry::{
    DepthPoint, Grid, LOCAL_MARGIN_CELLS, Surface, SwathDepth, local_surface,
};
use bathyscope_bottom::swath::{PART_DEPTHS_M, PART_PINGS_M, correct_part};
use bathyscope_log::support::geo::UtmZone;
use bathyscope_log::support::progress::Progress;

/// Interval of isobaths where the settings give none, metres: the same in all tiles, so that lines
/// meet at the edges.
const USUAL_INTERVAL_M: f64 = 0.5;

/// The depth map of a tile.
pub struct TileMap {
    /// Surface over the cells of the tile, without its halo.
    pub surface: Surface,
    /// Isobaths, cut at the edges of the tile and of the area of the archive's isobaths.
    pub isobaths: Vec<Isobath>,
}

/// Inputs of the map of a tile: the rows of all logs in it, and the offsets of the logs.
#[derive(Clone, Copy)]
pub struct TileInputs<'a> {
    /// Archive of the tile.
    pub archive: &'a Archive,
    /// The tile.
    pub tile: TileId,
    /// Logs of the map ([`Archive::logs_of_maps`]), in the order of their hashes.
    pub logs: &'a [LogRecord],
    /// Height offsets of the logs, and corrections of their positions.
    pub offsets: &'a Offsets,
    /// Progress of the work.
    pub progress: &'a Progress,
}

impl TileInputs<'_> {
    /// Makes the map of the tile by linear triangles, whatever `surface.method` is: the other
    /// methods depend on points beyond the halo. The depths are corrected by echo levels if
    /// `surface.swath` requires it. The maps of neighbouring tiles are parts of one map, equal to
    /// the bit. `None` where no depth is known.
    ///
    /// # Errors
    /// When rows cannot be read, or the work was cancelled.
    pub fn map(&self) -> Result<Option<TileMap>, Error> {
        let Self { archive, tile, progress, .. } = *self;
        let settings = archive.settings()?;
        let cell_m = archive.record.cell_m;
        // The isobaths depend on some cells beyond the edges of the tile.
        let grid = tile.grid(LOCAL_MARGIN_CELLS as f64 * cell_m, cell_m);
        let mut window = self.surface(grid)?;
        blank_other_zones(&mut window, tile);
        let surface = window.part(tile.grid(0.0, cell_m));
        if surface.depth_m.iter().all(|depth| depth.is_nan()) {
            return Ok(None);
        }
        if settings.isobaths.shoal_safe {
            window = with_shoalest(&window, &self.depth_points()?);
        }
        let isobaths = lines(&window, &settings.isobaths, tile, progress)?;
        Ok(Some(TileMap { surface, isobaths }))
    }

    /// Computes the depths of the tile and of some cells around it, on a grid of the archive's
    /// cells that reaches no farther than a few metres beyond the tile. The depths beyond the tile
    /// equal those in the map of the neighbour, to the bit.
    ///
    /// # Errors
    /// When rows cannot be read, or the work was cancelled.
    pub fn surface(&self, grid: Grid) -> Result<Surface, Error> {
        let settings = self.archive.settings()?.surface;
        match settings.swath {
            // The test of levels by cross-validation needs the whole archive, not one tile.
            SwathDepth::Off | SwathDepth::Auto => {
                let points = self.depth_points()?;
                Ok(local_surface(&points, grid, settings.max_gap_m, self.progress)?)
            }
            SwathDepth::Always => self.surface_from_levels(grid),
        }
    }

    /// Reads the points that count in the tile and its halo, log by log, with the height offset and
    /// the corrected positions of each log.
    ///
    /// # Errors
    /// When rows cannot be read, or the work was cancelled.
    fn depth_points(&self) -> Result<Vec<DepthPoint>, Error> {
        let mut points = Vec::new();
        for log in self.logs {
            self.progress.check()?;
            points.extend(self.moved_points(self.tile, log, |_| true)?);
        }
        Ok(points)
    }

    /// Reads the points of a log in a tile whose recorded places satisfy `lies_there`, with the
    /// height offset and the corrected positions of the log.
    ///
    /// # Errors
    /// When rows cannot be read.
    fn moved_points(
        &self,
        tile: TileId,
        log: &LogRecord,
        lies_there: impl Fn([f64; 2]) -> bool,
    ) -> Result<Vec<DepthPoint>, Error> {
        if log.rows_in(tile).is_none_or(|rows| rows.points == 0) {
            return Ok(Vec::new());
        }
        let (offset_m, shift) = (self.offsets.of(&log.log), self.offsets.shift_of(&log.log));
        let path = self.archive.rows_path(POINTS, tile, &log.log);
        let rows = point_rows::read(&path)?.into_iter();
        let of_row = |row: PointRow| {
            let place = [row.depth.east_m, row.depth.north_m];
            let [east_m, north_m] = moved(place, shift, row.velocity_mps);
            lies_there(place).then_some(DepthPoint {
                east_m,
                north_m,
                // An offset is added to elevations, so it is subtracted from depths.
                depth_m: row.depth.depth_m - offset_m,
                ..row.depth
            })
        };
        Ok(rows.filter_map(of_row).collect())
    }

    /// Computes the surface on a grid a few cells larger than the tile, with depths from echo
    /// levels.
    ///
    /// # Errors
    /// When rows cannot be read, or the work was cancelled.
    fn surface_from_levels(&self, grid: Grid) -> Result<Surface, Error> {
        let Self { archive, tile, progress, .. } = *self;
        let settings = archive.settings()?.surface;
        let tiles = tiles_read(SwathDepth::Always, tile);
        let points_m = beside(tile.bounds_m(), PART_DEPTHS_M + archive.record.halo_m);
        let mut points: Vec<DepthPoint> = Vec::new();
        for log in self.logs {
            for id in &tiles {
                progress.check()?;
                let rows = self.moved_points(*id, log, |place| {
                    id.holds(place, 0.0) && is_within(points_m, place)
                })?;
                points.extend(rows);
            }
        }
        let around = tile.grid(PART_DEPTHS_M, grid.cell_m);
        let mut made = local_surface(&points, around, settings.max_gap_m, progress)?;
        let stored = self.echoes_around(&tiles)?;
        let (laid_out, learnt): (Vec<_>, Vec<_>) =
            stored.iter().filter_map(StoredEchoes::laid_out).unzip();
        correct_part(&mut made, tile.bounds_m(), &laid_out, &learnt, &points, progress)?;
        Ok(made.part(grid))
    }

    fn echoes_around(&self, tiles: &[TileId]) -> Result<Vec<StoredEchoes>, Error> {
        let within_m = beside(self.tile.bounds_m(), PART_PINGS_M);
        let mut stored = Vec::new();
        for log in self.logs {
            self.progress.check()?;
            let files = tiles.iter().filter(|tile| {
                let rows = log.rows_in(**tile);
                rows.is_some_and(|rows| !rows.sha256_of(ECHOES).is_empty())
            });
            let path = |tile: &TileId| self.archive.rows_path(ECHOES, *tile, &log.log);
            let paths: Vec<_> = files.map(path).collect();
            stored.push(StoredEchoes::read(&paths, log, self.offsets, within_m)?);
        }
        Ok(stored)
    }
}

/// Clears the cells of a tile that lie beyond the edge of its zone: they belong to the other zone.
fn blank_other_zones(surface: &mut Surface, tile: TileId) {
    if tile.is_within_zone() {
        return;
    }
    let grid = surface.grid;
    for cell in 0..grid.len() {
        let at = tile.zone.to_lon_lat(grid.centre_of(cell));
        if UtmZone::of(at) != tile.zone {
            surface.depth_m[cell] = f32::NAN;
            surface.spread_m[cell] = f32::NAN;
            surface.distance_m[cell] = f32::NAN;
            surface.source[cell] = Default::default();
        }
    }
}

/// Returns the settings of the isobaths with an interval that is the same in all tiles.
pub(crate) fn isobath_settings(settings: &IsobathSettings) -> IsobathSettings {
    IsobathSettings {
        interval_m: settings.interval_m.or(Some(USUAL_INTERVAL_M)),
        ..settings.clone()
    }
}

/// Returns the extent of the depths of tiles with an error of 0, so that all tiles have the same
/// isobath interval.
pub(crate) fn without_error(range_m: [f64; 2]) -> DepthExtent {
    DepthExtent { range_m, error_m: 0.0 }
}

fn lines(
    window: &Surface,
    settings: &IsobathSettings,
    tile: TileId,
    progress: &Progress,
) -> Result<Vec<Isobath>, Error> {
    let levels_m = isobath_settings(settings).levels_m(without_error(window.range_m()))?;
    let area = clip_area(settings, tile_bounds_deg(&[tile]), |at| tile.zone.to_metres(at))?;
    let drawn = isobaths(window, &levels_m, progress)?;
    let cut = drawn.into_iter().flat_map(|line| {
        let rounded = Isobath { points: smoothed(&line.points, settings.smoothing()), ..line };
        let parts = match &area {
            Some(area) => area.parts_of(&rounded),
            None => vec![rounded],
        };
        let in_tile = parts.into_iter();
        in_tile.flat_map(|part| clipped(&part, tile.bounds_m()))
    });
    let mut lines: Vec<Isobath> = cut.collect();
    // The order of the lines must not depend on the order of the rows of the window.
    lines.sort_by(|a, b| {
        let first = |line: &Isobath| line.points.first().copied().unwrap_or_default();
        let (one, other) = (first(a), first(b));
        (a.depth_m.total_cmp(&b.depth_m))
            .then(one[0].total_cmp(&other[0]))
            .then(one[1].total_cmp(&other[1]))
    });
    Ok(lines)
}
