//! Turns the log that was read into the survey that the stages see: what the log does not say, or
//! says wrongly, is put right before any of them.

use super::Settings;
use super::settings::SourceSettings;
use bathyscope_log::formats::{TrackError, TrackFile};
use bathyscope_log::support::geo::CrsError;
use bathyscope_log::survey::{MountingSettings, Survey, TrackSettings};

/// Reason why a log cannot be used with its settings, in one sentence.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The metres of its positions are not those of `source.crs`.
    #[error(transparent)]
    System(#[from] CrsError),
    /// The track does not fit it.
    #[error(transparent)]
    Track(#[from] TrackError),
}

/// The settings that a survey depends on: with the same ones it is the same survey.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceKey {
    /// The track of another receiver.
    pub track: TrackSettings,
    swap_sides: bool,
    clock_offset_s: f64,
    sounding_lag_s: f64,
    source: SourceSettings,
}

impl SourceKey {
    /// Creates the key from these settings.
    pub fn of(settings: &Settings) -> Self {
        // Without a track its clock says nothing.
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

/// A log that was read, with what `mounting.*` and `source.*` put right: its sides, its clock, the
/// times of its soundings, the system of positions in metres, and which frequency is shown. Lever
/// arm and heading offset act where pings are placed.
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
        // It says that the system is not known.
        survey.warnings.retain(|warning| !warning.text.contains("source.crs"));
    }
    Ok(survey)
}

/// A log that was read as its settings have it, with the track of another receiver over it, if
/// there is one.
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
