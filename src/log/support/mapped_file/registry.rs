//! Lists all current maps of files, for a signal handler to look up without a lock and without
//! allocating memory.

use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

/// Value of [`Place::lost_from`] while no byte was lost.
const NONE: usize = usize::MAX;

/// First place of the list of maps.
static FIRST: Place = Place::new();

/// A place of the list: a map, or room for one. Places are never freed, only used again, so that a
/// handler can walk the list at any time; the list is as long as the largest number of maps that
/// existed at once.
pub(super) struct Place {
    is_taken: AtomicBool,
    /// Counter that is odd while the range is being changed, and different after each change, so
    /// that a reader notices a range that was changed while it was read.
    version: AtomicUsize,
    start: AtomicUsize,
    end: AtomicUsize,
    /// Number of faults so far.
    faults: AtomicUsize,
    /// Offset of the first byte that was lost; [`NONE`] while none was lost.
    lost_from: AtomicUsize,
    next: OnceLock<&'static Place>,
}

impl Place {
    const fn new() -> Self {
        Self {
            is_taken: AtomicBool::new(false),
            version: AtomicUsize::new(0),
            start: AtomicUsize::new(0),
            end: AtomicUsize::new(0),
            faults: AtomicUsize::new(0),
            lost_from: AtomicUsize::new(NONE),
            next: OnceLock::new(),
        }
    }

    fn set(&self, range: &Range<usize>) {
        self.version.fetch_add(1, SeqCst);
        self.start.store(range.start, SeqCst);
        self.end.store(range.end, SeqCst);
        self.faults.store(0, SeqCst);
        self.lost_from.store(NONE, SeqCst);
        self.version.fetch_add(1, SeqCst);
    }

    /// Returns the addresses of the map; `None` while they are being changed.
    fn range(&self) -> Option<Range<usize>> {
        let version = self.version.load(SeqCst);
        let range = self.start.load(SeqCst)..self.end.load(SeqCst);
        let is_settled = version.is_multiple_of(2) && self.version.load(SeqCst) == version;
        is_settled.then_some(range)
    }

    /// Records that the byte at an offset is lost; returns the number of faults of this map before.
    pub(super) fn lose(&self, offset: usize) -> usize {
        self.lost_from.fetch_min(offset, SeqCst);
        self.faults.fetch_add(1, SeqCst)
    }
}

/// Returns the map that contains an address, with the addresses of all its bytes; `None` where
/// there is none.
pub(super) fn find(address: usize) -> Option<(&'static Place, Range<usize>)> {
    let mut next = Some(&FIRST);
    while let Some(place) = next {
        // A map that is being read is not changed, so a map that is being changed can be skipped.
        if let Some(range) = place.range().filter(|range| range.contains(&address)) {
            return Some((place, range));
        }
        next = place.next.get().copied();
    }
    None
}

/// A map in the list; dropping this value removes the map.
pub(super) struct Registered(&'static Place);

impl Registered {
    /// Adds a map to the list; `start` is its first address, `length` its length in bytes.
    pub(super) fn new(start: usize, length: usize) -> Self {
        let mut place = &FIRST;
        while place.is_taken.swap(true, SeqCst) {
            place = (place.next).get_or_init(|| Box::leak(Box::new(Place::new())));
        }
        place.set(&(start..start.saturating_add(length)));
        Self(place)
    }

    /// Returns the offset of the first byte that was lost; `None` while none was lost.
    pub(super) fn lost_from(&self) -> Option<u64> {
        let from = self.0.lost_from.load(SeqCst);
        (from != NONE).then_some(from as u64)
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        self.0.set(&(0..0));
        self.0.is_taken.store(false, SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Addresses that no map has.
    const FREE: usize = usize::MAX / 2;

    #[test]
    fn maps_are_found_by_their_addresses_while_they_are_there() {
        let of = |index: usize| Registered::new(FREE + 100 * index, 50);
        let maps: Vec<Registered> = (0..300).map(of).collect();
        for index in 0..300 {
            let start = FREE + 100 * index;
            for inside in [start, start + 49] {
                let (_, range) = find(inside).expect("a map");
                assert_eq!(range, start..start + 50);
            }
            assert!(find(start + 50).is_none() && find(start + 99).is_none());
        }
        drop(maps);
        assert!((0..300).all(|index| find(FREE + 100 * index).is_none()));
        let again = of(7);
        assert!(find(FREE + 710).is_some());
        assert_eq!(again.lost_from(), None);
    }

    #[test]
    fn the_first_byte_lost_counts_and_is_forgotten_with_the_map() {
        let start = 2 * (FREE / 3);
        let map = Registered::new(start, 1000);
        let (place, _) = find(start + 500).expect("a map");
        assert_eq!([500, 900, 200].map(|offset| place.lose(offset)), [0, 1, 2]);
        assert_eq!(map.lost_from(), Some(200));
        drop(map);
        assert_eq!(Registered::new(start, 1000).lost_from(), None);
    }
}
