//! Draws tiles and other windows: each cell takes the mean of the samples that it covers on the ray through its middle.

use super::layout::{Layout, Ray, TileIndex};
use super::scan::spans;
use super::{Gain, GainTable, MosaicSettings, Overlap};
use crate::bathymetry::Grid;
use crate::progress::{Cancelled, Progress};
use crate::survey::{Side, SideSpan, Survey};
use std::convert::Infallible;
use std::ops::Range;

/// Cells along a tile's side.
pub const TILE_CELLS: usize = 256;
/// Most pings that a line of a coarse picture is the mean of: more of them would cost more than they smooth.
const MOST_AVERAGED: usize = 16;
/// Weight of the edges of a swath in a blend; its middle has 1.
const EDGE_WEIGHT: f32 = 0.03;

/// A piece of the mosaic.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Rows of [`TILE_CELLS`] levels: 0 where nothing was seen, else 1 to 255.
    pub levels: Vec<u8>,
}

impl Tile {
    /// Whether no cell was seen.
    pub fn is_empty(&self) -> bool {
        self.levels.iter().all(|&level| level == 0)
    }
}

/// Draws the tile of a row and column of tiles. `gain` is used where the settings ask for it.
pub fn tile(
    survey: &Survey,
    layout: &Layout,
    grid: &Grid,
    index: &TileIndex,
    gain: &GainTable,
    settings: &MosaicSettings,
    [row, column]: [usize; 2],
) -> Tile {
    let (first_row, first_column) = (row * TILE_CELLS, column * TILE_CELLS);
    let window = Grid {
        west_m: grid.west_m + first_column as f64 * grid.cell_m,
        north_m: grid.north_m - first_row as f64 * grid.cell_m,
        cell_m: grid.cell_m,
        // Cells of the grid inside this tile.
        columns: grid.columns.saturating_sub(first_column).min(TILE_CELLS),
        rows: grid.rows.saturating_sub(first_row).min(TILE_CELLS),
    };
    let canvas = Canvas::new(window, [TILE_CELLS; 2], layout.water_column(), settings);
    let strips = index.strips(row, column);
    let go_on = || Ok::<(), Infallible>(());
    let Ok(levels) = draw(canvas, survey, layout, strips, gain, settings, go_on);
    Tile { levels }
}

/// Draws all cells of a grid, row by row: 0 where nothing was seen, else 1 to 255. With a thinned layout a coarse grid costs
/// what it shows.
pub fn window(
    survey: &Survey,
    layout: &Layout,
    grid: &Grid,
    gain: &GainTable,
    settings: &MosaicSettings,
    progress: &Progress,
) -> Result<Vec<u8>, Cancelled> {
    let canvas = Canvas::new(
        *grid,
        [grid.columns, grid.rows],
        layout.water_column(),
        settings,
    );
    let ground = [
        grid.west_m,
        grid.north_m - grid.rows as f64 * grid.cell_m,
        grid.west_m + grid.columns as f64 * grid.cell_m,
        grid.north_m,
    ];
    let strips = layout.strips_in(ground);
    draw(canvas, survey, layout, strips, gain, settings, || {
        progress.check()
    })
}

/// Lays strips over each other. `check` is asked before each whether to go on.
fn draw<E>(
    mut canvas: Canvas<'_>,
    survey: &Survey,
    layout: &Layout,
    strips: impl Iterator<Item = (usize, Side)>,
    gain: &GainTable,
    settings: &MosaicSettings,
    check: impl Fn() -> Result<(), E>,
) -> Result<Vec<u8>, E> {
    let mut echoes =
        [Side::Port, Side::Starboard].map(|side| Echoes::new(side, layout.water_column()));
    let gain = (settings.gain == Gain::Empirical).then_some(gain);
    for (ping, side) in strips {
        check()?;
        let echoes = &mut echoes[usize::from(side == Side::Starboard)];
        if let Some(strip) = layout.strip(ping, side) {
            let [here, next] = &strip;
            let sums = [(ping, here), (ping + 1, next)].map(|(ping, ray)| {
                let heard = layout.ping(ping);
                let around = layout.stands_for(ping);
                let heard =
                    heard.is_some_and(|heard| echoes.hear(survey, gain, ping, heard, around, ray));
                (ping % 2, heard)
            });
            if sums.iter().all(|(_, heard)| *heard) {
                let lines = sums.map(|(slot, _)| echoes.kept[slot].1.as_slice());
                canvas.paint(&layout.corners(&strip), &strip, lines);
            }
        }
    }
    Ok(canvas.finish())
}

