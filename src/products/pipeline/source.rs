//! Makes the survey for the stages from the log that was read: missing or wrong facts of the log
//! are set or corrected before any stage.

use super::Settings;
use super::settings::SourceSettings;
use bathyscope_log::formats::TrackFile;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::CrsError;
use bathyscope_log::survey::{MountingSettings, Survey, TrackSettings};

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
