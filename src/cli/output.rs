//! Prints text on stdout and stderr. The standard macros panic when the reader of stdout has gone
//! or the disk is full. Control characters from a file are made printable, so that no text is a
//! command to the terminal. The remarks of a graphics driver are kept off stderr.

use super::Failure;
use crate::app::system_words::in_plain_words;
use bathyscope_log::support::printable;
use serde::Serialize;
use std::fmt::Display;
use std::io::{self, ErrorKind, Write as _};

/// Mesa's environment variable that disables its layer for the choice of an adapter. Without a
/// display that layer has no server to query, and complains about a missing `XDG_RUNTIME_DIR` each
/// time adapters are listed.
#[cfg(target_os = "linux")]
const NO_CHOICE: &str = "NODEVICE_SELECT";

/// Prints results on stdout, and a line end after them. A reader that has closed the pipe (`|
/// head`) is no error.
pub(super) fn results(text: impl Display) -> Result<(), Failure> {
    print(&printable::lines(&text.to_string()))
}

/// Prints a value as JSON on stdout; the strings are printed whole, with control characters
/// escaped.
pub(super) fn json(value: &impl Serialize) -> Result<(), Failure> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => print(&printable::json(&text)),
        Err(error) => Err(format!("cannot print the results as JSON: {error}").into()),
    }
}

fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("cannot write the results to stdout: {error}").into())
        }
        _ => Ok(()),
    }
}

/// Writes one line to stderr. A failure to write is ignored: there is no place left to report it.
pub(super) fn notify(text: impl Display) {
    let text = text.to_string();
    let line = printable::one_line(&in_plain_words(&text));
    writeln!(io::stderr(), "{line}").ok();
}

/// Starts the program again in the same process, with the same arguments and `NO_CHOICE` set, if
/// the driver would complain. Returns if it would not, or if the start fails: then the driver
/// complains, and all else works.
pub(super) fn restart_if_noisy() {
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::process::CommandExt as _;
        let is_set = |name: &str| std::env::var_os(name).is_some();
        if is_set("XDG_RUNTIME_DIR") || is_set(NO_CHOICE) {
            return;
        }
        let mut arguments = std::env::args_os();
        let name = arguments.next().unwrap_or_default();
        // `/proc/self/exe` works even if the program's file was moved or replaced meanwhile.
        let error = std::process::Command::new("/proc/self/exe")
            .arg0(name)
            .args(arguments)
            .env(NO_CHOICE, "1")
            .exec();
        drop(error);
    }
}
