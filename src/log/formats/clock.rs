//! Checks the times of records, which are written in time order apart from delays inside a
//! recorder.

use crate::support::calendar::moment;
use chrono::Datelike as _;
use std::collections::VecDeque;
use std::ops::{Range, RangeInclusive};

/// Years in which a log can have been recorded: side-scan has been recorded to disk since the
/// eighties. Zeros and unset counters are outside.
pub(super) const YEARS: RangeInclusive<i32> = 1980..=2100;
/// Unix seconds of logs of fish-finders: values below (year 2000) are a counter, not a time; values
/// above (2100) are damage.
pub(super) const UNIX_S: Range<u32> = 946_684_800..4_102_444_800;
/// Longest time by which frames of different channels are written out of order, seconds. Real logs
/// show 0.5.
const SLACK_S: f64 = 2.0;
/// Longest pause beside the first and the last frame, which have only one neighbour, seconds.
const END_SLACK_S: f64 = 60.0;

/// Judges the time of each record by the two records after it. A record whose time fits neither
/// neighbour, while the neighbours fit each other, is damaged. Where the time is set back
/// permanently (the unit was restarted while it recorded), the times continue from the last one, so
/// that the pings of both parts are not interleaved.
#[derive(Debug)]
pub(super) struct Clock<T> {
    before_s: Option<f64>,
    /// Sum of all times by which the clock was set back, seconds.
    pub(super) set_back_s: f64,
    waiting: VecDeque<(f64, T)>,
}

/// Verdict of the clock on a record.
#[derive(Debug, PartialEq)]
pub(super) enum ClockVerdict<T> {
    /// The time of the record fits.
    Sound {
        /// The record.
        record: T,
        /// Time of the record, seconds; later than recorded after a restart.
        time_s: f64,
    },
    /// The time of the record is impossible.
    Damaged(T),
}

impl<T> Default for Clock<T> {
    fn default() -> Self {
        Self { before_s: None, set_back_s: 0.0, waiting: VecDeque::with_capacity(3) }
    }
}

impl<T> Clock<T> {
    /// Adds the next record in file order; returns the verdict on the record two before it, if any.
    pub(super) fn push(&mut self, time_s: f64, record: T) -> Option<ClockVerdict<T>> {
        self.waiting.push_back((time_s, record));
        (self.waiting.len() > 2).then(|| self.next()).flatten()
    }

    /// Returns the verdict on the oldest record that still waits; `None` when no record waits.
    pub(super) fn next(&mut self) -> Option<ClockVerdict<T>> {
        let (time_s, record) = self.waiting.pop_front()?;
        let ahead = |index: usize| self.waiting.get(index).map(|(time_s, _)| *time_s);
        if !fits(self.before_s, time_s, ahead(0), ahead(1)) {
            return Some(ClockVerdict::Damaged(record));
        }
        if let Some(before_s) = self.before_s
            && is_set_back(before_s, time_s)
        {
            self.set_back_s += before_s - time_s;
        }
        self.before_s = Some(time_s);
        Some(ClockVerdict::Sound { record, time_s: time_s + self.set_back_s })
    }
}

/// Converts Unix milliseconds to seconds; `None` where the year is not plausible for a log.
pub(super) fn unix_s(unix_ms: i64) -> Option<f64> {
    let unix_s = unix_ms as f64 / 1000.0;
    YEARS.contains(&moment(unix_s).year()).then_some(unix_s)
}

fn is_set_back(earlier_s: f64, later_s: f64) -> bool {
    later_s < earlier_s - SLACK_S
}

fn follows(earlier_s: f64, later_s: f64, longest_pause_s: f64) -> bool {
    !is_set_back(earlier_s, later_s) && later_s <= earlier_s + longest_pause_s
}

/// Returns true if a time fits between the last sound one and the next two.
fn fits(before_s: Option<f64>, time_s: f64, next_s: Option<f64>, after_s: Option<f64>) -> bool {
    match (before_s, next_s) {
        (Some(before_s), Some(next_s)) if is_set_back(before_s, next_s) => {
            // The clock is set back permanently if the record after the next agrees; then this
            // record may belong to either part. Otherwise the next is damaged.
            after_s.is_none_or(|after_s| is_set_back(before_s, after_s))
                || follows(before_s, time_s, END_SLACK_S)
        }
        (Some(before_s), Some(next_s)) => {
            follows(before_s, time_s, f64::INFINITY) && follows(time_s, next_s, f64::INFINITY)
        }
        (Some(before_s), None) => follows(before_s, time_s, END_SLACK_S),
        // The first record is only rejected if the next two agree with each other and not with it.
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

    /// Returns the times of the sound records, and the indices of the damaged records.
    fn judge(times_s: &[f64]) -> (Vec<f64>, Vec<usize>) {
        let mut clock = Clock::default();
        let mut verdicts: Vec<ClockVerdict<usize>> = Vec::new();
        for (index, &time_s) in times_s.iter().enumerate() {
            verdicts.extend(clock.push(time_s, index));
        }
        verdicts.extend(std::iter::from_fn(|| clock.next()));
        let (mut sound_s, mut damaged) = (Vec::new(), Vec::new());
        for verdict in verdicts {
            match verdict {
                ClockVerdict::Sound { time_s, .. } => sound_s.push(time_s),
                ClockVerdict::Damaged(index) => damaged.push(index),
            }
        }
        assert_eq!(sound_s.len() + damaged.len(), times_s.len());
        (sound_s, damaged)
    }

    #[test]
    fn wrong_times_are_found_wherever_they_are() {
        for (times_s, damaged) in [
            (&[1317.7, 1318.0, 0.0, 1318.2, 1318.3][..], &[2][..]),
            (&[0.0, 1318.0, 1318.2], &[0]),
            (&[4e6, 0.1, 0.2], &[0]),
            (&[1318.0, 0.0, 1318.2], &[1]),
            (&[1318.0, 1318.2, 0.0], &[2]),
            (&[1.0, 1.1, 4e6, 1.2], &[2]),
            (&[9.0, 9.1, 0.0, 0.0, 9.2, 9.3], &[2, 3]),
        ] {
            assert_eq!(judge(times_s).1, damaged, "{times_s:?}");
        }
    }

    #[test]
    fn pauses_and_small_disorder_are_sound() {
        for times_s in [&[-0.454, 0.06, -0.06, 0.45][..], &[1.0, 1.1, 700.0, 700.1]] {
            assert_eq!(judge(times_s), (times_s.to_vec(), vec![]));
        }
    }

    #[test]
    fn after_a_restart_time_goes_on() {
        let (sound_s, damaged) = judge(&[700.0, 700.5, 0.0, 0.5, 1.0, 1.5]);
        assert_eq!(sound_s, [700.0, 700.5, 700.5, 701.0, 701.5, 702.0]);
        assert!(damaged.is_empty());
    }
}
