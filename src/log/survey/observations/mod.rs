//! Finds false positions and soundings in a recording before results are computed from them.
//!
//! A position is checked against the positions before and after it and the speed of the boat, a
//! sounding against its neighbours along the track. A value that contradicts these by more than
//! their errors is false: it does not count, and a sentence reports when, how many and why. The
//! rules are in metres of track and in the log's own intervals and speeds, so that they apply to
//! recorders of any rate; times in seconds only limit how far apart compared values may be.

mod fault;
mod fixes;
mod soundings;

pub use fault::{FaultCounts, SoundingFault};
pub(crate) use fixes::drop_false_fixes;
pub(crate) use soundings::{NEAREST_SOUNDING_S, give_depths, mark_faults_from};
pub use soundings::{differ_as_no_bed, is_step_of_no_bed, mark_faults};
