//! Computes results over all logs of a survey together.
//!
//! In: the results of several logs. Out: their differences, height offsets and one report.
//!
//! Every log is processed by itself, with its own calibration and outliers; all of them are in the
//! local coordinate frame of the first ([`bathyscope_log::survey::Survey::in_frame`]), so joint
//! results can combine theirs. `crossline` compares logs with each other where their tracks meet,
//! `contradicted` finds their height offsets and the soundings that others show to be false,
//! `corrections` describes the requested corrections, applied or refused, and `report` sums the
//! logs up, compares them with each other by their points, and lists them (`logs_report`).

mod contradicted;
mod corrections;
mod crossline;
mod logs_report;
mod report;

pub use contradicted::{ContradictedSoundings, HeightComparison, compare_heights};
pub use corrections::RequestedCorrection;
pub use crossline::{
    CrosslineAnalysis, LogPositions, crossline_analysis, latencies, position_offsets,
};
pub(crate) use crossline::{crossing_error, track_depths};
pub use logs_report::{LogReport, LogsReport};
pub(crate) use report::joint_report;
pub use report::{contradictions, depths_scale, heights_differ};
