//! Points that the tables and clouds are written from: of one log, or of all logs of a survey.

use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::cloud::{CloudPoint, Correction, PointClass, PointCloud, Reduction};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::survey::{Exclusions, Navigation, Survey};
use std::borrow::Cow;

/// The points of a log and what they come from.
#[derive(Clone, Copy)]
pub(crate) struct LogPoints<'a> {
    /// Name of the log, in a table of several logs.
    pub name: &'a str,
    /// The recording.
    pub survey: &'a Survey,
    /// Places of its pings.
    pub navigation: &'a Navigation,
    /// Its first returns.
    pub returns: &'a FirstReturns,
    /// Its scales.
    pub calibration: &'a Calibration,
    /// Corrections of its depths.
    pub correction: &'a Correction,
    /// Excluded pings and soundings.
    pub exclusions: &'a Exclusions,
    /// Its points.
    pub cloud: &'a PointCloud,
    /// The class of each point.
    pub classes: &'a [PointClass],
}

impl<'a> LogPoints<'a> {
    /// Returns the reduction of its samples and recorded depths to metres.
    pub(crate) fn reduction(&self) -> Reduction<'a> {
        Reduction::new(self.calibration, self.correction)
    }

    /// All points in the cloud's order, each with its class.
    pub(crate) fn points(
        &self,
    ) -> impl Iterator<Item = (&'a CloudPoint, PointClass)> + Clone + use<'a> {
        self.cloud.points.iter().zip(self.classes.iter().copied())
    }
}

/// The column of the log's name and what stands in it, each with its comma: only a table of several
/// logs has one.
pub(super) struct LogColumn {
    /// `log,`, or nothing.
    pub header: &'static str,
    is_shown: bool,
}

impl LogColumn {
    pub(super) fn of(logs: &[LogPoints<'_>]) -> Self {
        let is_shown = logs.len() > 1;
        Self { header: if is_shown { "log," } else { "" }, is_shown }
    }

    /// The field of a log, quoted where its name holds what ends a field.
    pub(super) fn field<'a>(&self, log: &LogPoints<'a>) -> Cow<'a, str> {
        match (self.is_shown, log.name.contains([',', '"', '\n', '\r'])) {
            (false, _) => Cow::Borrowed(""),
            (true, false) => Cow::Owned(format!("{},", log.name)),
            (true, true) => Cow::Owned(format!("\"{}\",", log.name.replace('"', "\"\""))),
        }
    }
}
