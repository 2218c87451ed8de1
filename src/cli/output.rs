//! Text for stdout and stderr. The standard macros panic where nobody reads any more or the disk is
//! full. Whatever a file holds, what reaches a terminal from here is text that it shows and no
//! command to it. A graphics driver's remarks are kept off stderr.

use super::Failure;
use crate::app::system_words::in_plain_words;
use bathyscope_log::support::printable;
use serde::Serialize;
use std::fmt::Display;
use std::io::{self, ErrorKind, Write as _};

/// Mesa's environment variable that leaves out its layer for choosing among adapters. Without a
/// display there is nothing that it could ask, and it complains about a missing `XDG_RUNTIME_DIR`
/// at every look.
#[cfg(target_os = "linux")]
const NO_CHOICE: &str = "NODEVICE_SELECT";

/// Prints results on stdout, a line end after them. A reader that has gone away (`| head`) has seen
/// enough: no error.
pub(super) fn results(text: impl Display) -> Result<(), Failure> {
    print(&printable::lines(&text.to_string()))
}

/// Prints a value as JSON on stdout, with all that its strings hold.
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

/// Writes one line to stderr. Where stderr takes nothing, there is no place left to complain.
pub(super) fn notify(text: impl Display) {
    let text = text.to_string();
    let line = printable::one_line(&in_plain_words(&text));
    writeln!(io::stderr(), "{line}").ok();
}

/// Starts the program anew in the same process, with the same arguments and `NO_CHOICE` set, where
/// the driver would complain. Returns where it would not, or where starting anew fails: then it
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
        // Whatever has become of the file that it was started from meanwhile.
        let error = std::process::Command::new("/proc/self/exe")
            .arg0(name)
            .args(arguments)
            .env(NO_CHOICE, "1")
            .exec();
        drop(error);
    }
}