/// Levels of the last two pings of a side, summed outward: `sums[n]` is the sum of the first n samples.
struct Echoes {
    side: Side,
    water_column: bool,
    kept: [(usize, Vec<f32>); 2],
    samples: Vec<u8>,
    /// Sums over the pings that one stands for, sample by sample.
    totals: Vec<u32>,
}

impl Echoes {
    fn new(side: Side, water_column: bool) -> Self {
        let none = || (usize::MAX, Vec::new());
        Self {
            side,
            water_column,
            kept: [none(), none()],
            samples: Vec::new(),
            totals: Vec::new(),
        }
    }

    /// Adds up the samples of a ping and of those `around` it that were recorded over the same range; how many that were.
    fn add_up(&mut self, survey: &Survey, ping: usize, around: Range<usize>) -> u32 {
        let own = survey.span(ping, self.side);
        let is_like = |other: usize| {
            let span = survey.span(other, self.side);
            let same = |a: &SideSpan, b: &SideSpan| {
                (a.count, a.near_m, a.far_m) == (b.count, b.near_m, b.far_m)
            };
            own.zip(span).is_some_and(|(own, span)| same(own, span))
        };
        let step = around.len().div_ceil(MOST_AVERAGED).max(1);
        let others = around.step_by(step).filter(|&other| other != ping);
        self.totals.clear();
        let mut count = 0;
        for ping in std::iter::once(ping).chain(others.filter(|&other| is_like(other))) {
            let Some(samples) = survey.samples(ping, self.side) else {
                continue;
            };
            samples.copy_outward(&mut self.samples);
            self.totals
                .resize(self.samples.len().max(self.totals.len()), 0);
            for (total, level) in self.totals.iter_mut().zip(&self.samples) {
                *total += u32::from(*level);
            }
            count += 1;
        }
        count
    }

    /// Reads a ping into the slot of its place in the layout (the last bit), unless it is there: the mean of it and those that
    /// it stands for. False when there is nothing to read.
    fn hear(
        &mut self,
        survey: &Survey,
        gain: Option<&GainTable>,
        place: usize,
        ping: usize,
        around: Range<usize>,
        ray: &Ray,
    ) -> bool {
        let slot = place % 2;
        if self.kept[slot].0 == place {
            return true;
        }
        let count = self.add_up(survey, ping, around);
        if count == 0 {
            return false;
        }
        self.kept[slot].0 = place;
        let sums = &mut self.kept[slot].1;
        sums.clear();
        sums.push(0.0);
        let mut sum = 0.0;
        for (index, &total) in self.totals.iter().enumerate() {
            let range_m = ray.range_m(index as f64 + 0.5);
            let factor = match gain {
                Some(gain) if range_m > ray.altitude_m => {
                    gain.factor(self.side, range_m, ray.altitude_m)
                }
                // The water column has no ground to be evened by.
                _ if self.water_column => 1.0,
                _ => gain.map_or(1.0, |gain| {
                    gain.factor(self.side, ray.altitude_m, ray.altitude_m)
                }),
            };
            sum += total as f32 / count as f32 * factor;
            sums.push(sum);
        }
        true
    }
}

/// Mean of the samples between two places counted in samples, by their running sums. At least one sample wide.
fn mean(sums: &[f32], from: f64, to: f64) -> Option<f32> {
    let last = (sums.len() - 1) as f64;
    let middle = 0.5 * (from + to);
    let half = (0.5 * (to - from)).max(0.5);
    if middle < 0.0 || middle > last {
        return None;
    }
    let (from, to) = ((middle - half).max(0.0), (middle + half).min(last));
    let at = |place: f64| {
        let low = (place as usize).min(sums.len() - 2);
        sums[low] + (sums[low + 1] - sums[low]) * (place - low as f64) as f32
    };
    Some((at(to) - at(from)) / (to - from) as f32)
}

/// The cells of a window while strips are laid over each other.
struct Canvas<'a> {
    settings: &'a MosaicSettings,
    water_column: bool,
    window: Grid,
    /// Cells from a row to the next.
    stride: usize,
    /// Weighted sum of levels, and the weights.
    sums: Vec<[f32; 2]>,
}

impl<'a> Canvas<'a> {
    /// For a window in the north-west of as many columns and rows of cells.
    fn new(
        window: Grid,
        [columns, rows]: [usize; 2],
        water_column: bool,
        settings: &'a MosaicSettings,
    ) -> Self {
        Self {
            settings,
            water_column,
            window,
            stride: columns,
            sums: vec![[0.0; 2]; columns * rows],
        }
    }

