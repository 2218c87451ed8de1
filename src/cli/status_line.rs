//! Progress of a headless run on stderr: one line that is rewritten on a terminal, a line a step elsewhere.

use super::output;
use crate::progress::Progress;
use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Shows the step under way and its done share until dropped.
pub struct StatusLine {
    step: Arc<Mutex<String>>,
    stop: Arc<AtomicBool>,
    painter: Option<JoinHandle<()>>,
}

impl StatusLine {
    /// Starts showing `progress`.
    pub fn new(progress: &Progress) -> Self {
        let step = Arc::new(Mutex::new(String::new()));
        let stop = Arc::new(AtomicBool::new(false));
        let painter = std::io::stderr().is_terminal().then(|| {
            let (step, stop, progress) = (step.clone(), stop.clone(), progress.clone());
            std::thread::spawn(move || paint(&step, &stop, &progress))
        });
        Self {
            step,
            stop,
            painter,
        }
    }

    /// Names the step that begins.
    pub fn step(&self, name: &str) {
        name.clone_into(&mut self.step.lock().unwrap_or_else(PoisonError::into_inner));
        if self.painter.is_none() {
            output::tell(name);
        }
    }
}

fn paint(step: &Mutex<String>, stop: &AtomicBool, progress: &Progress) {
    while !stop.load(Ordering::Relaxed) {
        let name = step.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if !name.is_empty() {
            write_over(format_args!("{name} {:3.0} %", 100.0 * progress.fraction()));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    write_over(format_args!(""));
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
        self.stop.store(true, Ordering::Relaxed);
        if let Some(painter) = self.painter.take() {
            painter.join().ok();
        }
    }
}
