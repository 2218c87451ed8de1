//! What the logs of a survey are called, and their points.

use crate::export::LogPoints;
use crate::pipeline::ProcessedLog;

/// What the logs are called, each otherwise: two recorders both begin with `Rec00001`.
pub fn log_names(logs: &[ProcessedLog]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in logs.iter().map(|log| log.survey.name()) {
        let same = |taken: &&String| taken.split(" (").next() == Some(name.as_str());
        let count = names.iter().filter(same).count();
        names.push(match count {
            0 => name,
            count => format!("{name} ({})", count + 1),
        });
    }
    names
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
            left_out: &products.left_out,
            cloud: &products.cloud,
            classes: &products.classes,
        }
    };
    names.iter().zip(logs).map(points).collect()
}
