//! Finds records whose time is damaged: frames are written in time order, give or take the delays inside a recorder.

use std::collections::VecDeque;

/// Frames of different channels are written up to this much out of order, seconds. Real logs show 0.5.
const SLACK_S: f64 = 2.0;
/// The first and the last frame have one neighbour only; a pause next to them may be this long, seconds.
const END_SLACK_S: f64 = 60.0;

/// Looks two records ahead: a record whose time fits neither neighbour, while they fit each other, is damaged.
#[derive(Debug)]
pub(super) struct Clock<T> {
    before_s: Option<f64>,
    waiting: VecDeque<(f64, T)>,
}

/// What the clock says about a record.
#[derive(Debug, PartialEq)]
pub(super) enum Verdict<T> {
    /// Its time fits.
    Sound(T),
    /// Its time cannot be.
    Damaged(T),
}

impl<T> Default for Clock<T> {
    fn default() -> Self {
        Self {
            before_s: None,
            waiting: VecDeque::with_capacity(3),
        }
    }
}

impl<T> Clock<T> {
    /// Takes the next record in file order; gives the verdict on the one two before it.
    pub(super) fn push(&mut self, time_s: f64, record: T) -> Option<Verdict<T>> {
        self.waiting.push_back((time_s, record));
        (self.waiting.len() > 2).then(|| self.finish()).flatten()
    }

    /// The verdict on the oldest record that still waits; call it until there is none.
    pub(super) fn finish(&mut self) -> Option<Verdict<T>> {
        let (time_s, record) = self.waiting.pop_front()?;
        let ahead = |index: usize| self.waiting.get(index).map(|(time_s, _)| *time_s);
        if fits(self.before_s, time_s, ahead(0), ahead(1)) {
            self.before_s = Some(time_s);
            Some(Verdict::Sound(record))
        } else {
            Some(Verdict::Damaged(record))
        }
    }
}

/// Whether a time can stand between the last sound one and the next two.
fn fits(before_s: Option<f64>, time_s: f64, next_s: Option<f64>, after_s: Option<f64>) -> bool {
    let follows = |earlier_s: f64, later_s: f64, pause_s: f64| {
        (-SLACK_S..=pause_s).contains(&(later_s - earlier_s))
    };
    match (before_s, next_s) {
        // The time was set back for good (the recorder was restarted): both sides are believed.
        (Some(before_s), Some(next_s)) if before_s > next_s + SLACK_S => true,
        (Some(before_s), Some(next_s)) => {
            follows(before_s, time_s, f64::INFINITY) && follows(time_s, next_s, f64::INFINITY)
        }
        (Some(before_s), None) => follows(before_s, time_s, END_SLACK_S),
        // The first is only doubted when the next two agree against it.
        (None, Some(next_s)) => {
            follows(time_s, next_s, END_SLACK_S)
                || after_s.is_none_or(|after_s| !follows(next_s, after_s, END_SLACK_S))
        }
        (None, None) => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn damaged(times_s: &[f64]) -> Vec<usize> {
        let mut clock = Clock::default();
        let mut verdicts: Vec<Verdict<usize>> = Vec::new();
        for (index, &time_s) in times_s.iter().enumerate() {
            verdicts.extend(clock.push(time_s, index));
        }
        verdicts.extend(std::iter::from_fn(|| clock.finish()));
        assert_eq!(verdicts.len(), times_s.len());
        verdicts
            .into_iter()
            .filter_map(|verdict| match verdict {
                Verdict::Damaged(index) => Some(index),
                Verdict::Sound(_) => None,
            })
            .collect()
    }

    #[test]
    fn one_wrong_time_is_found_wherever_it_is() {
        assert_eq!(damaged(&[1317.7, 1318.0, 0.0, 1318.2, 1318.3]), [2]);
        assert_eq!(damaged(&[0.0, 1318.0, 1318.2]), [0]);
        assert_eq!(damaged(&[4e6, 0.1, 0.2]), [0]);
        assert_eq!(damaged(&[1318.0, 0.0, 1318.2]), [1]);
        assert_eq!(damaged(&[1318.0, 1318.2, 0.0]), [2]);
        assert_eq!(damaged(&[1.0, 1.1, 4e6, 1.2]), [2]);
    }

    #[test]
    fn pauses_restarts_and_small_disorder_are_sound() {
        assert!(damaged(&[-0.454, 0.06, -0.06, 0.45]).is_empty());
        assert!(damaged(&[1.0, 1.1, 700.0, 700.1]).is_empty());
        assert!(damaged(&[700.0, 700.1, 0.0, 0.1, 0.2]).is_empty());
    }
}
