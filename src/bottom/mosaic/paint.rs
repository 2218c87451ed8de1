//! Draws tiles and other windows: each cell has the mean of the samples that it covers on the ray
//! through its middle. The part of a tile that one log shows can be stored, and joined with those
//! of other logs at any later time.

use super::canvas::{Canvas, CellSum};
use super::layout::{MosaicLayout, MosaicRay, TILE_CELLS, TileIndex};
use super::line::{LineContext, MosaicLine};
use super::{GainTable, MosaicSettings, Overlap};
use crate::bathymetry::Grid;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Side, Survey};
use std::convert::Infallible;
use std::sync::Arc;

/// Log in a mosaic.
#[derive(Clone, Debug)]
pub struct MosaicLog {
    /// The recording.
    pub survey: Arc<Survey>,
    /// Layout of its pings, in the plane that all logs share.
    pub layout: Arc<MosaicLayout>,
    /// Gain table that its levels are normalised with.
    pub gain: GainTable,
}

/// Draws the tile at a row and column of tiles, `place`, of several logs, each with its index: rows
/// of [`TILE_CELLS`] levels, 0 where nothing was insonified, else 1 to 255. The logs are drawn one
/// after the other by the rule of `mosaic.overlap`; the last one counts as the latest. Their gain
/// tables are used only where the settings require it.
pub fn joint_tile(
    logs: &[(&MosaicLog, &TileIndex)],
    grid: &Grid,
    settings: &MosaicSettings,
    place: [usize; 2],
) -> Vec<u8> {
    painted(logs, grid, settings, place).finish()
}

/// Paints a tile on a canvas, without converting it to levels.
fn painted(
    logs: &[(&MosaicLog, &TileIndex)],
    grid: &Grid,
    settings: &MosaicSettings,
    [row, column]: [usize; 2],
) -> Canvas {
    let (first_row, first_column) = (row * TILE_CELLS, column * TILE_CELLS);
    let window = Grid {
        west_m: grid.west_m + first_column as f64 * grid.cell_m,
        north_m: grid.north_m - first_row as f64 * grid.cell_m,
        cell_m: grid.cell_m,
        // Cells of the grid inside this tile.
        columns: grid.columns.saturating_sub(first_column).min(TILE_CELLS),
        rows: grid.rows.saturating_sub(first_row).min(TILE_CELLS),
    };
    let mut canvas = Canvas::new(window, [TILE_CELLS; 2], settings);
    let go_on = || Ok::<(), Infallible>(());
    for (log, index) in logs {
        let strips = index.strips(row, column);
        let lines = LineContext::new(&log.survey, &log.layout, &log.gain, settings, grid.cell_m);
        let Ok(()) = draw(&mut canvas, &log.layout, &lines, strips, go_on);
    }
    canvas
}

/// Draws all cells of a grid, row by row: 0 where nothing was insonified, else 1 to 255. With a
/// thinned layout, the time for a coarse grid is in proportion to the cells that it shows.
///
/// # Errors
/// When the work was cancelled.
pub fn window(
    survey: &Survey,
    layout: &MosaicLayout,
    grid: &Grid,
    gain: &GainTable,
    settings: &MosaicSettings,
    progress: &Progress,
) -> Result<Vec<u8>, Cancelled> {
    joint_window(std::iter::once((survey, layout, gain)), grid, settings, progress)
}

/// Draws all cells of a grid as [`window`] does, from several logs, one after the other by the rule
/// of `mosaic.overlap`.
///
/// # Errors
/// When the work was cancelled.
pub fn joint_window<'a>(
    logs: impl Iterator<Item = (&'a Survey, &'a MosaicLayout, &'a GainTable)>,
    grid: &Grid,
    settings: &MosaicSettings,
    progress: &Progress,
) -> Result<Vec<u8>, Cancelled> {
    let mut canvas = Canvas::new(*grid, [grid.columns, grid.rows], settings);
    let ground = grid.bounds_m();
    for (survey, layout, gain) in logs {
        let strips = layout.strips_in(ground);
        let lines = LineContext::new(survey, layout, gain, settings, grid.cell_m);
        draw(&mut canvas, layout, &lines, strips, || progress.check())?;
    }
    Ok(canvas.finish())
}

/// Paints strips over each other on the canvas. `check` is called before each strip, and its error
/// ends the drawing.
fn draw<E>(
    canvas: &mut Canvas,
    layout: &MosaicLayout,
    lines: &LineContext<'_>,
    strips: impl Iterator<Item = (usize, Side)>,
    check: impl Fn() -> Result<(), E>,
) -> Result<(), E> {
    // Lines of the last two pings of each side.
    let none = |side| [MosaicLine::none(side), MosaicLine::none(side)];
    let mut kept = Side::BOTH.map(none);
    for (ping, side) in strips {
        check()?;
        let Some(strip) = layout.strip(ping, side) else {
            continue;
        };
        let kept = &mut kept[side as usize];
        let apart_m = farthest_apart_m(&strip);
        let mut is_there = true;
        for (place, ray) in [ping, ping + 1].into_iter().zip(&strip) {
            // A part with a margin saves reading the ray again for the next strip.
            let parts = [1.0, 2.0].map(|times| canvas.distances_m(ray, times * apart_m));
            is_there &= match parts {
                [Some(part), Some(with_margin)] => {
                    kept[place % 2].read(lines, place, ray, part, with_margin)
                }
                _ => false,
            };
        }
        if is_there {
            let both = [ping, ping + 1].map(|place| &kept[place % 2]);
            canvas.paint(&layout.corners(&strip), &strip, both);
        }
    }
    Ok(())
}

