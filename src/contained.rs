//! Foreign code that panics on damaged bytes, made to fail instead. Leans on nothing; any room may use it.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Mutex, Once, PoisonError};

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work`; `None` when it panicked, of which nothing is printed. For work that leaves nothing behind when it stops half
/// way: what it borrowed mutably may be half changed.
pub fn contained<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |what| {
            if !CONTAINED.get() {
                before(what);
            }
        }));
    });
    let outer = CONTAINED.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(work));
    CONTAINED.set(outer);
    outcome.ok()
}

/// Runs all of a program's work. A panic becomes an error that names its cause and its place in the source, and nothing is printed
/// of it unless `RUST_BACKTRACE` asks for that.
pub fn reported<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    static FIRST: Mutex<Option<String>> = Mutex::new(None);
    let asked = std::env::var_os("RUST_BACKTRACE").is_some();
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |what| {
        let place = what.location();
        let place = place.map_or(String::new(), |at| {
            format!(" at {}:{}", at.file(), at.line())
        });
        let cause = what.payload_as_str().unwrap_or("no reason given");
        let mut first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert_with(|| format!("{cause}{place}"));
        if asked {
            before(what);
        }
    }));
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        let first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
        first.clone().unwrap_or_default()
    })
}

#[cfg(test)]
mod tests {
    use super::contained;

    #[test]
    fn a_panic_becomes_nothing() {
        assert_eq!(contained(|| 7), Some(7));
        let none: Option<u8> = contained(|| panic!("foreign"));
        assert_eq!(none, None);
    }
}
