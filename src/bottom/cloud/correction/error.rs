//! Reasons why readings of the water's height are not in force.

use bathyscope_log::support::calendar;
use std::path::PathBuf;

/// Reason why readings of the water's height are not in force: one sentence, the path last.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WaterLevelError {
    /// The settings name a file only.
    #[error("the readings of the water level have not been read: {}", path.display())]
    NotRead {
        /// The file of the readings.
        path: PathBuf,
    },
    /// The readings have dates and the log has none.
    #[error(
        "the log does not know the time, so readings of the water level cannot be applied to it; give one water_level_m instead: {}", path.display()
    )]
    UnknownTime {
        /// The file of the readings.
        path: PathBuf,
    },
    /// The log begins before the first reading, or ends after the last.
    #[error(
        "the readings of the water level go from {} to {} UTC, but the log from {} to {}; add the readings that are missing: {}",
        moment(readings_s[0]), moment(readings_s[1]), moment(log_s[0]), moment(log_s[1]), path.display()
    )]
    NotCovered {
        /// The first and the last reading, Unix seconds.
        readings_s: [f64; 2],
        /// Begin and end of the log, Unix seconds.
        log_s: [f64; 2],
        /// The file of the readings.
        path: PathBuf,
    },
}

/// Date and time of day, UTC.
pub(super) fn moment(unix_s: f64) -> String {
    format!("{} {}", calendar::date(unix_s), calendar::time_of_day(unix_s))
}
