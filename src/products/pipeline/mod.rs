//! Runs the stages in order, keeps the results that are still valid, and runs again those that are
//! stale.
//!
//! In: surveys and settings. Out: the results of every stage for each log, and the joint results of
//! all logs.
//!
//! `settings` defines every setting and the two presets, `log_settings` the settings that one of
//! several logs has of its own. `run_stages` defines the stages and which of them a change of
//! settings makes stale, and runs them; `products` holds their results, `growing` runs them over
//! the added part of a log that is being written, `task` runs any work on another thread. `derived`
//! computes the joint results of all logs, once and on demand, the places of echoes, and the passes
//! over a place. `surface` makes the depth map and the bottom across the track, and `uncertainty`
//! the error that all its depths have in common. `residuals` compares side-scan with soundings, also
//! with another geometry or scale, `agreement` compares points with a reference, `objects` computes
//! the places of objects, `report` sums a run up (`log_report` holds the part on each log),
//! `fingerprint` distinguishes versions of files, `source` corrects a log where its file has wrong
//! or no data on itself, `survey_coverage` computes the starting point of a plan of further lines,
//! `joint` combines all logs of a survey. No files are written here: see `outputs`.

mod agreement;
mod derived;
mod fingerprint;
mod growing;
pub mod joint;
mod log_report;
mod log_settings;
mod objects;
mod products;
mod report;
mod residuals;
mod run_stages;
pub mod settings;
mod source;
mod surface;
mod survey_coverage;
mod task;
mod uncertainty;

pub use agreement::{Agreement, LogDifferences, MissionLog, Reference, ResidualTables, positions};
pub(crate) use derived::Contours;
pub use derived::{
    Bottom, BottomColour, BottomKey, CornerGround, DepthMap, DepthMapKey, Derived, FINEST,
    IsobathKey, Isobaths, Mosaic, MosaicKey, MosaicPlane, Pass, PictureKey, clip_area,
    mosaic_layout, mosaic_layout_by, passes_over, place_of,
};
pub use fingerprint::{Fingerprint, in_hexadecimal};
pub(crate) use fingerprint::{LogFiles, sha256_of};
pub use growing::{GrowingResults, extend};
pub use joint::{Crosslines, crosslines};
pub use log_report::CalibrationReport;
pub use log_settings::{LogSettings, SettingValues, setting_values};
pub(crate) use log_settings::{deserialize_values, from_values, is_of_one_log};
pub use objects::{ObjectLocator, list_objects, object_shape};
pub use products::{LogLatency, ProcessedLog, Products, colour_range_m};
pub use report::Report;
pub use residuals::{GeometryChoice, ScaleEffect, ScaleTrial, choices};
pub(crate) use residuals::{NamedComparison, comparisons};
pub use run_stages::{Stage, run};
pub use settings::{Preset, Settings, SettingsError};
pub use source::{SourceError, SourceKey, as_mounted, as_set};
pub use surface::{depth_points, joint_depth_points, joint_depth_surface, log_echoes};
pub use survey_coverage::survey_coverage;
pub use task::{Background, Jobs, Same, Task, TaskOutcome};
pub use uncertainty::CommonUncertainty;

use bathyscope_log::support::geo::{CrsError, MapPlane};
use bathyscope_log::survey::Survey;

/// Returns the plane of the coordinate system that `crs` names.
///
/// # Errors
/// When the system is unknown, or does not fit the survey's place.
pub fn map_plane(survey: &Survey, settings: &Settings) -> Result<MapPlane, CrsError> {
    let origin = survey.track.frame.origin();
    Ok(MapPlane::new(settings.crs.at(origin)?, origin))
}
