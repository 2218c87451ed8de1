//! Surfaces and what is drawn from them, against what other programs make of the same numbers and
//! against simulated truth.

mod change;
mod height_offsets;
mod isobaths;
mod ponds;
