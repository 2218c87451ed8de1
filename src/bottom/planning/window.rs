//! The stretch of a line that gives most for its time.

use std::collections::VecDeque;
use std::ops::Range;

/// Rounds of Dinkelbach's method: three or four are usual.
const ROUNDS: usize = 12;

/// The stretch of `gains`, `least` to `most` steps long, with the largest gain for its time, each
/// step taking `step_s` and the whole `extra_s` more; with that gain. `None` where there is nothing
/// to gain, or no such stretch.
///
/// W. Dinkelbach (On nonlinear fractional programming, 1967): what is best for its time at a rate
/// is found as a sum, and gives a better rate, until that stays.
pub(super) fn best_stretch(
    gains: &[f32],
    least: usize,
    most: usize,
    step_s: f64,
    extra_s: f64,
) -> Option<(Range<usize>, f64)> {
    if least == 0 || least > most || gains.len() < least {
        return None;
    }
    let mut sums = Vec::with_capacity(gains.len() + 1);
    sums.push(0.0);
    for gain in gains {
        sums.push(sums[sums.len() - 1] + f64::from(*gain));
    }
    let mut best: Option<(Range<usize>, f64)> = None;
    let mut rate = 0.0;
    for _ in 0..ROUNDS {
        let stretch = largest(&sums, least, most, rate * step_s)?;
        let gain = sums[stretch.end] - sums[stretch.start];
        let found = gain / (stretch.len() as f64 * step_s + extra_s);
        if found <= rate * (1.0 + 1e-9) {
            break;
        }
        rate = found;
        best = Some((stretch, gain));
    }
    best
}

/// The stretch with the largest sum less `cost` a step.
fn largest(sums: &[f64], least: usize, most: usize, cost: f64) -> Option<Range<usize>> {
    let at = |index: usize| sums[index] - cost * index as f64;
    // Starts that may still be the best one, in the order of place and of what stands there, both
    // rising.
    let mut starts: VecDeque<usize> = VecDeque::new();
    let mut best: Option<(f64, Range<usize>)> = None;
    for end in least..sums.len() {
        let start = end - least;
        while starts.back().is_some_and(|last| at(*last) >= at(start)) {
            starts.pop_back();
        }
        starts.push_back(start);
        while starts.front().is_some_and(|first| end - first > most) {
            starts.pop_front();
        }
        let Some(&start) = starts.front() else {
            continue;
        };
        let sum = at(end) - at(start);
        if best.as_ref().is_none_or(|(most, _)| sum > *most) {
            best = Some((sum, start..end));
        }
    }
    best.map(|(_, stretch)| stretch)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_best_of_all_stretches() {
        for case in 0..60_u64 {
            let draw = |index: u64| ((case * 131 + index * 7919) % 101) as f32 / 20.0;
            let gains: Vec<f32> = (0..40).map(|index| (draw(index) - 3.0).max(0.0)).collect();
            let (least, most, extra_s) = (3, 6 + case as usize % 30, 0.5 * case as f64);
            let rate = |stretch: &Range<usize>| {
                let gain: f64 = gains[stretch.clone()].iter().map(|g| f64::from(*g)).sum();
                gain / (2.0 * stretch.len() as f64 + extra_s)
            };
            let all = (0..40).flat_map(|start| {
                (start + least..=(start + most).min(40)).map(move |end| start..end)
            });
            let expected = all.map(|stretch| rate(&stretch)).fold(0.0, f64::max);
            let (found, gain) = best_stretch(&gains, least, most, 2.0, extra_s).unwrap();
            assert!((rate(&found) - expected).abs() < 1e-9, "{case}: {found:?}");
            assert!((gain / (2.0 * found.len() as f64 + extra_s) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn nothing_to_gain_is_no_stretch() {
        assert_eq!(best_stretch(&[0.0; 9], 2, 9, 1.0, 1.0), None);
        assert_eq!(best_stretch(&[1.0; 3], 4, 9, 1.0, 1.0), None);
        assert_eq!(best_stretch(&[1.0; 9], 4, 3, 1.0, 1.0), None);
    }
}
