//! How well soundings are predicted that were left out: what the method and the stiffness of a plate are chosen by, and what depths are worth.

use super::plate::{Plate, Search};
use crate::bathymetry::{Between, Grid, Node, Tin};
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
/// Share of the work at a flat plate that is left when one that is tried counts as found: its errors are then right to a millimetre.
const SOLVED: f64 = 1e-3;
/// Of neighbouring plates that predict as well to this factor, the stiffer one is taken: it invents less.
const AS_GOOD: f64 = 1.05;
/// Fewer left-out soundings than this say nothing.
const LEAST_MISSES: usize = 40;
/// Soundings nearer than this share of a square to one that was not left out say nothing of the ground between lines.
const NEAR_SHARE: f64 = 0.125;
/// Bins by distance of what a stated error is read from.
const BINS: usize = 8;
/// Most soundings that are left out or kept: of more, as many are taken evenly from among them.
const MOST_NODES: usize = 30_000;

/// A sounding that is left out, and its distance to the nearest one that is not, metres.
struct LeftOut {
    node: Node,
    away_m: f64,
}

/// The soundings of a quarter of all squares, and all others.
struct Fold {
    out: Vec<LeftOut>,
    used: Vec<Node>,
}

/// Leaves soundings out and asks surfaces for them.
pub struct Judge<'a> {
    grid: &'a Grid,
    square_m: f64,
    folds: Vec<Fold>,
    progress: &'a Progress,
}

/// How a surface predicts the left-out soundings.
pub struct Judged {
    /// How far a plate gives way; triangles have none.
    pub give: Option<f64>,
    /// Predicted depth less the sounding's, metres, in the order of the folds; `None` where nothing is predicted.
    errors_m: Vec<Option<f64>>,
}

/// The standard deviation of a depth's error by the distance to the nearest sounding.
#[derive(Clone, Debug, PartialEq)]
pub struct SigmaByDistance {
    /// Distance and standard deviation, metres, both rising.
    steps: Vec<[f64; 2]>,
}

impl<'a> Judge<'a> {
    /// Leaves out the soundings of a quarter of all squares of a side at a time; plates lie on the grid.
    pub fn new(grid: &'a Grid, nodes: &[Node], square_m: f64, progress: &'a Progress) -> Self {
        let step = nodes.len().div_ceil(MOST_NODES).max(1);
        let some: Vec<Node> = nodes.iter().step_by(step).copied().collect();
        let folds = (0..FOLDS).into_par_iter();
        let folds = folds.filter_map(|left_out| Fold::of(&some, left_out, square_m));
        Self {
            grid,
            square_m,
            folds: folds.collect(),
            progress,
        }
    }

    /// The plate that predicts best.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn plate(&self) -> Result<Judged, Cancelled> {
        // Rarely are all of them tried: what comes then is sooner than the progress says.
        let steps = (GIVES.len() * FOLDS) as u64 * Plate::steps(self.grid);
        self.progress.start(steps);
        let mut tried: [Option<Judged>; GIVES.len()] = Default::default();
        let mut best = FIRST;
        loop {
            let neighbours = best.saturating_sub(1)..(best + 2).min(GIVES.len());
            for index in neighbours.clone() {
                if tried[index].is_none() {
                    tried[index] = Some(self.plate_that_gives(GIVES[index])?);
                }
            }
            let size = |index: usize| {
                let judged = tried[index].as_ref();
                judged.map_or(f64::MAX, |judged| self.usual_m(judged, judged))
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
        match tried[best].take() {
            Some(judged) => Ok(judged),
            None => self.plate_that_gives(GIVES[best]),
        }
    }

    fn plate_that_gives(&self, give: f64) -> Result<Judged, Cancelled> {
        let of_fold = |fold: &Fold| {
            let search = Search {
                give,
                solved: SOLVED,
            };
            let plate = Plate::through(self.grid, &fold.used, search, self.progress)?;
            let depth_m = |node: &Node| Some(plate.depth_at([node.east_m, node.north_m]));
            Ok(fold.errors_m(depth_m))
        };
        let errors: Result<Vec<_>, Cancelled> = self.folds.par_iter().map(of_fold).collect();
        Ok(Judged {
            give: Some(give),
            errors_m: errors?.concat(),
        })
    }

    /// Triangles between the soundings.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn triangles(&self) -> Result<Judged, Cancelled> {
        let of_fold = |fold: &Fold| {
            self.progress.check()?;
            let tin = Tin::new(fold.used.clone());
            let mut sampler = tin.as_ref().map(|tin| tin.sampler(Between::Linear));
            Ok(fold.errors_m(|node| sampler.as_mut()?.depth_at([node.east_m, node.north_m])))
        };
        let errors: Result<Vec<_>, Cancelled> = self.folds.par_iter().map(of_fold).collect();
        Ok(Judged {
            give: None,
            errors_m: errors?.concat(),
        })
    }

