//! Paints strips over each other on the cells of a window, and finds row by row the cells that each
//! strip covers. Echoes of cells that were insonified more than once are joined.

use super::MosaicSettings;
use super::layout::MosaicRay;
use super::line::MosaicLine;
use crate::bathymetry::Grid;
use crate::vectors::{VectorLoop, vectorised};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Number of cells that are located between rays at a time.
const RUN: usize = 8;
/// Length in cells by which a span is made longer at both ends: a cell on the edge between two
/// polygons must be in one of them, however their corners are rounded.
const MARGIN: f64 = 1e-6;

/// Window of cells with the sums of their echoes.
pub(super) struct Canvas {
    overlap: Overlap,
    /// Tangent of the angle from straight down within which nothing is shown.
    nadir_gap: f64,
    window: Grid,
    /// Number of cells from a row to the next.
    stride: usize,
    /// Sums of all cells.
    pub sums: Vec<CellSum>,
}

impl Canvas {
    /// Creates a canvas of `columns` by `rows` cells, with the window in its north-west corner.
    pub(super) fn new(
        window: Grid,
        [columns, rows]: [usize; 2],
        settings: &MosaicSettings,
    ) -> Self {
        Self {
            overlap: settings.overlap,
            nadir_gap: settings.nadir_gap_deg.to_radians().tan(),
            window,
            stride: columns,
            sums: vec![CellSum::default(); columns * rows],
        }
    }

    /// Returns the smallest and the largest ground distance along a ray of a strip at which the ray
    /// is no farther than `apart_m` from a cell of the window; `None` if there is no such distance.
    pub(super) fn distances_m(&self, ray: &MosaicRay, apart_m: f64) -> Option<[f64; 2]> {
        let window = &self.window;
        let around_m = apart_m + window.cell_m;
        let [west_m, south_m, east_m, north_m] = window.bounds_m();
        let mut distances_m = [0.0, f64::INFINITY];
        for (axis, bounds_m) in [[west_m, east_m], [south_m, north_m]].into_iter().enumerate() {
            let from_here = bounds_m.map(|bound_m| bound_m - ray.at[axis]);
            let [least_m, most_m] = [from_here[0] - around_m, from_here[1] + around_m];
            let out = ray.out[axis];
            if out.abs() < 1e-9 {
                if least_m > 0.0 || most_m < 0.0 {
                    return None;
                }
                continue;
            }
            let [one_m, other_m] = [least_m / out, most_m / out];
            distances_m[0] = distances_m[0].max(one_m.min(other_m));
            distances_m[1] = distances_m[1].min(one_m.max(other_m));
        }
        (distances_m[0] <= distances_m[1]).then_some(distances_m)
    }

    /// Paints a strip on the cells whose centres are in it.
    pub(super) fn paint(
        &mut self,
        corners: &[[f64; 2]; 4],
        strip: &[MosaicRay; 2],
        lines: [&MosaicLine; 2],
    ) {
        vectorised(PaintStrip { canvas: self, corners, strip, lines });
    }

    /// Returns the levels of all cells: 0 where nothing was insonified, else 1 to 255.
    pub(super) fn finish(self) -> Vec<u8> {
        let mut levels = vec![0; self.sums.len()];
        vectorised(FinishCells { sums: &self.sums, levels: &mut levels });
        levels
    }
}

/// Arguments of [`Canvas::paint`] for the vectorised loop.
struct PaintStrip<'a> {
    canvas: &'a mut Canvas,
    corners: &'a [[f64; 2]; 4],
    strip: &'a [MosaicRay; 2],
    lines: [&'a MosaicLine; 2],
}

impl VectorLoop for PaintStrip<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { canvas, corners, strip, lines } = self;
        let window = canvas.window;
        // Cells are processed along rows or along columns, whichever is closer to the direction of
        // the rays: this gives few and long runs.
        let is_along_rows = strip[0].out[0].abs() >= strip[0].out[1].abs();
        let turned = |[x, y]: [f64; 2]| if is_along_rows { [x, y] } else { [y, x] };
        // Corners in cells from the middle of the window's north-west cell, rows southward.
        let mut in_cells = *corners;
        for corner in &mut in_cells {
            *corner = turned([
                (corner[0] - window.west_m) / window.cell_m - 0.5,
                (window.north_m - corner[1]) / window.cell_m - 0.5,
            ]);
        }
        let (counts, steps) = if is_along_rows {
            ([window.columns, window.rows], [1, canvas.stride])
        } else {
            ([window.rows, window.columns], [canvas.stride, 1])
        };
        let between = GroundBetween::new(strip);
        let [from_m, to_m] = [strip[0].altitude_m, strip[1].altitude_m];
        let reach_m = strip[0].shown_m.max(0.1);
        let scan = Scan::new(&in_cells, counts[0], counts[1]);
        for line in scan.rows.clone() {
            let cells = scan.columns(line);
            for start in cells.clone().step_by(RUN) {
                let (mut shares, mut grounds_m) = ([0.0; RUN], [0.0; RUN]);
                for (index, (share, ground_m)) in shares.iter_mut().zip(&mut grounds_m).enumerate()
                {
                    let along = start as f64 + index as f64 + 0.5;
                    let [column, row] = turned([along, line as f64 + 0.5]);
                    let x = window.west_m + column * window.cell_m;
                    let y = window.north_m - row * window.cell_m;
                    [*share, *ground_m] = between.find([x, y]);
                }
                let places = shares.iter().zip(&grounds_m);
                for ((&share, &ground_m), cell) in places.zip(start..cells.end) {
                    let altitude_m = from_m + (to_m - from_m) * share;
                    let is_in_gap =
                        canvas.nadir_gap > 0.0 && ground_m < altitude_m * canvas.nadir_gap;
                    if ground_m.is_nan() || is_in_gap {
                        continue;
                    }
                    let [from, to] = [lines[0].at(ground_m), lines[1].at(ground_m)];
                    let level = from + (to - from) * share as f32;
                    if !level.is_nan() {
                        let echo = CellSum::of(level, canvas.overlap.weight(ground_m / reach_m));
                        let cell = &mut canvas.sums[cell * steps[0] + line * steps[1]];
                        canvas.overlap.join(cell, echo);
                    }
                }
            }
        }
    }
}

