//! Weighted linear equations and their solution by least squares: normal equations, sparse
//! Cholesky. The order in which unknowns are eliminated determines the fill-in, and so the time;
//! the solution does not depend on it.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, Par, Side as Triangle};
use rayon::prelude::*;
use std::sync::Arc;

/// Columns of the inverse that a worker holds at a time.
const COLUMNS_AT_ONCE: usize = 64;

/// Equations `sum of factor x unknown = goal`, each with a weight: the reciprocal of its standard
/// deviation.
#[derive(Clone, Debug, Default)]
pub(crate) struct Equations {
    /// Index of the first term of each equation, and the end of the last.
    starts: Vec<usize>,
    unknowns: Vec<u32>,
    factors: Vec<f64>,
    goals: Vec<f64>,
    weights: Vec<f64>,
}

/// Structure of the equations: the terms of every unknown, the lower triangle of the normal matrix,
/// and the order in which it is factorised. It is the same as long as only weights, factors and
/// goals change.
pub(crate) struct Pattern {
    /// The triangle, its rows and columns in the order of elimination.
    starts: Vec<usize>,
    rows: Vec<usize>,
    of_unknown: Occurrences,
    neighbours: Neighbours,
    elimination: Arc<Elimination>,
}

/// The unknowns in the order in which they are eliminated, and what that fills in.
struct Elimination {
    order: Vec<u32>,
    symbolic: SymbolicCholesky<usize>,
}

/// The terms of each unknown: the equation of each, and its place among all terms.
struct Occurrences {
    starts: Vec<usize>,
    equations: Vec<u32>,
    terms: Vec<u32>,
}

impl Occurrences {
    fn new(equations: &Equations, unknowns: usize) -> Self {
        let mut starts = vec![0; unknowns + 1];
        for unknown in &equations.unknowns {
            starts[*unknown as usize + 1] += 1;
        }
        for unknown in 0..unknowns {
            starts[unknown + 1] += starts[unknown];
        }
        let mut ends = starts.clone();
        let mut of = vec![0; equations.unknowns.len()];
        let mut terms = of.clone();
        for equation in 0..equations.len() {
            for term in equations.starts[equation]..equations.starts[equation + 1] {
                let end = &mut ends[equations.unknowns[term] as usize];
                of[*end] = equation as u32;
                terms[*end] = term as u32;
                *end += 1;
            }
        }
        Self { starts, equations: of, terms }
    }

    /// Equation and term of each time that an unknown occurs.
    fn of(&self, unknown: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let range = self.starts[unknown]..self.starts[unknown + 1];
        let both = self.equations[range.clone()].iter().zip(&self.terms[range]);
        both.map(|(equation, term)| (*equation as usize, *term as usize))
    }
}

/// A factorised normal matrix.
pub(crate) struct Factor {
    elimination: Arc<Elimination>,
    values: Vec<f64>,
}

impl Equations {
    /// Adds one; terms of the same unknown are added up. One whose weight is no positive number is
    /// left out.
    pub(crate) fn add(
        &mut self,
        terms: impl IntoIterator<Item = (usize, f64)>,
        goal: f64,
        sd: f64,
    ) {
        let weight = 1.0 / sd;
        if !(weight > 0.0 && weight.is_finite() && goal.is_finite()) {
            return;
        }
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        let start = self.unknowns.len();
        for (unknown, factor) in terms {
            let unknown = unknown as u32;
            match self.unknowns[start..].iter().position(|other| *other == unknown) {
                Some(at) => self.factors[start + at] += factor,
                None => {
                    self.unknowns.push(unknown);
                    self.factors.push(factor);
                }
            }
        }
        self.starts.push(self.unknowns.len());
        self.goals.push(goal);
        self.weights.push(weight);
    }

    /// Returns their number.
    pub(crate) fn len(&self) -> usize {
        self.goals.len()
    }

    /// Gives one another standard deviation.
    pub(crate) fn set_sd(&mut self, equation: usize, sd: f64) {
        self.weights[equation] = 1.0 / sd;
    }

    /// The reciprocal of the standard deviation of one.
    pub(crate) fn weight(&self, equation: usize) -> f64 {
        self.weights[equation]
    }

    /// Adds the terms of an equation, `times` times, to the entries of its unknowns in `out`.
    pub(crate) fn add_times(&self, equation: usize, times: f64, out: &mut [f64]) {
        for (unknown, factor) in self.terms(equation) {
            out[unknown] += times * factor;
        }
    }