    /// Whether a plate predicts better than triangles, by more than chance, what both predict. Where too few soundings can be left out
    /// to tell it does not.
    pub fn is_better(&self, plate: &Judged, triangles: &Judged) -> bool {
        let both = plate.errors_m.iter().zip(&triangles.errors_m);
        both.filter(|(one, other)| one.is_some() && other.is_some())
            .count()
            >= LEAST_MISSES
            && AS_GOOD * self.usual_m(plate, triangles) < self.usual_m(triangles, plate)
    }

    /// What the depths of a surface are worth; `None` where too few soundings can be left out to tell.
    pub fn sigma(&self, judged: &Judged) -> Option<SigmaByDistance> {
        let misses: Vec<Miss> = self.misses(judged, judged).collect();
        (misses.len() >= LEAST_MISSES).then(|| SigmaByDistance::of(misses))
    }

    /// What a surface misses, of the soundings that another one predicts too.
    fn misses(&self, judged: &Judged, other: &Judged) -> impl Iterator<Item = Miss> {
        let left_out = self.folds.iter().flat_map(|fold| &fold.out);
        let errors = judged.errors_m.iter().zip(&other.errors_m);
        left_out.zip(errors).filter_map(|(left_out, errors)| {
            let (Some(error_m), Some(_)) = errors else {
                return None;
            };
            Some(Miss {
                error_m: *error_m,
                away_m: left_out.away_m,
            })
        })
    }

    /// Root mean square of the errors away from soundings; those beyond three times the usual count as that.
    fn usual_m(&self, judged: &Judged, other: &Judged) -> f64 {
        let misses = self.misses(judged, other);
        let far = misses.filter(|miss| miss.away_m > NEAR_SHARE * self.square_m);
        let mut sizes: Vec<f64> = far.map(|miss| miss.error_m.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let limit_m = 3.0 * spread(&sizes);
        let squares: f64 = sizes.iter().map(|size| size.min(limit_m).powi(2)).sum();
        (squares / sizes.len() as f64).sqrt()
    }
}

impl Fold {
    /// `None` where all soundings are left out.
    fn of(nodes: &[Node], left_out: usize, square_m: f64) -> Option<Self> {
        let is_out = |node: &&Node| square_of(node, square_m) == left_out;
        let (out, used): (Vec<Node>, Vec<Node>) = nodes.iter().partition(is_out);
        let places: Vec<[f64; 2]> = used.iter().map(|p| [p.east_m, p.north_m]).collect();
        let near = ImmutableKdTree::<f64, 2>::new_from_slice(&places).ok()?;
        let away = |node: Node| {
            let place = [node.east_m, node.north_m];
            let nearest = near.query(&place);
            let nearest = nearest.nearest_one::<SquaredEuclidean<f64>>().execute();
            LeftOut {
                node,
                away_m: nearest.distance.sqrt(),
            }
        };
        Some(Self {
            out: out.into_iter().map(away).collect(),
            used,
        })
    }

    /// What a surface misses of each left-out sounding, metres.
    fn errors_m(&self, mut depth_m: impl FnMut(&Node) -> Option<f64>) -> Vec<Option<f64>> {
        let out = self.out.iter().map(|left_out| &left_out.node);
        out.map(|node| Some(depth_m(node)? - node.depth_m))
            .collect()
    }
}

/// A left-out sounding: the predicted depth less its own, and its distance to the nearest sounding that was there, metres.
#[derive(Clone, Copy, Debug)]
struct Miss {
    error_m: f64,
    away_m: f64,
}

/// The fold of the square that a place lies in: when it is left out.
fn square_of(node: &Node, square_m: f64) -> usize {
    let [column, row] =
        [node.east_m, node.north_m].map(|metres| (metres / square_m).floor() as i64);
    (column + 2 * row).rem_euclid(FOLDS as i64) as usize
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