    /// Lays a strip over the cells whose middles lie in it.
    fn paint(&mut self, corners: &[[f64; 2]; 4], strip: &[Ray; 2], lines: [&[f32]; 2]) {
        let window = self.window;
        // In cells from the window's north-west corner, rows southward; a cell's middle is at + 0.5.
        let corners = corners.map(|[x, y]| {
            [
                (x - window.west_m) / window.cell_m - 0.5,
                (window.north_m - y) / window.cell_m - 0.5,
            ]
        });
        for (row, columns) in spans(&corners, window.columns, window.rows) {
            for column in columns {
                let place = window.centre(row, column);
                if let Some([level, weight]) = self.look(strip, lines, place) {
                    self.lay(row * self.stride + column, level, weight);
                }
            }
        }
    }

    /// Level and blending weight of a strip at a place; `None` where the strip does not show it.
    fn look(&self, strip: &[Ray; 2], lines: [&[f32]; 2], place: [f64; 2]) -> Option<[f32; 2]> {
        let [share, ground_m] = within(strip, place)?;
        let altitude_m = strip[0].altitude_m + (strip[1].altitude_m - strip[0].altitude_m) * share;
        if ground_m < altitude_m * self.settings.nadir_gap_deg.to_radians().tan() {
            return None;
        }
        let heard = |ray: &Ray, sums: &[f32]| {
            let range_m = |ground_m: f64| match self.water_column {
                true => ground_m,
                false => ground_m.max(0.0).hypot(ray.altitude_m),
            };
            let [from, to] = [-0.5, 0.5]
                .map(|half| ray.sample_at(range_m(ground_m + half * self.window.cell_m)));
            mean(sums, from, to)
        };
        let levels = [heard(&strip[0], lines[0])?, heard(&strip[1], lines[1])?];
        let level = levels[0] + (levels[1] - levels[0]) * share as f32;
        let along =
            (ground_m / strip[0].reach_m(self.water_column).max(0.1)).clamp(0.0, 1.0) as f32;
        Some([level, (4.0 * along * (1.0 - along)).max(EDGE_WEIGHT)])
    }

    fn lay(&mut self, cell: usize, level: f32, weight: f32) {
        let sum = &mut self.sums[cell];
        match self.settings.overlap {
            Overlap::Later => *sum = [level, 1.0],
            Overlap::Brighter if sum[1] == 0.0 || level > sum[0] => *sum = [level, 1.0],
            Overlap::Brighter => {}
            Overlap::Blend => *sum = [sum[0] + level * weight, sum[1] + weight],
        }
    }

    fn finish(self) -> Vec<u8> {
        let level = |&[sum, weight]: &[f32; 2]| {
            if weight > 0.0 {
                (sum / weight).round().clamp(1.0, 255.0) as u8
            } else {
                0
            }
        };
        self.sums.iter().map(level).collect()
    }
}

/// Where a place lies in a strip: the share of the way from the first ray to the second, 0 to below 1, and the distance out
/// along the ray there, metres on the ground.
///
/// The ray at share `u` starts at `p + u dp` and runs along `s + u ds`. The place `q` (from `p`) lies on it where
/// `(q - u dp) x (s + u ds) = 0`, which is `q x s + u (q x ds - dp x s) - u^2 dp x ds = 0`.
fn within([here, next]: &[Ray; 2], place: [f64; 2]) -> Option<[f64; 2]> {
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let q = minus(place, here.at);
    let (dp, ds) = (minus(next.at, here.at), minus(next.out, here.out));
    let (a, b, c) = (
        -cross(dp, ds),
        cross(q, ds) - cross(dp, here.out),
        cross(q, here.out),
    );
    let roots = if a.abs() < 1e-9 * b.abs() {
        [-c / b, f64::NAN]
    } else {
        let root = (b * b - 4.0 * a * c).sqrt();
        // Of the two forms the one that does not take a difference of nearly equal numbers.
        let sum = -0.5 * (b + b.signum() * root);
        [c / sum, sum / a]
    };
    roots.into_iter().find_map(|share| {
        if !(0.0..1.0).contains(&share) {
            return None;
        }
        let out = [here.out[0] + share * ds[0], here.out[1] + share * ds[1]];
        let from = [q[0] - share * dp[0], q[1] - share * dp[1]];
        let ground_m = (from[0] * out[0] + from[1] * out[1]) / (out[0] * out[0] + out[1] * out[1]);
        (ground_m >= 0.0).then_some([share, ground_m])
    })
}
