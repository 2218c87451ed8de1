//! The bright and the dark run of a profile.

use std::ops::Range;

/// The bright and the dark run of a profile.
pub(super) struct Runs {
    pub(super) echo: Range<usize>,
    pub(super) shadow: Option<Range<usize>>,
}

/// The bright run, and the dark run that begins at most `gap` steps behind it, that explain most: a
/// run of `n` steps that sums to `s` takes `s^2 / n` off the squares. `None` where nothing is
/// bright.
pub(super) fn runs(contrast: &[f64], gap: usize) -> Option<Runs> {
    let count = contrast.len();
    let mut sums = vec![0.0; count + 1];
    for (step, value) in contrast.iter().enumerate() {
        sums[step + 1] = sums[step] + value;
    }
    let gain = |run: &Range<usize>, sign: f64| {
        let sum = sign * (sums[run.end] - sums[run.start]);
        if sum > 0.0 { sum * sum / run.len() as f64 } else { 0.0 }
    };
    let best = |candidates: &mut dyn Iterator<Item = Range<usize>>, sign: f64| {
        let gains = candidates.map(|run| (gain(&run, sign), run));
        let best = gains.max_by(|(a, _), (b, _)| a.total_cmp(b));
        best.unwrap_or((0.0, 0..0))
    };
    let dark: Vec<(f64, Range<usize>)> = (0..count)
        .map(|start| best(&mut (start + 1..=count).map(|end| start..end), -1.0))
        .collect();
    let mut found = (0.0, 0..0, 0..0);
    for end in 1..=count {
        let (bright, echo) = best(&mut (0..end).map(|start| start..end), 1.0);
        let behind = &dark[end.min(count)..(end + gap + 1).min(count)];
        let (shadowed, shadow) =
            behind.iter().max_by(|(a, _), (b, _)| a.total_cmp(b)).cloned().unwrap_or((0.0, 0..0));
        if bright > 0.0 && bright + shadowed > found.0 {
            found = (bright + shadowed, echo, shadow);
        }
    }
    let (_, echo, shadow) = found;
    (!echo.is_empty()).then(|| Runs {
        shadow: (gain(&shadow, -1.0) > 0.0 && !shadow.is_empty()).then_some(shadow),
        echo,
    })
}

/// Returns the reduction of the sum of squares by a run; 0 where it is no brighter than the
/// background.
pub(super) fn gain(run: &[f64]) -> f64 {
    let sum: f64 = run.iter().sum();
    if sum > 0.0 { sum * sum / run.len() as f64 } else { 0.0 }
}

/// Returns the largest reduction of the sum of squares by a bright run; 0 where nothing is bright.
pub(super) fn brightest(contrast: &[f64]) -> f64 {
    let starts = 0..contrast.len();
    let runs = starts.flat_map(|start| (start + 1..=contrast.len()).map(move |end| start..end));
    runs.map(|run| gain(&contrast[run])).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bright_run_and_the_dark_run_behind_it_are_found() {
        let mut profile = vec![0.5, -0.5, 0.2, -0.1, 0.0, 0.4];
        profile.extend([20.0, 26.0, 18.0, 3.0]);
        profile.extend([-15.0; 6]);
        profile.extend([0.3, -0.8, 0.1, 0.6]);
        let found = runs(&profile, 4).expect("an echo");
        assert_eq!(found.echo, 6..9);
        assert_eq!(found.shadow, Some(10..16));
        assert!(runs(&[-1.0, -2.0], 4).is_none());
    }
}
