//! Estimates the uncertainty of the depths of a surface from the errors with which left-out
//! soundings are predicted.
//!
//! In: depths with their places, and their surface. Out: a standard deviation for each cell, and
//! one as a function of the distance to the nearest sounding.
//!
//! The noise of the depths themselves comes from soundings left out in squares of a few cells. The
//! error of the ground between lines comes from soundings left out in squares as large as the gaps
//! between the lines, and in strips of this width along the lines: whole lines are then predicted
//! from their neighbours, as the ground between them is. Soundings on a bank along a line predict
//! each other well. `by_distance` describes how the error grows with the distance to the nearest
//! sounding, and where it is larger or smaller than that. The same left-out soundings
//! decide whether triangles that bend by the slopes on the lines (`super::slopes`) predict the
//! ground better than straight ones.

mod by_distance;

pub use by_distance::SigmaByDistance;

use super::slopes::{Bend, Bends, NodeSlopes};
use super::{Between, DepthPoint, Grid, Node, Tin, merge_repeated, suited_cell_m};
use crate::nearest::Nearest;
use bathyscope_log::support::progress::{Cancelled, Progress};
use by_distance::{Roughness, RoughnessSampler};
use rayon::prelude::*;

/// Number of times that soundings are left out, a quarter of all squares each time.
const FOLDS: usize = 4;
/// Fewest left-out soundings that determine an error.
const LEAST_MISSES: usize = 40;
/// Largest number of soundings that are left out or kept: of more, this many are taken evenly.
const MOST_NODES: usize = 30_000;
/// Share of the map whose distances to a sounding determine the side of the large squares: twice
/// the distance that this share does not exceed. The middles of the squares are then as far from
/// soundings as the map between lines.
const DISTANCE_SHARE: f64 = 0.9;
/// Sides of large squares between one and twice its length.
const SIDES_PER_OCTAVE: f64 = 4.0;
/// Side of the small squares, cells.
const SMALL_CELLS: f64 = 2.0;
/// Side of the squares that slopes are taken over, three by three, as a share of the large ones.
const SLOPE_SHARE: f64 = 0.25;
/// Least agreement of the directions from soundings to their neighbours, as a share of the number
/// of soundings, at which the soundings lie along lines.
const LEAST_ALIGNED: f64 = 0.25;
/// Standard deviation of the depth as a share of the distance to the nearest of the planes through
/// the corners: of bent triangles, and of straight ones.
const BENT_ERROR: f64 = 0.2;
const STRAIGHT_ERROR: f64 = 0.5;
/// Share from which bends count in full: bends of this share or more predict left-out soundings
/// best. Two surveys along the same lines then bend alike.
const FULL_SHARE: f64 = 0.8;
/// Largest ratio of the errors of left-out soundings with bends to those without them, at which
/// bends count.
const MOST_RATIO: f64 = 0.98;
/// Most cells whose distances determine the size of the large squares.
const MOST_CELLS_TRIED: usize = 10_000;

/// Miss of a sounding that was left out: the predicted depth less the measured one, and the
/// distance to the nearest sounding that was kept, metres.
#[derive(Clone, Copy, Debug)]
struct LeftOutMiss {
    place: [f64; 2],
    error_m: f64,
    away_m: f64,
    bend: Bend,
}

/// Standard deviation of a depth's error by place and distance to the nearest sounding.
struct StatedError {
    by_distance: SigmaByDistance,
    /// Factors on the variance of the depths themselves, and on that of the bottom between them.
    near: Roughness,
    far: Roughness,
    /// Bends of the triangles; `None` where these are straight.
    bends: Option<Bends>,
}

/// Result of leaving out soundings of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LeftOut {
    /// There are too few soundings: depths and spreads stay as they are.
    TooFew,
    /// The spreads are standard deviations of errors now; the triangles bend by these bends, `None`
    /// where they stay straight.
    Told(Option<Bends>),
}

