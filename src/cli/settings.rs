//! The settings that a command works with, and logs opened and processed as they ask.

use super::status_line::StatusLine;
use super::{LONGEST_TEXT, output};
use crate::bottom::cloud::Correction;
use crate::formats::{self, TrackFile};
use crate::pipeline::{self, Preset, Products, Settings, SourceError};
use crate::sonar::first_return::BottomSettings;
use crate::support::progress::Progress;
use crate::support::regular_file;
use crate::survey::Survey;
use std::path::{Path, PathBuf};

/// Where settings come from: the preset, then the files, then each `--set`, the last word winning.
#[derive(Debug, Default, clap::Args)]
pub struct SettingsArgs {
    /// The settings to start from
    #[arg(long, value_enum, default_value_t)]
    preset: Preset,
    /// TOML file of settings applied to the preset; may be given again, LOG.bottom.toml of Bathyscope among them
    #[arg(long, value_name = "FILE.toml")]
    settings: Vec<PathBuf>,
    /// One setting, for example first_return.threshold=0.35
    #[arg(long = "set", value_name = "KEY=VALUE", long_help = pipeline::settings::help())]
    assignments: Vec<String>,
}

impl SettingsArgs {
    /// Whether any of them was given: a project brings its own.
    pub fn are_given(&self) -> bool {
        self.preset != Preset::default()
            || !self.settings.is_empty()
            || !self.assignments.is_empty()
    }

    /// The settings that the arguments describe.
    pub fn resolve(&self) -> Result<Settings, String> {
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
            settings = settings
                .with_assignment(assignment)
                .map_err(|error| error.to_string())?;
        }
        settings.check().map_err(|error| error.to_string())?;
        settings.load_files().map_err(|error| error.to_string())?;
        Ok(settings)
    }
}

/// How logs are opened: the settings, and the track of another receiver if they name one, read once for all.
pub struct Logs {
    /// All settings.
    pub settings: Settings,
    track: Option<TrackFile>,
}

impl Logs {
    /// Reads the track that the settings name.
    ///
    /// # Errors
    /// A sentence when it cannot be used.
    pub fn new(settings: Settings) -> Result<Self, String> {
        let track = settings.track.file.as_deref();
        Ok(Self {
            track: track
                .map(TrackFile::read)
                .transpose()
                .map_err(|error| error.to_string())?,
            settings,
        })
    }

    /// Opens a log, applies the track, and names sidecar files that are not used.
    ///
    /// # Errors
    /// A sentence when it cannot be opened, or does not hold what the settings ask for.
    pub fn open(&self, path: &Path, progress: &Progress) -> Result<Survey, String> {
        let track = self.track.as_ref();
        let recorded = formats::open(path, progress).map_err(|error| error.to_string())?;
        let survey = pipeline::as_set(recorded, &self.settings, track)
            .map_err(|error| format!("{error}{}", of_log(&error, path)))?;
        tell_of_drawing(&survey, &self.settings);
        check_against(&survey, &self.settings)?;
        Ok(survey)
    }

    /// Runs the pipeline on one that was opened.
    ///
    /// # Errors
    /// A sentence when it cannot be processed.
    pub fn process(
        &self,
        survey: &Survey,
        status: &StatusLine,
        progress: &Progress,
    ) -> Result<Products, String> {
        status.work_on("", survey.side_scan.len());
        let products = pipeline::run(survey, &self.settings, None, progress, |stage| {
            status.step(stage.name())
        });
        products.map_err(|error| error.to_string())
    }
}

/// The log that a sentence does not end with yet.
fn of_log(error: &SourceError, path: &Path) -> String {
    match error {
        SourceError::System(_) => format!(": {}", path.display()),
        SourceError::Track(_) => String::new(),
    }
}

/// Warns that bottom edits lie next to the log and are not in force: a run uses only what it was given.
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

/// Refuses settings that ask for what this log does not hold.
pub fn check_against(survey: &Survey, settings: &Settings) -> Result<(), String> {
    if let Some(why) = Correction::new(settings.depth(), survey).refused() {
        return Err(why.to_string());
    }
    let origin = survey.track.frame.origin();
    let crs = settings.crs.at(origin);
    crs.map_err(|error| error.to_string())?;
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
        )),
        _ => Ok(()),
    }
}
