//! A log that is being written: its tail, its results, and the window that follows it.

mod results;
mod tails;
mod window;
