//! Turns panics into errors. This module depends on no other module of the crate.
//!
//! A library does not set the panic hook of the whole process: the program sets a hook, and the
//! hook calls [`is_to_be_printed`] to decide whether a panic is printed.

use std::any::Any;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Mutex, PoisonError};

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
}

/// State of the work that [`panic_as_error`] runs, whose panics become one error.
#[derive(Debug, Default)]
enum Reporting {
    /// No such work is running.
    #[default]
    Not,
    /// The work is running; cause and place of its first panic, `None` before one.
    Under(Option<String>),
}

static REPORTING: Mutex<Reporting> = Mutex::new(Reporting::Not);

/// Runs `work`; `None` when it panicked. Values that `work` borrows mutably may be half changed
/// after a panic and must not be used then.
pub fn catch_panic<T>(work: impl FnOnce() -> T) -> Option<T> {
    let outer = CATCHING.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(work));
    CATCHING.set(outer);
    outcome.ok()
}

/// Error that a panic became: the cause of the panic, and its place in the source where known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Panicked(pub String);

/// Runs all of a program's work. A panic becomes an error that names its cause, and also its place
/// in the source if the program's panic hook called [`is_to_be_printed`].
///
/// # Errors
/// When `work` panicked.
pub fn panic_as_error<T>(work: impl FnOnce() -> T) -> Result<T, Panicked> {
    *reporting() = Reporting::Under(None);
    let outcome = panic::catch_unwind(AssertUnwindSafe(work));
    let first = match std::mem::take(&mut *reporting()) {
        Reporting::Under(first) => first,
        Reporting::Not => None,
    };
    outcome.map_err(|payload| Panicked(first.unwrap_or_else(|| cause(payload.as_ref()).to_owned())))
}

/// Returns true if a panic is to be printed; to be called from the panic hook of a program. Panics
/// inside [`catch_panic`] are not printed: a dependency panicked on damaged bytes, which is an
/// ordinary error. Panics inside [`panic_as_error`] become its error and are printed only if
/// `RUST_BACKTRACE` is set; the first of them is recorded.
pub fn is_to_be_printed(fault: &PanicHookInfo<'_>) -> bool {
    if is_caught() {
        return false;
    }
    let Reporting::Under(first) = &mut *reporting() else {
        return true;
    };
    let place = fault.location();
    let place = place.map_or(String::new(), |at| format!(" at {}:{}", at.file(), at.line()));
    first.get_or_insert_with(|| format!("{}{place}", cause(fault.payload())));
    std::env::var_os("RUST_BACKTRACE").is_some()
}

/// Returns true while this thread runs inside [`catch_panic`], so that a panic does not end the
/// program.
pub fn is_caught() -> bool {
    CATCHING.get()
}

fn reporting() -> std::sync::MutexGuard<'static, Reporting> {
    REPORTING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the message of a panic.
pub fn cause(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no reason given")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_nothing() {
        assert_eq!(catch_panic(|| 7), Some(7));
        let none: Option<u8> = catch_panic(|| panic!("a fault"));
        assert_eq!(none, None);
    }

    #[test]
    fn a_panic_of_all_the_work_becomes_an_error_with_its_cause() {
        assert_eq!(panic_as_error(|| 7), Ok(7));
        let error = panic_as_error::<()>(|| panic!("no more {}", "ink")).unwrap_err();
        assert!(error.0.starts_with("no more ink"), "{error}");
    }
}
