//! Finds records whose time is damaged: frames are written in time order, give or take the delays inside a recorder.

/// Frames of different channels are written up to this much out of order, seconds. Real logs show 0.5.
const SLACK_S: f64 = 2.0;
/// The first and the last frame have one neighbour only; a pause next to them may be this long, seconds.
const END_SLACK_S: f64 = 60.0;

/// Looks one record ahead: a record whose time fits neither neighbour, while they fit each other, is damaged.
#[derive(Debug)]
pub(super) struct Clock<T> {
    before: Option<f64>,
    waiting: Option<(f64, T)>,
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
            before: None,
            waiting: None,
        }
    }
}

impl<T> Clock<T> {
    /// Takes the next record in file order; gives the verdict on the one before it.
    pub(super) fn push(&mut self, time_s: f64, record: T) -> Option<Verdict<T>> {
        let (waiting_s, waiting) = self.waiting.replace((time_s, record))?;
        let sound = match self.before {
            // The time was set back for good (the recorder restarted): both sides are believed.
            Some(before_s) if before_s > time_s + SLACK_S => true,
            Some(before_s) => (before_s - SLACK_S..=time_s + SLACK_S).contains(&waiting_s),
            None => (time_s - END_SLACK_S..=time_s + SLACK_S).contains(&waiting_s),
        };
        Some(self.judge(sound, waiting_s, waiting))
    }

    /// The verdict on the last record.
    pub(super) fn finish(&mut self) -> Option<Verdict<T>> {
        let (waiting_s, waiting) = self.waiting.take()?;
        let sound = self.before.is_none_or(|before_s| {
            (before_s - SLACK_S..=before_s + END_SLACK_S).contains(&waiting_s)
        });
        Some(self.judge(sound, waiting_s, waiting))
    }

    fn judge(&mut self, sound: bool, time_s: f64, record: T) -> Verdict<T> {
        if sound {
            self.before = Some(time_s);
            Verdict::Sound(record)
        } else {
            Verdict::Damaged(record)
        }
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
        verdicts.extend(clock.finish());
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