/// Bends the triangles of a surface as far as left-out soundings are then predicted better, and
/// replaces the spread of the cells by the standard deviation of their depth's error. The cells of
/// `grid` have depths, spreads, and distances to the nearest sounding, metres, row by row; NaN
/// where nothing is known.
///
/// # Errors
/// When the work was cancelled.
pub(super) fn bend_and_state_error(
    grid: &Grid,
    (depth_m, spread_m): (&mut [f32], &mut [f32]),
    distance_m: &[f32],
    tin: &Tin,
    between: Between,
    progress: &Progress,
) -> Result<LeftOut, Cancelled> {
    let nodes: Vec<Node> = tin.nodes().collect();
    let known = distance_m.iter().filter(|away_m| !away_m.is_nan());
    let usual_m = usual_of(known.copied().collect());
    let squares = Squares::over(grid, usual_m);
    let Some(stated) = StatedError::of(&nodes, squares, between, progress)? else {
        return Ok(LeftOut::TooFew);
    };
    let share = stated.bends.map_or(0.0, |bends| bends.share);
    let error_share = STRAIGHT_ERROR + share * (BENT_ERROR - STRAIGHT_ERROR);
    let slopes = NodeSlopes::of(&nodes, squares.slope_m());
    drop(nodes);
    let cells = spread_m.par_iter_mut().zip(depth_m).zip(distance_m);
    // A filter would move the samplers from cell to cell.
    cells.enumerate().for_each_init(
        || (stated.sampler(), slopes.sampler(tin.sampler(Between::Linear))),
        |(stated, bends), (cell, ((spread_m, depth_m), away_m))| {
            if spread_m.is_nan() {
                return;
            }
            let place = grid.centre_of(cell);
            let away_m = f64::from(*away_m);
            let mut bend_m = 0.0;
            if let Some(bend) = bends.at(place) {
                *depth_m += (share * bend.deeper_m()) as f32;
                // Nearer to a sounding than a side of the squares that slopes are taken over,
                // slopes do not determine how the bottom bends.
                let near = (1.0 - away_m / squares.slope_m()).max(0.0);
                bend_m = (error_share + near * (STRAIGHT_ERROR - error_share)) * bend.least_m;
            }
            *spread_m = stated.at(place, away_m).hypot(bend_m) as f32;
        },
    );
    Ok(LeftOut::Told(stated.bends))
}

/// Returns the error of a depth between soundings by the distance to the nearest, found by leaving
/// soundings out; distances up to `max_gap_m` count. `None` where there are too few soundings.
///
/// # Errors
/// When the work was cancelled.
pub fn sigma_by_distance(
    points: &[DepthPoint],
    max_gap_m: f64,
    progress: &Progress,
) -> Result<Option<SigmaByDistance>, Cancelled> {
    let grid = suited_cell_m(points, max_gap_m).and_then(|cell_m| Grid::over(points, cell_m, 4096));
    let Some(grid) = grid else {
        return Ok(None);
    };
    let nodes = merge_repeated(points, grid.cell_m);
    progress.check()?;
    let places: Vec<[f64; 2]> = nodes.iter().map(Node::place).collect();
    let Some(near) = Nearest::of(&places) else {
        return Ok(None);
    };
    let tried = grid.coarser(grid.times_coarser(MOST_CELLS_TRIED));
    let cells = (0..tried.len()).into_par_iter();
    let distances = cells.map(|cell| near.distance_m(tried.centre_of(cell)) as f32);
    let distances = distances.filter(|distance| f64::from(*distance) <= max_gap_m);
    let squares = Squares::over(&grid, usual_of(distances.collect()));
    let stated = StatedError::of(&nodes, squares, Between::Linear, progress)?;
    Ok(stated.map(|stated| stated.by_distance))
}

/// Sides of the squares that soundings are left out in, metres.
#[derive(Clone, Copy)]
struct Squares {
    small_m: f64,
    large_m: f64,
}

impl Squares {
    /// Returns the side of the squares that slopes are taken over.
    fn slope_m(self) -> f64 {
        SLOPE_SHARE * self.large_m
    }

    /// The side of the large squares is rounded: with a side that follows distances to the last
    /// digit, one sounding more would move all squares, and every stated error with them.
    fn over(grid: &Grid, usual_distance_m: f64) -> Self {
        let large_m = 2.0 * usual_distance_m.max(2.0 * grid.cell_m);
        Self {
            small_m: SMALL_CELLS * grid.cell_m,
            large_m: ((large_m.log2() * SIDES_PER_OCTAVE).round() / SIDES_PER_OCTAVE).exp2(),
        }
    }
}

