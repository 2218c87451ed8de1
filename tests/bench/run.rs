//! Runs the benchmarks of the library.

/// That of the program: what is measured of memory is what its users see.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    bathyscope::bench::main();
}