/// Returns the largest distance between places equally far along both rays of a strip, in the plane
/// of the map.
fn farthest_apart_m(strip: &[MosaicRay; 2]) -> f64 {
    let [near, far] =
        [|ray: &MosaicRay| ray.at, |ray: &MosaicRay| ray.place(ray.range_m(ray.count as f64))]
            .map(|place| strip.each_ref().map(place));
    let apart = |[[x0, y0], [x1, y1]]: [[f64; 2]; 2]| (x1 - x0).hypot(y1 - y0);
    apart(near).max(apart(far))
}

/// Part of a tile that one log shows.
#[derive(Clone, Debug, PartialEq)]
pub struct MosaicPart {
    /// Rows of [`TILE_CELLS`] levels: 0 where nothing was insonified, else 1 to 255.
    pub levels: Vec<u8>,
    /// Weight of each level when it is joined with the levels of other logs, 0 where nothing was
    /// insonified; empty where `mosaic.overlap` uses no weights.
    pub weights: Vec<f32>,
}

impl MosaicPart {
    /// Returns true if no cell was insonified.
    pub fn is_empty(&self) -> bool {
        self.levels.iter().all(|&level| level == 0)
    }

    /// Returns the part with all levels multiplied by a factor.
    #[must_use]
    pub fn brightened(mut self, factor: f32) -> Self {
        for level in self.levels.iter_mut().filter(|level| **level > 0) {
            *level = (f32::from(*level) * factor).round().clamp(1.0, 255.0) as u8;
        }
        self
    }
}

/// Draws the part of a log in the tile at a row and column of tiles, `place`.
pub fn part(
    log: &MosaicLog,
    index: &TileIndex,
    grid: &Grid,
    settings: &MosaicSettings,
    place: [usize; 2],
) -> MosaicPart {
    let sums = painted(&[(log, index)], grid, settings, place).sums;
    let weights = if settings.overlap.is_weighted() {
        sums.iter().map(|sum| stepped(sum.weight)).collect()
    } else {
        Vec::new()
    };
    MosaicPart { levels: sums.iter().map(CellSum::level).collect(), weights }
}

/// Rounds a weight to whole steps. Sums of levels times such weights are exact in 32 bits for 256
/// logs in any order, and such weights compress to a third of the size.
fn stepped(weight: f32) -> f32 {
    const STEPS: f32 = 256.0;
    (weight * STEPS).round() / STEPS
}

/// Joins the parts of several logs to a tile, one after the other by the rule of `mosaic.overlap`;
/// the part of a single log gives the same tile as [`joint_tile`].
///
/// # Errors
/// The first error of the parts.
pub fn join_parts<E>(
    parts: impl Iterator<Item = Result<MosaicPart, E>>,
    overlap: Overlap,
) -> Result<Vec<u8>, E> {
    let mut sums = vec![CellSum::default(); TILE_CELLS * TILE_CELLS];
    for part in parts {
        let MosaicPart { levels, weights } = part?;
        let weights = weights.into_iter().chain(std::iter::repeat(1.0));
        for ((sum, level), weight) in sums.iter_mut().zip(levels).zip(weights) {
            if level > 0 {
                overlap.join(sum, CellSum::of(f32::from(level), weight));
            }
        }
    }
    Ok(sums.iter().map(CellSum::level).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn part_of(cells: &[(u8, f32)], is_weighted: bool) -> MosaicPart {
        let mut levels: Vec<u8> = cells.iter().map(|cell| cell.0).collect();
        levels.resize(TILE_CELLS * TILE_CELLS, 0);
        let mut weights: Vec<f32> = cells.iter().map(|cell| stepped(cell.1)).collect();
        weights.resize(TILE_CELLS * TILE_CELLS, 0.0);
        MosaicPart { levels, weights: if is_weighted { weights } else { Vec::new() } }
    }

    fn joined(overlap: Overlap, parts: &[&[(u8, f32)]]) -> Vec<u8> {
        let parts = parts.iter();
        let parts = parts.map(|cells| Ok::<_, Infallible>(part_of(cells, overlap.is_weighted())));
        let Ok(tile) = join_parts(parts, overlap);
        tile[..3].to_vec()
    }

    #[test]
    fn parts_are_joined_by_the_rule_of_the_mosaic() {
        // The first log shows the first and the second cell, the second log the second and the
        // third.
        let one: &[(u8, f32)] = &[(10, 0.5), (200, 0.9), (0, 0.0)];
        let other: &[(u8, f32)] = &[(0, 0.0), (100, 0.3), (7, 0.03)];
        assert_eq!(joined(Overlap::Later, &[one, other]), [10, 100, 7]);
        assert_eq!(joined(Overlap::Later, &[other, one]), [10, 200, 7]);
        for order in [[one, other], [other, one]] {
            assert_eq!(joined(Overlap::Brighter, &order), [10, 200, 7]);
            assert_eq!(joined(Overlap::Middle, &order), [10, 200, 7]);
            assert_eq!(joined(Overlap::Blend, &order), [10, 175, 7]);
        }
    }

    #[test]
    fn a_mean_of_many_parts_does_not_hang_on_their_order() {
        let logs: Vec<[(u8, f32); 3]> = (0..40_u8)
            .map(|log| {
                let level = |step: u8| 1 + log.wrapping_mul(step) % 255;
                let weight = f32::from(log + 1) / 41.0;
                [(level(7), weight), (level(31), 1.0 - weight), (level(3), 0.03)]
            })
            .collect();
        let forward: Vec<&[(u8, f32)]> = logs.iter().map(|log| &log[..]).collect();
        let backward: Vec<&[(u8, f32)]> = logs.iter().rev().map(|log| &log[..]).collect();
        assert_eq!(joined(Overlap::Blend, &forward), joined(Overlap::Blend, &backward));
    }
}
