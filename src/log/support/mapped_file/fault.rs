//! A page of a mapped file that the system cannot give: zeros take its place, and the program goes
//! on.
//!
//! POSIX sends SIGBUS to the thread that touches such a page (`mmap(2)`): behind the end of a file
//! that was cut, of a card that was pulled out, of a disk with an error. The handler maps zeros
//! over the page and returns, and the system repeats the access. It calls nothing but what POSIX
//! lets a handler call (`signal-safety(7)`) and `mmap`, which Linux, macOS and the BSDs carry out
//! as a system call of its own; all else is loads and stores of atomics. It needs some hundred
//! bytes of whatever stack the thread has. `errno` stays as it is where `mmap` succeeds, and what
//! was interrupted is no call but a read of memory.

use super::registry;
use libc::{c_int, c_void, siginfo_t};
use std::sync::{Once, OnceLock};
use std::{mem, process, ptr};

/// Largest exponent of 2 for the number of pages that one fault replaces: 4 GiB at once are the
/// most.
const MOST_DOUBLED: usize = 20;

/// Data that the handler needs.
struct Installed {
    /// Earlier handler of SIGBUS: Rust's own check of the end of the stack.
    before: libc::sigaction,
    /// Bytes of a page.
    page: usize,
}

static INSTALLED: OnceLock<Installed> = OnceLock::new();

/// Handles faults in registered maps from the first call on.
#[allow(unsafe_code)]
pub(super) fn install() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // SAFETY: zeros are a value of the structure; both calls only read and write what they are
        // given. The handler takes its arguments as SA_SIGINFO has them, and what it goes by is
        // there before it is.
        unsafe {
            let mut before: libc::sigaction = mem::zeroed();
            libc::sigaction(libc::SIGBUS, ptr::null(), &raw mut before);
            let page = usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).unwrap_or(4096);
            INSTALLED.get_or_init(|| Installed { before, page });
            let mut action: libc::sigaction = mem::zeroed();
            action.sa_sigaction = on_fault as *const () as usize;
            // The stack that Rust gives its threads for handlers is used where there is one.
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
    // SAFETY: SA_SIGINFO has the system pass a structure that it filled.
    let (code, address) = unsafe { ((*info).si_code, (*info).si_addr().addr()) };
    // What another process sent has no address.
    let is_fault = code > 0;
    if is_fault && put_zeros(address, installed.page) {
        return;
    }
    // SAFETY: the action is the one that the system gave. A fault recurs after the return and comes
    // to it; what was sent is sent again.
    unsafe {
        libc::sigaction(signal, &raw const installed.before, ptr::null_mut());
        if !is_fault {
            libc::raise(signal);
        }
    }
}

/// Puts zeros in the place of the page of an address where that lies in a registered map. Each
/// further fault of a map takes twice as many pages: a bad place of a card costs little more than
/// itself, and the rest of a log of any size is taken after a few dozen. Otherwise each of millions
/// of pages would cost a fault and could become a mapping of its own, of which a process may have
/// some 65 000.
fn put_zeros(address: usize, page: usize) -> bool {
    let Some((map, range)) = registry::find(address) else {
        return false;
    };
    let faults = map.lose(address - range.start);
    let end = range.end.next_multiple_of(page);
    let from = address - address % page;
    let pages = 1_usize << faults.min(MOST_DOUBLED);
    let length = pages.saturating_mul(page).min(end - from);
    // Where there are too many mappings already, one takes the place of all those of this map.
    map_zeros(from, length) || map_zeros(range.start, end - range.start)
}

/// Maps zeros over whole pages of a registered map; `false` where the system refuses.
#[allow(unsafe_code)]
fn map_zeros(from: usize, length: usize) -> bool {
    let (start, flags) =
        (ptr::without_provenance_mut(from), libc::MAP_PRIVATE | libc::MAP_ANON | libc::MAP_FIXED);
    // SAFETY: the pages are those of a map that the thread of this handler is reading, so it is not
    // dropped meanwhile, and nothing else can lie there: it leaves the registry before it is
    // unmapped. Readers see bytes become zero, which `MappedFile` allows for. Unmapping takes
    // whatever lies in the range.
    let mapped = unsafe { libc::mmap(start, length, libc::PROT_READ, flags, -1, 0) };
    mapped != libc::MAP_FAILED
}
