//! Replaces a page of a mapped file that the system cannot read any more by zeros, so that the
//! program goes on. Lists all current maps, so that a signal handler can look them up without a
//! lock and without allocating memory.
//!
//! POSIX sends SIGBUS to the thread that touches such a page (`mmap(2)`): behind the end of a file
//! that was cut, on a card that was pulled out, on a disk with an error. The handler maps zeros
//! over the page and returns, and the system repeats the access. The handler calls only what POSIX
//! lets a handler call (`signal-safety(7)`) and `mmap`, which is a plain system call on Linux,
//! macOS and the BSDs; all else is loads and stores of atomics. The handler needs some hundred
//! bytes of the stack of the thread. `errno` is unchanged where `mmap` succeeds, and the handler
//! interrupts a read of memory, not a call.

use libc::{c_int, c_void, siginfo_t};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::{Once, OnceLock};
use std::{mem, process, ptr};

/// Largest exponent of 2 for the number of pages that one fault replaces: at most 4 GiB at once.
const MOST_DOUBLED: usize = 20;

/// Data that the handler needs.
struct Installed {
    /// Earlier handler of SIGBUS: Rust's own check of the end of the stack.
    before: libc::sigaction,
    /// Bytes of a page.
    page: usize,
}

static INSTALLED: OnceLock<Installed> = OnceLock::new();

/// Installs the handler of SIGBUS at the first call; later calls do nothing.
#[allow(unsafe_code)]
pub(super) fn install() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // SAFETY: zeros are a valid value of the structure; the calls only read and write their
        // arguments. The handler has the signature of SA_SIGINFO, and `INSTALLED`, which it reads,
        // is set before the handler is installed.
        unsafe {
            let mut before: libc::sigaction = mem::zeroed();
            libc::sigaction(libc::SIGBUS, ptr::null(), &raw mut before);
            let page = usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).unwrap_or(4096);
            INSTALLED.get_or_init(|| Installed { before, page });
            let mut action: libc::sigaction = mem::zeroed();
            action.sa_sigaction = on_fault as *const () as usize;
            // SA_ONSTACK: uses the signal stack that Rust gives its threads, where there is one.
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigemptyset(&raw mut action.sa_mask);
            libc::sigaction(libc::SIGBUS, &raw const action, ptr::null_mut());
        }
    });
}

#[allow(unsafe_code)]
extern "C" fn on_fault(signal: c_int, info: *mut siginfo_t, _context: *mut c_void) {
    let Some(installed) = INSTALLED.get() else {
        process::abort();
    };
    // SAFETY: with SA_SIGINFO the system passes a structure that it filled.
    let (code, address) = unsafe { ((*info).si_code, (*info).si_addr().addr()) };
    // A signal that another process sent has no address.
    let is_fault = code > 0;
    if is_fault && put_zeros(address, installed.page) {
        return;
    }
    // SAFETY: the action is the one that the system returned at installation. A fault recurs after
    // the return and reaches the earlier handler; a signal that was sent is raised again.
    unsafe {
        libc::sigaction(signal, &raw const installed.before, ptr::null_mut());
        if !is_fault {
            libc::raise(signal);
        }
    }
}

/// Replaces the page of an address by zeros; returns false if the address is in no registered map,
/// or the system refuses. Each further fault of a map replaces twice as many pages: one bad place
/// of a card costs little more than its own pages, and the rest of a log of any size is replaced
/// after a few dozen faults. Otherwise each of millions of pages would cost a fault and could
/// become a separate mapping, of which a process may have some 65 000.
fn put_zeros(address: usize, page: usize) -> bool {
    let Some((map, range)) = find(address) else {
        return false;
    };
    let faults = map.lose(address - range.start);
    let end = range.end.next_multiple_of(page);
    let from = address - address % page;
    let pages = 1_usize << faults.min(MOST_DOUBLED);
    let length = pages.saturating_mul(page).min(end - from);
    // Where the process has too many mappings already, one mapping replaces all of this map.
    map_zeros(from, length) || map_zeros(range.start, end - range.start)
}

/// Maps zeros over whole pages of a registered map; returns false if the system refuses.
#[allow(unsafe_code)]
fn map_zeros(from: usize, length: usize) -> bool {
    let (start, flags) =
        (ptr::without_provenance_mut(from), libc::MAP_PRIVATE | libc::MAP_ANON | libc::MAP_FIXED);
    // SAFETY: the pages belong to a map that the thread of this handler is reading, so the map is
    // not dropped meanwhile, and nothing else can be mapped there: a map leaves the registry before
    // it is unmapped. Readers see bytes become zero, which `MappedFile` allows for. Unmapping
    // removes whatever is mapped in the range.
    let mapped = unsafe { libc::mmap(start, length, libc::PROT_READ, flags, -1, 0) };
    mapped != libc::MAP_FAILED
}

/// Value of [`Place::lost_from`] while no byte was lost.
const NONE: usize = usize::MAX;

/// First place of the list of maps.
static FIRST: Place = Place::new();

/// A place of the list: a map, or room for one. Places are never freed, only used again, so that a
/// handler can walk the list at any time; the list is as long as the largest number of maps that
/// existed at once.
struct Place {
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
    fn lose(&self, offset: usize) -> usize {
        self.lost_from.fetch_min(offset, SeqCst);
        self.faults.fetch_add(1, SeqCst)
    }
}

/// Returns the map that contains an address, with the addresses of all its bytes; `None` where
/// there is none.
fn find(address: usize) -> Option<(&'static Place, Range<usize>)> {
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
