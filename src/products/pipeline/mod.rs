//! Runs the stages in order, keeps the results that are still valid, and runs again those that are
//! stale.
//!
//! In: surveys and settings. Out: the results of every stage for each log, and the joint results of
//! all logs.
//!
//! `settings` defines every setting and the two presets, `log_settings` the settings that one of
//! several logs has of its own. `run_stages` defines the stages and which of them a change of
//! settings makes stale, and runs them; `products` holds their results, `engine` runs them on a
//! worker for the window, `growing` runs them over the added part of a log that is being written,
//! `task` runs any work on another thread. `derived` computes the joint results of all logs, once
//! and on demand, and the places of echoes. `depth` makes the depth map and its products,
//! `agreement` compares points with a reference, `objects` computes the places of objects, `report`
//! sums a run up (`log_report` holds the part on each log), `scale_trial` computes the effect of
//! another scale, `fingerprint` distinguishes versions of files, `source` corrects a log where its
//! file has wrong or no data on itself, `survey_coverage` computes the starting point of a plan of
//! further lines, `joint` combines all logs of a survey. No files are written here: see `outputs`.

mod agreement;
mod clip_area;
mod depth;
mod derived;
mod fingerprint;
mod growing;
pub mod joint;
mod log_report;
mod log_settings;
mod objects;
mod passes;
mod products;
mod relief;
mod report;
mod run_stages;
mod scale_trial;
pub mod settings;
mod source;
mod survey_coverage;
mod task;

pub use agreement::{Agreement, LogDifferences, MissionLog, Reference, ResidualTables, positions};
pub use clip_area::clip_area;
pub(crate) use depth::{CloudPlane, NamedComparison, comparisons};
pub use depth::{
    CommonUncertainty, GeometryChoice, choices, depth_points, joint_depth_points,
    joint_depth_surface, log_echoes,
};
pub(crate) use derived::Contours;
pub use derived::{
    Bottom, BottomColour, BottomKey, CornerGround, DepthMap, DepthMapKey, Derived, FINEST,
    IsobathKey, Isobaths, Mosaic, MosaicKey, MosaicPlane, PictureKey, mosaic_layout,
    mosaic_layout_by,
};
pub use fingerprint::{Fingerprint, in_hexadecimal};
pub(crate) use fingerprint::{LogFiles, sha256_of};
pub use growing::{GrowingResults, extend};
pub use joint::{Crosslines, crosslines};
pub use log_report::CalibrationReport;
pub use log_settings::{LogSettings, SettingValues, setting_values};
pub(crate) use log_settings::{
    deserialize_values, from_values, is_of_one_log, is_setting, with_values,
};
pub use objects::{ObjectLocator, list_objects, object_shape};
pub use passes::{Pass, passes_over, place_of};
pub use products::{LogLatency, ProcessedLog, Products, colour_range_m};
pub use report::Report;
pub use run_stages::{Stage, run};
pub use scale_trial::{ScaleEffect, ScaleTrial};
pub use settings::{Preset, Settings, SettingsError};
pub use source::{SourceError, SourceKey, as_mounted, as_set};
pub use survey_coverage::survey_coverage;
pub use task::{Background, Jobs, Same, Task, TaskOutcome};

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
