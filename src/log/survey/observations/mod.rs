//! Judges what instruments recorded before anything is made of it.
//!
//! A recording has several witnesses of each thing: a position has those before and after it and
//! the speed of the boat, a sounding has its neighbours along the track. What contradicts them by
//! more than their errors is false; it does not count, and a sentence says when, how many and why.
//! Rules are in metres of track and in the log's own intervals and speeds, so that they hold for a
//! recorder of any rate; times in seconds only bound how long a memory or a gap may last.

mod fault;
mod fixes;
mod soundings;

pub use fault::{FaultCounts, SoundingFault};
pub(crate) use fixes::drop_false_fixes;
pub(crate) use soundings::{NEAREST_SOUNDING_S, give_depths, mark_faults_from};
pub use soundings::{differ_as_no_bed, is_step_of_no_bed, mark_faults};
