//! Progress of a headless run on stderr: one line that is rewritten on a terminal; elsewhere a line a step, and lines at intervals while
//! a step takes long.

use super::output;
use crate::progress::Progress;
use std::io::{IsTerminal as _, Write as _};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two looks at the progress.
const LOOK: Duration = Duration::from_millis(100);
/// Share of a step that is worth a line where lines stay.
const WORTH_A_LINE: f32 = 0.1;
/// Least time between two such lines.
const LEAST: Duration = Duration::from_secs(2);
/// Longest silence while a step goes on.
const LONGEST: Duration = Duration::from_secs(10);

/// Shows the step under way and its done share until dropped.
pub struct StatusLine {
    step: Arc<Mutex<Step>>,
    is_terminal: bool,
    /// Gone, it ends the painter.
    going_on: Option<Sender<()>>,
    painter: Option<JoinHandle<()>>,
}

/// The step under way.
#[derive(Clone, Debug)]
struct Step {
    name: String,
    began: Instant,
}

impl StatusLine {
    /// Starts showing `progress`.
    pub fn new(progress: &Progress) -> Self {
        let step = Arc::new(Mutex::new(Step {
            name: String::new(),
            began: Instant::now(),
        }));
        let is_terminal = std::io::stderr().is_terminal();
        let (going_on, stop) = mpsc::channel();
        let (shown, progress) = (step.clone(), progress.clone());
        let painter = std::thread::spawn(move || {
            let mut lines = Lines::default();
            while stop.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                let step = lock(&shown).clone();
                let fraction = progress.fraction();
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
        Self {
            step,
            is_terminal,
            going_on: Some(going_on),
            painter: Some(painter),
        }
    }

    /// Names the step that begins.
    pub fn step(&self, name: &str) {
        *lock(&self.step) = Step {
            name: name.to_owned(),
            began: Instant::now(),
        };
        if !self.is_terminal {
            output::notify(name);
        }
    }
}

fn lock(step: &Mutex<Step>) -> std::sync::MutexGuard<'_, Step> {
    step.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What was said where lines stay.
#[derive(Debug, Default)]
struct Lines {
    /// When the step began that the last line was about, when that was said, and the share then.
    last: Option<(Instant, Instant, f32)>,
}

impl Lines {
    /// The line that is due now: of a step that goes on for long, after each tenth, or after a longer silence.
    fn next(&mut self, step: &Step, fraction: f32, now: Instant) -> Option<String> {
        // The line that named the step counts as the first.
        let (said, share) = match self.last {
            Some((began, said, share)) if began == step.began => (said, share),
            _ => (step.began, 0.0),
        };
        let since = now.saturating_duration_since(said);
        let due = since >= LONGEST || (since >= LEAST && fraction - share >= WORTH_A_LINE);
        // A share that falls belongs to the next part of the same step.
        let due = due || (since >= LEAST && fraction < share);
        if !due || step.name.is_empty() {
            return None;
        }
        self.last = Some((step.began, now, fraction));
        let passed_s = now.saturating_duration_since(step.began).as_secs_f32();
        let line = format!("{} {:.0} %, {passed_s:.0} s", step.name, 100.0 * fraction);
        Some(match fraction > 0.0 && fraction < 1.0 {
            true => format!("{line}, {:.0} s to go", passed_s * (1.0 / fraction - 1.0)),
            false => line,
        })
    }
}

/// Replaces the line. A terminal that has gone away takes nothing, which is no reason to stop the work.
fn write_over(text: std::fmt::Arguments<'_>) {
    let mut err = std::io::stderr();
    write!(err, "\r\x1b[K{text}")
        .and_then(|()| err.flush())
        .ok();
}

impl Drop for StatusLine {
    fn drop(&mut self) {
        drop(self.going_on.take());
        if let Some(painter) = self.painter.take() {
            painter.join().ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_step_speaks_after_each_tenth_and_never_stays_silent() {
        let began = Instant::now();
        let step = Step {
            name: "objects".to_owned(),
            began,
        };
        let mut lines = Lines::default();
        let mut at = |seconds: f32, fraction: f32| {
            lines.next(&step, fraction, began + Duration::from_secs_f32(seconds))
        };
        assert_eq!(at(0.1, 0.05), None);
        assert_eq!(at(1.9, 0.3), None, "too early");
        assert_eq!(
            at(4.0, 0.25).as_deref(),
            Some("objects 25 %, 4 s, 12 s to go")
        );
        assert_eq!(at(6.5, 0.3), None, "no tenth more");
        assert_eq!(
            at(10.0, 0.5).as_deref(),
            Some("objects 50 %, 10 s, 10 s to go")
        );
        assert_eq!(at(19.9, 0.51), None);
        assert_eq!(
            at(20.5, 0.51).as_deref(),
            Some("objects 51 %, 20 s, 20 s to go")
        );
        assert_eq!(at(23.0, 1.0).as_deref(), Some("objects 100 %, 23 s"));
        // Of a step whose length nobody knows, the time.
        let next = Step {
            name: "cloud".to_owned(),
            began: began + Duration::from_secs(23),
        };
        let mut at = |seconds: u64| lines.next(&next, 0.0, began + Duration::from_secs(seconds));
        assert_eq!(at(25), None);
        assert_eq!(at(33).as_deref(), Some("cloud 0 %, 10 s"));
    }
}
