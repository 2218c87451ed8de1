//! Depths between soundings from a plate that bends least, as stiff as predicts left-out soundings best.
//!
//! `plate` is the surface, `equations` and `levels` find it, `left_out` chooses its stiffness, says whether triangles would do as well, and what depths are worth.

mod equations;
mod left_out;
mod levels;
mod plate;

use super::{
    DepthPoint, Grid, Node, Spread, Surface, SurfaceMethod, merge_repeated, suited_cell_m,
};
use crate::progress::{Cancelled, Progress};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use left_out::Judge;
pub use left_out::SigmaByDistance;
use plate::{Plate, Search};
use rayon::prelude::*;

/// Most cells of a plate, and of those that its stiffness is tried on: on a larger map the cells are larger.
const MOST_CELLS: usize = 400_000;
const MOST_CELLS_TRIED: usize = 10_000;
/// Share of the work at a flat plate that is left when the plate of a map counts as found.
const SOLVED: f64 = 1e-5;
/// How far a plate gives way where too few soundings can be left out to tell.
const USUAL_GIVE: f64 = 1.6;
/// Soundings are left out in squares whose side is twice the distance to a sounding that this share of the map does not exceed: their
/// middles are then as far from soundings as the map between lines.
const DISTANCE_SHARE: f64 = 0.9;

/// When a surface of triangles becomes a plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bend {
    /// Never: only its stated error is found.
    Never,
    /// In any case.
    Always,
    /// Where it predicts left-out soundings better than triangles do.
    WhereBetter,
}

/// Gives the known cells of a surface of triangles the depth of a plate through its nodes, and, whichever they have then, the standard
/// deviation of that depth's error for their spread; the spread stays as it is where too few soundings could be left out to tell.
///
/// # Errors
/// When the work was cancelled.
pub fn bend_least(
    made: &mut Surface,
    nodes: &[Node],
    bend: Bend,
    progress: &Progress,
) -> Result<(), Cancelled> {
    let square_m = 2.0 * usual_distance_m(made).max(2.0 * made.grid.cell_m);
    let grid = made.grid;
    let tried = grid.coarser(grid.times_coarser(MOST_CELLS_TRIED));
    let judge = Judge::new(&tried, nodes, square_m, progress);
    let judged = match bend {
        Bend::Never => judge.triangles()?,
        Bend::Always => judge.plate()?,
        Bend::WhereBetter => {
            let (plate, triangles) = (judge.plate()?, judge.triangles()?);
            match judge.is_better(&plate, &triangles) {
                true => plate,
                false => triangles,
            }
        }
    };
    let sigma = judge.sigma(&judged);
    if let Some(best) = judged.give {
        let give = sigma.as_ref().map_or(USUAL_GIVE, |_| best);
        take_plate(made, nodes, give, progress)?;
    }
    if let Some(sigma) = sigma {
        let cells = made.spread_m.par_iter_mut().zip(&made.distance_m);
        cells
            .filter(|(spread_m, _)| !spread_m.is_nan())
            .for_each(|(spread_m, away_m)| *spread_m = sigma.at(f64::from(*away_m)) as f32);
        made.spread_is = Spread::OfError;
    }
    Ok(())
}

/// Gives the known cells the depths of a plate.
fn take_plate(
    made: &mut Surface,
    nodes: &[Node],
    give: f64,
    progress: &Progress,
) -> Result<(), Cancelled> {
    let grid = made.grid;
    let cells = grid.coarser(grid.times_coarser(MOST_CELLS));
    progress.start(Plate::steps(&cells));
    let search = Search {
        give,
        solved: SOLVED,
    };
    let plate = Plate::through(&cells, nodes, search, progress)?;
    let cells = made.depth_m.par_iter_mut().enumerate();
    cells
        .filter(|(_, depth_m)| !depth_m.is_nan())
        .for_each(|(cell, depth_m)| {
            *depth_m = plate.depth_at(grid.centre(cell / grid.columns, cell % grid.columns)) as f32;
        });
    made.method = SurfaceMethod::Smooth;
    Ok(())
}

/// What the error of a depth between soundings is by the distance to the nearest, as leaving soundings out shows it; distances up to
/// `max_gap_m` count. `None` where there are too few soundings to tell.
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
    let places: Vec<[f64; 2]> = nodes.iter().map(|p| [p.east_m, p.north_m]).collect();
    let Ok(near) = ImmutableKdTree::<f64, 2>::new_from_slice(&places) else {
        return Ok(None);
    };
    let tried = grid.coarser(grid.times_coarser(MOST_CELLS_TRIED));
    let distance_m = |cell: usize| {
        let centre = tried.centre(cell / tried.columns, cell % tried.columns);
        let nearest = near.query(&centre);
        let nearest = nearest.nearest_one::<SquaredEuclidean<f64>>();
        nearest.execute().distance.sqrt() as f32
    };
    let cells = (0..tried.len()).into_par_iter();
    let distances: Vec<f32> = cells
        .map(distance_m)
        .filter(|distance| f64::from(*distance) <= max_gap_m)
        .collect();
    let square_m = 2.0 * usual_of(distances).max(2.0 * grid.cell_m);
    let judge = Judge::new(&tried, &nodes, square_m, progress);
    Ok(judge.sigma(&judge.plate()?))
}

/// The distance to a sounding that most of the map does not exceed, metres; 0 where nothing is known.
fn usual_distance_m(made: &Surface) -> f64 {
    let known = made
        .distance_m
        .iter()
        .filter(|distance| distance.is_finite());
    usual_of(known.copied().collect())
}

/// What [`DISTANCE_SHARE`] of some distances do not exceed; 0 of none.
fn usual_of(mut distances: Vec<f32>) -> f64 {
    let Some(last) = distances.len().checked_sub(1) else {
        return 0.0;
    };
    let rank = (DISTANCE_SHARE * last as f64) as usize;
    f64::from(*distances.select_nth_unstable_by(rank, f32::total_cmp).1)
}

#[cfg(test)]
mod tests;
