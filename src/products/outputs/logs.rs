//! What the logs of a survey are called, and their points.

use crate::export::LogPoints;
use crate::pipeline::ProcessedLog;
use bathyscope_log::survey::distinct_names;

/// What the logs are called: [`distinct_names`].
pub fn log_names(logs: &[ProcessedLog]) -> Vec<String> {
    distinct_names(logs.iter().map(|log| &*log.survey))
}

/// What a survey is called: by its log, or by all of them.
pub(super) fn survey_name(names: &[String]) -> String {
    match names {
        [first, .., last] if names.len() > 3 => format!("{first} to {last} ({} logs)", names.len()),
        names => names.join(", "),
    }
}

/// What the tables and clouds of points are written from.
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
