//! How well soundings are predicted that were left out: what the stiffness is chosen by, and what an error is worth.

use super::plate::Plate;
use crate::bathymetry::{Grid, Node};
use crate::progress::{Cancelled, Progress};
use crate::statistics::quantile;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

/// Times that soundings are left out, a quarter of all squares each time.
const FOLDS: usize = 4;
/// Gives of a plate that are tried, from a board to a sheet; neighbours differ by 4.
const GIVES: [f64; 8] = [0.006, 0.025, 0.1, 0.4, 1.6, 6.4, 25.0, 100.0];
/// The one that is tried first: on simulated ponds it is never far from the best.
const FIRST: usize = 4;
/// Of neighbouring plates that predict as well to this factor, the stiffer one is taken: it invents less.
const AS_GOOD: f64 = 1.05;
/// Fewer left-out soundings than this say nothing.
const LEAST_MISSES: usize = 40;
/// Soundings nearer than this share of a square to one that was not left out say nothing of the ground between lines.
const NEAR_SHARE: f64 = 0.125;
/// Bins by distance of what a stated error is read from.
const BINS: usize = 8;

/// A left-out sounding: the predicted depth less its own, and its distance to the nearest sounding that was there, metres.
#[derive(Clone, Copy, Debug)]
struct Miss {
    error_m: f64,
    away_m: f64,
}

/// What leaving soundings out shows.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The best of the gives that were tried.
    pub give: f64,
    /// What the plate's depths are worth.
    pub sigma: SigmaByDistance,
}

/// The standard deviation of a depth's error by the distance to the nearest sounding.
#[derive(Clone, Debug, PartialEq)]
pub struct SigmaByDistance {
    /// Distance and standard deviation, metres, both rising.
    steps: Vec<[f64; 2]>,
}

impl Judgement {
    /// Leaves out the soundings of a quarter of all squares of a side at a time; `None` where there are too few.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn of(
        grid: &Grid,
        nodes: &[Node],
        square_m: f64,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        // Rarely are all of them tried: what comes then is sooner than the progress says.
        progress.start((GIVES.len() * FOLDS) as u64 * Plate::steps(grid));
        let mut tried: [Option<Vec<Miss>>; GIVES.len()] = Default::default();
        let mut best = FIRST;
        loop {
            let neighbours = best.saturating_sub(1)..(best + 2).min(GIVES.len());
            for index in neighbours.clone() {
                if tried[index].is_none() {
                    tried[index] = Some(misses(grid, nodes, square_m, GIVES[index], progress)?);
                }
            }
            let size = |index: usize| {
                let misses = tried[index].as_deref();
                misses.map_or(f64::MAX, |misses| usual_m(misses, square_m))
            };
            let better = neighbours.clone().find(|index| size(*index) < size(best));
            match better {
                Some(index) => best = index,
                None => {
                    let is_as_good = |index: &usize| size(*index) <= AS_GOOD * size(best);
                    best = neighbours.clone().find(is_as_good).unwrap_or(best);
                    break;
                }
            }
        }
        let misses = tried[best].take().unwrap_or_default();
        Ok((misses.len() >= LEAST_MISSES).then(|| Self {
            give: GIVES[best],
            sigma: SigmaByDistance::of(misses),
        }))
    }
}

/// The square that a place lies in decides when it is left out.
fn fold(node: &Node, square_m: f64) -> usize {
    let [column, row] =
        [node.east_m, node.north_m].map(|metres| (metres / square_m).floor() as i64);
    (column + 2 * row).rem_euclid(FOLDS as i64) as usize
}

fn misses(
    grid: &Grid,
    nodes: &[Node],
    square_m: f64,
    give: f64,
    progress: &Progress,
) -> Result<Vec<Miss>, Cancelled> {
    let of_fold = |left_out: usize| {
        let (out, used): (Vec<Node>, Vec<Node>) = nodes
            .iter()
            .partition(|node| fold(node, square_m) == left_out);
        let places: Vec<[f64; 2]> = used
            .iter()
            .map(|node| [node.east_m, node.north_m])
            .collect();
        let Ok(near) = ImmutableKdTree::<f64, 2>::new_from_slice(&places) else {
            return Ok(Vec::new());
        };
        let plate = Plate::through(grid, &used, give, progress)?;
        Ok(out
            .iter()
            .map(|node| {
                let place = [node.east_m, node.north_m];
                Miss {
                    error_m: plate.depth_at(place) - node.depth_m,
                    away_m: near
                        .query(&place)
                        .nearest_one::<SquaredEuclidean<f64>>()
                        .execute()
                        .distance
                        .sqrt(),
                }
            })
            .collect())
    };
    let folds: Result<Vec<Vec<Miss>>, Cancelled> =
        (0..FOLDS).into_par_iter().map(of_fold).collect();
    Ok(folds?.into_iter().flatten().collect())
}