    fn terms(&self, equation: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let range = self.starts[equation]..self.starts[equation + 1];
        let unknowns = self.unknowns[range.clone()].iter().map(|unknown| *unknown as usize);
        unknowns.zip(self.factors[range].iter().copied())
    }

    /// An equation's terms at some values of the unknowns, in standard deviations.
    fn times(&self, equation: usize, values: &[f64]) -> f64 {
        let terms = self.terms(equation).map(|(unknown, factor)| factor * values[unknown]);
        self.weights[equation] * terms.sum::<f64>()
    }

    /// Returns the residual of an equation at some values of the unknowns, in standard deviations.
    pub(crate) fn residual(&self, equation: usize, values: &[f64]) -> f64 {
        self.times(equation, values) - self.weights[equation] * self.goals[equation]
    }

    /// Adds to `out` the transposed weighted matrix of the equations times a vector with an entry
    /// for each equation.
    fn add_transposed(&self, entry: impl Fn(usize) -> f64, out: &mut [f64]) {
        for equation in 0..self.len() {
            let value = self.weights[equation] * entry(equation);
            for (unknown, factor) in self.terms(equation) {
                out[unknown] += factor * value;
            }
        }
    }
}

impl Pattern {
    /// Creates the pattern of some equations of this many unknowns; `None` where their matrix
    /// cannot be analysed.
    pub(crate) fn of(equations: &Equations, unknowns: usize) -> Option<Self> {
        Self::new(equations, unknowns, None)
    }

    /// The same with unknowns eliminated in some order; `None` too where that is none.
    pub(crate) fn in_order(equations: &Equations, order: Vec<u32>) -> Option<Self> {
        Self::new(equations, order.len(), Some(order))
    }

    fn new(equations: &Equations, unknowns: usize, order: Option<Vec<u32>>) -> Option<Self> {
        let of_unknown = Occurrences::new(equations, unknowns);
        let neighbours = Neighbours::new(equations, &of_unknown, unknowns);
        let order = match order {
            Some(order) => order,
            None => neighbours.of_least_degree()?,
        };
        let places = places(&order, unknowns)?;
        // The analysis takes the upper triangle where nothing is to be put into another order.
        let (starts, rows) = neighbours.triangle(&order, &places, |row, column| row < column);
        let symbolic = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_unsorted_checked(unknowns, unknowns, &starts, None, &rows),
            Triangle::Upper,
            SymmetricOrdering::Identity,
            Default::default(),
        );
        let symbolic = symbolic.ok()?;
        let (starts, rows) = neighbours.triangle(&order, &places, |row, column| row > column);
        Some(Self {
            starts,
            rows,
            of_unknown,
            neighbours,
            elimination: Arc::new(Elimination { order, symbolic }),
        })
    }

    /// Number of unknowns.
    fn unknowns(&self) -> usize {
        self.elimination.order.len()
    }

    /// Numbers that a factor of the normal matrix consists of.
    #[cfg(test)]
    pub(crate) fn factor_len(&self) -> usize {
        self.elimination.symbolic.len_val()
    }

    /// Factorises the normal matrix of the equations; `None` where it is not positive definite.
    pub(crate) fn factorise(&self, equations: &Equations) -> Option<Factor> {
        let unknowns = self.unknowns();
        let triangle = SymbolicSparseColMatRef::new_unsorted_checked(
            unknowns,
            unknowns,
            &self.starts,
            None,
            &self.rows,
        );
        let normal = self.normal_matrix(equations);
        let symbolic = &self.elimination.symbolic;
        let mut values = vec![0.0; symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        symbolic
            .factorize_numeric_llt(
                &mut values,
                SparseColMatRef::new(triangle, &normal),
                Triangle::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut MemBuffer::try_new(scratch).ok()?),
                Default::default(),
            )
            .ok()?;
        Some(Factor { elimination: Arc::clone(&self.elimination), values })
    }

    /// The lower triangle of the normal matrix.
    fn normal_matrix(&self, equations: &Equations) -> Vec<f64> {
        let order = &self.elimination.order;
        let mut values = vec![0.0; self.rows.len()];
        let mut sums = vec![0.0; self.unknowns()];
        for (column, unknown) in order.iter().enumerate() {
            let unknown = *unknown as usize;
            for (equation, term) in self.of_unknown.of(unknown) {
                let factor = equations.factors[term] * equations.weights[equation].powi(2);
                for (other, of_other) in equations.terms(equation) {
                    sums[other] += factor * of_other;
                }
            }
            // Rows above the diagonal were summed, too: a test of each would take longer.
            for place in self.starts[column]..self.starts[column + 1] {
                values[place] = sums[order[self.rows[place]] as usize];
            }
            sums[unknown] = 0.0;
            for other in self.neighbours.of(unknown) {
                sums[*other as usize] = 0.0;
            }
        }
        values
    }
}

