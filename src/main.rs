//! The `bathyscope` program; everything it does is in the library. What is set for the whole
//! process is set here.

/// Gives freed memory back to the system. The C library's allocator keeps what the workers' passing
/// arrays of up to 32 MB took, which is more than an open log needs.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |fault| {
        bathyscope::cli::write_crash_report(fault);
        if bathyscope::cli::is_to_be_printed(fault) {
            before(fault);
        }
    }));
    bathyscope::cli::main()
}
