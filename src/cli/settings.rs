//! Resolves the settings of a command, and opens and processes logs with them.

use super::status_line::StatusLine;
use super::{Failure, LONGEST_TEXT, output};
use bathyscope_bottom::cloud::Correction;
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::formats::{self, TrackFile};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{self, Preset, ProcessedLog, Settings, SourceError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Sources of settings: the preset, then the files, then each `--set`; the last one wins.
#[derive(Debug, Default, clap::Args)]
pub(super) struct SettingsArgs {
    /// The settings to start from
    #[arg(long, value_enum, default_value_t)]
    preset: Preset,
    /// TOML file of settings applied to the preset, or of bottom edits; may be given again
    #[arg(long, value_name = "FILE.toml")]
    settings: Vec<PathBuf>,
    /// One setting, for example first_return.threshold=0.35
    #[arg(long = "set", value_name = "KEY=VALUE", long_help = pipeline::settings::help())]
    assignments: Vec<String>,
}

impl SettingsArgs {
    /// Returns true if any of the arguments was given. A project has its own settings.
    pub(super) fn are_given(&self) -> bool {
        self.preset != Preset::default()
            || !self.settings.is_empty()
            || !self.assignments.is_empty()
    }

    /// Returns the settings that the arguments describe.
    pub(super) fn resolve(&self) -> Result<Settings, Failure> {
        let mut settings = Settings::preset(self.preset);
        for path in &self.settings {
            let text = regular_file::read_text(path, LONGEST_TEXT).map_err(|error| {
                format!("cannot read the settings: {error}: {}", path.display())
            })?;
            settings = settings
                .with_toml(&text)
                .map_err(|error| format!("{error}: {}", path.display()))?;
        }
        for assignment in &self.assignments {
            settings = settings.with_assignment(assignment)?;
        }
        settings.check()?;
        settings.load_files()?;
        Ok(settings)
    }
}

/// Opener of logs, with the settings and, if they name one, the track of another receiver. The
/// track is read once for all logs.
pub(super) struct LogOpener {
    /// All settings.
    pub settings: Settings,
    track: Option<TrackFile>,
}

impl LogOpener {
    /// Creates an opener; reads the track that the settings name.
    ///
    /// # Errors
    /// When the track cannot be read.
    pub(super) fn new(settings: Settings) -> Result<Self, FileError> {
        let track = settings.track.file.as_deref();
        Ok(Self { track: track.map(TrackFile::read).transpose()?, settings })
    }

    /// Opens a log, applies the track, and names sidecar files that are not used.
    ///
    /// # Errors
    /// When the log cannot be opened, or lacks what the settings require.
    pub(super) fn open(&self, path: &Path, progress: &Progress) -> Result<Survey, Failure> {
        let track = self.track.as_ref();
        let recorded = formats::open(path, progress)?;
        let survey =
            pipeline::as_set(recorded, &self.settings, track).map_err(|error| match error {
                SourceError::System(_) => format!("{error}: {}", path.display()),
                // It ends with the path of the track.
                SourceError::Track(_) => error.to_string(),
            })?;
        tell_of_drawing(&survey, &self.settings);
        check_against(&survey, &self.settings)?;
        Ok(survey)
    }
}

/// Runs the pipeline on a log; results that do not depend on the changed settings are taken from
/// `previous`.
///
/// # Errors
/// When the work was cancelled.
pub(super) fn processed(
    survey: &Arc<Survey>,
    settings: &Settings,
    previous: Option<&ProcessedLog>,
    status: &StatusLine,
) -> Result<ProcessedLog, Cancelled> {
    let previous = previous.map(|log| &log.products);
    let products = pipeline::run(survey, settings, previous, &status.progress, |stage| {
        status.step(stage.name());
    })?;
    Ok(ProcessedLog::new(survey.clone(), products))
}

/// Warns if bottom edits are next to the log and are not used: a run uses only the settings that it
/// is given.
fn tell_of_drawing(survey: &Survey, settings: &Settings) {
    let log = survey.source.files.first();
    let sidecar = log.map(|log| log.with_extension(BottomSettings::SIDECAR));
    if let Some(path) = sidecar.filter(|path| settings.bottom.is_empty() && path.is_file()) {
        output::notify(format_args!(
            "warning: bottom edits lie next to the log and are not used; give them with --settings: {}",
            path.display()
        ));
    }
}

/// Refuses settings that do not fit the log.
pub(super) fn check_against(survey: &Survey, settings: &Settings) -> Result<(), Failure> {
    if let Some(why) = Correction::new(settings.depth(), survey).refused {
        return Err(why.into());
    }
    let origin = survey.track.frame.origin();
    settings.crs.at(origin)?;
    let count = survey.side_scan.len();
    match settings.calibration.pings {
        Some(pings) if pings.end > count => Err(format!(
            "calibration.pings is {}, but the log has {count} side-scan pings; choose a stretch among them: {}",
            String::from(pings),
            survey
                .source
                .files
                .first()
                .map_or(String::new(), |path| path.display().to_string())
        ).into()),
        _ => Ok(()),
    }
}