/// Arguments of [`Canvas::finish`] for the vectorised loop.
struct FinishCells<'a> {
    sums: &'a [CellSum],
    levels: &'a mut [u8],
}

impl VectorLoop for FinishCells<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (level, sum) in self.levels.iter_mut().zip(self.sums) {
            *level = sum.level();
        }
    }
}

/// Ground between two rays, on which a ray turns and moves evenly from the first to the second.
///
/// The ray at share `u` starts at `p + u dp` and runs along `s + u ds`. The place `q` (from `p`) is
/// on this ray where `f(u) = (q - u dp) x (s + u ds) = 0`. `f` is quadratic in `u`. The signs of
/// `f(0) = q x s` and `f(1) = (q - dp) x (s + ds)` give the side of the first and of the second ray
/// that the place is on. Where they differ, the place is between the rays.
struct GroundBetween {
    here: MosaicRay,
    next: MosaicRay,
    dp: [f64; 2],
    ds: [f64; 2],
    /// Coefficient of the square in `f`.
    bend: f64,
}

#[inline(always)]
fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline(always)]
fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

impl GroundBetween {
    #[inline(always)]
    fn new(&[here, next]: &[MosaicRay; 2]) -> Self {
        let (dp, ds) = (minus(next.at, here.at), minus(next.out, here.out));
        Self { here, next, dp, ds, bend: -cross(dp, ds) }
    }

    /// Finds a place between the rays: returns the share of the way from the first ray to the
    /// second, and the ground distance outward along the ray there, metres; the distance is NaN
    /// where the place is not between the rays.
    #[inline(always)]
    fn find(&self, place: [f64; 2]) -> [f64; 2] {
        let q = minus(place, self.here.at);
        let first = cross(q, self.here.out);
        // The next strip computes the same sign for this ray, so no place is in both strips or in
        // neither.
        let second = cross(minus(place, self.next.at), self.next.out);
        let is_between = (first >= 0.0) != (second >= 0.0);
        // The chord of `f`, then a step of Newton's method: the bend is small against the chord.
        let per_share = 1.0 / (first - second);
        let chord = first * per_share;
        let share = (chord - self.bend * chord * (1.0 - chord) * per_share).clamp(0.0, 1.0);
        let out = [self.here.out[0] + share * self.ds[0], self.here.out[1] + share * self.ds[1]];
        let from = [q[0] - share * self.dp[0], q[1] - share * self.dp[1]];
        let ground_m = (from[0] * out[0] + from[1] * out[1]) / (out[0] * out[0] + out[1] * out[1]);
        let is_there = is_between & (ground_m >= 0.0);
        [share, if is_there { ground_m } else { f64::NAN }]
    }
}

/// Cells, within a number of columns and rows, whose centres are in a polygon.
pub(super) struct Scan<'a> {
    /// Corners of the polygon, in cells from the middle of the first cell.
    corners: &'a [[f64; 2]; 4],
    columns: usize,
    /// Rows that the polygon covers.
    pub rows: Range<usize>,
    low: f64,
    high: f64,
}

impl<'a> Scan<'a> {
    /// Creates the scan of a polygon; its corners are in cells from the middle of the first cell.
    #[inline(always)]
    pub(super) fn new(corners: &'a [[f64; 2]; 4], columns: usize, rows: usize) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in corners {
            (low, high) = (low.min(corner[1]), high.max(corner[1]));
        }
        Self { corners, columns, rows: cells(low, high, rows), low, high }
    }

    /// Returns the columns that the polygon covers in one of its rows.
    #[inline(always)]
    pub(super) fn columns(&self, row: usize) -> Range<usize> {
        // A row whose middle is outside the polygon by rounding is moved to the edge.
        let row = (row as f64).max(self.low).min(self.high);
        let [from, to] = crossing(self.corners, row);
        cells(from, to, self.columns)
    }
}