impl Factor {
    /// The values of the unknowns, and `samples` draws from what is unknown of them: `A^-1 M^T z`
    /// has the covariance `A^-1` where `z` is standard normal. `draw` gives such a number.
    pub(crate) fn solve(
        &self,
        pattern: &Pattern,
        equations: &Equations,
        samples: usize,
        mut draw: impl FnMut() -> f64,
    ) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![0.0; pattern.unknowns()]; 1 + samples];
        let goals = |equation: usize| equations.weights[equation] * equations.goals[equation];
        equations.add_transposed(goals, &mut columns[0]);
        for column in &mut columns[1..] {
            let normal: Vec<f64> = (0..equations.len()).map(|_| draw()).collect();
            equations.add_transposed(|equation| normal[equation], column);
        }
        self.solve_for(&mut columns);
        columns
    }

    /// Replaces the right sides of some equations `A x = b`, where `A` is the normal matrix, by
    /// their solutions.
    pub(crate) fn solve_for(&self, columns: &mut [Vec<f64>]) {
        let Elimination { order, symbolic } = &*self.elimination;
        let mut sides = Mat::<f64>::zeros(order.len(), columns.len());
        for (side, column) in sides.col_iter_mut().zip(&*columns) {
            for (place, unknown) in side.iter_mut().zip(order) {
                *place = column[*unknown as usize];
            }
        }
        let scratch = symbolic.solve_in_place_scratch::<f64>(columns.len(), Par::Seq);
        LltRef::new(symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            sides.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
        );
        for (side, column) in sides.col_iter().zip(columns) {
            for (place, unknown) in side.iter().zip(order) {
                column[*unknown as usize] = *place;
            }
        }
    }

    /// Returns the variances of the unknowns: the diagonal of the inverse of the normal matrix.
    pub(crate) fn variances(&self, unknowns: usize) -> Vec<f64> {
        let starts: Vec<usize> = (0..unknowns).step_by(COLUMNS_AT_ONCE).collect();
        let block = |start: &usize| {
            let ones = *start..(start + COLUMNS_AT_ONCE).min(unknowns);
            let mut columns = vec![vec![0.0; unknowns]; ones.len()];
            for (unknown, column) in ones.clone().zip(&mut columns) {
                column[unknown] = 1.0;
            }
            self.solve_for(&mut columns);
            let own = ones.zip(columns).map(|(unknown, column)| column[unknown]);
            own.collect::<Vec<f64>>()
        };
        starts.par_iter().flat_map_iter(block).collect()
    }
}

/// Standard normal numbers, the same for the same seed: SplitMix64 (Steele et al. 2014) and Box and
/// Muller's transform.
pub(crate) struct Normal {
    state: u64,
    spare: Option<f64>,
}

impl Normal {
    /// Creates the generator from a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self { state: seed, spare: None }
    }

    /// The next one.
    pub(crate) fn draw(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// Above 0 and up to 1.
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^= mixed >> 31;
        ((mixed >> 11) as f64 + 1.0) / (1_u64 << 53) as f64
    }
}

/// Returns the solution of a few equations whose matrix is symmetric and positive definite; `None`
/// where it is not.
pub(crate) fn solve_dense(normal: &Mat<f64>, right: &[f64]) -> Option<Vec<f64>> {
    let factor = normal.llt(Triangle::Lower).ok()?;
    let column = Mat::from_fn(right.len(), 1, |row, _| right[row]);
    let solution = factor.solve(&column);
    let values: Vec<f64> = (0..right.len()).map(|row| solution[(row, 0)]).collect();
    values.iter().all(|value| value.is_finite()).then_some(values)
}

/// Marks what has no place yet.
const NONE: u32 = u32::MAX;

/// Unknowns that occur together in an equation.
struct Neighbours {
    starts: Vec<usize>,
    unknowns: Vec<u32>,
}

impl Neighbours {
    fn new(equations: &Equations, of_unknown: &Occurrences, unknowns: usize) -> Self {
        let mut starts = vec![0];
        let mut found: Vec<u32> = Vec::new();
        // The last unknown that a neighbour was found for.
        let mut seen = vec![usize::MAX; unknowns];
        for unknown in 0..unknowns {
            seen[unknown] = unknown;
            for (equation, _) in of_unknown.of(unknown) {
                for (other, _) in equations.terms(equation) {
                    let seen = &mut seen[other];
                    if *seen != unknown {
                        *seen = unknown;
                        found.push(other as u32);
                    }
                }
            }
            starts.push(found.len());
        }
        Self { starts, unknowns: found }
    }

