//! What is written of a survey: one run, the same from the window and the command line.
//!
//! `write` makes all files of a run and puts them in place together; `detected` those of a search alone; `overwrite` keeps them from
//! taking the place of what they are made from.

mod detected;
mod overwrite;
mod write;

pub use detected::{write_detected, write_detected_in_picture};
pub use overwrite::refuse_overwrite;
pub use write::{Order, Searched, Written, write};