/// Returns the cells whose centres are between two places, within `0..count`.
#[inline(always)]
fn cells(from: f64, to: f64, count: usize) -> Range<usize> {
    let start = ((from - MARGIN).ceil().max(0.0) as usize).min(count);
    let end = (((to + MARGIN).floor() + 1.0).max(0.0) as usize).min(count);
    start..end.max(start)
}

/// Returns the first and the last column at which a row crosses a polygon; the first is larger than
/// the last where the row does not cross it.
#[inline(always)]
fn crossing(corners: &[[f64; 2]; 4], row: f64) -> [f64; 2] {
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for index in 0..4 {
        let (a, b) = (corners[index], corners[(index + 1) % 4]);
        // The ends of an edge along the row belong to its neighbours too.
        if a[1] == b[1] || (a[1] - row) * (b[1] - row) > 0.0 {
            continue;
        }
        let column = a[0] + (b[0] - a[0]) * (row - a[1]) / (b[1] - a[1]);
        (first, last) = (first.min(column), last.max(column));
    }
    [first, last]
}

/// Weight of the edges of a swath; the middle has weight 1.
const EDGE_WEIGHT: f64 = 0.03;

/// Rule for cells that were insonified more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Overlap {
    /// The echo of the later pass.
    #[default]
    Later,
    /// The brighter echo: objects stay, shadows are lost.
    Brighter,
    /// The echo nearest to the middle of its swath, halfway out, where side-scan insonifies the
    /// ground best: objects and shadows stay, and the weak ends of a swath show only where there is
    /// nothing else.
    Middle,
    /// The mean, weighted towards the middle of each swath: smooth, but objects and shadows fade.
    Blend,
}

/// Weighted sum of the echoes of a cell so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CellSum {
    /// Sum of levels times their weights.
    weighted: f32,
    /// Sum of the weights; 0 where nothing was insonified.
    pub weight: f32,
}

impl CellSum {
    /// Creates the sum from one echo, or from the level of a whole log in the cell.
    #[inline(always)]
    pub(super) fn of(level: f32, weight: f32) -> Self {
        Self { weighted: level * weight, weight }
    }

    /// Returns the level: 0 where nothing was insonified, else 1 to 255.
    #[inline(always)]
    pub(super) fn level(&self) -> u8 {
        if self.weight > 0.0 {
            (self.weighted / self.weight).round().clamp(1.0, 255.0) as u8
        } else {
            0
        }
    }
}

impl Overlap {
    /// Returns true if the weight of an echo depends on its place in the swath.
    #[inline(always)]
    pub fn is_weighted(self) -> bool {
        matches!(self, Self::Middle | Self::Blend)
    }

    /// Returns the weight of an echo at a share of the way outward, 0 to 1: largest in the middle
    /// of the swath.
    #[inline(always)]
    pub(super) fn weight(self, way: f64) -> f32 {
        let way = way.clamp(0.0, 1.0);
        if self.is_weighted() { (4.0 * way * (1.0 - way)).max(EDGE_WEIGHT) as f32 } else { 1.0 }
    }

    /// Joins the sum of a cell with the sum of later echoes.
    #[inline(always)]
    pub(super) fn join(self, cell: &mut CellSum, later: CellSum) {
        if later.weight == 0.0 {
            return;
        }
        match self {
            Self::Later => *cell = later,
            Self::Brighter if cell.weight == 0.0 || later.weighted > cell.weighted => *cell = later,
            Self::Brighter => {}
            Self::Middle if later.weight > cell.weight => *cell = later,
            Self::Middle => {}
            Self::Blend => {
                cell.weighted += later.weighted;
                cell.weight += later.weight;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::AcrossTrack;

    #[test]
    fn a_place_between_two_turned_rays_is_found_where_it_was_put() {
        let ray = |at: [f64; 2], heading_deg: f64| MosaicRay {
            at,
            out: [heading_deg.to_radians().cos(), heading_deg.to_radians().sin()],
            altitude_m: 3.0,
            under_m: 3.0,
            across: AcrossTrack::LEVEL,
            start_m: 0.0,
            step_m: 0.02,
            count: 1400,
            shown_m: 28.0,
        };
        let strip = [ray([10.0, 20.0], 30.0), ray([10.0, 20.2], 33.0)];
        let between = GroundBetween::new(&strip);
        for share in [0.001, 0.25, 0.5, 0.9] {
            for ground_m in [0.01, 1.0, 7.0, 27.0] {
                let lerp = |a: f64, b: f64| a + (b - a) * share;
                let place = [0, 1].map(|axis| {
                    lerp(strip[0].at[axis], strip[1].at[axis])
                        + ground_m * lerp(strip[0].out[axis], strip[1].out[axis])
                });
                let found = between.find(place);
                assert!((found[0] - share).abs() < 1e-3, "{share} {ground_m}: {found:?}");
                assert!((found[1] - ground_m).abs() < 1e-3, "{share} {ground_m}: {found:?}");
            }
        }
        assert!(between.find([10.0, 19.9])[1].is_nan());
        assert!(between.find(strip[0].place(-3.0))[1].is_nan());
    }
}
