//! Shows the progress of a headless run on stderr: on a terminal, one line that is rewritten;
//! elsewhere a line for each step, and lines with share and rate at intervals during a long step.

use super::output;
use bathyscope_log::support::progress::Progress;
use std::io::{IsTerminal as _, Write as _};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two readings of the progress.
const LOOK: Duration = Duration::from_millis(100);
/// Least share of a step between two lines, where stderr is no terminal.
const WORTH_A_LINE: f32 = 0.1;
/// Least time between two lines, where stderr is no terminal.
const LEAST: Duration = Duration::from_secs(2);
/// Longest time without a line during a step, where stderr is no terminal.
const LONGEST: Duration = Duration::from_secs(10);

/// Characters of the longest line, where a line is cleared with spaces: a console of Windows has
/// 80.
const WIDTH: usize = 79;

/// Line on stderr with the current step and the share of it that is done, until dropped.
pub(super) struct StatusLine {
    /// Progress of the work, from which the share is read.
    pub progress: Progress,
    step: Arc<Mutex<Step>>,
    is_terminal: bool,
    /// Sender without messages: when dropped, the painter thread ends.
    going_on: Option<Sender<()>>,
    painter: Option<JoinHandle<()>>,
}

/// Current step.
#[derive(Clone, Debug)]
struct Step {
    name: String,
    began: Instant,
    /// Name of its subject, such as one of several logs, before its own; empty if all steps are
    /// about one thing.
    subject: String,
    /// Number of side-scan pings of the subject; 0 if it has none.
    pings: usize,
}

impl StatusLine {
    /// Creates a progress and starts to show it.
    pub(super) fn new() -> Self {
        let progress = Progress::new();
        let step = Arc::new(Mutex::new(Step {
            name: String::new(),
            began: Instant::now(),
            subject: String::new(),
            pings: 0,
        }));
        let is_terminal = std::io::stderr().is_terminal();
        let (going_on, stop) = mpsc::channel();
        let (shown, read) = (step.clone(), progress.clone());
        let painter = std::thread::spawn(move || {
            let mut lines = Lines::default();
            while stop.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                let step = lock(&shown).clone();
                let fraction = read.fraction();
                if is_terminal && !step.name.is_empty() {
                    write_over(format_args!("{} {:3.0} %", step.name, 100.0 * fraction));
                } else if let Some(line) = lines.next(&step, fraction, Instant::now()) {
                    output::notify(line);
                }
            }
            if is_terminal {
                write_over(format_args!(""));
            }
        });
        Self { progress, step, is_terminal, going_on: Some(going_on), painter: Some(painter) }
    }

    /// Creates a progress and starts to show it, in a step of this name.
    pub(super) fn at(name: &str) -> Self {
        let line = Self::new();
        line.step(name);
        line
    }

    /// Sets the subject of the following steps: its name, such as `log 2 of 5`, or empty if there
    /// is one subject only, and the number of its side-scan pings.
    pub(super) fn work_on(&self, name: &str, pings: usize) {
        let mut step = lock(&self.step);
        (step.subject, step.pings) = (name.to_owned(), pings);
    }

    /// Begins a step of this name.
    pub(super) fn step(&self, name: &str) {
        let (ended, begun) = {
            let mut step = lock(&self.step);
            let ended = step.ended(Instant::now());
            step.name = match step.subject.as_str() {
                "" => name.to_owned(),
                subject => format!("{subject}: {name}"),
            };
            step.began = Instant::now();
            (ended, step.name.clone())
        };
        if !self.is_terminal {
            ended.into_iter().for_each(output::notify);
            output::notify(begun);
        }
    }
}

impl Step {
    /// Returns a line about the ended step; `None` if the step was short.
    fn ended(&self, now: Instant) -> Option<String> {
        let passed = now.saturating_duration_since(self.began);
        let is_worth = passed >= LEAST && !self.name.is_empty();
        is_worth.then(|| {
            let (name, passed_s) = (&self.name, passed.as_secs_f32());
            format!("{name} done, {passed_s:.0} s{}", self.rate(1.0, passed))
        })
    }

    /// Returns the rate of a share of the work, pings a second, after a comma; empty if it is
    /// unknown.
    fn rate(&self, share: f32, passed: Duration) -> String {
        let rate = self.pings as f32 * share / passed.as_secs_f32().max(f32::MIN_POSITIVE);
        if rate > 0.0 && rate.is_finite() { format!(", {rate:.0} pings/s") } else { String::new() }
    }
}

fn lock(step: &Mutex<Step>) -> std::sync::MutexGuard<'_, Step> {
    step.lock().unwrap_or_else(PoisonError::into_inner)
}

/// State of the lines already written, where stderr is no terminal.
#[derive(Debug, Default)]
struct Lines {
    /// Start of the step of the last line, time of that line, and share at that time.
    last: Option<(Instant, Instant, f32)>,
    /// Current part of a step: start of the step, start of the part, and the last share read.
    part: Option<(Instant, Instant, f32)>,
}

