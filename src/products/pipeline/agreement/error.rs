//! Errors of the comparison of a survey with a reference.

use crate::pipeline::SourceError;
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_bottom::cloud::correction::WaterLevelError;
use bathyscope_bottom::presentation::text::way;
use bathyscope_log::formats::ReferenceError;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::{Crs, CrsError};
use bathyscope_log::support::progress::Cancelled;

/// Reason why a survey cannot be compared with a reference, in one sentence.
#[derive(Debug, thiserror::Error)]
pub enum AgreementError {
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The reference cannot be opened.
    #[error(transparent)]
    Open(#[from] ReferenceError),
    /// There is no log to compare with the reference.
    #[error("there is no log to compare with the reference")]
    NoLog,
    /// The reference does not fit.
    #[error(transparent)]
    Unusable(#[from] FileError<ReferenceFault>),
}

/// Fault of a reference, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceFault {
    /// Its points are in a system that is not known.
    #[error(transparent)]
    System(#[from] CrsError),
    /// Its points are in metres that lie over the survey neither in this system nor as metres from
    /// the first fix.
    #[error(
        "the file does not say which system its metres are in, and they lie over this survey neither as {0} nor as metres from its first fix; give longitude and latitude, or set crs to the file's system"
    )]
    UnknownMetres(Crs),
    /// A log of the other mission cannot be taken as the settings say.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The water levels do not fit a log of the other mission.
    #[error(transparent)]
    WaterLevels(WaterLevelError),
    /// The work was cancelled while a log of the other mission was processed.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The reference is empty.
    #[error("the reference holds no point with a place")]
    NoPlace,
    /// The reference lies this distance away from the survey, metres.
    #[error(
        "the reference lies {} from this survey; see whether both are of one water and whether its columns are named right",
        way(*.0)
    )]
    Elsewhere(f64),
    /// The reference lies over the survey, but no point is as near as required.
    #[error(
        "no point of this survey has a reference ({}); take a larger distance",
        (*.0).in_words()
    )]
    Unmatched(Matching),
}
