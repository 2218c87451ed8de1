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
//! the error that all its depths have in common. `residuals` compares side-scan with soundings,
//! also with another geometry or scale, `agreement` compares points with a reference, `objects`
//! computes the places of objects, `report` sums a run up (`log_report` holds the part on each
//! log), `fingerprint` distinguishes versions of files, `survey_coverage` computes the starting
//! point of a plan of further lines, `joint` combines all logs of a survey. Before any stage,
//! missing or wrong facts of a log are set or corrected ([`as_set`]). No files are written here:
//! see `outputs`.

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
pub use surface::{depth_points, joint_depth_points, joint_depth_surface, log_echoes};
pub use survey_coverage::survey_coverage;
pub use task::{Background, Jobs, Same, Task, TaskOutcome};
pub use uncertainty::CommonUncertainty;

use bathyscope_log::formats::TrackFile;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::{CrsError, MapPlane};
use bathyscope_log::survey::{MountingSettings, Survey, TrackSettings};
use settings::SourceSettings;

/// Returns the plane of the coordinate system that `crs` names.
///
/// # Errors
/// When the system is unknown, or does not fit the survey's place.
pub fn map_plane(survey: &Survey, settings: &Settings) -> Result<MapPlane, CrsError> {
    let origin = survey.track.frame.origin();
    Ok(MapPlane::new(settings.crs.at(origin)?, origin))
}

/// Reason why a log cannot be used with its settings, in one sentence.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The metres of the log's positions are not those of `source.crs`.
    #[error(transparent)]
    System(#[from] CrsError),
    /// The track of another receiver does not fit the log.
    #[error(transparent)]
    Track(#[from] FileError),
}

/// Settings on which a survey depends: equal keys give equal surveys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceKey {
    /// Settings of the track of another receiver.
    pub track: TrackSettings,
    swap_sides: bool,
    clock_offset_s: f64,
    sounding_lag_s: f64,
    source: SourceSettings,
}

impl SourceKey {
    /// Creates the key from these settings.
    pub fn of(settings: &Settings) -> Self {
        // Without a track, its time offset has no effect.
        let track = Some(settings.track.clone()).filter(|track| track.file.is_some());
        Self {
            track: track.unwrap_or_default(),
            swap_sides: settings.mounting.swap_sides,
            clock_offset_s: settings.mounting.clock_offset_s,
            sounding_lag_s: settings.mounting.sounding_lag_s,
            source: settings.source.clone(),
        }
    }
}

/// Returns the log that was read, corrected by `mounting.*` and `source.*`: its sides, its clock,
/// the times of its soundings, the coordinate system of positions in metres, and the frequency that
/// is shown. Lever arm and heading offset are applied when pings are placed.
///
/// # Errors
/// When the metres of its positions are not those of `source.crs`.
pub fn as_mounted(
    recorded: Survey,
    mounting: &MountingSettings,
    source: &SourceSettings,
) -> Result<Survey, SourceError> {
    let recorded = match source.frequency_khz {
        Some(frequency_khz) => recorded.with_frequency(frequency_khz),
        None => recorded,
    };
    let mut survey = recorded.mounted(mounting);
    if let Some(crs) = source.crs.filter(|_| survey.track.projected.is_some()) {
        survey.track = survey.track.in_system(&crs.system()?)?;
        // The warning is that the coordinate system is unknown.
        survey.warnings.retain(|warning| !warning.text.contains("source.crs"));
    }
    Ok(survey)
}

/// Returns the log that was read, corrected by its settings, with the track of another receiver
/// applied if there is one.
///
/// # Errors
/// When the metres of its positions are not those of `source.crs`, or the track does not fit the
/// log.
pub fn as_set(
    recorded: Survey,
    settings: &Settings,
    track: Option<&TrackFile>,
) -> Result<Survey, SourceError> {
    let mut survey = as_mounted(recorded, &settings.mounting, &settings.source)?;
    if let Some(track) = track {
        track.apply(&mut survey, settings.track.offset_s)?;
    }
    Ok(survey)
}