impl Lines {
    /// Returns the line that is due now, if any: during a long step, after each tenth of it or
    /// after [`LONGEST`].
    fn next(&mut self, step: &Step, fraction: f32, now: Instant) -> Option<String> {
        let part_began = self.part_of(step, fraction, now);
        // The line at the start of the step counts as the first.
        let (written_at, share) = match self.last {
            Some((began, written_at, share)) if began == step.began => (written_at, share),
            _ => (step.began, 0.0),
        };
        let since = now.saturating_duration_since(written_at);
        let due = since >= LONGEST || (since >= LEAST && fraction - share >= WORTH_A_LINE);
        // A share that falls belongs to the next part of the same step.
        let due = due || (since >= LEAST && fraction < share);
        if !due || step.name.is_empty() {
            return None;
        }
        self.last = Some((step.began, now, fraction));
        let passed_s = now.saturating_duration_since(step.began).as_secs_f32();
        let line = format!("{} {:.0} %, {passed_s:.0} s", step.name, 100.0 * fraction);
        let of_part = now.saturating_duration_since(part_began);
        let goes_on = fraction > 0.0 && fraction < 1.0 && !of_part.is_zero();
        Some(if goes_on {
            format!(
                "{line}{}, {:.0} s to go",
                step.rate(fraction, of_part),
                of_part.as_secs_f32() * (1.0 / fraction - 1.0)
            )
        } else {
            line
        })
    }

    /// Returns the start of the current part of the step: when the share falls, the next part
    /// begins.
    fn part_of(&mut self, step: &Step, fraction: f32, now: Instant) -> Instant {
        let began = match self.part {
            Some((of, began, share)) if of == step.began => {
                if fraction < share {
                    now
                } else {
                    began
                }
            }
            _ => step.began,
        };
        self.part = Some((step.began, began, fraction));
        began
    }
}

/// Replaces the line on the terminal. A closed terminal is no reason to stop the work: errors are
/// ignored.
fn write_over(text: std::fmt::Arguments<'_>) {
    let mut err = std::io::stderr();
    // A console of Windows does not clear the rest of a line by an escape sequence until a program
    // enables such sequences.
    let clear = if cfg!(windows) { format!("\r{:WIDTH$}\r", "") } else { "\r\x1b[K".to_owned() };
    write!(err, "{clear}{text}").and_then(|()| err.flush()).ok();
}

impl Drop for StatusLine {
    fn drop(&mut self) {
        drop(self.going_on.take());
        if let Some(painter) = self.painter.take() {
            painter.join().ok();
        }
        if !self.is_terminal {
            let ended = lock(&self.step).ended(Instant::now());
            ended.into_iter().for_each(output::notify);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(name: &str, began: Instant, pings: usize) -> Step {
        Step { name: name.to_owned(), began, subject: String::new(), pings }
    }

    #[test]
    fn a_long_step_speaks_after_each_tenth_and_never_stays_silent() {
        let began = Instant::now();
        let objects = step("objects", began, 8000);
        let mut lines = Lines::default();
        let mut at = |seconds: f32, fraction: f32| {
            lines.next(&objects, fraction, began + Duration::from_secs_f32(seconds))
        };
        assert_eq!(at(0.1, 0.05), None);
        assert_eq!(at(1.9, 0.2), None, "too early");
        assert_eq!(at(4.0, 0.25).as_deref(), Some("objects 25 %, 4 s, 500 pings/s, 12 s to go"));
        assert_eq!(at(6.5, 0.3), None, "no tenth more");
        assert_eq!(at(10.0, 0.5).as_deref(), Some("objects 50 %, 10 s, 400 pings/s, 10 s to go"));
        assert_eq!(at(19.9, 0.51), None);
        assert_eq!(at(20.5, 0.51).as_deref(), Some("objects 51 %, 20 s, 199 pings/s, 20 s to go"));
        assert_eq!(at(23.0, 1.0).as_deref(), Some("objects 100 %, 23 s"));
        // The next part of the step has its own share and rate.
        assert_eq!(at(25.0, 0.0).as_deref(), Some("objects 0 %, 25 s"));
        assert_eq!(at(27.0, 0.2).as_deref(), Some("objects 20 %, 27 s, 800 pings/s, 8 s to go"));
        let line = objects.ended(began + Duration::from_secs(32));
        assert_eq!(line.as_deref(), Some("objects done, 32 s, 250 pings/s"));
    }

    #[test]
    fn a_step_whose_length_or_pings_nobody_knows_has_the_time() {
        let began = Instant::now();
        let cloud = step("cloud", began, 0);
        let mut lines = Lines::default();
        let mut at = |seconds: u64, fraction: f32| {
            lines.next(&cloud, fraction, began + Duration::from_secs(seconds))
        };
        assert_eq!(at(2, 0.0), None);
        assert_eq!(at(10, 0.0).as_deref(), Some("cloud 0 %, 10 s"));
        assert_eq!(at(20, 0.5).as_deref(), Some("cloud 50 %, 20 s, 20 s to go"));
        let ended = |seconds: u64| cloud.ended(began + Duration::from_secs(seconds));
        assert_eq!(ended(1), None, "not worth a line");
        assert_eq!(ended(30).as_deref(), Some("cloud done, 30 s"));
    }
}
