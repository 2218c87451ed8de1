//! Work on many things, a few at a time.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Does some work on each of many things, on as many threads as there are processors and at most
/// `most`; results are in the order of the things. The threads are not those of rayon, where one
/// that waits for a part of its own work would begin the next thing meanwhile, so that there is
/// never more than one in the memory of each.
pub(super) fn each_in_parallel<T: Sync, R: Send>(
    things: &[T],
    most: usize,
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(things.len()));
    let worker = || {
        while let Some((index, thing)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            things.get(index).map(|thing| (index, thing))
        } {
            let result = work(thing);
            done.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        }
    };
    let processors = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        for _ in 0..processors.min(most).min(things.len()) {
            scope.spawn(worker);
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_unstable_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_things() {
        let things: Vec<usize> = (0..500).collect();
        assert_eq!(each_in_parallel(&things, 4, |thing| thing * 2)[77], 154);
        assert!(each_in_parallel(&[] as &[u8], 4, |_| ()).is_empty());
    }
}