impl StatedError {
    fn of(
        nodes: &[Node],
        squares: Squares,
        between: Between,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let step = nodes.len().div_ceil(MOST_NODES).max(1);
        // The small squares need the neighbours of a sounding, so that whole columns of large
        // squares are taken.
        let dense = nodes.iter().filter(|node| {
            step == 1 || column_and_row(node, squares.large_m)[0].rem_euclid(step as i64) == 0
        });
        let slope_m = squares.slope_m();
        let square = |side_m: f64| move |node: &Node| square_of(node, side_m);
        let mut near =
            misses(dense.copied().collect(), square(squares.small_m), between, slope_m, progress)?;
        let thin: Vec<Node> = nodes.iter().step_by(step).copied().collect();
        let places: Vec<[f64; 2]> = thin.iter().map(Node::place).collect();
        let mut strips = match direction(&places) {
            Some(along) => {
                let strip = |node: &Node| strip_of(node, along, squares.large_m);
                misses(thin.clone(), strip, between, slope_m, progress)?
            }
            None => Vec::new(),
        };
        let mut far = misses(thin, square(squares.large_m), between, slope_m, progress)?;
        if near.len() < LEAST_MISSES || far.len() < LEAST_MISSES {
            return Ok(None);
        }
        let bends = match between {
            Between::Linear => bends(&far, &strips, squares),
            Between::NaturalNeighbour => None,
        };
        if let Some(bends) = bends {
            for miss in [&mut near, &mut far, &mut strips].into_iter().flatten() {
                miss.error_m += bends.share * miss.bend.deeper_m();
            }
        }
        let mut by_distance = SigmaByDistance::of(&near, &far);
        if strips.len() >= LEAST_MISSES {
            by_distance = by_distance.larger(&SigmaByDistance::of(&near, &strips));
            far.extend(strips);
        }
        Ok(Some(Self {
            near: Roughness::of(&near, &by_distance, squares.large_m),
            far: Roughness::of(&far, &by_distance, squares.large_m),
            by_distance,
            bends,
        }))
    }

    fn sampler(&self) -> StatedErrorSampler<'_> {
        StatedErrorSampler {
            by_distance: &self.by_distance,
            noise: self.by_distance.at(0.0).powi(2),
            near: self.near.sampler(),
            far: self.far.sampler(),
        }
    }
}

/// Samples stated errors at many places, of which most are near the place before.
struct StatedErrorSampler<'a> {
    by_distance: &'a SigmaByDistance,
    /// Variance at a sounding.
    noise: f64,
    near: RoughnessSampler<'a>,
    far: RoughnessSampler<'a>,
}

impl StatedErrorSampler<'_> {
    fn at(&mut self, place: [f64; 2], away_m: f64) -> f64 {
        let all = self.by_distance.at(away_m).powi(2);
        (self.near.at(place) * self.noise + self.far.at(place) * (all - self.noise)).sqrt()
    }
}

/// Returns the number of the square that a node lies in; it differs for neighbouring squares.
fn square_of(node: &Node, side_m: f64) -> i64 {
    let [column, row] = column_and_row(node, side_m);
    column + 2 * row
}

/// Returns the number of the strip along a direction that a node lies in.
fn strip_of(node: &Node, [x, y]: [f64; 2], width_m: f64) -> i64 {
    let [east_m, north_m] = node.place();
    ((east_m * y - north_m * x) / width_m).floor() as i64
}

/// Returns the unit vector along the lines that most places lie on; `None` where they lie on no
/// lines.
fn direction(places: &[[f64; 2]]) -> Option<[f64; 2]> {
    let others: Vec<[f64; 2]> = places.iter().skip(1).step_by(2).copied().collect();
    let near = Nearest::of(&others)?;
    let tried = places.iter().step_by(2);
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for place in tried.step_by((places.len() / MOST_CELLS_TRIED).max(1)) {
        let (index, away_m) = near.at(*place);
        if away_m <= 0.0 {
            continue;
        }
        let [x, y] = [0, 1].map(|axis| (others[index][axis] - place[axis]) / away_m);
        sum = [sum[0] + x * x - y * y, sum[1] + 2.0 * x * y];
        count += 1.0;
    }
    let angle_rad = 0.5 * sum[1].atan2(sum[0]);
    let is_along = sum[0].hypot(sum[1]) > LEAST_ALIGNED * count;
    (is_along && count > 0.0).then(|| [angle_rad.cos(), angle_rad.sin()])
}