    /// Returns the neighbours of an unknown, itself left out, each once.
    fn of(&self, unknown: usize) -> &[u32] {
        &self.unknowns[self.starts[unknown]..self.starts[unknown + 1]]
    }

    /// Number of unknowns.
    fn unknowns(&self) -> usize {
        self.starts.len() - 1
    }

    /// The triangle of the matrix whose columns are the unknowns in an order, each with its
    /// diagonal first: where columns begin, and the rows that `is_in` says of a row and a column
    /// belong to it.
    fn triangle(
        &self,
        order: &[u32],
        places: &[u32],
        is_in: impl Fn(usize, usize) -> bool,
    ) -> (Vec<usize>, Vec<usize>) {
        let mut starts = vec![0];
        let mut rows = Vec::with_capacity(self.unknowns() + self.unknowns.len() / 2);
        for (column, unknown) in order.iter().enumerate() {
            rows.push(column);
            let of_column = self.of(*unknown as usize).iter();
            let of_column = of_column.map(|other| places[*other as usize] as usize);
            rows.extend(of_column.filter(|row| is_in(*row, column)));
            starts.push(rows.len());
        }
        (starts, rows)
    }

    /// Returns the order of approximately least degree (Amestoy et al. 1996): good for any
    /// equations. `None` where there is no room.
    fn of_least_degree(&self) -> Option<Vec<u32>> {
        let unknowns = self.unknowns();
        let given: Vec<u32> = (0..unknowns as u32).collect();
        let (starts, rows) = self.triangle(&given, &given, |row, column| row > column);
        let triangle =
            SymbolicSparseColMatRef::new_unsorted_checked(unknowns, unknowns, &starts, None, &rows);
        let (mut order, mut places) = (vec![0; unknowns], vec![0; unknowns]);
        let room = amd::order_maybe_unsorted_scratch::<usize>(unknowns, rows.len());
        amd::order_maybe_unsorted(
            &mut order,
            &mut places,
            triangle,
            amd::Control::default(),
            MemStack::new(&mut MemBuffer::try_new(room).ok()?),
        )
        .ok()?;
        Some(order.into_iter().map(|unknown| unknown as u32).collect())
    }
}

/// Returns the place of each unknown in an order; `None` where `order` is not an order of
/// `unknowns` unknowns.
fn places(order: &[u32], unknowns: usize) -> Option<Vec<u32>> {
    let mut places = vec![NONE; unknowns];
    for (place, unknown) in (0..).zip(order) {
        let own = places.get_mut(*unknown as usize)?;
        if *own != NONE {
            return None;
        }
        *own = place;
    }
    (order.len() == unknowns).then_some(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved_and_what_is_unknown_is_drawn() {
        let mut equations = Equations::default();
        equations.add([(0, 1.0), (1, 1.0)], 3.0, 0.1);
        equations.add([(0, 1.0), (1, -1.0)], 1.0, 0.1);
        equations.add([(2, 0.5), (2, 0.5)], 7.0, 2.0);
        let pattern = Pattern::of(&equations, 3).unwrap();
        let factor = pattern.factorise(&equations).unwrap();
        let mut normal = Normal::new(1);
        let columns = factor.solve(&pattern, &equations, 4000, || normal.draw());
        for (value, expected) in columns[0].iter().zip([2.0, 1.0, 7.0]) {
            assert!((value - expected).abs() < 1e-9);
        }
        let sd = (columns[1..].iter().map(|column| column[2].powi(2)).sum::<f64>() / 4000.0).sqrt();
        assert!((sd - 2.0).abs() < 0.1, "{sd}");
        assert!(equations.residual(2, &[0.0, 0.0, 9.0]) == 1.0);
        // Of (x + y) / 0.1 and (x - y) / 0.1 the normal matrix is 200 on its diagonal.
        for (variance, expected) in factor.variances(3).into_iter().zip([0.005, 0.005, 4.0]) {
            assert!((variance - expected).abs() < 1e-12, "{variance}");
        }
    }

    #[test]
    fn only_an_order_of_all_unknowns_has_places() {
        assert_eq!(places(&[2, 0, 1], 3), Some(vec![1, 2, 0]));
        for order in [&[0, 1][..], &[0, 1, 1], &[0, 1, 3], &[0, 1, 2, 3]] {
            assert_eq!(places(order, 3), None);
        }
    }
}
