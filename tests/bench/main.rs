//! Benchmarks: `cargo bench` runs all, with `-- NAME...` some of them.
//!
//! A figure is a ratio against a baseline in the same run, or a throughput beside a plain read of
//! the same bytes: absolute times of one machine prove nothing on another.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "as in tests")]

mod accuracy;
mod bottom;
mod confidence;
mod decode;
mod detector;
mod first_return;
mod following;
mod large_log;
mod levels;
mod levels_cost;
mod lines;
mod many_logs;
mod map;
mod memory;
mod mosaic;
mod outliers;
mod products;
mod resources;
mod surface;
#[allow(dead_code, reason = "tests of bathyscope-products use all of it")]
#[path = "../../src/products/tests/suite/truth.rs"]
mod truth;
mod waterfall;

/// Allocator of Bathyscope, so that the measured memory is what its users see.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Name on the command line and what it runs.
const BENCHES: &[(&str, fn())] = &[
    ("decode", decode::run),
    ("detector", detector::run),
    ("first_return", first_return::run),
    ("following", following::run),
    ("many_logs", many_logs::run),
    ("memory", memory::run),
    ("mosaic", mosaic::run),
    ("outliers", outliers::run),
    ("products", products::run),
    ("levels", levels::run),
    ("levels_cost", levels_cost::run),
    ("surface", surface::run),
    ("waterfall", waterfall::run),
    ("bottom", bottom::run),
    ("map", map::run),
    ("accuracy", accuracy::run),
    ("confidence", confidence::run),
];

/// Runs the benchmarks that the command line names, all of them without a name.
fn main() {
    // Cargo passes `--bench`; what is left are names.
    let requested: Vec<String> =
        std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    for (name, run) in BENCHES {
        if requested.is_empty() || requested.iter().any(|requested| requested == name) {
            println!("== {name}");
            run();
        }
    }
}
