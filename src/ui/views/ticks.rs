//! Round numbers for grids, scale bars and legends.

use crate::ui::text;

/// The round step that divides `span` into at most `most` parts; 1 where there is no span.
pub fn round_step(span: f64, most: f64) -> f64 {
    let least = span / most;
    if least > 0.0 && least.is_finite() {
        text::round_step(least)
    } else {
        1.0
    }
}

/// The multiples of `step` from `low` to `high`, at most a thousand.
pub fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step - 1e-9).ceil();
    let count = ((high / step + 1e-9).floor() - first + 1.0).clamp(0.0, 1000.0) as usize;
    // Adding zero turns a negative zero into zero, which prints without a sign.
    (0..count).map(move |index| (first + index as f64) * step + 0.0)
}

/// A number with as many decimals as its step needs.
pub fn label(value: f64, step: f64) -> String {
    let decimals = (-step.log10() - 1e-9).ceil().clamp(0.0, 6.0) as usize;
    // Rounded first, so that a hair below zero does not print as minus zero.
    let rounded = (value / step * 1e3).round() * 1e-3 * step;
    format!("{:.decimals$}", rounded + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_not_too_many() {
        assert_eq!(round_step(10.0, 5.0), 2.0);
        assert_eq!(round_step(9.0, 4.0), 5.0);
        assert_eq!(round_step(0.11, 4.0), 0.05);
        assert_eq!(round_step(0.0, 4.0), 1.0);
        for span in [0.003, 0.7, 12.0, 830.0, 51_000.0] {
            let step = round_step(span, 6.0);
            assert!(
                (span / step) <= 6.0 + 1e-9 && (span / step) >= 2.0,
                "{span}"
            );
        }
    }

    #[test]
    fn multiples_cover_the_span() {
        let found: Vec<f64> = multiples(-1.05, 1.0, 0.5).collect();
        assert_eq!(found, [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(multiples(1.0, 0.0, 0.5).count(), 0);
    }

    #[test]
    fn labels_have_the_decimals_of_the_step() {
        assert_eq!(label(2.5, 0.5), "2.5");
        assert_eq!(label(20.0, 10.0), "20");
        assert_eq!(label(-1e-6, 50.0), "0");
        assert_eq!(label(0.05, 0.05), "0.05");
    }
}
