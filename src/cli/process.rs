//! `bathyscope process`: the whole pipeline without a window.

use super::status_line::StatusLine;
use crate::formats;
use crate::pipeline::{self, Preset, Settings};
use crate::progress::Progress;
use crate::survey::Survey;
use std::fs;
use std::path::{Path, PathBuf};

/// `bathyscope process SURVEY... -o DIR`.
#[derive(Debug, clap::Args)]
pub struct ProcessArgs {
    /// The logs; several are written into a folder each
    #[arg(required = true)]
    surveys: Vec<PathBuf>,
    /// Folder for the products; made when missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Where settings come from: the preset, then the file, then each `--set`, the last word winning.
#[derive(Debug, Default, clap::Args)]
pub struct SettingsArgs {
    /// The settings to start from
    #[arg(long, value_enum, default_value_t)]
    preset: Preset,
    /// TOML file of settings laid over the preset
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
    /// One setting, for example first_return.threshold=0.35
    #[arg(long = "set", value_name = "KEY=VALUE")]
    assignments: Vec<String>,
}

impl SettingsArgs {
    /// The settings that the arguments describe.
    pub fn resolve(&self) -> Result<Settings, String> {
        let mut settings = Settings::preset(self.preset);
        if let Some(path) = &self.settings {
            let text = fs::read_to_string(path).map_err(|error| {
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
        Ok(settings)
    }
}

/// Processes every log.
pub fn run(args: ProcessArgs) -> Result<(), String> {
    let settings = args.settings.resolve()?;
    let several = args.surveys.len() > 1;
    for path in &args.surveys {
        let progress = Progress::new();
        let survey = formats::open(path, &progress).map_err(|error| error.to_string())?;
        let folder = if several {
            args.output.join(survey.name())
        } else {
            args.output.clone()
        };
        process_into(&survey, &settings, &folder)?;
    }
    Ok(())
}

/// Runs the pipeline on one survey, writes its products and tells in a few lines what came out.
pub fn process_into(survey: &Survey, settings: &Settings, folder: &Path) -> Result<(), String> {
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    let products = pipeline::run(survey, settings, None, &progress, |stage| {
        status.step(stage.name())
    })
    .map_err(|error| error.to_string())?;
    status.step("writing");
    let written = pipeline::write_products(survey, &products, folder, &progress)?;
    drop(status);
    for warning in &written.report.warnings {
        eprintln!("warning: {warning}");
    }
    println!("{}", written.report.summary());
    println!(
        "wrote {} into {}",
        written.files.join(", "),
        folder.display()
    );
    Ok(())
}
