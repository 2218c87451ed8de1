//! Replaces a page of a mapped file that the system cannot read any more by zeros, so that the
//! program goes on.
//!
//! POSIX sends SIGBUS to the thread that touches such a page (`mmap(2)`): behind the end of a file
//! that was cut, on a card that was pulled out, on a disk with an error. The handler maps zeros
//! over the page and returns, and the system repeats the access. The handler calls only what POSIX
//! lets a handler call (`signal-safety(7)`) and `mmap`, which is a plain system call on Linux,
//! macOS and the BSDs; all else is loads and stores of atomics. The handler needs some hundred
//! bytes of the stack of the thread. `errno` is unchanged where `mmap` succeeds, and the handler
//! interrupts a read of memory, not a call.

use super::registry;
use libc::{c_int, c_void, siginfo_t};
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
    let Some((map, range)) = registry::find(address) else {
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
