//! Names of the logs of a survey, and their points.

use crate::export::LogPoints;
use crate::pipeline::ProcessedLog;
use bathyscope_log::survey::distinct_names;

/// Returns the names of the logs: [`distinct_names`].
pub fn log_names(logs: &[ProcessedLog]) -> Vec<String> {
    distinct_names(logs.iter().map(|log| &*log.survey))
}

/// Returns the name of a survey: the names of its logs, or the first and the last of more than
/// three.
pub(super) fn survey_name(names: &[String]) -> String {
    match names {
        [first, .., last] if names.len() > 3 => format!("{first} to {last} ({} logs)", names.len()),
        names => names.join(", "),
    }
}

/// Returns the points of each log, from which tables and clouds are written.
pub(super) fn log_points<'a>(logs: &'a [ProcessedLog], names: &'a [String]) -> Vec<LogPoints<'a>> {
    let points = |(name, log): (&'a String, &'a ProcessedLog)| {
        let products = &log.products;
        LogPoints {
            name,
            survey: &log.survey,
            navigation: &products.navigation,
            returns: &products.returns,
            calibration: &products.calibration,
            correction: &products.correction,
            exclusions: &products.exclusions,
            cloud: &products.cloud,
            classes: &products.classes,
        }
    };
    names.iter().zip(logs).map(points).collect()
}
