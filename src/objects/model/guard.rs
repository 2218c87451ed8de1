//! Work on a file that may be made to harm: it may fail, stop half way or never end, and only that
//! work ends.

use super::Unusable;
use bathyscope_log::support::catch_panic::catch_panic;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// Deep networks are walked by recursion; address space alone is set aside for it.
const STACK_BYTES: usize = 64 << 20;

/// Runs `work` on a thread of its own and waits `limit` for it. `what` names the work in the
/// message. A thread that is late is left to itself: what it may cost is bounded before it starts,
/// and its result is dropped.
///
/// # Errors
/// Why the model cannot be used.
pub(super) fn guarded<T: Send + 'static>(
    what: &'static str,
    limit: Duration,
    work: impl FnOnce() -> Result<T, Unusable> + Send + 'static,
) -> Result<T, Unusable> {
    let (sender, receiver) = mpsc::channel();
    thread::Builder::new().name(what.to_owned()).stack_size(STACK_BYTES).spawn(move || {
        let outcome = catch_panic(work).unwrap_or(Err(Unusable::Damaged(what)));
        // A receiver that has gone away waits no more.
        sender.send(outcome).ok();
    })?;
    receiver.recv_timeout(limit).unwrap_or_else(|gone| {
        Err(match gone {
            RecvTimeoutError::Timeout => Unusable::Slow { what, seconds: limit.as_secs() },
            RecvTimeoutError::Disconnected => Unusable::Damaged(what),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_stops_or_never_ends_is_distinguished() {
        let soon = Duration::from_millis(50);
        let late = Duration::from_secs(600);
        assert_eq!(guarded("this", late, || Ok(7)).unwrap(), 7);
        let panicked = guarded::<()>("this", late, || panic!("a fault"));
        assert!(matches!(panicked, Err(Unusable::Damaged("this"))));
        let slow = guarded("this", soon, || {
            thread::sleep(Duration::from_millis(500));
            Ok(())
        });
        assert!(matches!(slow, Err(Unusable::Slow { what: "this", .. })));
    }
}
