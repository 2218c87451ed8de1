//! Computes round numbers, for ticks, scale bars, levels and cells.

/// Numbers that count as round within a decade.
const ONE_TWO_FIVE: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
/// Numbers at which a scale may end, within a decade: closer together than [`ONE_TWO_FIVE`], so
/// that little of a scale stays empty.
const ENDS: [f64; 10] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
/// Steps that count as round in time, seconds; above them, whole days are round.
const TIMES_S: [f64; 12] =
    [1.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0, 21_600.0, 86_400.0];
/// Share by which a number may differ from a round one and still be equal to it: the rounding error
/// of a quotient.
const HAIR: f64 = 1e-9;

/// Returns the smallest of 1, 2, 5, 10, 20 ... and 0.5, 0.2, 0.1 ... that is at least `least`; at
/// least 1e-9, also where `least` is NaN.
pub fn round_up(least: f64) -> f64 {
    next_of(&ONE_TWO_FIVE, least)
}

/// Returns the largest of 1, 2, 5 times a power of ten that is at most `most`; 0 where there is
/// none.
pub fn round_down(most: f64) -> f64 {
    if !(most > 0.0 && most.is_finite()) {
        return 0.0;
    }
    let exponent = most.log10().floor() as i32;
    let rounds = ONE_TWO_FIVE.into_iter().rev();
    let fits = |round: &f64| *round <= most * (1.0 + HAIR);
    (rounds.map(|digit| decimal(digit, exponent)))
        .find(fits)
        .unwrap_or_else(|| decimal(1.0, exponent))
}

/// Returns the smallest end of a scale that is at least `least`; the ends are closer together than
/// the numbers of [`round_up`].
pub(crate) fn scale_end(least: f64) -> f64 {
    next_of(&ENDS, least)
}

/// Returns the smallest round step in time that is at least `least_s`, seconds.
pub fn time_step_s(least_s: f64) -> f64 {
    let found = TIMES_S.into_iter().find(|step_s| *step_s >= least_s);
    found.unwrap_or(86_400.0 * (least_s / 86_400.0).ceil().max(1.0))
}

fn next_of(digits: &[f64], least: f64) -> f64 {
    let least = least.max(1e-9);
    if least.is_infinite() {
        return least;
    }
    let exponent = least.log10().floor() as i32;
    let rounds = digits.iter().map(|digit| decimal(*digit, exponent));
    let mut enough = rounds.filter(|round| *round >= least * (1.0 - HAIR));
    enough.next().unwrap_or_else(|| decimal(10.0, exponent))
}

/// Returns `digit` times a power of ten, rounded as its decimal notation is: five thousandths are
/// 0.005 to the last bit.
fn decimal(digit: f64, exponent: i32) -> f64 {
    if exponent < 0 { digit / 10f64.powi(-exponent) } else { digit * 10f64.powi(exponent) }
}

/// Returns the smallest round step that divides `span` into at most `most` parts; 1 where there is
/// no span.
pub fn round_step(span: f64, most: f64) -> f64 {
    let least = span / most;
    if least > 0.0 && least.is_finite() { round_up(least) } else { 1.0 }
}

/// Returns the multiples of `step` from `low` to `high`, at most a thousand.
pub fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step - HAIR).ceil();
    let count = ((high / step + HAIR).floor() - first + 1.0).clamp(0.0, 1000.0) as usize;
    // Adding zero turns a negative zero into zero, which prints without a sign.
    (0..count).map(move |index| (first + index as f64) * step + 0.0)
}

/// Returns about four to eight ticks from `low` to `high`, each with its label; none where there is
/// no span.
pub fn ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let step = round_down((high - low) / 4.0);
    if step <= 0.0 {
        return Vec::new();
    }
    let values = multiples(low, high, step);
    values.map(|value| (value, label(value, step))).collect()
}

/// Formats a number with as many decimals as its step needs.
pub fn label(value: f64, step: f64) -> String {
    let decimals = (-step.log10() - HAIR).ceil().clamp(0.0, 6.0) as usize;
    // The number is rounded first, so that a value slightly below zero does not print as minus
    // zero.
    let rounded = (value / step * 1e3).round() * 1e-3 * step;
    format!("{:.decimals$}", rounded + 0.0)
}

/// Formats the round length of a scale bar: `20 m`, `5 km`.
pub fn bar_label(length_m: f64) -> String {
    if length_m >= 1000.0 {
        format!("{} km", label(length_m / 1000.0, length_m / 1000.0))
    } else {
        format!("{} m", label(length_m, length_m))
    }
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
            assert!((span / step) <= 6.0 + 1e-9 && (span / step) >= 2.0, "{span}");
        }
    }

    #[test]
    fn round_numbers_are_those_that_a_person_would_write() {
        for exponent in -8..9 {
            for digit in ["1", "2", "5"] {
                let round: f64 = format!("{digit}e{exponent}").parse().unwrap();
                assert_eq!([round_up(round), round_down(round)], [round; 2]);
                // Rounding errors of a quotient do not change the result.
                assert_eq!(round_up(round * (1.0 + 1e-12)), round);
                assert_eq!(round_down(round * (1.0 - 1e-12)), round);
                assert!(round_up(round * 1.01) > round && round_down(round * 1.01) == round);
            }
        }
        for (least, round) in [(0.03, 0.05), (1.1, 2.0), (7.0, 10.0), (51.0, 100.0)] {
            assert_eq!(round_up(least), round);
        }
        assert_eq!([round_up(0.0), round_up(f64::NAN)], [1e-9; 2]);
        assert_eq!([0.0, -1.0, f64::NAN, f64::INFINITY].map(round_down), [0.0; 4]);
        assert_eq!([round_down(73.0), round_down(0.2)], [50.0, 0.2]);
    }

    #[test]
    fn times_are_round_and_never_too_close() {
        assert_eq!(time_step_s(0.3), 1.0);
        assert_eq!(time_step_s(12.0), 30.0);
        assert_eq!(time_step_s(4000.0), 7200.0);
        assert_eq!(time_step_s(100_000.0), 172_800.0);
    }

    #[test]
    fn multiples_cover_the_span() {
        let found: Vec<f64> = multiples(-1.05, 1.0, 0.5).collect();
        assert_eq!(found, [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(multiples(1.0, 0.0, 0.5).count(), 0);
    }

    #[test]
    fn ticks_lie_within_their_span_and_show_the_decimals_of_their_step() {
        let labels = |low, high| -> Vec<String> {
            ticks(low, high).into_iter().map(|(_, text)| text).collect()
        };
        assert_eq!(labels(0.0, 1000.0), ["0", "200", "400", "600", "800", "1000"]);
        assert_eq!(labels(1.16, 2.4), ["1.2", "1.4", "1.6", "1.8", "2.0", "2.2", "2.4"]);
        assert!(labels(2.0, 2.0).is_empty());
    }

    #[test]
    fn labels_have_the_decimals_of_the_step() {
        assert_eq!(label(2.5, 0.5), "2.5");
        assert_eq!(label(20.0, 10.0), "20");
        assert_eq!(label(-1e-6, 50.0), "0");
        assert_eq!(label(0.05, 0.05), "0.05");
        assert_eq!([0.5, 20.0, 2000.0].map(bar_label), ["0.5 m", "20 m", "2 km"]);
    }
}
