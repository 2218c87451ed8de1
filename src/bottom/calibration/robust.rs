//! Fits a straight line that a third of wild points cannot move.

use bathyscope_log::support::statistics::{median, spread_about};

/// Straight line `y = slope x + offset` with the robust standard deviation about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FittedLine {
    pub slope: f64,
    pub offset: f64,
    pub spread: f64,
}

/// Largest number of points that the starting line is drawn through; the cost of the median of
/// their pairwise slopes grows with its square.
const START_POINTS: usize = 300;
/// Number of reweighting rounds; the weights settle after a handful.
const ROUNDS: usize = 12;
/// Distance from the line, in standard deviations, beyond which points have no weight (Tukey's
/// biweight).
const CUT_SIGMAS: f64 = 4.685;

/// Returns the robust line through `(x, y)`: Theil-Sen over an even subsample, then least squares
/// with Tukey's weights. `None` when `x` hardly varies.
pub(crate) fn robust_line(points: &[(f64, f64)]) -> Option<FittedLine> {
    let mut line = theil_sen(points)?;
    for _ in 0..ROUNDS {
        let scale = CUT_SIGMAS * line.spread.max(1e-6);
        let weighted = points.iter().map(|&(x, y)| {
            let u = (y - line.slope * x - line.offset) / scale;
            (x, y, (1.0 - u * u).max(0.0).powi(2))
        });
        let (slope, offset) = weighted_line(weighted)?;
        line = FittedLine { slope, offset, spread: spread(points, slope, offset) };
    }
    Some(line)
}

fn spread(points: &[(f64, f64)], slope: f64, offset: f64) -> f64 {
    let mut residuals: Vec<f64> = points.iter().map(|&(x, y)| y - slope * x - offset).collect();
    spread_about(&mut residuals, 0.0)
}

fn theil_sen(points: &[(f64, f64)]) -> Option<FittedLine> {
    let step = points.len().div_ceil(START_POINTS).max(1);
    let sample: Vec<(f64, f64)> = points.iter().copied().step_by(step).collect();
    let mut slopes = Vec::with_capacity(sample.len() * sample.len() / 2);
    for (index, a) in sample.iter().enumerate() {
        let later = sample[index + 1..].iter().filter(|b| (b.0 - a.0).abs() > 1e-9);
        slopes.extend(later.map(|b| (b.1 - a.1) / (b.0 - a.0)));
    }
    if slopes.is_empty() {
        return None;
    }
    let slope = median(&mut slopes);
    let offset = median(&mut points.iter().map(|&(x, y)| y - slope * x).collect::<Vec<_>>());
    Some(FittedLine { slope, offset, spread: spread(points, slope, offset) })
}

fn weighted_line(points: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Option<(f64, f64)> {
    let sum = |value: fn(f64, f64, f64) -> f64| {
        points.clone().map(|(x, y, w)| value(x, y, w)).sum::<f64>()
    };
    let weight = sum(|_, _, w| w);
    let (x_mean, y_mean) = (sum(|x, _, w| w * x) / weight, sum(|_, y, w| w * y) / weight);
    let (xx, xy) = points.fold((0.0, 0.0), |(xx, xy), (x, y, w)| {
        (xx + w * (x - x_mean).powi(2), xy + w * (x - x_mean) * (y - y_mean))
    });
    let slope = xy / xx;
    slope.is_finite().then_some((slope, y_mean - slope * x_mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_wild_points_does_not_move_the_line() {
        let points: Vec<(f64, f64)> = (0..900)
            .map(|i| {
                let x = 1.0 + f64::from(i % 97) / 30.0;
                let wild = if i % 3 == 0 { f64::from(i % 11) } else { 0.0 };
                (x, 1.04 * x - 0.05 + wild)
            })
            .collect();
        let line = robust_line(&points).unwrap();
        assert!((line.slope - 1.04).abs() < 1e-3, "{line:?}");
        assert!((line.offset + 0.05).abs() < 3e-3, "{line:?}");
    }
}
