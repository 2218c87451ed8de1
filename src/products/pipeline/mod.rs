//! Runs the stages in order, keeps what is still valid, and knows what is stale.
//!
//! In: surveys and settings. Out: the results of every stage for each log, and what all logs give
//! together.
//!
//! `settings` holds every setting and the two presets, `log_settings` those that one of several
//! logs has for itself, `run_stages` has the stages, which of them a change of settings makes
//! stale, and runs them, `products` is what they made, `engine` runs them on a worker for the
//! window, `growing` over what was added to a log that is being written, `task` is how all work
//! runs off its thread. `derived` makes what all logs give together, once and on demand, and says
//! where echoes lie. `depth` makes the depth map and what follows from it, `agreement` compares
//! points with a reference, `objects` says where objects lie, `report` sums a run up (`log_report`
//! has what it says of each log), `scale_trial` what another scale would change, `fingerprint`
//! tells versions of files apart, `source` puts right what a log does not say of itself,
//! `survey_coverage` what a plan of further lines starts from, `joint` what all logs of a survey
//! give together. Nothing is written here: see `outputs`.

mod agreement;
mod clip_area;
mod depth;
mod derived;
mod engine;
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

pub use agreement::LogDifferences;
pub use agreement::{Agreement, AgreementError, MissionLog, Reference, ResidualTables, positions};
pub use clip_area::clip_area;
pub(crate) use depth::CloudPlane;
pub(crate) use depth::NamedComparison;
pub(crate) use depth::comparisons;
pub use depth::{
    CommonUncertainty, Crosslines, GeometryChoice, choices, crosslines, depth_points,
    joint_depth_points, joint_depth_surface, log_echoes,
};
pub use derived::{
    Bottom, BottomColour, BottomKey, CornerGround, DepthMapKey, FINEST, IsobathKey, Isobaths,
    MosaicKey, PictureKey,
};
pub use derived::{
    Contours, DepthMap, Derived, Mosaic, MosaicPlane, mosaic_layout, mosaic_layout_by,
};
pub use engine::{Engine, EngineStatus};
pub use fingerprint::{Fingerprint, Input, InputError, in_hexadecimal};
pub(crate) use fingerprint::{LogFiles, sha256_of};
pub use growing::{GrowingResults, extend};
pub use log_report::CalibrationReport;
pub use log_settings::{
    LogSettings, SettingValues, deserialize_values, is_of_one_log, setting_values, with_values,
};
pub(crate) use log_settings::{from_values, is_setting};
pub use objects::{ObjectLocator, list_objects, object_shape};
pub use passes::{Pass, passes_over, place_of};
pub use products::colour_range_m;
pub use products::{LogLatency, ProcessedLog, Products};
pub use report::Report;
pub use run_stages::{Stage, run};
pub use scale_trial::{ScaleEffect, ScaleTrial};
pub use settings::SettingsError;
pub use settings::{Preset, Settings};
pub use source::{SourceError, SourceKey, as_mounted, as_set};
pub use survey_coverage::survey_coverage;
pub use task::{Background, Jobs, Same, Task, TaskOutcome};

use bathyscope_log::support::geo::{CrsError, MapPlane};
use bathyscope_log::survey::Survey;

/// The plane of the system that `crs` names.
///
/// # Errors
/// When the system is not known, or does not fit the place.
pub fn map_plane(survey: &Survey, settings: &Settings) -> Result<MapPlane, CrsError> {
    let origin = survey.track.frame.origin();
    Ok(MapPlane::new(settings.crs.at(origin)?, origin))
}
