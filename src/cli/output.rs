//! Text for stdout and stderr. The standard macros panic where nobody reads any more or the disk is full.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write as _};

/// Prints results on stdout, a line end after them. A reader that has gone away (`| head`) has seen enough: no error.
pub fn results(text: impl Display) -> Result<(), String> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("cannot write the results to stdout: {error}"))
        }
        _ => Ok(()),
    }
}

/// Tells something on stderr. Where stderr takes nothing, there is no place left to complain.
pub fn tell(text: impl Display) {
    writeln!(io::stderr(), "{text}").ok();
}
