//! Depths between soundings from a plate that bends least, as stiff as predicts left-out soundings best.
//!
//! `plate` is the surface, `left_out` chooses its stiffness and says what its depths are worth.

mod left_out;
mod plate;

use super::{Node, Surface};
use crate::progress::{Cancelled, Progress};
use left_out::Judgement;
use plate::Plate;
use rayon::prelude::*;

/// Most cells of a plate, and of those that its stiffness is tried on: on a larger map the cells are larger.
const MOST_CELLS: usize = 1_500_000;
const MOST_CELLS_TRIED: usize = 10_000;
/// How far a plate gives way where too few soundings can be left out to tell.
const USUAL_GIVE: f64 = 1.6;
/// Soundings are left out in squares whose side is twice the distance to a sounding that this share of the map does not exceed: their
/// middles are then as far from soundings as the map between lines.
const DISTANCE_SHARE: f64 = 0.9;

/// Gives the known cells of a surface the depth of a plate through its nodes, and the standard deviation of its error for their spread; that
/// stays as it is where too few soundings could be left out to tell.
///
/// # Errors
/// When the work was cancelled.
pub fn bend_least(
    made: &mut Surface,
    nodes: &[Node],
    progress: &Progress,
) -> Result<(), Cancelled> {
    let square_m = 2.0 * usual_distance_m(made).max(2.0 * made.grid.cell_m);
    let within = |most: usize| made.grid.coarser(made.grid.times_coarser(most));
    let judged = Judgement::of(&within(MOST_CELLS_TRIED), nodes, square_m, progress)?;
    let give = judged.as_ref().map_or(USUAL_GIVE, |judged| judged.give);
    let cells = within(MOST_CELLS);
    progress.start(Plate::steps(&cells));
    let plate = Plate::through(&cells, nodes, give, progress)?;
    let grid = made.grid;
    made.depth_m
        .par_iter_mut()
        .zip(&mut made.spread_m)
        .zip(&made.distance_m)
        .enumerate()
        .filter(|(_, ((depth_m, _), _))| !depth_m.is_nan())
        .for_each(|(cell, ((depth_m, spread_m), distance_m))| {
            *depth_m = plate.depth_at(grid.centre(cell / grid.columns, cell % grid.columns)) as f32;
            if let Some(judged) = &judged {
                *spread_m = judged.sigma.at(f64::from(*distance_m)) as f32;
            }
        });
    Ok(())
}

/// The distance to a sounding that most of the map does not exceed, metres; 0 where nothing is known.
fn usual_distance_m(made: &Surface) -> f64 {
    let known = made
        .distance_m
        .iter()
        .filter(|distance| distance.is_finite());
    let mut distances: Vec<f32> = known.copied().collect();
    let Some(last) = distances.len().checked_sub(1) else {
        return 0.0;
    };
    let rank = (DISTANCE_SHARE * last as f64) as usize;
    f64::from(*distances.select_nth_unstable_by(rank, f32::total_cmp).1)
}

#[cfg(test)]
mod tests;
