//! Latency of the positions of a log, in numbers and in words.

use serde::Serialize;

/// Latency of the positions of a log, as its crossings show it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogLatency {
    /// Value that `mounting.latency_s` should have, seconds.
    pub latency_s: f64,
    /// Its standard error, seconds.
    pub standard_error_s: f64,
    /// Latency in force, seconds.
    pub in_force_s: f64,
}

/// Least difference, in seconds and in standard errors, by which crossings contradict the latency
/// in force.
const CONTRADICTED_S: f64 = 0.15;
const CONTRADICTED_SIGMAS: f64 = 3.0;

impl LogLatency {
    /// Returns true if the crossings contradict what is in force.
    pub(crate) fn contradicts(&self) -> bool {
        let off_s = (self.latency_s - self.in_force_s).abs();
        off_s > CONTRADICTED_S && off_s > CONTRADICTED_SIGMAS * self.standard_error_s
    }

    /// The sentence about what is in force, where the crossings contradict it.
    pub(crate) fn warning(&self) -> String {
        let more_s = self.latency_s - self.in_force_s;
        let (when, cause) = if more_s > 0.0 {
            ("later", "the receiver is late, or its antenna is behind the transducer")
        } else {
            ("earlier", "the antenna is ahead of the transducer")
        };
        format!(
            "Where the track crosses itself over slopes, depths agree best with positions recorded {:.2} s {when} (standard error {:.2} s): {cause}. Depths beside slopes are wrong until it is corrected: set mounting.latency_s to {:.2} (Compare positions, then Apply positions; or process with --latency).",
            more_s.abs(),
            self.standard_error_s,
            self.latency_s
        )
    }

    /// `0.62 s, standard error 0.08 s`.
    pub fn in_words(&self) -> String {
        format!("{:.2} s, standard error {:.2} s", self.latency_s, self.standard_error_s)
    }
}
