//! The fuzzer: all readers of Bathyscope in one program, fed by libFuzzer, and sweeps over harmed
//! recordings. `run` says how to use it.
//!
//! ```text
//! fuzz list                            names, longest inputs and shares of the readers
//! fuzz seeds FOLDER                    writes small files to begin with, a folder for each reader
//! fuzz sweep [--each N] RECORDING...   harms recordings in every way (one in N of all) and prints what was lost
//! fuzz READER [libFuzzer's options]    feeds one reader; with the name of a file, that input alone
//! ```
//!
//! An input may take four times its own memory and 64 MiB; an allocation beyond that ends the
//! program, as a panic does.

#[path = "mod.rs"]
mod readers;

use libfuzzer_sys as _;
use readers::{TARGETS, Target, sweep};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ffi::{CString, c_char, c_int};
use std::path::PathBuf;
use std::process::{ExitCode, abort};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Memory that an input may take beside a multiple of its own size.
const SPARE: usize = 64 << 20;
/// Multiple of its own size that an input may take as memory.
const TIMES: usize = 4;

/// Bytes that are allocated now, and at most.
static LIVE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);
static TARGET: OnceLock<&'static Target> = OnceLock::new();

/// The system's allocator with a limit.
struct Limited;

#[global_allocator]
static ALLOCATOR: Limited = Limited;

impl Limited {
    fn add(bytes: usize) {
        let live = LIVE.fetch_add(bytes, Ordering::Relaxed) + bytes;
        if live > MOST.load(Ordering::Relaxed) {
            MOST.store(usize::MAX, Ordering::Relaxed);
            eprintln!(
                "an allocation of {bytes} bytes, {live} in all, is beyond four times the input and 64 MiB"
            );
            abort();
        }
    }
}

// SAFETY: all is left to the system's allocator; its sizes are only counted.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::add(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        Self::add(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        Self::add(size);
        unsafe { System.realloc(place, layout, size) }
    }
}

unsafe extern "C" {
    fn LLVMFuzzerRunDriver(
        count: *mut c_int,
        arguments: *mut *mut *mut c_char,
        test_input: extern "C" fn(*const u8, usize) -> c_int,
    ) -> c_int;
    fn LLVMFuzzerMutate(bytes: *mut u8, count: usize, most: usize) -> usize;
}

/// Changes an input as libFuzzer does; what a reader checks of it is put right in every other one.
///
/// # Safety
/// `bytes` has room for `most` bytes, of which `count` are set: libFuzzer calls it so.
#[unsafe(no_mangle)]
unsafe extern "C" fn LLVMFuzzerCustomMutator(
    bytes: *mut u8,
    count: usize,
    most: usize,
    seed: u32,
) -> usize {
    // SAFETY: as this function's.
    let count = unsafe { LLVMFuzzerMutate(bytes, count, most) };
    if let Some(target) = TARGET.get().filter(|_| seed.is_multiple_of(2)) {
        // SAFETY: so many bytes are set now.
        (target.repair)(unsafe { std::slice::from_raw_parts_mut(bytes, count) });
    }
    count
}

/// The crate of libFuzzer asks for one; it is never called.
#[unsafe(no_mangle)]
#[allow(improper_ctypes_definitions, reason = "both sides are Rust")]
extern "C" fn rust_fuzzer_test_input(_: &[u8]) -> i32 {
    0
}

extern "C" fn feed(bytes: *const u8, count: usize) -> c_int {
    let bytes = match count {
        0 => &[][..],
        // SAFETY: libFuzzer hands over so many bytes and leaves them alone meanwhile.
        _ => unsafe { std::slice::from_raw_parts(bytes, count) },
    };
    if let Some(target) = TARGET.get() {
        let limit = LIVE.load(Ordering::Relaxed) + TIMES * count + SPARE;
        MOST.store(limit, Ordering::Relaxed);
        (target.run)(bytes);
        MOST.store(usize::MAX, Ordering::Relaxed);
    }
    0
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some("list") => {
            for target in TARGETS {
                println!("{} {} {}", target.name, target.longest, target.share);
            }
            ExitCode::SUCCESS
        }
        Some("seeds") => write_seeds(&PathBuf::from(arguments.next().unwrap_or_default())),
        Some("sweep") => run_sweep(arguments),
        Some(name) => match TARGETS.iter().find(|target| target.name == name) {
            Some(target) => run_fuzzer(target, arguments),
            None => usage(),
        },
        None => usage(),
    }
}

fn usage() -> ExitCode {
    eprintln!(
        "fuzz list | seeds FOLDER | sweep [--each N] RECORDING... | READER [libFuzzer's options]"
    );
    ExitCode::from(2)
}

fn write_seeds(folder: &std::path::Path) -> ExitCode {
    for target in TARGETS {
        let folder = folder.join(target.name);
        std::fs::create_dir_all(&folder).expect("a folder for seeds");
        for (index, seed) in (target.seeds)().iter().enumerate() {
            std::fs::write(folder.join(format!("seed-{index}")), seed).expect("a seed");
        }
    }
    ExitCode::SUCCESS
}

fn run_sweep(arguments: impl Iterator<Item = String>) -> ExitCode {
    let mut each = 1;
    let mut arguments = arguments.peekable();
    if arguments.next_if_eq("--each").is_some() {
        let number = arguments.next().and_then(|number| number.parse().ok());
        each = number.filter(|each| *each > 0).unwrap_or(1);
    }
    let paths: Vec<PathBuf> = arguments.map(PathBuf::from).collect();
    if sweep::sweep(&paths, each) {
ExitCode::SUCCESS
} else {
ExitCode::FAILURE
}
}

fn run_fuzzer(target: &'static Target, options: impl Iterator<Item = String>) -> ExitCode {
    TARGET.get_or_init(|| target);
    std::panic::set_hook(Box::new(|panic| {
        if readers::is_fault(panic) {
            MOST.store(usize::MAX, Ordering::Relaxed);
            eprintln!("{panic}");
            eprintln!("{}", std::backtrace::Backtrace::force_capture());
            abort();
        }
    }));
    // What a reader builds once is not counted for its first input.
    (target.seeds)().iter().for_each(|seed| (target.run)(seed));
    let name = std::iter::once("fuzz".to_owned());
    let options = name
        .chain(options)
        .map(|option| CString::new(option).unwrap_or_default());
    let mut options: Vec<*mut c_char> = options.map(CString::into_raw).collect();
    let mut count = options.len() as c_int;
    options.push(std::ptr::null_mut());
    let mut list = options.as_mut_ptr();
    // SAFETY: the options are C strings that live as long as the program, and the list ends with a
    // null.
    let status = unsafe { LLVMFuzzerRunDriver(&raw mut count, &raw mut list, feed) };
    ExitCode::from(u8::try_from(status).unwrap_or(1))
}
