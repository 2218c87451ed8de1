//! Judges what instruments recorded before anything is made of it.
//!
//! A recording has several witnesses of each thing: a position has those before and after it and
//! the speed of the boat. What contradicts them by more than their errors is false; it is left out,
//! and a sentence says when, how many and why. Rules are in the log's own intervals and speeds,
//! never in seconds of one recorder.

mod fixes;
mod soundings;

pub(crate) use fixes::drop_false_fixes;
pub use soundings::mark_bottom_lock;
pub(crate) use soundings::{NEAREST_SOUNDING_S, give_depths, mark_bottom_lock_from};