/// Root mean square of the errors away from soundings; those beyond three times the usual count as that.
fn usual_m(misses: &[Miss], square_m: f64) -> f64 {
    let far = misses
        .iter()
        .filter(|miss| miss.away_m > NEAR_SHARE * square_m);
    let mut sizes: Vec<f64> = far.map(|miss| miss.error_m.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let limit_m = 3.0 * spread(&sizes);
    let squares: f64 = sizes.iter().map(|size| size.min(limit_m).powi(2)).sum();
    (squares / sizes.len() as f64).sqrt()
}

/// The standard deviation that the sizes of errors, in order, speak of: the mean of what holds 68 % of them and half of what holds 95 %.
fn spread(sizes: &[f64]) -> f64 {
    0.5 * (quantile(sizes, 0.683) + 0.5 * quantile(sizes, 0.954))
}

impl SigmaByDistance {
    fn of(mut misses: Vec<Miss>) -> Self {
        misses.sort_by(|a, b| a.away_m.total_cmp(&b.away_m));
        let bins = misses
            .chunks(misses.len().div_ceil(BINS).max(1))
            .map(|bin| {
                let mut sizes: Vec<f64> = bin.iter().map(|miss| miss.error_m.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                [bin[bin.len() / 2].away_m, spread(&sizes)]
            });
        Self {
            steps: rising(bins.collect()),
        }
    }

    /// At a distance from the nearest sounding, metres; beyond all that were left out it grows on as between the last two.
    pub fn at(&self, away_m: f64) -> f64 {
        let after = self
            .steps
            .partition_point(|[distance_m, _]| *distance_m <= away_m);
        let pair = match (after, self.steps.len()) {
            (0, _) | (_, 1) => return self.steps.first().map_or(f64::NAN, |[_, sigma_m]| *sigma_m),
            (after, count) => after.min(count - 1),
        };
        let ([from_m, low_m], [to_m, high_m]) = (self.steps[pair - 1], self.steps[pair]);
        let share = (away_m - from_m) / (to_m - from_m).max(f64::MIN_POSITIVE);
        low_m + (high_m - low_m) * share
    }
}

/// Makes the second numbers rise by giving neighbours that do not their mean (pool adjacent violators).
fn rising(steps: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for [_, value] in &steps {
        pools.push((*value, 1));
        while let [.., (before, many), (last, more)] = pools[..]
            && before > last
        {
            let mean = (before * many as f64 + last * more as f64) / (many + more) as f64;
            pools.truncate(pools.len() - 2);
            pools.push((mean, many + more));
        }
    }
    let values = pools
        .into_iter()
        .flat_map(|(value, count)| std::iter::repeat_n(value, count));
    let places = steps.iter().map(|[place, _]| *place);
    let mut made: Vec<[f64; 2]> = places
        .zip(values)
        .map(|(place, value)| [place, value])
        .collect();
    made.dedup_by_key(|[place, _]| *place);
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_falls_is_made_to_rise_by_means() {
        let steps = [[0.0, 1.0], [1.0, 3.0], [2.0, 2.0], [3.0, 1.0], [4.0, 5.0]];
        let expected = [[0.0, 1.0], [1.0, 2.0], [2.0, 2.0], [3.0, 2.0], [4.0, 5.0]];
        assert_eq!(rising(steps.to_vec()), expected);
    }

    #[test]
    fn a_stated_error_is_read_between_its_steps_and_beyond_them() {
        let sigma = SigmaByDistance {
            steps: vec![[1.0, 0.1], [3.0, 0.2]],
        };
        for (away_m, sigma_m) in [(0.0, 0.1), (1.0, 0.1), (2.0, 0.15), (3.0, 0.2), (5.0, 0.3)] {
            assert!((sigma.at(away_m) - sigma_m).abs() < 1e-12, "{away_m}");
        }
    }
}
