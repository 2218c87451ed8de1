//! The inverse of a positive definite matrix.

/// The inverse, which is symmetric, by Cholesky's decomposition; `None` where the matrix is not positive definite.
pub(super) fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let lower = decomposed(matrix)?;
    Some(
        (0..lower.len())
            .map(|column| solved(&lower, column))
            .collect(),
    )
}

/// A column of the inverse: `L y = e`, then `L' x = y`.
fn solved(lower: &[Vec<f64>], column: usize) -> Vec<f64> {
    let n = lower.len();
    let mut x = vec![0.0; n];
    for row in column..n {
        let known: f64 = (column..row).map(|k| lower[row][k] * x[k]).sum();
        let right = if row == column { 1.0 } else { 0.0 };
        x[row] = (right - known) / lower[row][row];
    }
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| lower[k][row] * x[k]).sum();
        x[row] = (x[row] - known) / lower[row][row];
    }
    x
}

fn decomposed(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    let mut lower = vec![vec![0.0; n]; n];
    for row in 0..n {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let rest = matrix[row][column] - known;
            if row == column {
                // Of one that is not connected nothing is left but rounding.
                if rest <= 1e-12 * matrix[row][row] {
                    return None;
                }
                lower[row][row] = rest.sqrt();
            } else {
                lower[row][column] = rest / lower[column][column];
            }
        }
    }
    Some(lower)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let matrix = vec![
            vec![4.0, -1.0, 0.5],
            vec![-1.0, 3.0, 0.2],
            vec![0.5, 0.2, 2.0],
        ];
        let inverse = inverse(&matrix).expect("positive definite");
        for (row, line) in matrix.iter().enumerate() {
            for (column, other) in inverse.iter().enumerate() {
                // The inverse is symmetric: its rows are its columns.
                let product: f64 = line.iter().zip(other).map(|(a, b)| a * b).sum();
                let expected = if row == column { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-12, "{row} {column}");
            }
        }
        assert!(super::inverse(&[vec![1.0, 1.0], vec![1.0, 1.0]]).is_none());
    }
}
