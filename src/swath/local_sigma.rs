//! How large the correction may be, place by place: learnt from what the solution and what is unknown of it show (expectation
//! maximisation).

use super::nodes::Nodes;
use super::system::{innovation_sd, innovations};

/// Standard deviation of the window that the size is averaged with, metres.
const WINDOW_M: f64 = 1.5;
/// The window ends at so many of them.
const WINDOW_ENDS: f64 = 4.0;
/// What the usual size counts, in values of the window.
const USUAL_COUNTS: f64 = 10.0;

/// Standard deviation of the correction at every node, metres: the root of the mean square of its innovations over a window of 1.5 m,
/// drawn towards `usual_m`. `samples` are draws of what is unknown of the correction.
pub fn local_sigma(
    nodes: &Nodes,
    correction_m: &[f64],
    samples: &[&[f64]],
    usual_m: f64,
) -> Vec<f64> {
    let mut squares: Vec<f64> = innovations(nodes, correction_m)
        .iter()
        .map(|value| value * value)
        .collect();
    for sample in samples {
        for (square, value) in squares.iter_mut().zip(innovations(nodes, sample)) {
            *square += value * value / samples.len() as f64;
        }
    }
    let unit = innovation_sd(nodes, 1.0);
    let window = WINDOW_M / nodes.step_m;
    let count = 4.0 * std::f64::consts::PI * window * window;
    let local = blurred(nodes.counts, &squares, window);
    let sigma = |square: f64| {
        let local = square / (unit * unit);
        ((USUAL_COUNTS * usual_m * usual_m + count * local) / (USUAL_COUNTS + count)).sqrt()
    };
    local.into_iter().map(sigma).collect()
}

/// Values in rows averaged by a Gaussian of a standard deviation in steps; beyond the edges they go on as on them.
pub fn blurred([columns, rows]: [usize; 2], values: &[f64], window: f64) -> Vec<f64> {
    let ends = (WINDOW_ENDS * window + 0.5) as isize;
    let kernel: Vec<f64> = (-ends..=ends)
        .map(|step| (-0.5 * (step as f64 / window).powi(2)).exp())
        .collect();
    let whole: f64 = kernel.iter().sum();
    let along = |values: &[f64], count: usize, stride: usize, node: usize| {
        let at = (node / stride % count) as isize;
        let first = node - at as usize * stride;
        let parts = kernel.iter().zip(-ends..).map(|(share, step)| {
            let other = (at + step).clamp(0, count as isize - 1) as usize;
            share * values[first + other * stride]
        });
        parts.sum::<f64>() / whole
    };
    let across: Vec<f64> = (0..values.len())
        .map(|node| along(values, columns, 1, node))
        .collect();
    (0..values.len())
        .map(|node| along(&across, rows, columns, node))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blur_keeps_a_constant_and_the_sum_far_from_edges() {
        let even = blurred([30, 40], &[2.0; 1200], 2.0);
        assert!(even.iter().all(|value| (value - 2.0).abs() < 1e-12));
        let mut spot = vec![0.0; 1200];
        spot[20 * 30 + 15] = 1.0;
        let spread = blurred([30, 40], &spot, 2.0);
        assert!((spread.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert!(spread[20 * 30 + 15] < 0.05);
    }
}