/// Returns the errors of triangles at left-out soundings; every fourth part is left out at a time.
/// `part_of` returns the number of the square or strip that a node lies in.
fn misses(
    nodes: Vec<Node>,
    part_of: impl Fn(&Node) -> i64 + Sync,
    between: Between,
    slope_m: f64,
    progress: &Progress,
) -> Result<Vec<LeftOutMiss>, Cancelled> {
    let of_fold = |fold: usize| {
        progress.check()?;
        let is_out = |node: &&Node| part_of(node).rem_euclid(FOLDS as i64) as usize == fold;
        let (out, used): (Vec<Node>, Vec<Node>) = nodes.iter().partition(is_out);
        Ok(predicted(&out, used, between, slope_m))
    };
    let folds: Result<Vec<_>, Cancelled> = (0..FOLDS).into_par_iter().map(of_fold).collect();
    Ok(folds?.concat())
}

fn predicted(out: &[Node], used: Vec<Node>, between: Between, slope_m: f64) -> Vec<LeftOutMiss> {
    let places: Vec<[f64; 2]> = used.iter().map(Node::place).collect();
    let slopes = NodeSlopes::of(&used, slope_m);
    let (Some(near), Some(tin)) = (Nearest::of(&places), Tin::new(used)) else {
        return Vec::new();
    };
    let mut sampler = tin.sampler(between);
    let mut bends = slopes.sampler(tin.sampler(Between::Linear));
    let miss = |node: &Node| {
        let place = node.place();
        Some(LeftOutMiss {
            place,
            error_m: sampler.depth_at(place)? - node.depth_m,
            away_m: near.distance_m(place),
            bend: bends.at(place)?,
        })
    };
    out.iter().filter_map(miss).collect()
}

/// Returns the bends of the triangles; `None` where straight ones predict left-out soundings about
/// as well.
///
/// The share that counts is that of least squares. Errors and bends grow with the distance to the
/// nearest sounding, so that the farthest soundings alone would decide: each is weighed by the
/// inverse square of this distance.
fn bends(far: &[LeftOutMiss], strips: &[LeftOutMiss], squares: Squares) -> Option<Bends> {
    let misses = || far.iter().chain(strips);
    let (mut product, mut square) = (0.0, 0.0);
    for miss in misses() {
        let deeper_m = miss.bend.deeper_m();
        let weight = 1.0 / (miss.away_m.powi(2) + squares.small_m.powi(2));
        product -= weight * miss.error_m * deeper_m;
        square += weight * deeper_m.powi(2);
    }
    let share = (product / square / FULL_SHARE).min(1.0);
    let rms_m = |share: f64| {
        let errors_m = misses().map(|miss| miss.error_m + share * miss.bend.deeper_m());
        (errors_m.map(|error_m| error_m.powi(2)).sum::<f64>() / misses().count() as f64).sqrt()
    };
    let left_out_m = [rms_m(0.0), rms_m(share)];
    // A plane bed has no bends, and no share.
    let is_better = square > 0.0 && share > 0.0 && left_out_m[1] <= MOST_RATIO * left_out_m[0];
    is_better.then(|| Bends { square_m: squares.slope_m(), share, left_out_m })
}

/// Returns the column and row of the square that a sounding lies in.
fn column_and_row(node: &Node, square_m: f64) -> [i64; 2] {
    node.place().map(|metres| (metres / square_m).floor() as i64)
}

/// Returns the distance that [`DISTANCE_SHARE`] of some distances do not exceed; 0 without any
/// distance.
fn usual_of(mut distances: Vec<f32>) -> f64 {
    let Some(last) = distances.len().checked_sub(1) else {
        return 0.0;
    };
    let rank = (DISTANCE_SHARE * last as f64) as usize;
    f64::from(*distances.select_nth_unstable_by(rank, f32::total_cmp).1)
}

#[cfg(test)]
mod tests;
